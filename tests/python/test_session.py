"""Sessions: radiance after changes, use by several threads, leaks of memory."""

import ctypes
import gc
import os
import re
import signal
import threading
import time

import numpy
import pytest
from conftest import description, floor_arrays, sky_pixels

import haarfield


@pytest.fixture
def session(scene):
    return scene.session()


def resident_bytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE")


def allowed_threads():
    """Returns oneTBB's limit of threads in this process: max_allowed_parallelism of tbb::global_control."""
    active_value = ctypes.CDLL("libtbb.so.12")._ZN3tbb6detail2r127global_control_active_valueEi
    active_value.restype = ctypes.c_size_t
    return active_value(0)


def relative_rmse(a, b):
    return numpy.sqrt(((a - b) ** 2).mean() / (b**2).mean())


def test_a_commit_is_bit_identical_to_a_bake(scene, bake, session):
    session.commit()
    for array, name in zip(session.radiance, scene.instances):
        assert numpy.array_equal(array, bake[name].radiance)


def test_the_number_of_threads_is_the_requested_one():
    haarfield.use_threads(3)
    try:
        scene = haarfield.scene(description(), name="threads")
        seen = {}
        scene.bake(error="off", progress=lambda stage, *_: seen.setdefault(stage, set()).add(allowed_threads()))
        assert seen and all(threads == {3} for threads in seen.values()), seen
        assert allowed_threads() == 3
        session = scene.session()
        session.vary_light()
        session.frame()
        assert allowed_threads() == 3
        del session
        assert allowed_threads() == 3
    finally:
        haarfield.use_threads(0)


def test_arrays_follow_the_light(scene, session):
    session.vary_light()
    session.frame()
    floor = session.radiance[0]
    place, before = floor.__array_interface__["data"][0], floor.copy()
    session.turn_environment(90)
    session.frame()
    assert floor.__array_interface__["data"][0] == place
    assert not numpy.array_equal(floor, before)
    turned = scene.changed({"environment": {"rotation": 90}}).bake(error="off")
    assert relative_rmse(floor, turned["floor"].radiance) < 0.05
    session.commit()
    assert session.radiance[0].__array_interface__["data"][0] == place
    assert relative_rmse(floor, turned["floor"].radiance) < 0.01


def test_radiance_follows_a_replaced_light(scene, session):
    session.set_environment(2 * scene.environment())
    session.commit()
    assert relative_rmse(session.radiance[0], 2 * scene.bake(error="off")["floor"].radiance) < 1e-5


def test_radiance_follows_the_eye_and_instances(scene, session):
    session.vary_eye()
    session.set_eye((0, 3, 4))
    session.frame()
    session.vary_instance("left")
    session.place("left", translate=(-0.8, 0, 0.5))
    session.frame()
    moved = description()
    moved["camera"]["position"] = [0, 3, 4]
    moved["instances"][1]["translate"] = [-0.8, 0, 0.5]
    # A preview can be drawn, and a commit equals a bake of the changed scene.
    assert session.picture().shape == (72, 96, 3)
    session.commit()
    baked = haarfield.scene(moved).bake(error="off")
    assert relative_rmse(session.radiance[1], baked["left"].radiance) < 1e-5
    session.rotate("left", (0, 1, 0), 30)
    session.commit()
    assert session.matrices[1][0, 0] == pytest.approx(numpy.cos(numpy.radians(30)), abs=1e-6)


def test_radiance_follows_lamps_and_materials(scene, session):
    lamp = {"name": "bulb", "position": [0, 2, 1], "colour": [3, 3, 3], "fade_distance": 1}
    session.vary_lamps()
    session.set_lamps([lamp])
    session.frame()
    lit = scene.changed({"lights": [lamp]}).bake(error="off")
    assert relative_rmse(session.radiance[0], lit["floor"].radiance) < 0.01
    assert relative_rmse(session.radiance[0], scene.bake(error="off")["floor"].radiance) > 0.1
    session.set_material("grey", {"diffuse": [0.2, 0.4, 0.6]})
    with pytest.raises(haarfield.Error, match="vary_lamps"):
        session.frame()
    session.commit()
    blue = scene.changed({"lights": [lamp], "materials": {"grey": {"diffuse": [0.2, 0.4, 0.6]}}}).bake(error="off")
    for array, name in zip(session.radiance, scene.instances):
        assert numpy.array_equal(array, blue[name].radiance)
    session.set_lamps([])
    session.set_material("grey", {"diffuse": [0.5, 0.5, 0.5]})
    session.commit()
    assert numpy.array_equal(session.radiance[0], scene.bake(error="off")["floor"].radiance)
    with pytest.raises(KeyError, match="no material"):
        session.set_material("gold", {})
    with pytest.raises(haarfield.Error, match="diffuse"):
        session.set_material("grey", {"diffuse": [2, 2, 2]})


def test_radiance_is_separate_from_images():
    positions, triangles = floor_arrays()
    floor = haarfield.Mesh(positions, triangles, uvs=positions[:, [0, 2]] / 4 + 0.5)
    made = description()
    texels = numpy.full((4, 4, 3), 128, numpy.uint8)
    made["materials"]["grey"] = {"diffuse": [1, 1, 1], "specular": [0.3, 0.3, 0.3], "image": texels}
    made["entities"]["floor"]["mesh"] = floor
    scene = haarfield.scene(made, name="tiles")
    session, bake = scene.session(), scene.bake(error="off")
    assert session.under == [] and session.over == []
    session.commit()
    for number, name in enumerate(scene.instances):
        assert relative_rmse(session.under[number], bake[name].under) < 1e-3
    assert session.over[1] is None and session.over[0].max() > 0
    assert relative_rmse(session.over[0], bake["floor"].over) < 0.01
    assert numpy.allclose(session.picture(), bake.picture(), atol=0.01)
    session.vary_eye()
    session.frame()
    assert relative_rmse(session.under[0], bake["floor"].under) < 0.01
    session.vary_lamps()
    session.frame()
    assert relative_rmse(session.under[0], bake["floor"].under) < 0.01
    assert relative_rmse(session.over[0], bake["floor"].over) < 0.01


def test_arrays_keep_their_values_after_clones_and_removals(session):
    session.commit()
    shown = session.radiance
    kept = [array.copy() for array in shown]
    assert session.clone("right", "third") == 3
    session.place("third", translate=(0, 0, 1.5))
    assert session.instances == ["floor", "left", "right", "third"]
    session.commit()
    session.remove("left")
    session.commit()
    gc.collect()
    assert session.instances == ["floor", "right", "third"]
    assert [len(array) for array in session.radiance] == [len(kept[0]), len(kept[2]), len(kept[2])]
    for array, before in zip(shown, kept):
        assert numpy.array_equal(array, before)
    assert not numpy.array_equal(session.radiance[0], kept[0])


def test_radiance_outlives_its_session(scene):
    session = scene.session()
    session.commit()
    radiance = session.radiance[1]
    kept = radiance.copy()
    del session
    gc.collect()
    assert numpy.array_equal(radiance, kept)


def test_a_frame_without_a_varying_input_is_an_error(session):
    with pytest.raises(haarfield.Error, match="no transfer vectors") as raised:
        session.frame()
    named = re.findall(r"vary_\w+", str(raised.value))
    assert named and all(hasattr(session, name) for name in named)
    with pytest.raises(haarfield.Error, match="found no radiance"):
        session.picture()
    assert session.radiance == []


@pytest.mark.parametrize(
    "act, error",
    [
        (lambda s: s.place("nobody"), KeyError),
        (lambda s: s.place(7), IndexError),
        (lambda s: s.place(None), TypeError),
        (lambda s: s.place("left", translate=(1, 2)), ValueError),
        (lambda s: s.place("left", translate=(1, 2, numpy.nan)), ValueError),
        (lambda s: s.place("left", scale=0), ValueError),
        (lambda s: s.place("left", scale=numpy.nan), ValueError),
        (lambda s: s.rotate("left", (0, 0, 0), 1), ValueError),
        (lambda s: s.rotate("left", (0, 1, 0), numpy.inf), ValueError),
        (lambda s: s.turn_environment(numpy.nan), ValueError),
        (lambda s: s.turn_environment(1, (0, 0, 0)), ValueError),
        (lambda s: s.set_eye("here"), TypeError),
        (lambda s: s.set_environment(numpy.zeros((4, 4, 3))), ValueError),
        (lambda s: s.clone("nobody"), KeyError),
        (lambda s: s.vary_instance(-9), IndexError),
        (lambda s: s.vary_light(progress=3), TypeError),
    ],
)
def test_wrong_arguments_are_exceptions(session, act, error):
    with pytest.raises(error):
        act(session)


def test_the_last_instance_cannot_be_removed(session):
    session.remove(0)
    session.remove(0)
    with pytest.raises(ValueError, match="last instance"):
        session.remove(0)


def test_progress_is_called_in_the_calling_thread(session):
    told = []
    session.commit(progress=lambda stage, done, total: told.append((threading.get_ident(), stage, done, total)))
    assert told and {thread for thread, *_ in told} == {threading.get_ident()}
    assert all(done <= total for _, _, done, total in told)


def test_exceptions_of_progress_end_the_call(session):
    def refuse(stage, done, total):
        raise ZeroDivisionError(stage)

    with pytest.raises(ZeroDivisionError):
        session.commit(progress=refuse)
    session.commit()


def test_two_threads_share_a_scene_and_a_session(scene, bake):
    shared = scene.session()
    shared.vary_light()
    errors = []

    def drive(turns):
        try:
            own = scene.session()
            own.commit()
            assert numpy.array_equal(own.radiance[0], bake["floor"].radiance)
            for _ in range(turns):
                shared.turn_environment(0)
                shared.frame()
                shared.radiance[0].sum()
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=drive, args=(20,)) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert errors == []


def test_other_threads_run_during_long_calls(scene):
    counted = [0]
    stop = threading.Event()

    def count():
        while not stop.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    scene.bake(evaluator="dense")
    stop.set()
    thread.join()
    assert counted[0] > 5


def test_an_interrupt_ends_a_long_call_soon(scene):
    sent = []

    def interrupt():
        time.sleep(0.3)
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    many = scene.changed({"entities": {"floor": {"fine_vertices": 400000}}})
    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        many.bake(evaluator="dense")
    thread.join()
    assert time.monotonic() - sent[0] < 10  # some 50 ms on an idle machine


def test_a_thousand_sessions_leak_nothing(scene):
    def open_and_close(count):
        for _ in range(count):
            session = scene.session()
            session.set_eye((1, 2, 3))
            assert session.radiance == []
        gc.collect()

    open_and_close(50)
    before = resident_bytes()
    open_and_close(1000)
    assert resident_bytes() - before < 8e6


def test_committed_sessions_leak_nothing():
    small = description()
    for entity in small["entities"].values():
        entity["fine_vertices"] = 100
    scene = haarfield.scene(small)
    scene.prepare()
    kept = []

    def open_and_close(count):
        for _ in range(count):
            session = scene.session(occlusion="fields")
            session.commit()
            kept[:] = session.radiance
        kept.clear()
        gc.collect()

    open_and_close(8)
    before = resident_bytes()
    open_and_close(30)
    assert resident_bytes() - before < 16e6
