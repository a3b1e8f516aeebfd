#!/usr/bin/env python3
"""Computes the integral of a product of six functions of direction, in wavelet space and with numpy.

Usage: six_functions.py FOLDER [POINTS] [VERTICES]

At points on a floor next to two boxes, the six are the light (three channels), a glossy lobe and a diffuse term (one
BRDF), the cosine, the visibility around each of the two boxes, and a veil that dims one half of the sky. numpy
multiplies all texels. haarfield traverses the quadtrees: where at most one function varies, the integral of the product
is the product of the means. Prints the largest difference, and writes FOLDER/six_functions.png.

product_integral is a function for single integrals: each call transforms the light again, which takes longer than the
integral. The method is for many vertices: a bake of the same floor with VERTICES vertices transforms each function
once. The example prints the processor time per vertex of that bake and of numpy.
"""

import sys
import time
from pathlib import Path

import haarfield
import matplotlib
import numpy

matplotlib.use("Agg")
from matplotlib import pyplot

folder = Path(sys.argv[1])
points = int(sys.argv[2]) if len(sys.argv) > 2 else 200
vertices = int(sys.argv[3]) if len(sys.argv) > 3 else 50000
folder.mkdir(parents=True, exist_ok=True)
size = 64

# A box on the ground, and its visibility field.
corners = numpy.array([(x, y, z) for x in (-0.5, 0.5) for y in (0, 1) for z in (-0.5, 0.5)])
quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
box = haarfield.Mesh(corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
scene = haarfield.scene(
    {
        "environment": {"sky": {"turbidity": 3, "sun_elevation": 30}},
        "entities": {"box": {"mesh": box, "fine_vertices": 2000, "planar_samples": 3000, "spherical_samples": 1000}},
        "instances": [{"entity": "box"}],
    }
)
field = scene.field("box")

# The functions: F_1 light, F_2 BRDF, F_3 cosine, F_4 and F_5 visibility, F_6 a veil over one half of the sky.
sky = haarfield.lighting(scene.environment(), size)
directions = haarfield.texel_directions(size)
cosine = haarfield.lobe(1, (0, 1, 0), size)
brdf = (0.3 + 0.2 * 26 * haarfield.lobe(50, (0.7, 0.7, 0), size)) / numpy.pi
veil = numpy.where(directions[..., 2] > 0, 0.6, 1.0).astype(numpy.float32)

random = numpy.random.default_rng(2006)
places = random.uniform(-3, 3, (points, 3)) * (1, 0, 1)
wavelets, texels = numpy.zeros((2, points, 3))
numpy_seconds = 0
constant = [haarfield.CubemapTree(f) for f in (brdf, cosine, veil)]
for i, place in enumerate(places):
    first, second = (field.tree(place - box_at, "planar") for box_at in ((-1.5, 0, 0), (1.5, 0, 0.5)))
    wavelets[i] = haarfield.product_integral(*constant, first, second, light=sky)
    visible = [first.texels(), second.texels()]
    start = time.process_time()
    product = brdf * cosine * veil * visible[0] * visible[1]
    texels[i] = (sky * product[..., None]).mean(axis=(1, 2)).sum(axis=0)
    numpy_seconds += time.process_time() - start

difference = numpy.abs(wavelets - texels).max() / texels.mean()
print(f"{points} integrals of six functions on 6 x {size} x {size} texels")
print(f"largest difference, relative to the mean: {difference:.1e}")
assert difference < 1e-4

# The product of all functions but the light determines the response of a point to any light.
answer = haarfield.function_product(*constant, first, second)
assert numpy.allclose(haarfield.product_integral(answer, light=sky), wavelets[-1], rtol=1e-4)

# The intended use: direct light at every vertex of the same floor, with the same two boxes as occluders.
floor = haarfield.Mesh([(-3, 0, -3), (-3, 0, 3), (3, 0, 3), (3, 0, -3)], [(0, 1, 2), (0, 2, 3)])
paint = {"diffuse": [0.3, 0.3, 0.3], "specular": [0.2, 0.2, 0.2], "shininess": 50}
baked_scene = scene.changed(
    {
        "materials": {"paint": paint},
        "entities": {"floor": {"mesh": floor, "material": "paint", "fine_vertices": vertices, "coarse_triangles": 0}},
        "instances": [
            {"entity": "floor"},
            {"entity": "box", "translate": [-1.5, 0, 0]},
            {"entity": "box", "translate": [1.5, 0, 0.5]},
        ],
    }
)
baked_scene.prepare()
start = time.process_time()
bake = baked_scene.bake(error="off", bounces=0, occlusion="fields")
bake_microseconds = 1e6 * (time.process_time() - start) / bake.vertices
numpy_microseconds = 1e6 * numpy_seconds / points
print(f"processor time per vertex: bake {bake_microseconds:.1f} us (of {bake.vertices} vertices, lighting included), "
      f"numpy {numpy_microseconds:.1f} us: {numpy_microseconds / bake_microseconds:.0f} times as long")

figure, axes = pyplot.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
axes[0].loglog(texels.ravel(), wavelets.ravel(), ".", markersize=3)
axes[0].set(xlabel="numpy, all texels [W/(m² sr)]", ylabel="product integral of wavelets [W/(m² sr)]")
brightness = axes[1].scatter(places[:, 0], places[:, 2], c=wavelets[:, 1], s=30, cmap="magma")
axes[1].set(xlabel="x [m]", ylabel="z [m]", aspect="equal", title="radiance of the floor around two boxes")
figure.colorbar(brightness, ax=axes[1])
figure.savefig(folder / "six_functions.png", dpi=110)
