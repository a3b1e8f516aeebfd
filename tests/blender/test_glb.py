"""Output of `bake --format glb` in Blender without a window: images times light, upright, correctly placed.

blender -b --factory-startup --python tests/blender/test_glb.py, with the program in HAARFIELD_PROGRAM.
"""

import math
import os
import subprocess
import sys
import tempfile
import traceback
from pathlib import Path

import bpy
import numpy
from mathutils import Matrix, Vector

if not hasattr(numpy, "bool"):
    numpy.bool = bool  # required by Blender 3.4's importer, removed from newer numpy

CAMERA = {"position": (1.5, 1.6, 3), "target": (0, 0.45, 0), "vertical_fov": 35, "resolution": (160, 120)}

MODEL = """mtllib board.mtl
v -1 0 1
v 1 0 1
v 1 0 -1
v -1 0 -1
v -0.5 0.05 -0.3
v 0.5 0.05 -0.3
v 0.5 1 -0.3
v -0.5 1 -0.3
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl plain
f 1 2 3 4
usemtl painted
f 5/1 6/2 7/3 8/4
"""

SCENE = """[camera]
position = [1.5, 1.6, 3]
target = [0, 0.45, 0]
vertical_fov = 35
resolution = [160, 120]
[environment]
sky = { turbidity = 4, sun_elevation = 60, sun_azimuth = 60, sun_angular_radius = 5 }
exposure = "auto"
[entities.board]
mesh = "board.obj"
fine_vertices = 6000
[[instances]]
entity = "board"
"""


def write_scene(folder):
    """Writes a board above a plain floor. The board has an image with a dark lower part and one bright corner."""
    pixels = numpy.ones((16, 16, 4), numpy.float32)
    pixels[:, :, :3] = numpy.random.default_rng(1).uniform(0.2, 0.6, (4, 4, 3)).repeat(4, 0).repeat(4, 1)
    pixels[:8, :, 2] = 0.05
    pixels[12:, 12:, :3] = 1
    image = bpy.data.images.new("paint", 16, 16)
    image.pixels.foreach_set(pixels.ravel())
    image.filepath_raw, image.file_format = str(folder / "paint.png"), "PNG"
    image.save()
    bpy.data.images.remove(image)
    (folder / "board.obj").write_text(MODEL)
    (folder / "board.mtl").write_text(
        "newmtl plain\nKd 0.5 0.4 0.3\nnewmtl painted\nKd 0.9 0.9 0.9\nmap_Kd paint.png\n"
    )
    (folder / "board.toml").write_text(SCENE)


def pixels_of(path):
    """Returns linear RGBA, with rows from the top."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    pixels = numpy.empty(4 * image.size[0] * image.size[1], numpy.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(image.size[1], image.size[0], 4)[::-1]


def in_blender(v):
    return Vector((v[0], -v[2], v[1]))


def render(path):
    scene = bpy.context.scene
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle = "VERTICAL", math.radians(CAMERA["vertical_fov"])
    camera = bpy.data.objects.new("camera", data)
    position, target = in_blender(CAMERA["position"]), in_blender(CAMERA["target"])
    turn = (target - position).to_track_quat("-Z", "Y").to_matrix().to_4x4()
    camera.matrix_world = Matrix.Translation(position) @ turn
    scene.collection.objects.link(camera)
    scene.camera, scene.world = camera, None
    scene.render.resolution_x, scene.render.resolution_y = CAMERA["resolution"]
    scene.render.engine, scene.cycles.samples = "CYCLES", 64
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.render.film_transparent = True
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.image_settings.color_mode = "RGBA"
    scene.view_settings.view_transform = "Raw"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def srgb(linear):
    linear = numpy.clip(linear, 0, 1)
    return numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def psnr(first, second, mask):
    error = (srgb(first[..., :3]) - srgb(second[..., :3]))[mask]
    return -10 * math.log10((error**2).mean())


def test_images_are_multiplied_with_the_light(folder):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    write_scene(folder)
    program = os.environ["HAARFIELD_PROGRAM"]
    arguments = [program, "bake", folder / "board.toml", "-o", folder / "out", "--format", "glb"]
    arguments += ["--error", "off", "--face-size", "16"]
    subprocess.run(arguments, check=True, stdout=subprocess.DEVNULL)
    bpy.ops.import_scene.gltf(filepath=str(folder / "out/board.glb"))
    (board,) = [object for object in bpy.data.objects if object.type == "MESH"]
    materials = [slot.material for slot in board.material_slots]
    assert len(materials) == 2, materials
    (painted,) = [m for m in materials if any(node.type == "TEX_IMAGE" for node in m.node_tree.nodes)]
    image = next(node.image for node in painted.node_tree.nodes if node.type == "TEX_IMAGE")
    assert tuple(image.size) == (16, 16) and image.packed_file.data == (folder / "paint.png").read_bytes()
    assert len(board.data.uv_layers) == 1

    render(folder / "blender.exr")
    baked, shown = pixels_of(folder / "out/baked.exr"), pixels_of(folder / "blender.exr")
    inside = (baked[..., 3] > 0.999) & (shown[..., 3] > 0.999)
    assert inside.sum() > 4000, inside.sum()
    figure = psnr(baked, shown, inside)
    print(f"Cycles shows the GLB as POV-Ray shows the bake: {figure:.1f} dB, {inside.sum()} pixels")
    assert figure >= 35


def main():
    failed = []
    for name, test in [(n, t) for n, t in globals().items() if n.startswith("test_")]:
        with tempfile.TemporaryDirectory() as folder:
            try:
                test(Path(folder))
                print("passed", name)
            except Exception:
                traceback.print_exc()
                failed.append(name)
    print("failed:", failed or "none")
    return 1 if failed else 0


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    sys.exit(code)
