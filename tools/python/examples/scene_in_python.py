#!/usr/bin/env python3
"""Builds a scene in Python: a winding stair of arrays, under a sky that is an array.

Usage: scene_in_python.py FOLDER [VERTICES]

Writes FOLDER/stair.pov for POV-Ray, FOLDER/stair.glb for other programs, and FOLDER/stair.png.
"""

import sys
from pathlib import Path

import haarfield
import numpy

folder = Path(sys.argv[1])
vertices = int(sys.argv[2]) if len(sys.argv) > 2 else 60000
folder.mkdir(parents=True, exist_ok=True)


def surface(function, rows, columns):
    """Returns a grid of (u, v) in [0, 1] as a mesh. The function returns (rows, columns, 3) positions."""
    v, u = numpy.meshgrid(numpy.linspace(0, 1, rows), numpy.linspace(0, 1, columns), indexing="ij")
    first = (numpy.arange(rows - 1)[:, None] * columns + numpy.arange(columns - 1)).ravel()
    a, b, c, d = first, first + 1, first + columns + 1, first + columns
    return haarfield.Mesh(function(u, v).reshape(-1, 3), numpy.concatenate([numpy.c_[a, c, b], numpy.c_[a, d, c]]))


def box(width, height, depth):
    corners = numpy.array([(x, y, z) for x in (-0.5, 0.5) for y in (0, 1) for z in (-0.5, 0.5)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return haarfield.Mesh(corners * (width, height, depth), [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def torus(u, v):
    ring, tube = 2 * numpy.pi * u, 2 * numpy.pi * v
    across = 0.55 + 0.18 * numpy.cos(tube)
    return numpy.stack([across * numpy.cos(ring), 0.18 + 0.18 * numpy.sin(tube), across * numpy.sin(ring)], axis=-1)


# A sky: blue above, warm on one side, with a small bright window. Rows from the top, +z in the middle.
height = 128
latitude = numpy.pi * (0.5 - (numpy.arange(height) + 0.5) / height)[:, None]
longitude = numpy.pi * (1 - 2 * (numpy.arange(2 * height) + 0.5) / (2 * height))[None, :]
warm = numpy.exp(-3 * (longitude - 0.8) ** 2 - 6 * latitude**2)[..., None]
sky = 0.35 + 0.4 * numpy.sin(latitude)[..., None] * numpy.array([0.4, 0.7, 1.2]) + warm * numpy.array([1.6, 0.9, 0.4])
sky[(latitude < 0).ravel()] = 0.15
sky[(abs(latitude - 0.7) < 0.06) & (abs(longitude - 0.5) < 0.06)] = 140

angles = 24.0 * numpy.arange(16)
steps = [
    {
        "entity": "step",
        "name": f"step_{i + 1}",
        "translate": [1.1 * numpy.sin(numpy.radians(angle)), 0.16 * i, 1.1 * numpy.cos(numpy.radians(angle))],
        "rotate": [0, angle, 0],
    }
    for i, angle in enumerate(angles)
]
scene = haarfield.scene(
    {
        "camera": {"position": [4.6, 3.4, 5.2], "target": [0, 1.1, 0], "vertical_fov": 38, "resolution": [640, 480]},
        "environment": {"image": sky, "exposure": "auto"},
        "materials": {
            "stone": {"diffuse": [0.6, 0.58, 0.52]},
            "wood": {"diffuse": [0.42, 0.2, 0.08], "specular": [0.1, 0.1, 0.1], "convention": "povray"},
            "glaze": {"diffuse": [0.1, 0.2, 0.35], "specular": [0.4, 0.4, 0.4], "shininess": 60, "convention": "povray"},
        },
        "entities": {
            "ground": {"mesh": box(12, 0.1, 12), "material": "stone", "fine_vertices": vertices // 2},
            "pillar": {"mesh": box(0.3, 3.0, 0.3), "material": "stone", "fine_vertices": vertices // 10},
            "step": {"mesh": box(0.5, 0.07, 1.4), "material": "wood", "fine_vertices": max(100, vertices // 40)},
            "ring": {"mesh": surface(torus, 33, 65), "material": "glaze", "fine_vertices": 2145},
        },
        "instances": [
            {"entity": "ground", "translate": [0, -0.1, 0]},
            {"entity": "pillar"},
            {"entity": "ring", "translate": [2.2, 0, 1.4]},
            *steps,
        ],
    },
    name="stair",
)
bake = scene.bake(progress=lambda stage, done, total: print(f"\r{stage} {done} of {total}   ", end="", file=sys.stderr))
print(f"\n{bake.vertices} vertices in {bake.seconds:.2f} s, error {100 * bake.error['reached']:.1f} %")
print("POV-Ray:", bake.write_povray(folder)["scene"])
bake.write_glb(folder / "stair.glb")
haarfield.write_image(bake.picture(), folder / "stair.png")
