"""Frames from Python: equal to those of C++, with radiance that is not copied."""

import gc

import numpy
import pytest
from conftest import floor_arrays, sky_pixels
from frame_times import GESTURES, least_times
from test_session import resident_bytes

import haarfield


@pytest.mark.parametrize("gesture", GESTURES)
def test_frames_are_bit_identical_to_those_of_cpp(chair_file, gesture):
    least_times(chair_file, gesture, rounds=3, frames=5)  # compares them after each round


def test_radiance_of_many_vertices_is_not_copied(vertices=300_000):
    floor = {"mesh": haarfield.Mesh(*floor_arrays()), "fine_vertices": vertices}
    scene = haarfield.scene(
        {"environment": {"image": sky_pixels()}, "entities": {"floor": floor}, "instances": [{"entity": "floor"}]}
    )
    session = scene.session(bounces=0, light_coefficients=50)
    session.vary_light()
    for step in range(1, 6):
        session.turn_environment(9 * step, axis=(1, 0, 0))
        session.frame()
    (first,) = session.radiance
    assert first.shape[0] >= vertices and first.shape[1] == 3 and first.dtype == numpy.float32
    assert not first.flags.owndata and first.base is not None and first.flags.c_contiguous
    place, before = first.__array_interface__["data"][0], first.copy()
    gc.collect()
    resident = resident_bytes()
    kept = []
    for step in range(6, 26):
        session.turn_environment(9 * step, axis=(1, 0, 0))
        session.frame()
        kept += session.radiance
    assert {array.__array_interface__["data"][0] for array in kept} == {place}
    assert not numpy.array_equal(first, before)
    grown = resident_bytes() - resident
    print(f"20 arrays of {len(first)} vertices, {1e-6 * first.nbytes:.1f} MB each, in {1e-6 * grown:.1f} MB more")
    assert grown < 5 * first.nbytes  # copies would take 20, and threads take some of their own


if __name__ == "__main__":
    test_radiance_of_many_vertices_is_not_copied(1_000_000)
