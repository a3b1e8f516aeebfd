"""A scene of ten objects: linked duplicates, modifiers, an image texture, a mirrored one, a rotated HDR world."""

import math

import bpy
import numpy


# Names of sockets of the Principled BSDF in Blender 4.
NEW_NAMES = {"Specular": "Specular IOR Level"}


def material(name, kind="BSDF_DIFFUSE", colour=(0.5, 0.5, 0.5), image=None, **inputs):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    if kind == "BSDF_DIFFUSE":
        tree.nodes.clear()
        output = tree.nodes.new("ShaderNodeOutputMaterial")
        shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
        tree.links.new(shader.outputs["BSDF"], output.inputs["Surface"])
        colour_input = shader.inputs["Color"]
    else:
        shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
        colour_input = shader.inputs["Base Color"]
    colour_input.default_value = (*colour, 1)
    if image is not None:
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = image
        tree.links.new(texture.outputs["Color"], colour_input)
    for key, value in inputs.items():
        name = key if key in shader.inputs else NEW_NAMES[key]
        shader.inputs[name].default_value = value
    return made


def checked_image():
    image = bpy.data.images.new("checks", 64, 64)
    y, x = numpy.mgrid[0:64, 0:64] // 8
    pixels = numpy.ones((64, 64, 4), numpy.float32)
    pixels[..., :3] = numpy.where(((x + y) % 2)[..., None], (0.7, 0.6, 0.5), (0.2, 0.3, 0.4))
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def sky_image():
    """Returns a float image of a warm window, a blue sky and a dark ground."""
    image = bpy.data.images.new("sky", 256, 128, float_buffer=True)
    v, u = numpy.mgrid[0:128, 0:256]
    latitude, longitude = numpy.pi * ((v + 0.5) / 128 - 0.5), 2 * numpy.pi * (u + 0.5) / 256
    light = 0.3 + 0.5 * numpy.clip(numpy.sin(latitude), -0.3, 1)[..., None] * numpy.array([0.6, 0.8, 1.2])
    window = numpy.exp(-8 * (longitude - 2.0) ** 2 - 10 * (latitude - 0.7) ** 2)
    light = light + window[..., None] * numpy.array([5, 4, 2.5])
    pixels = numpy.ones((128, 256, 4), numpy.float32)
    pixels[..., :3] = light
    image.pixels.foreach_set(pixels.ravel())
    return image


def set_world(image, degrees, strength):
    world = bpy.data.worlds.new("lit")
    world.use_nodes = True
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    background.inputs["Strength"].default_value = strength
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = (0, 0, math.radians(degrees))
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    bpy.context.scene.world = world


def added(operator, name, shown, location, **options):
    operator(location=location, **options)
    made = bpy.context.object
    made.name = name
    made.data.materials.append(shown)
    return made


def make(image=None, degrees=40, strength=0.9):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    context, mesh = bpy.context, bpy.ops.mesh
    grey, red = material("grey"), material("red", colour=(0.6, 0.12, 0.1))
    checks = material("checks", image=checked_image())
    gloss = material("gloss", "BSDF_PRINCIPLED", (0.1, 0.25, 0.5), Roughness=0.45, Specular=0.5)

    floor = added(mesh.primitive_grid_add, "Floor", checks, (0, 0, 0), size=8, x_subdivisions=40, y_subdivisions=40)
    box = added(mesh.primitive_cube_add, "Box", red, (-1.4, 0.2, 0.5), size=1)
    box.modifiers.new("bevel", "BEVEL").segments = 2
    box.modifiers.new("finer", "SUBSURF").levels = 2
    ball = added(mesh.primitive_uv_sphere_add, "Ball", gloss, (0.2, -0.6, 0.5), radius=0.5, segments=32, ring_count=16)
    bpy.ops.object.shade_smooth()
    cone = added(mesh.primitive_cone_add, "Cone", grey, (1.5, 0.4, 0.6), radius1=0.5, depth=1.2, vertices=24)
    cone.modifiers.new("finer", "SUBSURF").levels = 1
    monkey = added(mesh.primitive_monkey_add, "Head", grey, (0.1, 1.2, 0.8), size=1)
    monkey.rotation_euler = (math.radians(-20), 0, math.radians(30))
    torus = added(mesh.primitive_torus_add, "Ring", red, (-0.6, -1.5, 0.15), major_radius=0.4, minor_radius=0.15,
                  major_segments=32, minor_segments=12)
    # Linked duplicates: rotated, scaled, mirrored.
    for name, of, place, scale, angle in [
        ("Ball 2", ball, (1.3, -1.3, 0.3), (0.6, 0.6, 0.6), 0),
        ("Head 2", monkey, (-1.6, 1.6, 0.8), (-0.8, 0.8, 0.8), 70),
        ("Ring 2", torus, (2.2, -0.6, 0.15), (1, 1, 1), 45),
        ("Ball 3", ball, (-2.3, -0.7, 0.35), (0.5, 0.5, 0.7), 20),
    ]:
        copy = of.copy()
        copy.name = name
        copy.location, copy.scale = place, scale
        copy.rotation_euler = (0, 0, math.radians(angle))
        context.collection.objects.link(copy)

    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    context.collection.objects.link(camera)
    camera.location = (4.2, -5.4, 3.6)
    camera.rotation_euler = (math.radians(62), 0, math.radians(38))
    camera.data.lens = 40
    context.scene.camera = camera
    context.scene.render.resolution_x, context.scene.render.resolution_y = 160, 120
    context.scene.render.resolution_percentage = 100
    set_world(image or sky_image(), degrees, strength)
    context.view_layer.update()
    assert len([o for o in context.scene.objects if o.type == "MESH"]) == 10
    return context
