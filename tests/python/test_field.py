"""Access to the content of fields."""

import numpy
import pytest
from conftest import ball_arrays

import haarfield


@pytest.fixture(scope="module")
def field():
    """Samples around a ball of radius 1/2 on the ground. Boxes have too few triangles to need samples."""
    return haarfield.scene(
        {
            "environment": {"sky": {}},
            "entities": {
                "ball": {"mesh": haarfield.Mesh(*ball_arrays()), "planar_samples": 600, "spherical_samples": 900}
            },
            "instances": [{"entity": "ball"}],
        }
    ).field("ball")


def test_visibility_is_blocked_towards_the_object(field):
    seen = field.visibility((3, 0.5, 0))
    size = field.face_size
    assert seen.shape == (6, size, size)
    middle = size // 2
    assert seen[0, middle, middle] == pytest.approx(1, abs=0.02)  # +x, away from the ball
    assert seen[1, middle, middle] == pytest.approx(0, abs=0.1)  # -x, towards the ball
    assert seen.min() > -0.2 and seen.max() < 1.2


def test_visibility_far_away_is_one(field):
    assert field.visibility((1e4, 0, 0)).mean() > 0.9999


def test_interpolation_is_the_weighted_sum_of_cubemaps(field):
    for sampler in ("planar", "spherical"):
        found = field.interpolation((1.3, 0.2, 0.4), sampler)
        texels = found["open"] + sum(
            weight * field.cubemap(handle).texels() for weight, handle in zip(found["weights"], found["handles"])
        )
        assert found["weights"].sum() + found["open"] == pytest.approx(1, abs=1e-5)
        assert numpy.allclose(texels, field.visibility((1.3, 0.2, 0.4), sampler), atol=1e-5)


def test_trees_reproduce_their_texels(field):
    handle = int(field.spherical["handles"][400])
    texels = field.cubemap(handle).texels()
    for face, tree in enumerate(field.cubemap(handle).faces):
        assert tree["scaling"] == pytest.approx(texels[face].mean(), abs=1e-5)
        children = tree["children"]
        assert sorted(children[children >= 0]) == list(range(1, len(children))) or len(children) == 0


def test_samples_are_around_the_object(field):
    planar, spherical = field.planar, field.spherical
    assert planar["positions"].shape == (planar["rings"] * planar["angles"], 3)
    assert (planar["positions"][:, 1] == planar["centre"][1]).all()
    distance = numpy.linalg.norm(spherical["positions"] - numpy.array(spherical["centre"]), axis=1)
    assert distance.max() == pytest.approx(spherical["outer_radius"], rel=1e-5)
    assert len(planar["handles"]) == len(planar["positions"])
    assert planar["handles"].max() < field.cubemaps
    assert numpy.allclose(field.bounds, ((-0.5, 0, -0.5), (0.5, 1, 0.5)), atol=0.02)


def test_invalid_arguments_and_files_are_refused(field, scene, tmp_path):
    with pytest.raises(IndexError, match="handle -1"):
        field.cubemap(-1)
    with pytest.raises(IndexError):
        field.cubemap(field.cubemaps)
    with pytest.raises(ValueError, match="sampler is"):
        field.visibility((0, 0, 0), "cubic")
    with pytest.raises(ValueError, match="point has the shape"):
        field.visibility((0, 0))
    with pytest.raises(ValueError, match="is nan"):
        field.visibility((0, 0, numpy.nan))
    with pytest.raises(KeyError, match="expected one of: floor, box"):
        scene.field("chair")
    damaged = tmp_path / "damaged.vdb"
    damaged.write_bytes(b"no field")
    with pytest.raises(haarfield.Error, match="damaged.vdb"):
        haarfield.read_field(damaged)
