"""Runs the examples with small sizes."""

import os
import subprocess
import sys

from conftest import SOURCE

import haarfield


def run(name, folder, *arguments):
    """Returns the output of an example."""
    environment = dict(os.environ, MPLCONFIGDIR=str(folder / "matplotlib"))
    result = subprocess.run(
        [sys.executable, SOURCE / "tools/python/examples" / name, *map(str, arguments)],
        capture_output=True,
        text=True,
        env=environment,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout


def is_picture(path):
    pixels, _ = haarfield.read_image(path)
    return pixels.std() > 0.01


def test_relight(chair_file, tmp_path):
    said = run("relight.py", tmp_path, chair_file, tmp_path, 4, 32)
    assert float(said.split("at the vertices ")[1].split(",")[0]) < 0.05
    assert is_picture(tmp_path / "relight.png")


def test_six_functions(tmp_path):
    said = run("six_functions.py", tmp_path, tmp_path, 20, 4000)
    assert "integrals of six functions" in said
    assert "processor time per vertex" in said
    assert is_picture(tmp_path / "six_functions.png")


def test_look_into_field(chair_file, tmp_path):
    assert "is open" in run("look_into_field.py", tmp_path, chair_file, "chair", tmp_path)
    assert is_picture(tmp_path / "field.png")


def test_scene_in_python(tmp_path):
    assert "vertices in" in run("scene_in_python.py", tmp_path, tmp_path, 2000)
    assert is_picture(tmp_path / "stair.png")
    assert (tmp_path / "stair.pov").exists() and (tmp_path / "stair.glb").exists()
