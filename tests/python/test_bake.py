"""Bakes: equality with the command line, arrays without copies, files and measurements."""

import gc
import subprocess

import numpy
import pytest
from conftest import PROGRAM, box_arrays, description

import haarfield

def read_ply(path):
    """Returns the vertices of a PLY file."""
    data = path.read_bytes()
    head, body = data.split(b"end_header\n", 1)
    kinds = {"float": "<f4", "uchar": "u1", "int": "<i4", "uint": "<u4"}
    fields, count = [], 0
    for line in head.decode().splitlines():
        words = line.split()
        if words[:2] == ["element", "vertex"]:
            count = int(words[2])
        if words[:1] == ["element"] and words[1] == "face":
            break
        if words[:1] == ["property"]:
            fields.append((words[2], kinds[words[1]]))
    return numpy.frombuffer(body, numpy.dtype(fields), count)


@pytest.mark.parametrize("error", ["off", "5%"])
def test_bakes_are_bit_identical_to_those_of_the_command_line(chair_file, tmp_path, error):
    options = ["--no-render", "--quiet", "--pass", "occlusion", "--error", error]
    subprocess.run([PROGRAM, "bake", chair_file, "-o", tmp_path / "command", *options], check=True)
    bake = haarfield.open(chair_file).bake(error=error, passes=["occlusion"])
    written = read_ply(tmp_path / "command/small_chair.ply")
    for number in range(len(bake)):
        mesh, of_file = bake[number], written[written["instance"] == number]
        for channel, name in enumerate(("radiance_r", "radiance_g", "radiance_b")):
            assert numpy.array_equal(mesh.radiance[:, channel], of_file[name])
        assert numpy.array_equal(mesh.passes["occlusion"], of_file["occlusion"])
    (tmp_path / "module").mkdir()
    bake.write_ply(tmp_path / "module/small_chair.ply")
    files = bake.write_povray(tmp_path / "module")
    for file in [tmp_path / "module/small_chair.ply", files["scene"], *files["includes"]]:
        assert file.read_bytes() == (tmp_path / "command" / file.name).read_bytes(), file.name


def test_original_vertices_equal_those_of_the_command_line(chair_file, tmp_path):
    options = ["--no-render", "--quiet", "--pass", "occlusion", "--original-vertices"]
    subprocess.run([PROGRAM, "bake", chair_file, "-o", tmp_path, *options], check=True)
    scene = haarfield.open(chair_file)
    bake = scene.bake(passes=["occlusion"], original_vertices=True)
    written = read_ply(tmp_path / "small_chair.ply")
    assert bake.vertices == len(written)
    for number in range(len(bake)):
        mesh, of_file = bake[number], written[written["instance"] == number]
        assert numpy.array_equal(mesh.original_vertices, of_file["original_vertex"])
        for channel, name in enumerate(("radiance_r", "radiance_g", "radiance_b")):
            assert numpy.array_equal(mesh.radiance[:, channel], of_file[name])
        assert numpy.array_equal(mesh.passes["occlusion"], of_file["occlusion"])
    bake.write_ply(tmp_path / "module.ply")
    assert (tmp_path / "module.ply").read_bytes() == (tmp_path / "small_chair.ply").read_bytes()
    files = bake.write_povray(tmp_path / "module")
    for file in [files["scene"], *files["includes"]]:
        assert file.read_bytes() == (tmp_path / file.name).read_bytes(), file.name
    # The number of vertices is that of the chair's file, regardless of the scene's fine_vertices.
    with open(haarfield.open(chair_file).description["entities"]["chair"]["mesh"]) as file:
        assert len(bake["chair"]) == sum(line.startswith("v ") for line in file)
    again = scene.bake(error="off")
    assert len(again["chair"]) >= 1500


def test_original_vertices_of_arrays_have_the_order_of_the_arrays():
    changed = description()
    positions, triangles = box_arrays()
    lonely = numpy.vstack([positions, [(9, 9, 9)]])
    changed["entities"]["box"]["mesh"] = haarfield.Mesh(lonely, triangles)
    with pytest.warns(haarfield.Warning, match="2 of the files' 22 vertices belong to no triangle with an area and get radiance 0"):
        bake = haarfield.scene(changed).bake(original_vertices=True)
    mesh = bake["left"]
    assert numpy.array_equal(mesh.original_vertices, range(9)) and len(bake["floor"]) == 4
    assert numpy.allclose(mesh.positions, lonely, atol=0.002)  # it is laid on the floor
    assert numpy.array_equal(mesh.triangles, triangles)
    assert (mesh.radiance[:8] > 0).all() and (mesh.radiance[8] == 0).all()
    with pytest.raises(ValueError, match="expected None with original_vertices"):
        haarfield.scene(changed).bake(refine=0.1, original_vertices=True)


def test_fields_in_a_folder_are_shared_with_the_command_line(chair_file, tmp_path):
    subprocess.run([PROGRAM, "precompute", chair_file, "-o", tmp_path, "--quiet"], check=True)
    before = {file.name: file.stat().st_mtime_ns for file in (tmp_path / "fields").iterdir()}
    scene = haarfield.open(chair_file)
    scene.prepare(fields=tmp_path / "fields")
    assert before == {file.name: file.stat().st_mtime_ns for file in (tmp_path / "fields").iterdir()}
    in_file = haarfield.read_field(next((tmp_path / "fields").glob("chair-*.vdb")))
    in_memory = haarfield.open(chair_file).field("chair")
    assert in_file.key == in_memory.key == scene.field("chair").key
    assert numpy.array_equal(in_file.bytes, in_memory.bytes)


def test_radiance_does_not_depend_on_threads(scene, bake):
    haarfield.use_threads(1)
    try:
        alone = scene.bake(error="off")
    finally:
        haarfield.use_threads(0)
    for name in scene.instances:
        assert numpy.array_equal(alone[name].radiance, bake[name].radiance)


def test_arrays_are_views_that_outlive_the_bake(scene):
    bake = scene.bake(error="off")
    mesh = bake["left"]
    radiance, again = mesh.radiance, mesh.radiance
    assert radiance.dtype == numpy.float32 and radiance.shape == (len(mesh), 3)
    assert radiance.__array_interface__["data"] == again.__array_interface__["data"]
    assert not radiance.flags.owndata and not radiance.flags.writeable
    with pytest.raises(ValueError):
        radiance[0] = 0
    kept = radiance.copy()
    del bake, mesh, again
    gc.collect()
    assert numpy.array_equal(radiance, kept)


def test_meshes_are_placed_as_in_the_scene(bake):
    mesh = bake["right"]
    world = mesh.positions @ mesh.matrix[:3, :3].T + mesh.matrix[:3, 3]
    assert world.min(axis=0) == pytest.approx([0.5, 0, -0.1], abs=1e-5)
    assert world.max(axis=0) == pytest.approx([1.1, 0.6, 0.5], abs=1e-5)
    assert mesh.triangles.max() < len(mesh)
    assert numpy.allclose(numpy.linalg.norm(mesh.normals, axis=1), 1, atol=1e-5)


def test_an_unknown_instance_is_a_key_error(bake):
    with pytest.raises(KeyError):
        bake["nobody"]
    with pytest.raises(IndexError):
        bake[3]
    assert bake[-1].name == "right"


@pytest.mark.parametrize(
    "options",
    [
        {"refine": 2},
        {"refine": float("nan")},
        {"vertex_budget": 0},
        {"occlusion": "none"},
        {"occlusion_error": float("nan")},
        {"reach": 0.5},
        {"depth": -1},
        {"light_coefficients": -1},
        {"evaluator": "slow"},
        {"colours": "red"},
        {"passes": ["depth"]},
        {"samples": None},
    ],
)
def test_options_out_of_range_are_value_errors(scene, options):
    with pytest.raises(ValueError, match=next(iter(options))):
        scene.bake(**options)


@pytest.mark.parametrize(
    "options, said",
    [
        ({"evaluator": "dense", "refine": 0.1}, "knows vertices only"),
        ({"passes": ["diffuse", "diffuse"]}, "is listed twice"),
    ],
)
def test_options_that_exclude_each_other_are_errors(scene, options, said):
    with pytest.raises(haarfield.Error, match=said):
        scene.bake(**options)


def test_a_bake_reaches_its_target_and_says_so(scene, bake):
    assert bake.error is None
    found = scene.bake(error=0.05)
    assert found.error["target"] == 0.05
    assert found.error["is_met"] and found.error["reason"] == ""
    assert found.error["low"] <= found.error["reached"] <= min(found.error["high"], 0.05)
    assert scene.bake(error="5%", everywhere=True).error["is_met"]
    with pytest.raises(ValueError, match="expected 'off' with original_vertices"):
        scene.bake(error=0.05, original_vertices=True)
    with pytest.raises(ValueError, match="error is 0; expected off or a number"):
        scene.bake(error=0)


def test_refinement_adds_vertices(scene, bake):
    assert scene.bake(refine=0.02, vertex_budget=6000).vertices > bake.vertices


def test_pictures_and_figures(scene, bake, tmp_path):
    quick = bake.picture()
    assert quick.shape == (72, 96, 3)
    baked, coverage = bake.render(tmp_path, antialiasing=0)
    assert (tmp_path / "baked.exr").exists() and (tmp_path / "baked.png").exists()
    reference = scene.reference(tmp_path, lights=64, antialiasing=0)
    assert 0 < reference["relative_error"] < 0.1
    both = numpy.dstack([reference["image"], reference["coverage"]])
    figures = haarfield.compare(numpy.dstack([baked, coverage]), both)
    assert figures["psnr_db"] > 25
    from_files = haarfield.compare(tmp_path / "baked.exr", tmp_path / "reference.exr")
    assert from_files["psnr_db"] == pytest.approx(figures["psnr_db"], abs=0.01)
    assert figures["flip_errors"].shape == (72, 96)
    shown = coverage == 1
    assert haarfield.compare(numpy.where(shown[..., None], quick, 0), numpy.where(shown[..., None], baked, 0))[
        "psnr_db"
    ] > 30


def test_references_have_bounces_on_request(scene, tmp_path):
    def written(**options):
        made = scene.reference(tmp_path, lights=16, render=False, **options)
        assert "image" not in made
        return made["scene"].read_text()

    text = written(bounces=2)
    assert "#declare Recursion_Limit = 2;" in text and "recursion_limit Recursion_Limit" in text
    assert "Without_Bounces" in written(bounces=2)
    assert "Without_Bounces" not in written()
    with pytest.raises(ValueError, match="bounces is 21; expected 0 to 20"):
        written(bounces=21)


def test_compare_refuses_invalid_pictures():
    picture = numpy.zeros((4, 4, 3))
    with pytest.raises(haarfield.Error):
        haarfield.compare(picture, numpy.zeros((4, 5, 3)))
    with pytest.raises(ValueError, match="expected the name of a picture file, or an array"):
        haarfield.compare(picture, numpy.zeros((4, 4)))
    with pytest.raises(ValueError, match="b.1, 2, 0. is nan"):
        bad = picture.copy()
        bad[1, 2, 0] = numpy.nan
        haarfield.compare(picture, bad)
    with pytest.raises(haarfield.Error, match="nowhere.png"):
        haarfield.read_image("nowhere.png")


def test_images_are_written_and_read_back(tmp_path):
    picture = numpy.linspace(0, 2, 4 * 5 * 4).reshape(4, 5, 4).astype(numpy.float32)
    picture[..., 3] = 0.5
    haarfield.write_image(picture, tmp_path / "a.exr")
    pixels, coverage = haarfield.read_image(tmp_path / "a.exr")
    assert numpy.allclose(pixels, picture[..., :3], rtol=1e-3)
    assert (coverage == 0.5).all()


def test_the_budget_lists_the_approximations(scene):
    entries = scene.budget(points=20)
    names = [entry["approximation"] for entry in entries]
    assert "interpolation" in names and len(set(names)) == len(names)
    assert all(entry["relative_rmse"] >= 0 for entry in entries)


def test_bakes_leave_no_files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    haarfield.scene(description()).bake(error="off")
    assert list(tmp_path.iterdir()) == []


def test_a_bake_is_a_mapping_by_instance_names(scene):
    bake = scene.bake(error="off", bounces=0)
    assert bake.keys() == scene.instances
    assert "left" in bake and "nobody" not in bake and 0 not in bake
    assert dict(bake).keys() == set(scene.instances)
