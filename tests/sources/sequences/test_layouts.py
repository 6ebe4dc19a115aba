"""What holds for recorded frames of every layout: the registry, as a table."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from published_folders import PUBLISHED
from recorded_folders import REAL, REAL_CAMERAS, SIZE, fov_of, taken
from ros_bags import FORMS, form_of

from hmdwarp import WarpMap
from hmdwarp.errors import InputError
from hmdwarp.poses import Origin
from hmdwarp.poses.assumptions import By
from hmdwarp.sources import sequences
from hmdwarp.sources.sequences import FACTS, RecordedFrame, SequenceOptions, depth_notes, parse_intrinsics, readers

from .folders import fact, made

DEPTH_WITHIN_M = 0.5e-3 + 1e-6  # Half a step of 16 bits in millimetres, the coarsest unit


@pytest.fixture(params=FORMS)
def layout(request):
    return form_of(request.param)


@pytest.fixture
def folder(tmp_path):
    """A folder whose parent belongs to the same test."""
    (tmp_path / "taken").mkdir()
    return tmp_path / "taken"


def test_every_reader_is_tried():
    assert {form.reader for form in FORMS.values()} == set(readers.names())


@pytest.mark.parametrize("reader", list(readers), ids=lambda reader: reader.name)
def test_every_layout_says_what_it_assumes(reader):
    assert [assume.what for assume in reader.assumes if assume.what in FACTS] == list(FACTS)
    assert all(assume.value and isinstance(assume.by, By) for assume in reader.assumes)


def test_every_layout_gives_the_frames_that_were_taken(layout, folder):
    """Poses and fields of view within the digits of their files (12), depth within half a unit."""
    frames = taken(4)
    layout.write(folder, frames)
    sequence = sequences.open(folder, layout.options)
    assert (sequence.layout, sequence.name, len(sequence.frames)) == (layout.reader, folder.name, 4)
    assert sequence.rate_hz == pytest.approx(30, abs=1e-6)
    expected = fov_of()
    for found, one in zip(sequence.frames, frames, strict=True):
        assert found.pose.isclose(one.pose, 1e-9)
        assert attrs.astuple(found.fov)[:4] == pytest.approx(attrs.astuple(expected)[:4], abs=1e-9)
        assert found.view.pose is found.pose and found.view.fov is found.fov and found.time_ns == one.time_ns
        at = sequence.track.at(found.time_ns)
        assert at.origin is Origin.MEASURED and at.pose.isclose(found.pose, 0)
        assert found.size == SIZE
        colour, depth_m = found.read()
        assert colour.dtype == np.uint8
        assert np.abs(colour.astype(int) - one.colour).max() <= layout.colour_within
        assert depth_m.dtype == np.float32 and np.abs(depth_m - one.depth_m).max() <= DEPTH_WITHIN_M
        assert depth_m[0, 0] == 0
    assert [*sequence] == [*sequence.frames] and "4 frames" in repr(sequence) and sequence[-1] is sequence.frames[3]


def test_every_recording_says_who_states_each_fact(layout, folder):
    """Each fact is one entry; what an option states is the user's, and the others are not."""
    layout.write(folder, taken(2))
    found, options = sequences.open(folder, layout.options), layout.options
    by = {assumption.what: assumption.by for assumption in found.assumptions}
    assert set(FACTS) | {"camera axes"} <= by.keys() and len(by) == len(found.assumptions)
    assert (by["intrinsics"] is By.USER) == (options.intrinsics is not None)
    assert (by["depth scale"] is By.USER) == (options.depth_scale is not None)
    assert (by["frame clock"] is By.USER) == (options.frames_rate_hz is not None) and by["no depth"] is not By.USER
    stated = sequences.open(folder, attrs.evolve(options, frames_rate_hz=12.0, no_depth="far"))
    (clock,) = [one for one in found.assumptions if one.what == "frame clock"]
    assert fact(stated, "no depth")[1] is By.USER
    assert fact(stated, "frame clock")[1] is By.USER or "rate" not in clock.option


def test_cropping_leaves_every_pixel_where_it_was_seen(layout, folder):
    layout.write(folder, taken(2))
    whole, inner = (sequences.open(folder, attrs.evolve(layout.options, crop=crop)) for crop in (0, 3))
    for one, other in zip(whole.frames, inner.frames, strict=True):
        assert other.size == (one.size[0] - 6, one.size[1] - 6) and other.pose.isclose(one.pose, 0)
        for before, after in zip(one.read(), other.read(), strict=True):
            assert np.array_equal(before[3:-3, 3:-3], after)
        left, right, down, up = one.fov.tangents
        x, y = (right - left) / one.size[0], (up - down) / one.size[1]
        assert other.fov.tangents == pytest.approx((left + 3 * x, right - 3 * x, down + 3 * y, up - 3 * y), abs=1e-12)
    assert inner.notes == (*whole.notes, "The 3 outermost pixels of each picture are left out.")


def test_texts_with_a_mark_and_lines_of_windows_are_read_alike(layout, folder):
    layout.write(folder, taken(3))
    plain = sequences.open(folder, layout.options)
    for path in folder.parent.rglob("*"):
        if path.suffix in (".txt", ".json", ".freiburg", ".log", ".csv"):
            path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n"))
    again = sequences.open(folder, layout.options)
    assert (again.layout, len(again.frames)) == (layout.reader, 3)
    for one, other in zip(again.frames, plain.frames, strict=True):
        assert one.time_ns == other.time_ns and one.pose.isclose(other.pose, 0)


@pytest.mark.parametrize("form", PUBLISHED)
def test_a_layout_by_name_refuses_an_empty_folder(form, tmp_path):
    with pytest.raises(InputError, match="expected|no such file|cannot be read") as caught:
        sequences.open(tmp_path, attrs.evolve(PUBLISHED[form].options, layout=PUBLISHED[form].reader))
    assert "\n" not in str(caught.value)


def test_a_crop_leaves_some_pixels(tmp_path):
    made(tmp_path, "npz")
    most = (min(SIZE) - 1) // 2
    assert min(sequences.open(tmp_path, SequenceOptions(crop=most)).frames[0].size) in (1, 2)
    with pytest.raises(InputError, match=f"--crop {most + 1}: .* has {SIZE[0]}x{SIZE[1]} pixels; expected to leave"):
        sequences.open(tmp_path, SequenceOptions(crop=most + 1))


def agreeing(first: RecordedFrame, second: RecordedFrame) -> float:
    """Share of the first's pixels seen in the second that have the same depth there, within 2 %.

    By the warp map, in pixels from the bottom left. What the second hides by something nearer is
    left out.
    """
    (wide, high), depths = first.size, [np.flipud(frame.depth_m).astype(float) for frame in (first, second)]
    y, x = np.nonzero(depths[0] > 0)
    warp = WarpMap.between(first.view, first.size, second.view, second.size)
    pixels, inverse, _ = warp.apply(np.stack([x + 0.5, y + 0.5], axis=1), 1 / depths[0][y, x])
    inside = (pixels >= 0).all(axis=1) & (pixels < (wide, high)).all(axis=1)
    column, row = pixels[inside].astype(int).T
    nearer = depths[1][row, column] * inverse[inside]
    return float((np.abs(nearer[nearer > 0.98] - 1) < 0.02).mean())


@pytest.mark.parametrize("name", REAL_CAMERAS)
def test_real_frames_agree_with_each_other_and_have_no_sky(name):
    """A share that only the right axes, unit and inverse give: the wrong inverse gives 2 to 6 %."""
    if not (REAL / name).is_dir():
        pytest.skip(f"no real frames: {REAL / name} is absent (they are not shipped)")
    intrinsics, scale, share = REAL_CAMERAS[name]
    sequence = sequences.open(REAL / name, SequenceOptions(intrinsics=parse_intrinsics(intrinsics), depth_scale=scale))
    assert len(sequence.frames) == 5 and depth_notes(sequence) == []
    assert agreeing(*sequence.frames[3:]) > share
