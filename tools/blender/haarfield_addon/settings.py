"""What the panel lets one choose; kept with the scene."""

import bpy


class HaarfieldSettings(bpy.types.PropertyGroup):
    objects: bpy.props.EnumProperty(
        name="Objects",
        description="Which objects are baked, and cast shadows",
        items=[
            ("VISIBLE", "Visible", "All that are visible in this view layer and in renders"),
            ("SELECTED", "Selected", "Of these the selected ones"),
        ],
        default="VISIBLE",
    )
    vertices: bpy.props.IntProperty(
        name="Vertices",
        description="Subdivide each mesh to at least this many vertices; 0: do not",
        default=500,
        min=0,
        max=2_000_000,
    )
    refine: bpy.props.FloatProperty(
        name="Refine",
        description="Split triangles where the light between vertices is off by more than this; 0: do not",
        default=0.02,
        min=0.0,
        max=1.0,
        precision=3,
    )
    samples: bpy.props.IntProperty(
        name="Samples",
        description="Of each mesh's visibility field, from which its shadows on other objects are looked up",
        default=6000,
        min=100,
        max=200_000,
    )
    folder: bpy.props.StringProperty(
        name="Folder",
        description="For visibility fields and POV-Ray scenes",
        default="//haarfield",
        subtype="DIR_PATH",
    )
    cycles_samples: bpy.props.IntProperty(
        name="Cycles Samples", description="At each vertex, for the comparison", default=4096, min=16, max=65536
    )


def register():
    bpy.utils.register_class(HaarfieldSettings)
    bpy.types.Scene.haarfield = bpy.props.PointerProperty(type=HaarfieldSettings)


def unregister():
    del bpy.types.Scene.haarfield
    bpy.utils.unregister_class(HaarfieldSettings)
