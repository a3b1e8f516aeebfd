"""Fixtures of the tests of the Python module."""

import json
import os
from pathlib import Path

import numpy
import pytest

import haarfield

SOURCE = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("HAARFIELD_PROGRAM", str(SOURCE / "build/dev/haarfield"))

# A few hundred samples and vertices, so that a field takes a tenth of a second.
SMALL = {"fine_vertices": 600, "coarse_triangles": 300, "planar_samples": 60, "spherical_samples": 60}


def box_arrays(size=1.0):
    """Returns positions and triangles of a cube on the ground."""
    positions = numpy.array([(x, y, z) for x in (-0.5, 0.5) for y in (0, 1) for z in (-0.5, 0.5)]) * size
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return positions, numpy.array(triangles)


def floor_arrays(half=2.0):
    """Returns positions and triangles of a square on the ground."""
    positions = numpy.array([(-half, 0, -half), (-half, 0, half), (half, 0, half), (half, 0, -half)])
    return positions, numpy.array([(0, 1, 2), (0, 2, 3)])


def ball_arrays(rows=16, columns=24):
    """Returns positions and triangles of a ball of radius 1/2 on the ground."""
    polar, azimuth = numpy.meshgrid(
        numpy.linspace(0, numpy.pi, rows), numpy.linspace(0, 2 * numpy.pi, columns + 1), indexing="ij"
    )
    across = numpy.where(numpy.arange(rows) % (rows - 1) == 0, 0, numpy.sin(polar[:, 0]))[:, None]
    positions = numpy.stack([across * numpy.cos(azimuth), numpy.cos(polar), across * numpy.sin(azimuth)], -1) / 2
    positions[:, -1] = positions[:, 0]
    a = (numpy.arange(rows - 1)[:, None] * (columns + 1) + numpy.arange(columns)).ravel()
    b, c, d = a + 1, a + columns + 2, a + columns + 1
    return positions.reshape(-1, 3) + (0, 0.5, 0), numpy.concatenate([numpy.c_[a, b, c], numpy.c_[a, c, d]])


def sky_pixels(height=16):
    """Returns light from above that is brighter towards +x."""
    y, x = numpy.mgrid[0:height, 0 : 2 * height]
    latitude = numpy.pi * (0.5 - (y + 0.5) / height)
    longitude = numpy.pi * (1 - 2 * (x + 0.5) / (2 * height))
    light = numpy.maximum(0.1, numpy.sin(latitude)) * (1.5 + numpy.sin(longitude))
    return light[..., None] * numpy.array([1.0, 0.9, 0.7])


def description():
    """Returns two boxes on a floor."""
    return {
        "camera": {"position": [3, 2.5, 4], "target": [0, 0.4, 0], "resolution": [96, 72]},
        "environment": {"image": sky_pixels()},
        "materials": {
            "red": {"diffuse": [0.6, 0.1, 0.1], "specular": [0.2, 0.2, 0.2], "convention": "povray"},
            "grey": {"diffuse": [0.5, 0.5, 0.5]},
        },
        "entities": {
            "box": {"mesh": haarfield.Mesh(*box_arrays()), "material": "red", **SMALL},
            "floor": {"mesh": haarfield.Mesh(*floor_arrays()), "material": "grey", **SMALL},
        },
        "instances": [
            {"entity": "floor"},
            {"entity": "box", "name": "left", "translate": [-0.8, 0, 0]},
            {"entity": "box", "name": "right", "translate": [0.8, 0, 0.2], "scale": 0.6},
        ],
    }


@pytest.fixture(scope="session")
def scene():
    return haarfield.scene(description(), name="boxes")


@pytest.fixture(scope="session")
def bake(scene):
    return scene.bake(error="off")


SMALL_CHAIR = {
    "camera": {"resolution": [64, 48]},
    "entities": {
        "chair": {"fine_vertices": 1500, "coarse_triangles": 500, "planar_samples": 100, "spherical_samples": 60},
        "floor": {"fine_vertices": 1000},
    },
}


def toml_text(value):
    """Returns a value as TOML. Values other than tables have the same text in JSON."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml_text(inside)}" for key, inside in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml_text, value)) + "]"
    return json.dumps(value)


@pytest.fixture(scope="session")
def chair_file(tmp_path_factory):
    folder = tmp_path_factory.mktemp("chair")
    tables = haarfield.open(SOURCE / "scenes/single_chair.toml", SMALL_CHAIR).description
    for entity in tables["entities"].values():
        entity["mesh"] = str(SOURCE / "scenes" / entity["mesh"])
    file = folder / "small_chair.toml"
    file.write_text("".join(f"{key} = {toml_text(value)}\n" for key, value in tables.items()))
    return file
