"""Installs the add-on's zip as a user does, into a temporary folder: blender -b --python tests/blender/test_zip.py.

Needs the zip in HAARFIELD_ADDON and an empty folder in BLENDER_USER_SCRIPTS.
"""

import os
import shutil
import sys
import tempfile
import zipfile
from pathlib import Path

import addon_utils
import bpy

HERE = Path(__file__).resolve().parent
ADDON = Path(os.environ["HAARFIELD_ADDON"])
USER = Path(os.environ["BLENDER_USER_SCRIPTS"])
SOURCE = HERE.parents[1] / "tools/blender/haarfield_addon"


def main():
    with zipfile.ZipFile(ADDON) as file:
        inside = {name: file.read(name) for name in file.namelist()}
    assert inside == {f"haarfield_addon/{path.name}": path.read_bytes() for path in SOURCE.glob("*.py")}

    shutil.rmtree(USER, ignore_errors=True)
    (USER / "addons").mkdir(parents=True)
    assert bpy.ops.preferences.addon_install(filepath=str(ADDON)) == {"FINISHED"}
    assert bpy.ops.preferences.addon_enable(module="haarfield_addon") == {"FINISHED"}
    installed = sys.modules["haarfield_addon"]
    assert Path(installed.__file__).is_relative_to(USER), installed.__file__
    assert addon_utils.check("haarfield_addon") == (True, True)

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="haarfield_addon")
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.scene.world = bpy.data.worlds.new("grey")
    bpy.context.view_layer.update()
    with tempfile.TemporaryDirectory() as folder:
        bpy.context.scene.haarfield.folder, bpy.context.scene.haarfield.samples = folder, 100
        assert bpy.ops.haarfield.bake() == {"FINISHED"}
    (copy,) = bpy.data.collections["haarfield"].objects
    assert copy.data.color_attributes["haarfield"].data_type == "FLOAT_COLOR"

    assert bpy.ops.preferences.addon_disable(module="haarfield_addon") == {"FINISHED"}
    assert not hasattr(bpy.types.Scene, "haarfield") and not hasattr(bpy.types, "HAARFIELD_OT_bake")
    print("passed")


main()
