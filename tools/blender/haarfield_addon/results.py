"""Displays bakes in Blender: a copy of each object with the light as a colour attribute, and a material for it."""

import bpy
import numpy
from mathutils import Matrix

from .frame import TO_HAARFIELD
from .gather import BAKED
from .shaders import bytes_of, decoded

COLLECTION = "haarfield"
ATTRIBUTE = "haarfield"
OVER = "haarfield over"  # specular light, which is added to textured light
OWNER = "haarfield_owner"  # marks objects that were baked, or that instance baked objects
HIDDEN = "haarfield_hidden"  # marks those of them that are hidden now


def collection_of(scene):
    for collection in scene.collection.children:
        if BAKED in collection:
            return collection
    collection = bpy.data.collections.new(COLLECTION)
    collection[BAKED] = True
    scene.collection.children.link(collection)
    return collection


def copies(scene):
    """Returns the existing copies by the name of their instance."""
    return {
        object[BAKED]: object
        for collection in scene.collection.children
        if BAKED in collection
        for object in collection.objects
        if BAKED in object
    }


def is_shown(scene):
    return any(not copy.hide_render for copy in copies(scene).values())


def remove(copy):
    mesh = copy.data
    bpy.data.objects.remove(copy)
    if mesh.users == 0:
        bpy.data.meshes.remove(mesh)


def linear_image(image):
    """Returns a float copy of an image, because Cycles interpolates bytes as sRGB values, unlike POV-Ray."""
    pixels = decoded(bytes_of(image) / 255)
    height, width = pixels.shape[:2]
    name = f"haarfield {image.name}"
    copy = bpy.data.images.get(name)
    if copy is None or tuple(copy.size) != (width, height):
        copy = bpy.data.images.new(name, width, height, float_buffer=True)
    rgba = numpy.ones((height, width, 4), numpy.float32)
    rgba[..., :3] = pixels[::-1]
    copy.pixels.foreach_set(rgba.ravel())
    copy.pack()
    return copy


def showing_material(name, image, has_over):
    """Returns a material that emits the attribute, times the image, plus specular light, exactly like POV-Ray."""
    name = f"haarfield {name}"
    material = bpy.data.materials.get(name) or bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(emission.outputs["Emission"], output.inputs["Surface"])

    def attribute(name):
        node = tree.nodes.new("ShaderNodeAttribute")
        node.attribute_name = name
        return node.outputs["Color"]

    def mixed(operation, first, second):
        node = tree.nodes.new("ShaderNodeVectorMath")
        node.operation = operation
        tree.links.new(first, node.inputs[0])
        tree.links.new(second, node.inputs[1])
        return node.outputs["Vector"]

    colour = attribute(ATTRIBUTE)
    if image is not None:
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = linear_image(image)
        colour = mixed("MULTIPLY", colour, texture.outputs["Color"])
    if has_over:
        colour = mixed("ADD", colour, attribute(OVER))
    tree.links.new(colour, emission.inputs["Color"])
    return material


def set_colours(mesh, name, colours):
    if name in mesh.color_attributes:
        mesh.color_attributes.remove(mesh.color_attributes[name])
    attribute = mesh.color_attributes.new(name, "FLOAT_COLOR", "POINT")
    rgba = numpy.ones((len(colours), 4), numpy.float32)
    rgba[:, :3] = colours
    attribute.data.foreach_set("color", rgba.ravel())
    return attribute


def mesh_of(baked, gathered, name):
    """Returns a baked mesh as a mesh of Blender, in Blender's frame."""
    mesh = bpy.data.meshes.new(name)
    positions = baked.positions @ TO_HAARFIELD.astype(numpy.float32)
    normals = baked.normals @ TO_HAARFIELD.astype(numpy.float32)
    triangles = baked.triangles.astype(numpy.int32)
    count = len(triangles)
    mesh.vertices.add(len(positions))
    mesh.vertices.foreach_set("co", positions.ravel())
    mesh.loops.add(3 * count)
    mesh.loops.foreach_set("vertex_index", triangles.ravel())
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", 3 * numpy.arange(count, dtype=numpy.int32))
    mesh.polygons.foreach_set("loop_total", numpy.full(count, 3, numpy.int32))
    mesh.polygons.foreach_set("material_index", baked.vertex_materials[triangles[:, 0]].astype(numpy.int32))
    mesh.polygons.foreach_set("use_smooth", numpy.ones(count, bool))
    if baked.uvs is not None:
        layer = mesh.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", baked.uvs[triangles.ravel()].ravel())
    mesh.update(calc_edges=True)
    if hasattr(mesh, "use_auto_smooth"):  # until Blender 4.0
        mesh.use_auto_smooth = True
    mesh.normals_split_custom_set_from_vertices(normals.tolist())
    for slot in baked.materials:
        own = slot.split(" ", 1)[1]
        image = gathered.images[own]
        mesh.materials.append(showing_material(own, image, image is not None and baked.over is not None))
    set_colours(mesh, ATTRIBUTE, baked.under)
    if baked.over is not None:
        set_colours(mesh, OVER, baked.over)
    mesh.color_attributes.active_color = mesh.color_attributes[ATTRIBUTE]
    return mesh


def show(scene, view_layer, baked):
    """Shows the copies and hides the original objects, or vice versa."""

    def set_hidden(object, hidden):
        object.hide_render = hidden
        if object.name in view_layer.objects:
            object.hide_set(hidden, view_layer=view_layer)

    for object in scene.objects:
        if BAKED in object:
            set_hidden(object, not baked)
        elif baked and OWNER in object and not object.hide_render:
            object[HIDDEN] = True
            set_hidden(object, True)
        elif not baked and HIDDEN in object:
            set_hidden(object, False)
            del object[HIDDEN]


def write(scene, view_layer, bake, gathered, changed):
    """Makes the copies of a bake.

    changed  names of the instances whose copies are rebuilt; other copies only get new colours.
    """
    collection = collection_of(scene)
    before = copies(scene)
    for name, copy in before.items():
        if name not in gathered.names or name in changed:
            remove(copy)
    before = copies(scene)
    for number in range(len(bake)):
        baked = bake[number]
        if baked.name in before and len(before[baked.name].data.vertices) == len(baked):
            set_colours(before[baked.name].data, ATTRIBUTE, baked.under)
            if baked.over is not None:
                set_colours(before[baked.name].data, OVER, baked.over)
            continue
        if baked.name in before:
            remove(before[baked.name])
        name = f"{gathered.names[baked.name]} baked"
        copy = bpy.data.objects.new(name, mesh_of(baked, gathered, name))
        copy[BAKED] = baked.name
        collection.objects.link(copy)
        matrix = baked.matrix.copy()
        matrix[:3, :3] = TO_HAARFIELD.T @ matrix[:3, :3] @ TO_HAARFIELD
        matrix[:3, 3] = TO_HAARFIELD.T @ matrix[:3, 3]
        copy.matrix_world = Matrix(matrix.tolist())
    owners = set(gathered.owners)
    for object in scene.objects:
        if object.name in owners:
            object[OWNER] = True
        elif OWNER in object:
            del object[OWNER]
    show(scene, view_layer, True)
