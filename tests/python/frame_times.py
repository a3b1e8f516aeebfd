"""Measures a session's frames from Python and from C++, alternating: python3 frame_times.py SCENE [ROUNDS].

Needs the module in PYTHONPATH and haarfield_study in HAARFIELD_STUDY. Prints, for each gesture, the minimum wall and
processor time of a frame by haarfield_study and by the module, after checking that both have equal radiance. Compare
processor times on a busy machine.
"""

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy

import haarfield

STUDY = os.environ.get("HAARFIELD_STUDY", str(Path(__file__).resolve().parents[2] / "build/dev/haarfield_study"))
GESTURES = ("light", "eye", "instance")


class InCpp:
    """A session in haarfield_study."""

    def __init__(self, scene, frames):
        command = [STUDY, "session", str(scene), "--frames", str(frames)]
        self.study = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.study.stdout.readline()  # the compiler's name

    def gesture(self, name):
        """Returns the minimum wall and processor time of its frames [s], and a checksum of the final radiance."""
        self.study.stdin.write(name + "\n")
        self.study.stdin.flush()
        seconds, work, digest = self.study.stdout.readline().split()
        return (float(seconds), float(work)), int(digest, 16)

    def close(self):
        self.study.stdin.close()
        self.study.stdout.close()
        return self.study.wait()


class InPython:
    """A session of the module, with the steps of tests/studies/study_session.cpp."""

    def __init__(self, scene, frames):
        self.session = haarfield.open(scene).session()
        self.frames, self.number, self.varying = frames, 0, None

    def vary(self, name):
        if name == "light":
            self.session.vary_light()
        elif name == "eye":
            self.session.vary_eye()
        else:
            self.session.vary_instance(-1)
        self.varying = name

    def step(self, name):
        self.number += 1
        if name == "light":
            self.session.turn_environment(7 * self.number)
        elif name == "eye":
            self.session.set_eye((2 + 0.125 * (self.number % 16), 1.5, 2))
        else:
            self.session.place(-1, translate=(-1 - 0.03125 * (self.number % 16), 0, 0.25))

    def gesture(self, name):
        if name != self.varying:
            self.vary(name)
        seconds, work = float("inf"), float("inf")
        for _ in range(self.frames):
            self.step(name)
            work_start, start = time.process_time(), time.perf_counter()
            self.session.frame()
            seconds = min(seconds, time.perf_counter() - start)
            work = min(work, time.process_time() - work_start)
        bits = numpy.concatenate(self.session.radiance).view(numpy.uint32).ravel().astype(numpy.uint64)
        weights = 2 * numpy.arange(len(bits), dtype=numpy.uint64) + 1
        return (seconds, work), int((weights * bits).sum())


def least_times(scene, name, rounds, frames=10):
    """Returns wall and processor time of a gesture's frames in C++ and in Python [s]. Fails if radiance differs."""
    sides = InCpp(scene, frames), InPython(scene, frames)
    least = numpy.full((2, 2), numpy.inf)
    for number in range(rounds):
        made = [None, None]
        for which in (0, 1) if number % 2 else (1, 0):
            times, made[which] = sides[which].gesture(name)
            least[which] = numpy.minimum(least[which], times)
        assert made[0] == made[1], f"{name}, round {number}: C++ and Python have other bits"
    assert sides[0].close() == 0
    return least


if __name__ == "__main__":
    for gesture in GESTURES:
        cpp, python = 1e3 * least_times(sys.argv[1], gesture, int(sys.argv[2]) if len(sys.argv) > 2 else 30)
        for which, what in enumerate(("frame", "its threads' work")):
            more = 100 * (python[which] / cpp[which] - 1)
            print(f"{gesture:<10}{what:<18} C++ {cpp[which]:8.3f} ms   Python {python[which]:8.3f} ms   {more:+.2f} %")
        sys.stdout.flush()
