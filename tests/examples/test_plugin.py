"""examples/plugin, installed as a user would, adds its warp to hmdwarp."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def python(*words: object, **env: str) -> str:
    command = [sys.executable, *map(str, words)]
    done = subprocess.run(command, env={**os.environ, **env}, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def path(tmp_path_factory) -> str:
    """Return a PYTHONPATH with the plugin in it, built and installed without a network."""
    place = tmp_path_factory.mktemp("plugin")
    shutil.copytree(ROOT / "examples" / "plugin", place / "source")
    python("-m", "build", "--wheel", "--no-isolation", "--outdir", place, place / "source")
    (wheel,) = place.glob("*.whl")
    python("-m", "pip", "install", "--quiet", "--no-index", "--no-deps", "--target", place / "site", wheel)
    return os.pathsep.join([str(place / "site"), str(ROOT)])


def test_its_warp_turns_the_picture_as_rotation_does_where_the_head_only_yaws(path):
    """And not at all where the head only nods."""
    program = """
import numpy as np
from hmdwarp import Fov, Pose, View, warp_image
fov = Fov.symmetric(1.0, 1.0)
colour, depth_m = np.random.default_rng(1).random((24, 24, 3)), np.full((24, 24), 2.0)
def shown(warp, *axis):
    rendered, now = View(Pose(), fov), View(Pose(orientation_xyzw=(*axis, 1)), fov)
    return warp_image(colour, depth_m, rendered, now, warp=warp).colour
assert (shown("yaw_only", 0, 0.1, 0) == shown("rotation", 0, 0.1, 0)).all()
assert (shown("yaw_only", 0.1, 0, 0) == shown("none", 0.1, 0, 0)).all()
assert (shown("rotation", 0.1, 0, 0) != shown("none", 0.1, 0, 0)).any()
"""
    python("-c", program, PYTHONPATH=path)
