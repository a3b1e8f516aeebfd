"""The settings in the panel, which are stored in the scene."""

import bpy


class HaarfieldSettings(bpy.types.PropertyGroup):
    objects: bpy.props.EnumProperty(
        name="Objects",
        description="Objects that are baked and cast shadows",
        items=[
            ("VISIBLE", "Visible", "All objects that are visible in this view layer and in renders"),
            ("SELECTED", "Selected", "The visible objects that are selected"),
        ],
        default="VISIBLE",
    )
    vertices: bpy.props.IntProperty(
        name="Vertices",
        description="Subdivide each mesh to at least this many vertices; 0: no subdivision",
        default=500,
        min=0,
        max=2_000_000,
    )
    error: bpy.props.FloatProperty(
        name="Error",
        description="Error of the light over all surfaces, which chooses the vertices; 0: bake the vertices as they are",
        default=1.0,
        min=0.0,
        max=100.0,
        precision=2,
        subtype="PERCENTAGE",
    )
    samples: bpy.props.IntProperty(
        name="Samples",
        description="Samples of each mesh's visibility field, which gives its shadows on other objects",
        default=6000,
        min=100,
        max=200_000,
    )
    folder: bpy.props.StringProperty(
        name="Folder",
        description="Folder for visibility fields and POV-Ray scenes",
        default="//haarfield",
        subtype="DIR_PATH",
    )
    cycles_samples: bpy.props.IntProperty(
        name="Cycles Samples", description="Cycles' samples per vertex in the comparison", default=4096, min=16, max=65536
    )


def register():
    bpy.utils.register_class(HaarfieldSettings)
    bpy.types.Scene.haarfield = bpy.props.PointerProperty(type=HaarfieldSettings)


def unregister():
    del bpy.types.Scene.haarfield
    bpy.utils.unregister_class(HaarfieldSettings)
