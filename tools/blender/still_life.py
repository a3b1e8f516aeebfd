"""Makes the picture of this folder's README: a still life baked by the add-on, and rendered by Cycles' path tracer.

    export PYTHONPATH=build/release/python
    blender -b --factory-startup --python-use-system-env --python tools/blender/still_life.py -- FOLDER

writes still_life.png and the .blend into FOLDER, and prints both times and the difference of the pictures. --small
makes small pictures, for the tests.
"""

import math
import sys
import time
from pathlib import Path

import bpy
import numpy

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import haarfield
import haarfield_addon
from haarfield_addon import operators, results


def diffuse(name, colour, image=None):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    output, shader = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = (*colour, 1)
    tree.links.new(shader.outputs["BSDF"], output.inputs["Surface"])
    if image is not None:
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = image
        tree.links.new(texture.outputs["Color"], shader.inputs["Color"])
    return made


def wood_image(width=512, height=512):
    """Returns an image of boards along u, with grain."""
    random = numpy.random.default_rng(4)
    v, u = numpy.mgrid[0:height, 0:width] / numpy.array([height, width])[:, None, None]
    board = numpy.floor(5 * v).astype(int)
    shade, shift = random.uniform(0.8, 1.1, 5)[board], random.uniform(0, 9, 5)[board]
    wave = sum(numpy.sin(2 * numpy.pi * (a * u + shift) + shift) / (a + 1) for a in (1, 2, 3))
    grain = 0.5 + 0.5 * numpy.sin(60 * v + 5 * wave + 3 * shift)
    seam = numpy.clip(numpy.abs((5 * v + 0.5) % 1 - 0.5) * 40, 0.35, 1)
    pixels = numpy.ones((height, width, 4), numpy.float32)
    light, dark = numpy.array([0.60, 0.40, 0.24]), numpy.array([0.47, 0.29, 0.16])
    pixels[..., :3] = (dark + (light - dark) * grain[..., None]) * (shade * seam)[..., None]
    image = bpy.data.images.new("wood", width, height)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def linked(object):
    bpy.context.collection.objects.link(object)
    return object


def placed(object, name, material, location=(0, 0, 0), turn=0.0, scale=(1, 1, 1)):
    object.name, object.location, object.scale = name, location, scale
    object.rotation_euler[2] = math.radians(turn)
    if material is not None:
        object.data.materials.append(material)
    return object


def turned(name, profile, material, location):
    """Makes a surface of revolution from a profile of (radius, height), with the modifiers Screw and Subdivision."""
    mesh = bpy.data.meshes.new(name)
    edges = [(i, i + 1) for i in range(len(profile) - 1)]
    mesh.from_pydata([(r, 0, z) for r, z in profile], edges, [])
    made = placed(linked(bpy.data.objects.new(name, mesh)), name, material, location)
    screw = made.modifiers.new("turned", "SCREW")
    screw.steps = screw.render_steps = 32
    screw.use_merge_vertices, screw.use_smooth_shade, screw.use_normal_calculate = True, True, True
    made.modifiers.new("finer", "SUBSURF").levels = 2
    return made


def book(name, colour, height, z, turn, location=(0, 0)):
    bpy.ops.mesh.primitive_cube_add(size=1)
    made = placed(bpy.context.object, name, diffuse(name, colour), (*location, z + height / 2), turn)
    made.scale = (0.74, 0.52, height)
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    bevel = made.modifiers.new("edges", "BEVEL")
    bevel.width, bevel.segments = 0.015, 2
    bpy.ops.object.shade_smooth()
    if hasattr(made.data, "use_auto_smooth"):  # until Blender 4.0
        made.data.use_auto_smooth = True
    made.modifiers.new("flat", "WEIGHTED_NORMAL")
    return z + height


def make_scene(light):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_grid_add(size=4.4, x_subdivisions=60, y_subdivisions=60)
    placed(bpy.context.object, "Table", diffuse("wood", (1, 1, 1), wood_image()))

    z = book("Atlas", (0.10, 0.19, 0.27), 0.13, 0, 8, (-0.55, 0.35))
    z = book("Novel", (0.52, 0.12, 0.08), 0.10, z, -6, (-0.53, 0.36))
    z = book("Poems", (0.75, 0.66, 0.46), 0.07, z, 17, (-0.56, 0.34))
    bpy.ops.mesh.primitive_monkey_add(size=0.62)
    head = placed(bpy.context.object, "Suzanne", diffuse("clay", (0.62, 0.34, 0.22)), (-0.56, 0.33, z + 0.245), 24)
    head.rotation_euler[0] = math.radians(-32)
    head.modifiers.new("finer", "SUBSURF").levels = 2
    bpy.ops.object.shade_smooth()

    glaze, cream = diffuse("glaze", (0.09, 0.26, 0.27)), diffuse("cream", (0.78, 0.73, 0.63))
    cup = [(0, 0.012), (0.1, 0.012), (0.125, 0.03), (0.175, 0.11), (0.195, 0.21), (0.2, 0.262),
           (0.192, 0.266), (0.183, 0.255), (0.176, 0.2), (0.155, 0.11), (0.11, 0.045), (0, 0.036)]
    first = turned("Cup", cup, glaze, (0.22, -0.28, 0))
    vase = [(0, 0.01), (0.12, 0.01), (0.15, 0.04), (0.24, 0.26), (0.22, 0.46), (0.1, 0.66), (0.085, 0.76), (0.13, 0.86),
            (0.118, 0.862), (0.07, 0.76), (0.08, 0.66), (0.19, 0.46), (0.2, 0.26), (0.1, 0.06), (0, 0.05)]
    turned("Vase", vase, cream, (0.52, 0.42, 0))
    for number, (place, scale) in enumerate([((0.72, -0.1, 0), 0.85), ((0.22, -0.28, 0.115), 0.98)], 2):
        copy = linked(first.copy())
        placed(copy, f"Cup {number}", None, place, 40 * number, (scale, scale, scale))
    orange = diffuse("orange", (0.80, 0.33, 0.05))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=0.115, location=(-0.16, -0.45, 0.113))
    fruit = placed(bpy.context.object, "Orange", orange, bpy.context.object.location.copy())
    bpy.ops.object.shade_smooth()
    for number, place in enumerate([(-0.40, -0.36, 0.113), (-0.27, -0.63, 0.113)], 2):
        placed(linked(fruit.copy()), f"Orange {number}", None, place, 50 * number, (1, 1, 0.95))

    text = bpy.data.curves.new("letters", "FONT")
    text.body, text.size, text.extrude, text.bevel_depth = "haarfield", 0.26, 0.03, 0.003
    text.align_x = "CENTER"
    letters = placed(linked(bpy.data.objects.new("Letters", text)), "Letters", cream, (0.36, -0.66, 0.003), 10)
    letters.rotation_euler[0] = math.radians(90)

    world = bpy.data.worlds.new("lit")
    world.use_nodes = True
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    background.inputs["Strength"].default_value = light["strength"]
    texture, mapping = tree.nodes.new("ShaderNodeTexEnvironment"), tree.nodes.new("ShaderNodeMapping")
    lights = Path(bpy.utils.system_resource("DATAFILES", path="studiolights/world"))
    texture.image = bpy.data.images.load(str(lights / light["image"]))
    mapping.inputs["Rotation"].default_value[2] = math.radians(light["turn"])
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    scene = bpy.context.scene
    scene.world = world

    camera = linked(bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera")))
    camera.location, camera.data.lens = (0.36, -3.2, 1.42), 58
    camera.rotation_euler = (math.radians(70), 0, math.radians(6.5))
    scene.camera = camera
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"
    bpy.context.view_layer.update()
    return bpy.context


def rendered(path, samples):
    """Renders with Cycles. Returns the time in seconds."""
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples = "CYCLES", samples
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(path)
    start = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    return time.perf_counter() - start


def main():
    arguments = sys.argv[sys.argv.index("--") + 1 :]
    is_small, folder = "--small" in arguments, Path(next(a for a in arguments if not a.startswith("--")))
    folder.mkdir(parents=True, exist_ok=True)
    haarfield_addon.register()
    context = make_scene({"image": "courtyard.exr", "turn": 150, "strength": 1.0})
    scene = context.scene
    scene.render.resolution_x, scene.render.resolution_y = (120, 90) if is_small else (560, 420)
    settings = scene.haarfield
    settings.folder = str(folder)
    settings.samples = 600 if is_small else 6000
    settings.vertices = 0
    settings.error = 0 if is_small else 1

    traced_seconds = rendered(folder / "traced.exr", 16 if is_small else 256)
    start = time.perf_counter()
    assert bpy.ops.haarfield.bake() == {"FINISHED"}
    baked_seconds = time.perf_counter() - start
    shown_seconds = rendered(folder / "baked.exr", 8 if is_small else 64)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "still_life.blend"))

    pictures = [haarfield.read_image(folder / f"{name}.exr")[0] for name in ("baked", "traced")]
    haarfield.write_image(numpy.hstack(pictures), folder / "still_life.png")
    figures = haarfield.compare(*(numpy.ascontiguousarray(picture) for picture in pictures))
    # in the small picture, noise of the path tracer dominates
    assert figures["psnr_db"] > (20 if is_small else 30), figures
    bake = operators.remembered[scene.name].bake
    print(f"{len(results.copies(scene))} objects, {bake.vertices} vertices: baked in {baked_seconds:.1f} s, "
          f"shown in {shown_seconds:.1f} s; traced in {traced_seconds:.1f} s; {figures['psnr_db']:.1f} dB apart")


main()
