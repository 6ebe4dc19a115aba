"""What the depth of recorded frames suggests: values that are none, sky as holes, another unit."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from recorded_folders import MILLIMETRES, taken, write_npz, write_numbered, write_pictures

from hmdwarp.sources import sequences
from hmdwarp.sources.sequences import SequenceOptions, about_sky, about_unit, depth_notes

from .folders import blotted, edited


def scene(size=(160, 120)) -> np.ndarray:
    """Depth of a floor and of a wall with noise, in metres."""
    return 2 + np.random.default_rng(3).random(size[::-1]).astype(np.float32)


PART, ONE = (slice(5, 8), slice(6, 12)), (slice(5, 6), slice(6, 7))


@pytest.mark.parametrize(
    ("numbers", "part", "value", "told"),
    [
        (
            (0, 1, 4),
            PART,
            65535,
            "36 pixels (1.4 %) of the depth of 3 frames looked at are 65535, the largest value of",
        ),
        # A PNG does not say how many bits its sensor has: 4095 is a depth, of which many are told.
        (
            range(5),
            PART,
            4095,
            "54 pixels (2.1 %) of the depth of 3 frames looked at are 4095, the largest value of 12",
        ),
        (range(5), ONE, 4095, ""),
    ],
)
def test_a_largest_value_is_counted(numbers, part, value, told, tmp_path):
    """In the first, middle and last frame."""
    edited(tmp_path, "numbered", {f"depth/{number}.png": blotted(*part, value) for number in numbers}, 5)
    sequence = sequences.open(tmp_path, MILLIMETRES)
    notes = depth_notes(sequence)
    assert [note[: len(told)] for note in notes] == ([told] if told else [])
    assert sequence.frames[0].depth_m[5, 6] == np.float32(4.095 if value == 4095 else 0)


def test_intrinsics_of_another_picture_size_are_told(tmp_path):
    """No option but --intrinsics tells how large the picture was that they are for."""
    write_numbered(tmp_path, taken(2, (320, 240)))
    (note,) = depth_notes(sequences.open(tmp_path, MILLIMETRES))
    assert note.startswith("The optical axis is at 6 % of the width and 5 % of the height") and "--intrinsics" in note


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


def test_sky_that_is_far_is_not_suggested_again(tmp_path):
    frames = [attrs.evolve(frame, depth_m=sky_above(scene())) for frame in taken(2, (160, 120))]
    write_npz(tmp_path, frames)
    assert len(depth_notes(sequences.open(tmp_path))) == 1
    assert depth_notes(sequences.open(tmp_path, SequenceOptions(no_depth="far"))) == []


@pytest.mark.parametrize(("unit", "name"), [(1000, "millimetres"), (100, "centimetres")])
def test_depth_in_another_unit_is_noticed(unit, name, tmp_path):
    (tmp_path / "wrong").mkdir()
    write_npz(tmp_path / "wrong", [attrs.evolve(frame, depth_m=frame.depth_m * unit) for frame in taken(3)])
    (note,) = depth_notes(sequences.open(tmp_path / "wrong"))
    assert "the eye moves by 0.04 m" in note and f"--depth-scale {1 / unit:g} takes it as {name}: 1." in note
    assert depth_notes(sequences.open(tmp_path / "wrong", SequenceOptions(depth_scale=1 / unit))) == []


@pytest.mark.parametrize("value", [0.0, np.nan, -2.0])
def test_frames_without_any_depth_are_noted(value, tmp_path):
    frames = taken(3)
    frames[1] = attrs.evolve(frames[1], depth_m=np.full_like(frames[1].depth_m, value))
    write_npz(tmp_path, frames)
    (note,) = depth_notes(sequences.open(tmp_path))
    assert note.startswith("1 of 3 frames looked at have no depth at all")
    assert ("below 0: expected metres along -z" in note) == (value < 0)


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
    assert all(("reversed_z=True" in note) == (buffer == "reversed") for note in said)
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


def test_plain_frames_have_no_notes(tmp_path):
    write_pictures(tmp_path, taken(3))
    assert depth_notes(sequences.open(tmp_path)) == []
