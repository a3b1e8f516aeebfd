#!/usr/bin/env python3
"""Plots a visibility field: its samples, cubemaps, quadtrees and errors.

Usage: look_into_field.py FIELD.vdb FOLDER
       look_into_field.py SCENE.toml ENTITY FOLDER

Writes FOLDER/field.png.
"""

import sys
from pathlib import Path

import haarfield
import matplotlib
import numpy

matplotlib.use("Agg")
from matplotlib import pyplot

if len(sys.argv) == 4:
    field = haarfield.open(sys.argv[1]).field(sys.argv[2])
else:
    field = haarfield.read_field(sys.argv[1])
folder = Path(sys.argv[-1])
folder.mkdir(parents=True, exist_ok=True)


def cross(faces):
    """Unfolds the six faces +x -x +y -y +z -z: +x +z -x -z in a row, +y above and -y below -z."""
    size = faces.shape[1]
    picture = numpy.full((3 * size, 4 * size), numpy.nan)
    places = {0: (1, 0), 4: (1, 1), 1: (1, 2), 5: (1, 3), 2: (0, 3), 3: (2, 3)}
    for face, (row, column) in places.items():
        picture[row * size : (row + 1) * size, column * size : (column + 1) * size] = faces[face]
    return picture


def squares(tree, size):
    """Returns the level at which the quadtree of a face ends, by texel."""
    level = numpy.zeros((size, size))

    def walk(node, depth, x, y, width):
        level[y : y + width, x : x + width] = depth
        if node < 0:
            return
        half = width // 2
        for quadrant, child in enumerate(tree["children"][node]):
            if half:
                walk(child, depth + 1, x + quadrant % 2 * half, y + quadrant // 2 * half, half)

    walk(0 if len(tree["children"]) else -1, 0, 0, 0, size)
    return level


lower, upper = (numpy.array(corner) for corner in field.bounds)
centre, radius = (lower + upper) / 2, numpy.linalg.norm(upper - lower) / 2
place = centre + (0.9 * radius, 0, 0.5 * radius)
tree = field.tree(place)
visibility = field.visibility(place)
print(field, f"with {field.nodes} nodes")
print(f"at {numpy.round(place, 2)} {100 * visibility.mean():.1f} % of the cubemap is open, in {tree.nodes} nodes")

figure = pyplot.figure(figsize=(12, 9), layout="constrained")
axes = figure.subplots(2, 2)
for unfolded in axes[0]:
    unfolded.set_facecolor("0.85")
    unfolded.set(xticks=[], yticks=[])
axes[0, 0].imshow(cross(visibility), cmap="gray", vmin=0, vmax=1)
axes[0, 0].set_title(f"visibility one step from the {field.entity}")
levels = numpy.array([squares(face, field.face_size) for face in tree.faces])
shown = axes[0, 1].imshow(cross(levels), cmap="viridis")
axes[0, 1].set_title("levels of its quadtrees")
figure.colorbar(shown, ax=axes[0, 1], ticks=range(int(levels.max()) + 1))

positions, handles = field.planar["positions"], field.planar["handles"]
step = max(1, len(handles) // 2000)
share = [1 - field.cubemap(int(handle)).texels().mean() for handle in handles[::step]]
shown = axes[1, 0].scatter(positions[::step, 0], positions[::step, 2], c=share, s=8, cmap="magma", norm="log", vmin=1e-3)
axes[1, 0].set(title="occlusion at the samples on the ground", xlabel="x [m]", ylabel="z [m]", aspect="equal")
figure.colorbar(shown, ax=axes[1, 0])

for name in ("planar", "spherical"):
    error = getattr(field, name)["error"]
    axes[1, 1].plot((numpy.arange(16) + 0.5) / 16, 100 * error["band"], label=f"{name} samples")
axes[1, 1].set(title="error between samples", xlabel="radial position", ylabel="RMS [% of what is open]", ylim=(0, None))
axes[1, 1].legend()
figure.savefig(folder / "field.png", dpi=100)
