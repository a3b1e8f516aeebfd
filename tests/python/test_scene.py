"""Scenes: files, dicts and arrays, and messages about errors in them."""

import numpy
import pytest
from conftest import SOURCE, box_arrays, description, floor_arrays, sky_pixels

import haarfield


def changed(path, value):
    """Returns the description with one value replaced."""
    result = description()
    inside = result
    for key in path[:-1]:
        inside = inside[key]
    inside[path[-1]] = value
    return result


def test_an_opened_file_has_its_names():
    scene = haarfield.open(SOURCE / "scenes/single_chair.toml")
    assert scene.name == "single_chair"
    assert scene.instances == ["floor", "chair"]
    assert scene.description["entities"]["chair"]["fine_vertices"] == 12000


def test_changes_replace_keys_of_the_file():
    changes = {"environment": {"sky": None, "image": sky_pixels()}, "camera": {"resolution": [10, 20]}}
    scene = haarfield.open(SOURCE / "scenes/single_chair.toml", changes)
    assert scene.description["camera"]["resolution"] == [10, 20]
    assert scene.description["camera"]["vertical_fov"] == 36
    assert "sky" not in scene.description["environment"]


def test_a_description_is_a_scene(scene):
    assert scene.instances == ["floor", "left", "right"]
    camera = scene.camera()
    assert camera["position"] == pytest.approx((3, 2.5, 4))
    assert camera["vertical_fov"] == pytest.approx(35)
    assert scene.environment().shape == (16, 32, 3)


def test_a_missing_camera_is_placed():
    without = description()
    del without["camera"]
    position = haarfield.scene(without).camera()["position"]
    assert position[1] > 1


@pytest.mark.parametrize(
    "path, value, said",
    [
        (("materials", "red", "diffuse"), [0.5, 1.5, 0], "materials.red.diffuse[1] is 1.5; expected"),
        (("materials", "red", "diffuse"), numpy.array([0.5, numpy.nan, 0]), "diffuse[1] is nan; expected"),
        (("materials", "red", "shine"), 1, "materials.red.shine is not known; expected one of"),
        (("entities", "box", "material"), "blue", 'is "blue"; there is no such material'),
        (("instances", 1, "entity"), "ball", 'is "ball"; there is no such entity'),
        (("instances", 1, "scale"), 0, "scale is 0; expected"),
        (("environment",), {}, "environment has neither image nor sky"),
        (("environment", "exposure"), float("inf"), "exposure is inf; expected"),
        (("entities", "box", "mesh"), "nowhere.obj", "there is no such file"),
    ],
)
def test_invalid_scenes_are_errors(path, value, said):
    with pytest.raises(haarfield.Error) as raised:
        haarfield.scene(changed(path, value))
    assert said in str(raised.value)
    assert raised.value.where == "scene"


@pytest.mark.parametrize("value", [object(), {1: 2}, b"bytes", 1j, [object()]])
def test_values_of_other_types_are_type_errors(value):
    with pytest.raises(TypeError, match="materials.red"):
        haarfield.scene(changed(("materials", "red", "diffuse"), value))


@pytest.mark.parametrize("shape", [(4, 2, 3), (2, 4, 4), (8, 4, 3), (4,), (0, 0, 3)])
def test_environments_of_other_shapes_are_refused(shape):
    with pytest.raises(ValueError, match="environment.image has the shape"):
        haarfield.scene(changed(("environment", "image"), numpy.zeros(shape)))


def test_invalid_pixels_of_environments_are_repaired_with_a_warning():
    pixels = sky_pixels()
    pixels[2, 3] = -1
    pixels[4, 5] = numpy.nan
    with pytest.warns(haarfield.Warning, match="3 negative and 3 non-finite"):
        haarfield.scene(changed(("environment", "image"), pixels)).prepare()


def test_errors_of_files_name_the_place():
    with pytest.raises(haarfield.Error) as raised:
        haarfield.open("nowhere.toml")
    assert raised.value.where == "nowhere.toml"
    assert "no such file" in raised.value.what


BOX = box_arrays()
BAD_MESHES = [
    (dict(positions=BOX[0][:, :2], triangles=BOX[1]), ValueError, "positions has the shape (8, 2); expected (N, 3)"),
    (dict(positions=BOX[0] * numpy.nan, triangles=BOX[1]), ValueError, "positions[0, 0] is nan"),
    (dict(positions="no", triangles=BOX[1]), TypeError, "positions has elements of type"),
    (dict(positions=None, triangles=BOX[1]), TypeError, "positions has elements of type object"),
    (dict(positions=BOX[0] + 1j, triangles=BOX[1]), TypeError, "complex"),
    (dict(positions=[[1, 2], [3]], triangles=BOX[1]), (TypeError, ValueError), "positions"),
    (dict(positions=BOX[0], triangles=BOX[1] + 1), ValueError, "triangles contains 8; expected whole numbers from 0 to 7"),
    (dict(positions=BOX[0], triangles=-BOX[1]), ValueError, "triangles contains -1"),
    (dict(positions=BOX[0], triangles=BOX[1] * 0.5), TypeError, "triangles has elements of type float64"),
    (dict(positions=BOX[0], triangles=BOX[1][:, :2]), ValueError, "triangles has the shape (12, 2); expected (N, 3)"),
    (dict(positions=BOX[0], triangles=BOX[1][:0]), ValueError, "triangles is empty"),
    (dict(positions=BOX[0], triangles=BOX[1], normals=BOX[0][:4]), ValueError, "normals has the shape (4, 3)"),
    (dict(positions=BOX[0], triangles=BOX[1], uvs=BOX[0]), ValueError, "uvs has the shape (8, 3)"),
    (dict(positions=BOX[0], triangles=BOX[1], materials=[]), ValueError, "materials is empty"),
    (
        dict(positions=BOX[0], triangles=BOX[1], triangle_materials=numpy.ones(12, int)),
        ValueError,
        "triangle_materials contains 1; expected whole numbers from 0 to 0",
    ),
]


@pytest.mark.parametrize("arrays, error, said", BAD_MESHES)
def test_arrays_of_invalid_meshes_are_refused(arrays, error, said):
    with pytest.raises(error) as raised:
        haarfield.Mesh(**arrays)
    assert said in str(raised.value)


@pytest.mark.parametrize("kind", [numpy.float32, numpy.float64, numpy.int32])
@pytest.mark.parametrize("order", ["C", "F"])
def test_arrays_of_any_layout_give_the_same_mesh(kind, order, bake):
    other = description()
    positions, triangles = floor_arrays()
    other["entities"]["floor"]["mesh"] = haarfield.Mesh(
        numpy.asarray(positions, kind, order), numpy.asarray(triangles, numpy.uint16, order)
    )
    assert numpy.array_equal(haarfield.scene(other).bake(error="off")["floor"].radiance, bake["floor"].radiance)


def test_materials_of_triangles_and_images_show():
    positions, triangles = floor_arrays()
    uvs = (positions[:, [0, 2]] + 2) / 4
    half = haarfield.Mesh(
        positions, triangles, uvs=uvs, materials=["near", "far"], triangle_materials=numpy.array([0, 1])
    )
    texels = numpy.zeros((2, 2, 3), numpy.uint8)
    texels[:, 0] = [255, 0, 0]
    texels[:, 1] = [0, 255, 0]
    scene = haarfield.scene(
        {
            "environment": {"image": numpy.ones((8, 16, 3))},
            "materials": {"plain": {"diffuse": [0.5, 0.5, 0.5]}, "cloth": {"image": texels, "diffuse": [1, 1, 1]}},
            "entities": {
                "floor": {"mesh": half, "materials": {"near": "plain", "far": "cloth"}, "fine_vertices": 100}
            },
            "instances": [{"entity": "floor"}],
        }
    )
    mesh = scene.bake(error="off")[0]
    assert mesh.materials == ["near", "far"]
    near = mesh.vertex_materials == 0
    assert numpy.allclose(mesh.radiance[near], 0.5, atol=0.01)
    # The image multiplies the radiance below it: red on the left, green on the right.
    far = ~near
    assert numpy.allclose(mesh.under[far], 1, atol=0.02)
    assert (mesh.radiance[far][:, 2] == 0).all()
    left = far & (mesh.uvs[:, 0] == 0.25)
    assert (mesh.radiance[left, 0] > 0.95).all()


def test_changed_scenes_share_prepared_meshes_and_fields(scene, bake):
    turned = scene.changed({"environment": {"rotation": 90}})
    told = []
    other = turned.bake(error="off", progress=lambda stage, done, total: told.append(stage))
    assert not any("mesh" in stage for stage in told)
    assert not numpy.array_equal(other["floor"].radiance, bake["floor"].radiance)
    back = turned.changed({"environment": {"rotation": 0}}).bake(error="off")
    assert numpy.array_equal(back["floor"].radiance, bake["floor"].radiance)


def test_a_description_of_arrays_reproduces_the_scene(scene):
    texels = numpy.random.default_rng(3).integers(0, 256, (4, 6, 3), dtype=numpy.uint8)
    textured = scene.changed({"materials": {"paper": {"diffuse": [1, 1, 1], "image": texels}}})
    again = haarfield.scene(textured.description, name="again")
    images = [one.description["materials"]["paper"]["image"] for one in (textured, again)]
    assert images[0].shape == (4, 6, 3) and (images[0] == images[1]).all()
    assert (again.environment() == textured.environment()).all()
    for one, other in zip(textured.bake(error="off", bounces=0), again.bake(error="off", bounces=0)):
        assert (one.radiance == other.radiance).all()
