"""What the depth of recorded frames suggests: values that are none, sky as holes, another unit."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.sources.sequences import about_sky, about_unit

from .folders import blotted


def scene(size=(160, 120)) -> np.ndarray:
    """Depth of a floor and of a wall with noise, in metres."""
    return 2 + np.random.default_rng(3).random(size[::-1]).astype(np.float32)


def sky_above(depth: np.ndarray) -> np.ndarray:
    depth[:50] = 0
    depth[20:80, 60:70] = 3  # a tower before it
    return depth


def at(rows: slice, columns: slice, value: float = 0):
    return lambda depth: (blotted(rows, columns, value)(depth), depth)[1]


EVERY = slice(None)
# With whether they are sky.
MADE = {
    "sky above": (sky_above, True),
    "sky at one side": (at(slice(10, 80), slice(0, 40), np.nan), True),
    "holes inside": (at(slice(30, 80), slice(40, 100)), False),
    "a rim": (lambda depth: np.pad(depth[8:-8, 8:-12], ((8, 8), (8, 12))), False),
    "noise": (lambda depth: np.where(np.random.default_rng(5).random(depth.shape) < 0.3, 0, depth), False),
    "nothing": (at(EVERY, EVERY), False),
    "all of it": (lambda depth: depth, False),
}


@pytest.mark.parametrize("made", MADE)
def test_sky_without_depth_is_noticed_and_holes_of_a_depth_camera_are_no_sky(made):
    change, is_sky = MADE[made]
    notes = about_sky([scene(), change(scene())])
    assert ["--no-depth far" in note for note in notes] == [True] * is_sky


@pytest.mark.parametrize("near", [0.05, 0.1, 0.3])
@pytest.mark.parametrize("far", [10.0, 1000.0, np.inf])
@pytest.mark.parametrize("buffer", ["standard", "signed", "reversed"])
def test_values_of_a_depth_buffer_are_noted(near, far, buffer):
    """Of a room from 1 to 9 m, at planes that engines use."""
    metres = np.linspace(1, 9, 120 * 90).reshape(90, 120)
    clip = (1 - near / metres) / (1 - near / far)
    values = {"standard": clip, "signed": 2 * clip - 1, "reversed": 1 - clip}[buffer]
    said = about_unit([values], 0.05, "{:g}")
    crowded = np.median(values) > 0.9 or np.median(values) < 0.05
    assert len(said) == crowded and all("values of a depth buffer, not metres" in note for note in said)
    assert all(("(0, 1, far, near)" in note) == (buffer == "reversed") for note in said)
    assert crowded or near == 0.3  # 1 - 0.3 m / 5 m, and twice that less 1: a table in front of the eye
    assert about_unit([values], 0.0, "{:g}") == []


@pytest.mark.parametrize(("dtype", "said"), [(np.float32, True), (np.uint16, False)])
def test_metres_that_a_scale_for_millimetres_shrinks_are_noted(dtype, said):
    """A room from 1 to 9 m in floats; the same integers are what a scale is for."""
    raw = np.linspace(1, 9, 108).astype(dtype)
    (note,) = about_unit([raw * 0.001], 0.05, "--depth-scale {:g}", [raw])
    assert ("up to 9 in the file: if that is metres already, --depth-scale 1" in note) == said


@pytest.mark.parametrize("depth", [np.ones((9, 12)), np.linspace(0.2, 1, 108), np.linspace(0.3, 4, 108)])
def test_metres_near_the_eye_are_no_depth_buffer(depth):
    assert about_unit([depth], 0.05, "{:g}") == []
