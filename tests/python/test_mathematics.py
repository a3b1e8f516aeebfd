"""Wavelets and products of functions, against numpy."""

import subprocess
import sys

import numpy
import pytest

import haarfield


def functions(count, size, seed):
    """Returns an image of shapes with edges, in [0, 1]."""
    random = numpy.random.default_rng(seed)
    directions = haarfield.texel_directions(size)
    made = []
    for _ in range(count):
        axis = random.normal(size=3)
        axis /= numpy.linalg.norm(axis)
        made.append(((directions @ axis > random.uniform(-0.8, 0.2)) * random.uniform(0.5, 1)).astype(numpy.float32))
    return made


@pytest.mark.parametrize("size", [1, 2, 8, 64, 256])
def test_the_haar_transform_is_orthonormal_and_inverts(size):
    texels = numpy.random.default_rng(size).normal(size=(size, size)).astype(numpy.float32)
    scaling, levels = haarfield.haar_transform(texels)
    assert [level.shape for level in levels] == [(3, 2**l, 2**l) for l in range(size.bit_length() - 1)]
    energy = scaling**2 + sum((level.astype(float) ** 2).sum() * 4.0**-l for l, level in enumerate(levels))
    assert energy == pytest.approx((texels.astype(float) ** 2).mean(), rel=1e-5)
    assert numpy.allclose(haarfield.inverse_haar_transform(scaling, levels), texels, atol=1e-5)


def test_wavelets_have_the_documented_signs():
    scaling, levels = haarfield.haar_transform([[1, 0], [0, 0]])
    assert scaling == 0.25 and levels[0].ravel().tolist() == [0.25, 0.25, 0.25]
    scaling, levels = haarfield.haar_transform([[1, 0], [1, 0]])
    assert levels[0].ravel().tolist() == [0.5, 0, 0]


def test_lack_of_memory_has_a_message():
    code = """
import haarfield, numpy, resource
texels = numpy.random.default_rng(1).random((6, 256, 256), dtype=numpy.float32)
haarfield.CubemapTree(texels[:, :2, :2].copy())
pages = int(open("/proc/self/statm").read().split()[0])
resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize(),) * 2)
try:
    trees = [haarfield.CubemapTree(texels) for _ in range(1000)]
except MemoryError as error:
    print(error)
"""
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert ended.stdout == "not enough memory\n", ended.stderr


def test_trees_invert_and_truncate():
    texels = functions(1, 32, 3)[0]
    tree = haarfield.CubemapTree(texels)
    assert numpy.allclose(tree.texels(), texels, atol=1e-6)
    few = haarfield.CubemapTree(texels, coefficients=5)
    assert few.nodes < tree.nodes
    close = haarfield.CubemapTree(texels, relative_l2_error=0.1)
    error = numpy.linalg.norm(close.texels() - texels, axis=(1, 2))
    assert (error <= 0.1 * numpy.linalg.norm(texels, axis=(1, 2)) + 1e-5).all()


@pytest.mark.parametrize("count", [1, 2, 3, 6, 9])
@pytest.mark.parametrize("size", [1, 4, 32])
def test_the_product_integral_equals_that_of_numpy(count, size):
    for seed in range(3):
        made = functions(count, size, seed)
        wanted = numpy.prod([f.astype(float) for f in made], axis=0).mean(axis=(1, 2)).sum()
        assert haarfield.product_integral(*made) == pytest.approx(wanted, abs=2e-5)
        trees = [haarfield.CubemapTree(f) for f in made]
        assert haarfield.product_integral(*trees) == pytest.approx(wanted, abs=2e-5)


def test_the_product_of_no_functions_is_one():
    assert haarfield.product_integral() == 6


def test_light_of_three_channels_can_be_a_factor():
    made = functions(2, 16, 7)
    light = numpy.random.default_rng(1).uniform(size=(6, 16, 16, 3)).astype(numpy.float32)
    wanted = (light * (made[0] * made[1])[..., None]).mean(axis=(1, 2)).sum(axis=0)
    assert numpy.allclose(haarfield.product_integral(*made, light=light), wanted, atol=1e-4)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_the_function_product_equals_that_of_numpy(count):
    made = functions(count, 16, count)
    assert numpy.allclose(haarfield.function_product(*made).texels(), numpy.prod(made, axis=0), atol=1e-5)


def test_a_function_product_integrates_as_its_factors():
    made = functions(4, 32, 11)
    product = haarfield.function_product(*made[:3])
    assert haarfield.product_integral(product, made[3]) == pytest.approx(haarfield.product_integral(*made), abs=1e-5)


def test_solid_angles_cover_the_sphere():
    assert 6 * haarfield.solid_angles(32).sum() == pytest.approx(4 * numpy.pi)
    assert numpy.allclose(numpy.linalg.norm(haarfield.texel_directions(8), axis=-1), 1, atol=1e-6)


def test_uniform_light_on_a_plane_gives_pi():
    light = haarfield.lighting(numpy.ones((16, 32, 3)), 32)
    irradiance = haarfield.product_integral(haarfield.lobe(1, (0, 1, 0), 32), light=light)
    assert numpy.allclose(irradiance, numpy.pi, rtol=1e-3)


@pytest.mark.parametrize(
    "act, error",
    [
        (lambda: haarfield.product_integral(numpy.zeros((6, 3, 3))), ValueError),
        (lambda: haarfield.product_integral(numpy.zeros((5, 4, 4))), ValueError),
        (lambda: haarfield.product_integral(numpy.zeros((6, 4, 8))), ValueError),
        (lambda: haarfield.product_integral(numpy.zeros((6, 4, 4)), numpy.zeros((6, 8, 8))), ValueError),
        (lambda: haarfield.product_integral(numpy.full((6, 4, 4), numpy.nan)), ValueError),
        (lambda: haarfield.product_integral("light"), TypeError),
        (lambda: haarfield.product_integral(numpy.zeros((6, 512, 512))), ValueError),
        (lambda: haarfield.product_integral(numpy.zeros((6, 0, 0))), ValueError),
        (lambda: haarfield.product_integral(numpy.zeros((6, 4, 4)), light=numpy.zeros((6, 8, 8, 3))), ValueError),
        (lambda: haarfield.product_integral(depth=-1, light=numpy.zeros((6, 4, 4, 3))), ValueError),
        (lambda: haarfield.function_product(), TypeError),
        (lambda: haarfield.haar_transform(numpy.zeros((4, 8))), ValueError),
        (lambda: haarfield.inverse_haar_transform(0, [numpy.zeros((3, 2, 2))]), ValueError),
        (lambda: haarfield.CubemapTree(numpy.zeros((6, 4, 4)), coefficients=-1), ValueError),
        (lambda: haarfield.CubemapTree(numpy.zeros((6, 4, 4)), relative_l2_error=numpy.nan), ValueError),
        (lambda: haarfield.lobe(numpy.nan, (0, 1, 0), 8), ValueError),
        (lambda: haarfield.lobe(1, (0, 0, 0), 8), ValueError),
        (lambda: haarfield.texel_directions(3), ValueError),
        (lambda: haarfield.lighting(numpy.zeros((4, 4, 3)), 8), ValueError),
        (lambda: haarfield.use_threads(-1), ValueError),
    ],
)
def test_wrong_arguments_are_exceptions(act, error):
    with pytest.raises(error):
        act()
