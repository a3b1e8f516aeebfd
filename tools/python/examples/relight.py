#!/usr/bin/env python3
"""Turns the light of a scene in a loop, and plots time and error of each frame.

Usage: relight.py SCENE.toml FOLDER [STEPS [LIGHTS]]

Writes FOLDER/relight.png: above, the error of the frames at the vertices relative to full bakes, and in the picture
relative to POV-Ray's ray tracer; below, some of the frames.
"""

import sys
import time
from pathlib import Path

import haarfield
import matplotlib
import numpy

matplotlib.use("Agg")
from matplotlib import pyplot

scene = haarfield.open(sys.argv[1])
folder = Path(sys.argv[2])
steps = int(sys.argv[3]) if len(sys.argv) > 3 else 24
lights = int(sys.argv[4]) if len(sys.argv) > 4 else 256
folder.mkdir(parents=True, exist_ok=True)


def relative_rmse(values, wanted):
    difference = numpy.concatenate(values) - numpy.concatenate(wanted)
    return numpy.sqrt((difference**2).mean() / (numpy.concatenate(wanted) ** 2).mean())


def display(radiance):
    """Returns the sRGB values of linear radiance."""
    clipped = numpy.clip(radiance, 0, 1)
    return numpy.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)


session = scene.session()
start = time.perf_counter()
session.vary_light()  # folds all factors but the light into a sparse vector per vertex
print(f"vectors in {time.perf_counter() - start:.2f} s, {session.transfer_bytes / 1e6:.0f} MB")

angles = numpy.arange(steps) * 360 / steps
seconds, against_bake, pictures = [], [], []
for angle in angles:
    session.turn_environment(angle)
    start = time.perf_counter()
    session.frame()  # one dot product per vertex; updates session.radiance
    seconds.append(time.perf_counter() - start)
    pictures.append(session.picture())
    bake = scene.changed({"environment": {"rotation": float(angle)}}).bake(error="off")
    against_bake.append(relative_rmse(session.radiance, [bake[name].radiance for name in scene.instances]))

# The ray tracer, for a quarter of the angles.
traced = angles[:: max(1, steps // 4)]
against_tracer = []
for angle in traced:
    turned = scene.changed({"environment": {"rotation": float(angle)}})
    reference = turned.reference(folder, lights=lights, antialiasing=0)
    shown = pictures[list(angles).index(angle)]
    both = numpy.dstack([reference["image"], reference["coverage"]])
    against_tracer.append(haarfield.compare(shown, both)["relative_rmse"])

print(f"{steps} frames in {1000 * numpy.median(seconds):.2f} ms each (median)")
print(f"relative RMSE at the vertices {numpy.mean(against_bake):.4f}, in the picture {numpy.mean(against_tracer):.4f}")

figure = pyplot.figure(figsize=(10, 6), layout="constrained")
plots, frames = figure.subfigures(2, 1, height_ratios=[2, 1])
errors, times = plots.subplots(1, 2)
errors.plot(angles, 100 * numpy.array(against_bake), label="vertices, against a bake in full")
errors.plot(traced, 100 * numpy.array(against_tracer), "o", label="picture, against the ray tracer")
errors.set(xlabel="turn of the light [degrees]", ylabel="relative RMSE [%]", ylim=(0, None))
errors.legend()
times.plot(angles, 1000 * numpy.array(seconds))
times.set(xlabel="turn of the light [degrees]", ylabel="frame [ms]", ylim=(0, None))
for axes, picture in zip(frames.subplots(1, 4), pictures[:: max(1, steps // 4)]):
    axes.imshow(display(picture))
    axes.axis("off")
figure.savefig(folder / "relight.png", dpi=110)
