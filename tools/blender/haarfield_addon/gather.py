"""Converts Blender's scene to a scene of haarfield."""

import hashlib

import numpy

import haarfield

from .frame import TO_HAARFIELD
from .lights import lamp_of
from .shaders import Refusal, is_volume, material_of, world_of

# Marks objects that a bake made.
BAKED = "haarfield_baked"

GEOMETRY = {"MESH", "CURVE", "SURFACE", "FONT", "META"}

# Objects that Cycles renders and haarfield ignores.
LEFT_OUT = {"CURVES": "hair", "VOLUME": "a volume", "POINTCLOUD": "a point cloud", "GPENCIL": "a grease pencil"}


class Gathered:
    """A scene, and the data that is needed to display its bake."""

    def __init__(self):
        self.description = {}
        self.names = {}  # by instance: names of the objects
        self.owners = set()  # names of the objects that were baked, or that instance baked objects
        self.images = {}  # by material: images of the image texture nodes
        self.materials = {}  # by haarfield's names: Blender's materials
        self.warnings = []
        self.lights = []  # (object, matrix_world, its owner's name)
        self.digests = {}  # of all data that affects the bake, by instance, "light" and "camera"


def digest_of(*parts):
    made = hashlib.blake2b(digest_size=16)
    for part in parts:
        made.update(part.tobytes() if isinstance(part, numpy.ndarray) else repr(part).encode())
        made.update(b"\0")
    return made.hexdigest()


def table_digest(table):
    return digest_of(*(part for key in sorted(table) for part in (key, table[key])))


def arrays_of(mesh):
    """Returns a mesh's distinct corners with normals, uvs and materials, in haarfield's frame."""
    mesh.calc_loop_triangles()
    if hasattr(mesh, "calc_normals_split"):  # until Blender 4.0
        mesh.calc_normals_split()
    count = len(mesh.loop_triangles)
    if count == 0:
        return None

    def taken(collection, name, kind, width):
        values = numpy.empty(len(collection) * width, kind)
        collection.foreach_get(name, values)
        return values.reshape(-1, width) if width > 1 else values

    positions = taken(mesh.vertices, "co", numpy.float32, 3)
    if hasattr(mesh, "corner_normals"):
        normals = taken(mesh.corner_normals, "vector", numpy.float32, 3)
    else:
        normals = taken(mesh.loops, "normal", numpy.float32, 3)
    vertices = taken(mesh.loops, "vertex_index", numpy.int32, 1)
    triangles = taken(mesh.loop_triangles, "loops", numpy.int32, 3)
    materials = taken(mesh.loop_triangles, "material_index", numpy.int32, 1)
    columns = [positions[vertices], normals]
    if mesh.uv_layers.active:
        columns.append(taken(mesh.uv_layers.active.data, "uv", numpy.float32, 2))
    corners = numpy.ascontiguousarray(numpy.hstack(columns) + 0.0)  # no -0
    rows = corners.view(numpy.dtype((numpy.void, corners.dtype.itemsize * corners.shape[1]))).ravel()
    _, first, number = numpy.unique(rows, return_index=True, return_inverse=True)
    unique = corners[first]
    turned = TO_HAARFIELD.astype(numpy.float32)
    return {
        "positions": unique[:, :3] @ turned.T,
        "triangles": number[triangles],
        "normals": unique[:, 3:6] @ turned.T,
        "uvs": numpy.ascontiguousarray(unique[:, 6:8]) if unique.shape[1] > 6 else None,
        "triangle_materials": materials,
    }


def mesh_table(name, arrays, slots, of_triangles):
    """Returns an object's mesh for a scene of haarfield."""
    try:
        return haarfield.Mesh(
            arrays["positions"],
            arrays["triangles"],
            arrays["normals"],
            arrays["uvs"],
            materials=slots,
            triangle_materials=of_triangles,
        )
    except ValueError as error:
        raise Refusal(f"Object '{name}': {error}") from error


def matrix_of(matrix_world, name):
    """Returns a transform as rows, in haarfield's frame."""
    matrix = numpy.array(matrix_world, float)
    stretch = numpy.linalg.svd(matrix[:3, :3], compute_uv=False)
    if not numpy.isfinite(matrix).all() or stretch[2] < 1e-6 or stretch[0] > 1e4 * stretch[2]:
        raise Refusal(f"Object '{name}': its scale is almost zero along an axis; expected positive scales")
    rows = numpy.empty((3, 4))
    rows[:, :3] = TO_HAARFIELD @ matrix[:3, :3] @ TO_HAARFIELD.T
    rows[:, 3] = TO_HAARFIELD @ matrix[:3, 3]
    return rows.tolist()


def camera_of(scene, warnings):
    """Returns the active camera as a table; only the resolution if haarfield does not support the camera."""
    render = scene.render
    scale = render.resolution_percentage / 100
    resolution = [max(1, int(render.resolution_x * scale)), max(1, int(render.resolution_y * scale))]
    camera = scene.camera
    if camera is None or camera.type != "CAMERA" or camera.data.type != "PERSP":
        found = f"Camera '{camera.name}' is not a perspective camera" if camera else "The scene has no camera"
        warnings.append(f"{found}: haarfield chooses a view")
        return {"resolution": resolution}
    corners = [numpy.array(corner) for corner in camera.data.view_frame(scene=scene)]
    height = max(c[1] for c in corners) - min(c[1] for c in corners)
    middle = sum(corners) / 4
    if abs(middle[0]) + abs(middle[1]) > 1e-5:
        warnings.append(f"Camera '{camera.name}': its shift is ignored")
    matrix = numpy.array(camera.matrix_world, float)
    axes = matrix[:3, :3] / numpy.linalg.norm(matrix[:3, :3], axis=0)
    if abs(axes[2, 0]) > 1e-3:
        warnings.append(f"Camera '{camera.name}': its roll is ignored; POV-Ray's picture is level")
    position = TO_HAARFIELD @ matrix[:3, 3]
    return {
        "position": position.tolist(),
        "target": (position - TO_HAARFIELD @ axes[:, 2]).tolist(),
        "vertical_fov": float(numpy.degrees(2 * numpy.arctan2(height / 2, -corners[0][2]))),
        "resolution": resolution,
    }


def plain_name(name, taken):
    """Returns a valid and unused name for files."""
    plain = "".join(c if c.isprintable() and c not in "/\\" else "_" for c in name).lstrip(".-")[:80] or "object"
    result, number = plain, 1
    while result in taken:
        number += 1
        result = f"{plain}_{number}"
    taken.add(result)
    return result


def rendered_instances(context):
    """Yields all evaluated objects that are visible in the view layer and in renders, with their transforms."""
    depsgraph = context.evaluated_depsgraph_get()
    for instance in depsgraph.object_instances:
        made = instance.object
        original = made.original
        owner = instance.parent.original if instance.is_instance else original
        if BAKED in original or original.hide_render or owner.hide_render or not instance.show_self:
            continue
        name = f"{owner.name}.{original.name}" if instance.is_instance else original.name
        yield name, owner, made, instance.matrix_world.copy()


def report_hair(made, name, warnings):
    """Warns about an object whose particles are drawn as strands, which are not part of its mesh."""
    for system in made.particle_systems:
        settings = system.settings
        if settings.type == "HAIR" and settings.render_type == "PATH":
            warnings.append(f"Object '{name}': its hair '{system.name}' is ignored")


def is_geometry(made, name, warnings):
    """Tests whether an object has faces to bake. Warns if it is ignored."""
    original = made.original
    if made.type in LEFT_OUT:
        warnings.append(f"Object '{name}': is {LEFT_OUT[made.type]}, which is ignored")
        return False
    if made.type not in GEOMETRY or (made.type == "MESH" and original.type != "MESH"):
        return False  # the mesh of a text, curve, surface or metaball, which is listed itself
    report_hair(made, original.name, warnings)
    materials = [slot.material for slot in made.material_slots]
    if materials and all(is_volume(material) for material in materials):
        warnings.append(f"Object '{name}': is a volume, which is ignored")
        return False
    return True


def extent_of(instances, radii):
    """Returns an upper bound of the distance from the origin to the instances' vertices. [m]

    radii  by entity: the largest distance from its origin to a vertex.
    """
    extent = 0.0
    for instance in instances:
        rows = numpy.array(instance["matrix"])
        size = numpy.linalg.norm(rows[:, :3], 2) * radii[instance["entity"]]
        extent = max(extent, float(numpy.linalg.norm(rows[:, 3]) + size))
    return extent


def faces_of(positions, triangles):
    """Returns the value of an entity's key `faces`. A closed mesh whose faces point inwards is a room."""
    _, merged = numpy.unique(positions, axis=0, return_inverse=True)
    corners = merged.reshape(-1)[triangles]
    edges = numpy.concatenate([corners[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    forwards, backwards = (numpy.sort(e[:, 0].astype(numpy.int64) * len(positions) + e[:, 1]) for e in (edges, edges[:, ::-1]))
    a, b, c = (numpy.asarray(positions, dtype=float)[triangles[:, k]] - positions[0] for k in range(3))
    is_room = numpy.array_equal(forwards, backwards) and numpy.sum(a * numpy.cross(b, c)) < 0
    return "inwards" if is_room else "outwards"


class Gatherer:
    def __init__(self, context, error):
        self.context = context
        self.settings = context.scene.haarfield
        self.error = error
        self.result = Gathered()
        self.entities = {}  # by digest: names
        self.known = {}  # by original mesh, if not modified: digests
        self.tables = {}
        self.radii = {}  # of entities [m]
        self.materials = {}
        self.names = {"entity": set(), "instance": set(), "material": set(), "light": set()}

    def gathered(self):
        scene, result = self.context.scene, self.result
        instances = []
        lights = []
        for name, owner, made, matrix in rendered_instances(self.context):
            if made.type == "LIGHT":
                lights.append((name, made.original, matrix))
                result.lights.append((made.original, matrix, owner.name))
                continue
            if self.settings.objects == "SELECTED" and not (owner.select_get() or made.original.select_get()):
                continue
            if not is_geometry(made, name, result.warnings):
                continue
            entity = self.entity(name, made)
            if entity is None:
                continue
            own = plain_name(name, self.names["instance"])
            result.names[own] = name
            result.owners.add(owner.name)
            rows = matrix_of(matrix, name)
            instances.append({"entity": entity, "name": own, "matrix": rows})
            result.digests[own] = digest_of(entity, self.tables[entity][1], rows)
        if not instances:
            raise Refusal("Nothing to bake; expected a visible mesh with faces")
        lamps = self.lamps(lights, extent_of(instances, self.radii))
        emits = any("emission" in table for _, table in self.materials.values())
        light = world_of(scene.world, bool(lamps) or emits, result.warnings)
        camera = camera_of(scene, result.warnings)
        result.description = {
            "camera": camera,
            "environment": light,
            "materials": {name: table for name, table in self.materials.values()},
            "entities": {name: table for name, (table, _) in self.tables.items()},
            "instances": instances,
            "lights": lamps,
        }
        result.digests["light"] = digest_of(table_digest(light), *(table_digest(lamp) for lamp in lamps))
        result.digests["camera"] = table_digest(camera)
        settings = self.settings
        result.digests["settings"] = digest_of(settings.vertices, self.error, settings.samples)
        result.warnings = list(dict.fromkeys(result.warnings))
        return result

    def lamps(self, lights, extent):
        tables = []
        for name, light, matrix in lights:
            table = lamp_of(light, matrix, name, extent, self.result.warnings)
            if table is not None:
                tables.append({"name": plain_name(name, self.names["light"]), **table})
        return tables

    def material(self, slot_material, user):
        """Returns a material's name and table. Warnings name the first object that uses the material."""
        key = slot_material.name if slot_material else None
        if key not in self.materials:
            found = []
            try:
                table, image = material_of(slot_material, found)
            except Refusal as refusal:
                raise Refusal(f"Object '{user}': {refusal}") from refusal
            self.result.warnings += [f"Object '{user}': {warning}" for warning in found]
            name = plain_name(key or "default", self.names["material"])
            self.materials[key] = (name, table)
            self.result.materials[name] = slot_material
            self.result.images[name] = image.image if image else None
        return self.materials[key]

    def entity(self, name, made):
        """Returns the name of an object's entity, which objects with equal meshes and materials share."""
        slots = [slot.material for slot in made.material_slots] or [None]
        materials = [self.material(material, name) for material in slots]
        original = made.original
        shared = None
        if original.type == "MESH" and not original.modifiers and original.data.shape_keys is None:
            shared = (original.data.name_full, tuple(own for own, _ in materials))
        if shared in self.known:
            return self.known[shared]
        mesh = made.to_mesh()
        try:
            arrays = arrays_of(mesh)
        finally:
            made.to_mesh_clear()
        if arrays is None:
            return None
        names = [own for own, _ in materials]
        of_triangles = numpy.clip(arrays["triangle_materials"], 0, len(names) - 1)
        if arrays["uvs"] is None:
            missing = [own for own, table in materials if "image" in table]
            if missing:
                raise Refusal(f"Object '{name}': has no UV map for the image of its material '{missing[0]}'")
        digest = digest_of(
            *(arrays[key] for key in ("positions", "triangles", "normals")),
            arrays["uvs"] if arrays["uvs"] is not None else 0,
            of_triangles,
            [table_digest(table) for _, table in materials],
            names,
        )
        if digest not in self.entities:
            entity = plain_name(name, self.names["entity"])  # errors and warnings name an object
            # two slots may have the same material
            slots_of = [f"{number} {own}" for number, own in enumerate(names)]
            used = sorted(set(of_triangles.tolist()))
            self.entities[digest] = entity
            self.radii[entity] = float(numpy.linalg.norm(arrays["positions"], axis=1).max())
            self.tables[entity] = (
                {
                    "mesh": mesh_table(name, arrays, slots_of, of_triangles),
                    "materials": {slots_of[number]: names[number] for number in used},
                    "faces": faces_of(arrays["positions"], arrays["triangles"]),
                    "fine_vertices": max(1, self.settings.vertices),
                    "planar_samples": max(1, self.settings.samples * 2 // 3),
                    "spherical_samples": max(1, self.settings.samples // 3),
                },
                digest,
            )
        if shared is not None:
            self.known[shared] = self.entities[digest]
        return self.entities[digest]


def gather(context, error=None):
    """Returns all data that a bake needs from Blender, with warnings. Raises Refusal if the scene cannot be baked.

    error  overrides the settings.
    """
    return Gatherer(context, context.scene.haarfield.error if error is None else error).gathered()
