"""The panel in the render properties."""

import bpy

from . import results


class HAARFIELD_PT_bake(bpy.types.Panel):
    bl_label = "haarfield"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = self.layout, context.scene.haarfield
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column()
        column.prop(settings, "objects")
        column.prop(settings, "vertices")
        column.prop(settings, "error")
        column.prop(settings, "samples")
        column.prop(settings, "folder")
        layout.operator("haarfield.bake", icon="LIGHT_SUN").export = False
        layout.operator("haarfield.bake", text="Bake and Export for POV-Ray", icon="EXPORT").export = True
        if results.copies(context.scene):
            row = layout.row(align=True)
            row.operator("haarfield.show", text="Show Baked").baked = True
            row.operator("haarfield.show", text="Show Objects").baked = False
        column = layout.column()
        column.prop(settings, "cycles_samples")
        column.operator("haarfield.compare", icon="VIEWZOOM")


def register():
    bpy.utils.register_class(HAARFIELD_PT_bake)


def unregister():
    bpy.utils.unregister_class(HAARFIELD_PT_bake)
