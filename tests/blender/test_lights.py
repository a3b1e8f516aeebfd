"""The Blender add-on's lights: blender -b --factory-startup --python tests/blender/test_lights.py."""

import math
import sys
from pathlib import Path

import bpy
import numpy

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "tools/blender")]

import ten_objects
from haarfield_addon import cycles_check, operators, results
from haarfield_addon.gather import gather
from haarfield_addon.lights import spread_keys
from test_addon import attribute_of, main, small, words


def floor_and_box(folder):
    """Creates a dark scene of a floor and a box that shadows it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    context, mesh = bpy.context, bpy.ops.mesh
    grey = ten_objects.material("grey", colour=(0.5, 0.5, 0.5))
    ten_objects.added(mesh.primitive_grid_add, "Floor", grey, (0, 0, 0), size=4, x_subdivisions=24, y_subdivisions=24)
    ten_objects.added(mesh.primitive_cube_add, "Box", grey, (0.9, 0.3, 0.25), size=0.5)
    settings = small(context, folder)
    settings.cycles_samples = 64
    return context


def add_light(kind, name="Lamp", location=(-0.3, 0.2, 1.8), rotation=(0, 0, 0), scale=(1, 1, 1), **properties):
    light = bpy.data.lights.new(name, kind)
    for key, value in properties.items():
        setattr(light, key, value)
    made = bpy.data.objects.new(name, light)
    bpy.context.collection.objects.link(made)
    made.location, made.rotation_euler, made.scale = location, rotation, scale
    bpy.context.view_layer.update()
    return made


def gathered_warnings():
    return gather(bpy.context).warnings


LIGHTS = {
    "point": ("POINT", {"energy": 60, "shadow_soft_size": 0.1, "color": (1, 0.8, 0.5)}),
    "small point": ("POINT", {"energy": 60, "shadow_soft_size": 0}),
    "spot": ("SPOT", {"energy": 80, "spot_size": 1.2, "spot_blend": 0.6, "shadow_soft_size": 0.02,
                      "rotation": (0.2, 0.1, 0), "scale": (2, 2, 2)}),
    "square": ("AREA", {"energy": 40, "size": 0.5, "rotation": (0.4, 0.3, 0.2)}),
    "rectangle": ("AREA", {"energy": 40, "shape": "RECTANGLE", "size": 0.2, "size_y": 1, "scale": (1, 1.5, 1)}),
    "disk": ("AREA", {"energy": 40, "shape": "DISK", "size": 1, "rotation": (0, -0.5, 0)}),
    "ellipse": ("AREA", {"energy": 40, "shape": "ELLIPSE", "size": 0.3, "size_y": 0.9}),
    "spread": ("AREA", {"energy": 40, "size": 0.2, "spread": 2.0}),
    "sun": ("SUN", {"energy": 3, "angle": 0.0092, "rotation": (0.6, 0.3, 0)}),
    "wide sun": ("SUN", {"energy": 3, "angle": 0.7, "rotation": (0.6, 0.3, 0)}),
    "sharp sun": ("SUN", {"energy": 3, "angle": 0, "rotation": (0.6, 0.3, 0)}),
    "shadowless": ("POINT", {"energy": 60, "use_shadow": False}),
}  # fmt: skip


def errors_of_floor():
    """Returns RMSE and bias of the floor, and Cycles' noise, relative to the RMS of Cycles' values. [%]"""
    assert bpy.ops.haarfield.compare() == {"FINISHED"}
    text = bpy.data.texts[cycles_check.TABLE].as_string()
    line = next(line for line in text.splitlines() if line.startswith("Floor"))
    numbers = words(line)[-9:]
    return numbers[0], numbers[2], numbers[6]


def test_each_light_is_as_bright_as_in_cycles(folder):
    wrong = []
    for name, (kind, properties) in LIGHTS.items():
        floor_and_box(folder)
        add_light(kind, **properties)
        rmse, bias, noise = errors_of_floor()
        print(f"{name:<12} RMSE {rmse:.2f} %, bias {bias:+.2f} %, Cycles' noise {noise:.2f} %")
        if name == "spread":
            bias_limit, rmse_limit = 1, 3 + noise
        else:
            bias_limit, rmse_limit = 0.5, 1 + noise
        if abs(bias) > bias_limit or rmse > rmse_limit:
            wrong.append(name)
    assert not wrong, wrong


def test_instanced_and_several_lights_add_up_as_in_cycles(folder):
    context = floor_and_box(folder)
    lamp = add_light("POINT", energy=20)
    inside = bpy.data.collections.new("inside")
    context.collection.objects.unlink(lamp)
    inside.objects.link(lamp)
    # With an object in the collection, its owner is hidden while the copies are visible.
    context.collection.objects.unlink(bpy.data.objects["Box"])
    inside.objects.link(bpy.data.objects["Box"])
    for number in range(2):
        empty = bpy.data.objects.new(f"Pair {number}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", inside
        empty.location, empty.rotation_euler = (0.5 * number, 0, 0.2 * number), (0, 0, number)
        context.collection.objects.link(empty)
    add_light("SUN", "Sun", energy=1)
    hidden = add_light("SUN", "Hidden", energy=10)
    hidden.hide_render = True
    context.view_layer.update()
    names = {lamp["name"] for lamp in gather(context).description["lights"]}
    assert names == {"Sun", "Pair 0.Lamp", "Pair 1.Lamp"}, names
    objects = set(bpy.data.objects.keys())
    rmse, bias, noise = errors_of_floor()
    print(f"RMSE {rmse:.2f} %, bias {bias:+.2f} %, Cycles' noise {noise:.2f} %")
    assert abs(bias) < 1 and rmse < 4 + noise
    assert {name for name in bpy.data.objects.keys() if not name.endswith(" baked")} == objects


def test_constants_of_light_nodes_scale_the_light(folder):
    floor_and_box(folder)
    lamp = add_light("POINT", energy=20)
    before = gather(bpy.context).description["lights"][0]["colour"]
    lamp.data.use_nodes = True
    node = next(node for node in lamp.data.node_tree.nodes if node.type == "EMISSION")
    node.inputs["Strength"].default_value, node.inputs["Color"].default_value = 3, (0.5, 1, 1, 1)
    after = gather(bpy.context).description["lights"][0]["colour"]
    assert numpy.allclose(after, numpy.array(before) * (1.5, 3, 3), rtol=1e-5)
    assert errors_of_floor()[1] < 1


def test_a_changed_light_is_shaded_without_new_fields(folder):
    context = floor_and_box(folder)
    lamp = add_light("POINT", energy=20)
    context.scene.haarfield.error = 0
    bpy.ops.haarfield.bake()
    before = attribute_of(results.copies(context.scene)["Floor"])
    fields = {file: file.stat().st_mtime_ns for file in (folder / "fields").iterdir()}
    lamp.data.energy = 40
    bpy.ops.haarfield.bake()
    assert numpy.allclose(attribute_of(results.copies(context.scene)["Floor"]), 2 * before, rtol=0.01, atol=1e-3)
    assert {file: file.stat().st_mtime_ns for file in (folder / "fields").iterdir()} == fields


def test_a_world_without_a_surface_shader_is_black(folder):
    floor_and_box(folder)
    world = bpy.data.worlds.new("Bare")
    bpy.context.scene.world = world
    world.use_nodes = True
    world.node_tree.nodes.clear()
    add_light("POINT", energy=20)
    gathered = gather(bpy.context)
    assert not gathered.description["environment"]["image"].any()
    assert [warning for warning in gathered.warnings if "World 'Bare': it has no surface shader" in warning]


def test_vertices_inside_others_are_not_compared_with_cycles(folder):
    floor_and_box(folder)
    objects = {name: bpy.data.objects[name] for name in ("Floor", "Box")}
    masks = cycles_check.vertices_in_others(objects)
    inside = numpy.array([vertex.co for vertex in objects["Floor"].data.vertices])[masks["Floor"]]
    assert len(inside) == 9 and (abs(inside - (0.9, 0.3, 0)).max(axis=0) < 0.25).all()
    assert not masks["Box"].any()


def test_what_is_left_out_is_named_once(folder):
    context = floor_and_box(folder)
    portal = add_light("AREA", "Window")
    portal.data.cycles.is_portal = True
    photometric = add_light("POINT", "Photometric")
    photometric.data.use_nodes = True
    tree = photometric.data.node_tree
    node = next(node for node in tree.nodes if node.type == "EMISSION")
    tree.links.new(tree.nodes.new("ShaderNodeTexIES").outputs["Fac"], node.inputs["Strength"])
    add_light("POINT", "Shadowless", use_shadow=False, specular_factor=0.5)
    add_light("AREA", "Narrow", spread=1.0)
    add_light("SPOT", "Plain")
    bpy.data.objects["Box"].modifiers.new("Fur", "PARTICLE_SYSTEM")
    bpy.data.objects["Box"].particle_systems[0].settings.type = "HAIR"
    fog = ten_objects.added(bpy.ops.mesh.primitive_cube_add, "Fog", bpy.data.materials.new("fog"), (0, 0, 0), size=9)
    tree = fog.material_slots[0].material
    tree.use_nodes = True
    tree = tree.node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.remove(output.inputs["Surface"].links[0])
    tree.links.new(tree.nodes.new("ShaderNodeVolumePrincipled").outputs[0], output.inputs["Volume"])
    bpy.ops.object.volume_add()
    context.object.name = "Cloud"
    context.view_layer.update()
    gathered = gather(context)
    print("\n".join(gathered.warnings))
    assert not {"Fog", "Cloud"} & set(gathered.names.values())
    for part in (
        "Light 'Window': is a portal",
        "Light 'Photometric': its Strength from IES Texture is ignored",
        "Light 'Shadowless': casts no shadows",
        "Light 'Shadowless': its specular factor is ignored",
        "Light 'Narrow': its spread of 57 degrees",
        "Object 'Box': its hair",
        "Object 'Fog': is a volume",
        "Object 'Cloud': is a volume",
    ):
        assert sum(part in warning for warning in gathered.warnings) == 1, (part, gathered.warnings)
    assert not any("Plain" in warning for warning in gathered.warnings)


def test_warnings_and_errors_name_the_object(folder):
    context = floor_and_box(folder)
    add_light("SUN")
    material = bpy.data.objects["Box"].material_slots[0].material
    material.use_nodes = True
    tree = material.node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(tree.nodes.new("ShaderNodeBsdfGlass").outputs[0], output.inputs["Surface"])
    assert any("Object 'Floor': Material 'grey': its surface is Glass" in text for text in gathered_warnings())
    bpy.data.objects["Box"].data.vertices[0].co.x = math.nan
    bpy.data.objects["Box"].data.name = "Cube.001"
    try:
        bpy.ops.haarfield.bake()
    except RuntimeError as error:
        assert "Box" in str(error), error
    else:
        raise AssertionError("a mesh with a NaN was baked")


def test_a_plane_as_it_is_shows_the_shadow_in_its_middle(folder):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    context = bpy.context
    grey = ten_objects.material("grey")
    ten_objects.added(bpy.ops.mesh.primitive_plane_add, "Floor", grey, (0, 0, 0), size=10)
    ten_objects.added(bpy.ops.mesh.primitive_cube_add, "Box", grey, (0, 0, 0.6), size=1)
    add_light("SUN", energy=3, angle=0.02)
    settings = context.scene.haarfield
    settings.folder, settings.samples = str(folder), 600
    assert bpy.ops.haarfield.bake() == {"FINISHED"}
    floor = results.copies(context.scene)["Floor"]
    positions = numpy.array([vertex.co[:2] for vertex in floor.data.vertices])
    light = attribute_of(floor)[:, 0]
    assert len(positions) >= 500
    under = abs(positions).max(axis=1) < 0.4
    outside = abs(positions).max(axis=1) > 1.5
    assert under.any() and light[under].max() < 0.2 * light[outside].min()


def test_a_spread_keeps_the_light_of_its_lamp(folder):
    for degrees in (20, 60, 100, 140, 170):
        half = math.radians(degrees) / 2
        keys, axial, error = spread_keys(2 * half)
        angle = (numpy.arange(4000) + 0.5) / 4000 * half
        edge, begin = (math.cos(math.radians(keys[name])) for name in ("falloff", "radius"))
        t = numpy.clip((numpy.cos(angle) - edge) / (begin - edge), 0, 1)
        shape = t * t * (3 - 2 * t) * numpy.cos(angle) ** keys["tightness"]
        flux = axial * 2 * (shape * numpy.sin(angle)).sum() * half / 4000
        print(f"spread {degrees}: differs by {100 * error:.1f} %")
        assert abs(flux - 1) < 0.02 and error < 0.15, (degrees, flux, error)


if __name__ == "__main__":
    sys.stdout.flush()
    code = main(globals())
    sys.stdout.flush()
    sys.exit(code)
