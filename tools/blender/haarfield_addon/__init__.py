"""Bakes the light of the world into colour attributes with haarfield, exports POV-Ray scenes, checks with Cycles."""

bl_info = {
    "name": "haarfield",
    "description": "Bake light with shadows into colour attributes, and export it for POV-Ray",
    "author": "haarfield",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Properties > Render > haarfield",
    "category": "Render",
}

try:
    import haarfield  # noqa: F401
except ModuleNotFoundError as error:
    raise ModuleNotFoundError("haarfield's Python module is not installed: cmake --install build/release") from error

from . import operators, panel, settings

MODULES = (settings, operators, panel)


def register():
    for module in MODULES:
        module.register()


def unregister():
    for module in reversed(MODULES):
        module.unregister()
