"""Compares bakes with Cycles: direct diffuse light at the vertices of the baked copies."""

import time

import bpy
import numpy
from mathutils import Vector

from . import results
from .lights import casts_shadows

ATTRIBUTE = "cycles"
TABLE = "haarfield and Cycles"


def diffuse_material(name, colour):
    """Returns a Lambertian material like haarfield's diffuse term. The Principled BSDF's depends on roughness."""
    material = bpy.data.materials.new(f"cycles {name}")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = (*colour, 1)
    tree.links.new(shader.outputs["BSDF"], output.inputs["Surface"])
    return material


def bake_seconds(scene, seed):
    scene.cycles.seed = seed
    start = time.perf_counter()
    bpy.ops.object.bake(type="DIFFUSE", pass_filter={"DIRECT", "COLOR"}, target="VERTEX_COLORS")
    return time.perf_counter() - start


def colours_of(mesh):
    values = numpy.empty(4 * len(mesh.vertices), numpy.float32)
    mesh.color_attributes[ATTRIBUTE].data.foreach_get("color", values)
    return values.reshape(-1, 4)[:, :3].copy()


def is_closed(mesh):
    """True if each edge has two faces. Vertices at one place count as one: bakes split them at sharp edges."""
    places = [tuple(round(c, 5) for c in vertex.co) for vertex in mesh.vertices]
    edges = {frozenset((places[a], places[b])) for a, b in (edge.vertices for edge in mesh.edges)}
    return len(mesh.loops) == 2 * len(edges)


def vertices_in_others(copies):
    """Returns for each object a mask of the vertices inside closed objects: black in Cycles, filled in bakes."""
    masks = {}
    for name, object in copies.items():
        inside = numpy.zeros(len(object.data.vertices), bool)
        # Vertices on a surface of the other object count as inside if their own side is.
        offset = 1e-4 * max(object.dimensions)
        for other in copies.values():
            if other == object or not is_closed(other.data):
                continue
            corners = numpy.array([other.matrix_world @ Vector(corner) for corner in other.bound_box])
            lower, upper = corners.min(axis=0), corners.max(axis=0)
            to_other = other.matrix_world.inverted()
            for index, vertex in enumerate(object.data.vertices):
                normal = (object.matrix_world.to_3x3() @ vertex.normal).normalized()
                place = object.matrix_world @ vertex.co + offset * normal
                if (numpy.array(place) < lower).any() or (numpy.array(place) > upper).any():
                    continue
                found, near, outwards, _ = other.closest_point_on_mesh(to_other @ place)
                inside[index] |= found and (to_other @ place - near).dot(outwards) < 0
        masks[name] = inside
    return masks


def shown_lights(scene, gathered):
    """Adds copies of the lights of instances that are hidden while the baked copies are shown."""
    made = []
    for object, matrix, owner in gathered.lights:
        if owner in gathered.owners:
            copy = object.copy()
            copy.parent = None
            scene.collection.objects.link(copy)
            copy.matrix_world = matrix
            made.append(copy)
    return made


def compared(context, bake, sums, gathered):
    """Bakes the copies twice with Cycles, with different seeds. The difference measures the noise.

    bake     the bake with the pass diffuse.
    sums     the same bake by plain sums over exact visibility.
    returns  for each instance a dict of name, haarfield, sums, cycles and noise (n, 3 each), seconds; without
             the vertices inside other objects.
    """
    scene = context.scene
    copies = results.copies(scene)
    before = {
        (scene.render, "engine"): scene.render.engine,
        (scene.cycles, "samples"): scene.cycles.samples,
        (scene.cycles, "seed"): scene.cycles.seed,
        (scene.cycles, "use_adaptive_sampling"): scene.cycles.use_adaptive_sampling,
        (scene.cycles, "use_denoising"): scene.cycles.use_denoising,
        (scene.cycles, "sample_clamp_direct"): scene.cycles.sample_clamp_direct,
        (scene.render.bake, "margin"): scene.render.bake.margin,
    }
    scene.render.engine = "CYCLES"
    scene.cycles.samples = scene.haarfield.cycles_samples
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.cycles.sample_clamp_direct = 0
    for object, _, _ in gathered.lights:
        if hasattr(object.data.cycles, "cast_shadow"):  # Cycles' own, until Blender 4.2
            before[object.data.cycles, "cast_shadow"] = object.data.cycles.cast_shadow
            object.data.cycles.cast_shadow = casts_shadows(object.data)
    shown = shown_lights(scene, gathered)
    materials, made = {}, []
    tables = gathered.description["materials"]
    for object in copies.values():
        materials[object] = [slot.material for slot in object.material_slots]
        for slot in object.material_slots:
            own = slot.material.name.removeprefix("haarfield ")
            replaced = diffuse_material(own, tables[own]["diffuse"])
            made.append(replaced)
            slot.material = replaced
    selected = [object for object in context.view_layer.objects if object.select_get()]
    active = context.view_layer.objects.active
    try:
        for object in context.view_layer.objects:
            object.select_set(object in copies.values())
        context.view_layer.objects.active = next(iter(copies.values()))
        for object in copies.values():
            attribute = results.set_colours(object.data, ATTRIBUTE, numpy.zeros((len(object.data.vertices), 3)))
            object.data.color_attributes.active_color = attribute
        seconds, values = [], []
        for seed in (1, 2):
            seconds.append(bake_seconds(scene, seed))
            values.append({name: colours_of(object.data) for name, object in copies.items()})
    finally:
        for object, slots in materials.items():
            for slot, material in zip(object.material_slots, slots):
                slot.material = material
            object.data.color_attributes.active_color = object.data.color_attributes[results.ATTRIBUTE]
        for material in made:
            bpy.data.materials.remove(material)
        for object in shown:
            bpy.data.objects.remove(object)
        for (owner, name), value in before.items():
            setattr(owner, name, value)
        for object in context.view_layer.objects:
            object.select_set(object in selected)
        context.view_layer.objects.active = active
    rows = []
    hidden = vertices_in_others(copies)
    for name in copies:
        first, second = (of_seed[name][~hidden[name]] for of_seed in values)
        rows.append(
            {
                "name": gathered.names[name],
                "haarfield": bake[name].passes["diffuse"][~hidden[name]],
                "sums": sums[name].passes["diffuse"][~hidden[name]],
                "cycles": (first + second) / 2,
                "noise": (first - second) / 2,
                "seconds": seconds,
            }
        )
    return rows


def figures_of(rows):
    """Returns RMSE, median and bias of haarfield, of the sums and of Cycles' noise, in this order, relative to Cycles.

    RMSE and median are relative to the RMS of all values.
    """
    theirs = numpy.concatenate([row["cycles"] for row in rows])
    size = numpy.sqrt((theirs**2).mean())
    figures = []
    for kind in ("haarfield", "sums", "noise"):
        difference = numpy.concatenate([row[kind] for row in rows]) - (0 if kind == "noise" else theirs)
        error = numpy.sqrt((difference**2).mean(axis=1)) / size
        figures += [numpy.sqrt((error**2).mean()), numpy.median(error), difference.mean() / theirs.mean()]
    return figures


def write_table(scene, rows, seconds):
    """Writes the table into a text of Blender. Returns the text's name."""
    text = bpy.data.texts.get(TABLE) or bpy.data.texts.new(TABLE)
    text.clear()
    text.write(
        "Direct diffuse light at the vertices compared with Cycles, in percent of the RMS of Cycles' values.\n"
        "baked: haarfield's bake.  sums: haarfield's plain sums over exact visibility.\n"
        "noise: the error of the mean of Cycles' two bakes, estimated as half of their difference.\n\n"
    )
    text.write(f"{'':<24} {'':>9}{'baked':>24}{'sums':>24}{'noise':>24}\n")
    text.write(f"{'object':<24} {'vertices':>9}" + 3 * f"{'RMSE':>10}{'median':>7}{'bias':>7}" + "\n")
    for name, part in [*((row["name"], [row]) for row in rows), ("all", rows)]:
        figures = [100 * figure for figure in figures_of(part)]
        vertices = sum(len(row["cycles"]) for row in part)
        text.write(f"{name[:24]:<24} {vertices:>9}")
        for rmse, median, bias in zip(*[iter(figures)] * 3):
            text.write(f"{rmse:>10.2f}{median:>7.2f}{bias:>+7.2f}")
        text.write("\n")
    cycles = sum(rows[0]["seconds"])
    text.write(
        f"\nhaarfield, all light: {seconds:.2f} s.  Cycles, 2 x {scene.haarfield.cycles_samples} samples: {cycles:.2f} s.\n"
    )
    return text.name
