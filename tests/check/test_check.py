"""hmdwarp check: a wrong convention is found and named, right frames are called right, and what
frames do not show is not guessed."""

from __future__ import annotations

import os
from collections import Counter

import attrs
import numpy as np
import pytest
from check_rates import SAME_PX, off_px, recorded_for, results
from depth_camera import DepthCamera
from other_faults import FAULTS, Fault
from PIL import Image
from scipy.spatial.transform import Rotation
from wrong_frames import INTERVAL_NS, MISREADINGS, Recording, filmed, right_frames

from hmdwarp.base import InputError
from hmdwarp.check import LEFT, Answer, Reading, Stated, StatedFrame, check, read_stated
from hmdwarp.geometry import DepthLayer, Fov, Pose, View
from hmdwarp.sources.sequences import SequenceOptions

# Random cases, by default each misreading once; docs/check.md has the figures of 1000.
ONE_OF_EACH = len(MISREADINGS)
CASES = int(os.environ.get("HMDWARP_CHECK_CASES", ONE_OF_EACH))
TWO = max(4, CASES // 5)
# Of the faults, by default one of each kind: others take as long.
SOME = (
    "cut off at 2.5 m", "scales, 0.03", "lens, k1 (0.2,)", "depth 1.07 as wide", "turned by (0, 2, 0)", "late by 0.15 s"
)  # fmt: skip
CAMERA = DepthCamera(noise=0.002, near_m=0.2, far_m=8.0, edge_gaps=0.5)


@pytest.fixture(scope="module")
def recorded(gpu) -> list[Recording]:
    return recorded_for(gpu, CASES)


@pytest.fixture(scope="module")
def in_the_room(recorded) -> Recording:
    return recorded[0]


def named(frames: list[StatedFrame]) -> list[str]:
    return [finding.name for finding in check(Stated(frames)).findings if not finding.as_stated]


if CASES > ONE_OF_EACH:  # those are tests of their own, below

    def test_a_single_wrong_convention_is_found_and_named_and_right_frames_are_called_right(recorded):
        """At least 99 %, of random cameras, motions, noise, gaps, worlds and numbers."""
        missed = Counter(trial.misread for trial in results(recorded, range(CASES)) if not trial.is_right)
        print(f"{missed.total()} of {CASES} missed: {dict(missed)}")
        assert missed.total() <= 0.01 * CASES, missed


def test_two_wrong_conventions_are_both_named_or_it_says_that_it_cannot_tell(recorded):
    found = Counter(trial.outcome for trial in results(recorded, range(TWO), faults=2))
    assert found["wrong"] <= 0.02 * TWO and found["right"] >= 0.6 * TWO, found


@pytest.mark.parametrize("name", FAULTS if CASES >= 1000 else SOME)
def test_a_fault_that_is_no_convention_gets_no_other_cause(name):
    """In a room and a motion of its own: it cannot be told, or is the time of a late pose."""
    answer = check(Stated(FAULTS[name].frames(list(FAULTS).index(name))))
    told = [finding.name for finding in answer.findings if not finding.as_stated and answer.is_told]
    assert told in ([], ["time"] if "late" in name else []) and bool(told) == bool(answer.code)
    assert told or answer.verdict != "wrong" or "cannot be told" in answer.headline


def test_a_focal_length_that_is_3_percent_long_is_named_and_measured(in_the_room):
    right = right_frames(in_the_room, CAMERA, np.random.default_rng(12))
    given = filmed(right, (1 / 1.03, 1 / 1.03))
    answer = check(Stated(given))
    assert [finding.name for finding in answer.findings if not finding.as_stated] == ["focal"]
    assert intrinsics(mend(given[0], answer.code)) == pytest.approx(intrinsics(right[0]), abs=SAME_INTRINSICS_PX)


def test_intrinsics_of_another_size_are_found(in_the_room):
    """525/319.5/239.5 of 640x480, taken for those of a small picture."""
    right = right_frames(in_the_room, CAMERA, np.random.default_rng(13))
    fx, fy, cx, cy = right[0].view.fov.intrinsics((96, 72))
    answer = check(Stated(filmed(right, (fx / 78.75, fy / 78.75), (48, 36))))
    assert {finding.name for finding in answer.findings if not finding.as_stated} == {"focal", "centre"}
    # A hundredth of the focal length and half a pixel of the small picture: noise and gaps.
    assert answer.reading.wide_x == pytest.approx(78.75 / fx, rel=0.01)
    assert (answer.reading.pixel_x, answer.reading.pixel_y) == pytest.approx((48, 36), abs=0.5)


def moved(turn_deg: float, way_m: tuple[float, float, float], axis: tuple[float, float, float] = (0, 1, 0)):
    """Return frames of a head that turns there and back, and moves along one line."""

    def at(time_ns: int) -> Pose:
        turn = Rotation.from_rotvec(np.radians(turn_deg) * np.sin(time_ns / 8e7) * np.array(axis))
        return Pose(np.array([0, 1.5, 0]) + np.sin(time_ns / 1.2e8) * np.array(way_m), turn.as_quat())

    return Fault().frames(14, at)


def test_a_head_that_moves_to_the_side_alone_does_not_tell_focal_length_from_depth_scale():
    """Parallax is the focal length times the way over the depth: both name the same pictures."""
    frames = filmed(moved(0, (0.3, 0, 0)), (1.2, 1.2))
    answer = check(Stated(frames))
    assert answer.verdict == "wrong" and "cannot be told" in answer.headline
    assert "field of view" in answer.headline and "depth scale" in answer.headline
    assert not answer.code and len(answer.as_good) > 1
    assert all(finding.as_stated for finding in answer.findings)
    assert {"focal", "scale"} <= {finding.name for finding in answer.findings if not finding.told}


def test_a_head_that_only_turns_tells_the_focal_length_and_no_scale_and_says_why():
    frames = moved(15, (0, 0, 0), (0.3, 1, 0.5))
    assert named(filmed(frames, (1.1, 1.1))) == ["focal"]
    answer = check(Stated(frames))
    found = untold(answer)
    assert all(finding.as_stated for finding in answer.findings) and "order" not in found
    assert "places farther apart" in found["scale"]


def test_pixels_stay_square_where_a_head_that_never_looks_up_leaves_the_height_open():
    """Intrinsics of another size: the height was 3.5 times too flat. Noise moves a hundredth."""
    frames = moved(15, (0.3, 0, 0.1))
    fx, fy, _, _ = frames[0].view.fov.intrinsics((96, 72))
    answer = check(Stated(filmed(frames, (fx / 78.75, fy / 78.75), (48, 36))))
    assert answer.reading.wide_x == answer.reading.wide_y == pytest.approx(78.75 / fx, rel=0.02)


@pytest.mark.parametrize("number", range(ONE_OF_EACH), ids=MISREADINGS)
def test_what_is_wrong_is_named_is_told_and_has_code_that_reads_the_frames_right(number, recorded):
    """Headline, reasons and code are one decision."""
    (trial,) = results(recorded, [number])
    answer = trial.answer
    assert trial.is_right
    changed = [finding for finding in answer.findings if not finding.as_stated]
    assert all(finding.told and finding.label in answer.headline for finding in changed)
    assert bool(changed) == bool(answer.code) == (answer.verdict == "wrong" and not answer.as_good)
    if trial.misread in ("right", "eyes swapped", "late", "not reversed"):
        return  # no line of code alone puts these right
    assert answer.verdict == "wrong" and answer.code
    mended = [mend(frame, answer.code) for frame in trial.wrong]
    assert off_px(trial.right, mended, Reading()) < SAME_PX
    assert intrinsics(mended[0]) == pytest.approx(intrinsics(trial.right[0]), abs=SAME_INTRINSICS_PX)
    if trial.misread == "scale":
        known = np.isfinite(trial.wrong[0].depth) & (trial.right[0].depth > 0)
        factors = trial.wrong[0].depth[known] / trial.right[0].depth[known]
        assert answer.reading.factor == pytest.approx(np.median(factors), rel=0.02)


def under_sky(recording: Recording, rng: np.random.Generator) -> list[StatedFrame]:
    """Return frames with sky above 1.2 m, of one colour, infinitely far: more than half of all."""
    frames = []
    for one, frame in zip(recording.eyes[LEFT], right_frames(recording, CAMERA, rng), strict=True):
        up = (one.view.rays(frame.depth.shape[::-1])[::-1] @ one.view.pose.rotation_matrix.T)[..., 1]
        is_sky = one.view.pose.position_m[1] + up * one.truth_m > 1.2
        colour = np.where(is_sky[..., None], np.array([160, 190, 235], frame.colour.dtype), frame.colour)
        frames.append(attrs.evolve(frame, depth=np.where(is_sky, np.inf, frame.depth), colour=colour))
    assert np.median([np.isinf(frame.depth).mean() for frame in frames]) > 0.5
    return frames


@pytest.mark.parametrize("name", ["rows up", "along the ray"])
def test_most_of_the_picture_may_be_sky(name, in_the_room):
    """Sky agrees with sky under many readings."""
    rng = np.random.default_rng(17)
    misread, expected = MISREADINGS[name]
    assert named(misread(under_sky(in_the_room, rng), rng)) == [expected] * (expected is not None)


def test_sky_at_the_far_plane_of_a_buffer_moves_no_plane(in_the_room):
    """Where a buffer was cleared, nothing is: a surface there would make the frames disagree."""
    layer = DepthLayer(0, 1, 0.1, 30)
    with np.errstate(divide="ignore"):
        frames = [
            attrs.evolve(one, depth=layer.encode(1 / one.depth).astype(np.float32))
            for one in under_sky(in_the_room, np.random.default_rng(17))
        ]
    answer = check(Stated(frames))
    assert [finding.name for finding in answer.findings if not finding.as_stated] == ["encoding"]
    # 1 / near - 1 / far is the factor: noise and gaps move it by less than a fiftieth.
    assert answer.reading.factor == pytest.approx(-(1 / 0.1 - 1 / 30), rel=0.02)


def mend(frame: StatedFrame, code: tuple[str, ...]) -> StatedFrame:
    """Run the lines over one frame."""
    height, width = frame.depth.shape
    known = {"np": np, "Pose": Pose, "View": View, "Fov": Fov, "Rotation": Rotation, "width": width, "height": height}
    known |= {"DepthLayer": DepthLayer, "pose": frame.view.pose, "fov": frame.view.fov}
    known |= {"colour": frame.colour, "depth_m": frame.depth}
    with np.errstate(divide="ignore"):
        exec("\n".join(code), known)
    view = View(known["pose"], known["fov"])
    return attrs.evolve(frame, colour=known["colour"], depth=known["depth_m"], view=view)


# A hundredth of the focal length is half a pixel at the border; noise and gaps move no more.
SAME_INTRINSICS_PX = 0.6


def intrinsics(frame: StatedFrame) -> np.ndarray:
    return np.array(frame.view.fov.intrinsics(frame.depth.shape[::-1]))


def test_the_time_is_the_one_that_was_wrong(in_the_room):
    frames = right_frames(in_the_room, CAMERA, np.random.default_rng(5))
    late = round(0.4 * INTERVAL_NS)
    moved = [
        attrs.evolve(frame, view=View(in_the_room.eye_at(LEFT, frame.time_ns - late), frame.view.fov))
        for frame in frames
    ]
    # A tenth of the offset: the motion between frames is a curve through their poses.
    assert check(Stated(moved)).reading.late_s == pytest.approx(late / 1e9, rel=0.1)


def untold(answer: Answer) -> dict[str, str]:
    return {finding.name: finding.why for finding in answer.findings if not finding.told}


def test_two_frames_tell_no_time_and_one_eye_no_swap(in_the_room):
    frames = right_frames(in_the_room, CAMERA, np.random.default_rng(7))[2:9:6]
    found = untold(check(Stated(frames)))
    assert "five or more frames" in found["time"]
    assert "two folders" in found["eyes"]


def test_one_instant_of_both_eyes_does_not_tell_a_swap_from_an_inverse(in_the_room):
    """Eyes that look the same way: either turns the way from one to the other around."""
    frames = right_frames(in_the_room, CAMERA, np.random.default_rng(8), stereo=True)[8:10]
    frames = [attrs.evolve(frame, view=View(Pose(frame.view.pose.position_m), frame.view.fov)) for frame in frames]
    apart = frames[1].view.pose.position_m - frames[0].view.pose.position_m
    along = np.linalg.norm(apart)
    poses = (Pose(), Pose((along, 0, 0)))
    swapped = [attrs.evolve(one, view=View(pose, one.view.fov)) for one, pose in zip(frames, poses[::-1], strict=True)]
    answer = check(Stated(swapped))
    assert answer.verdict == "wrong" and answer.as_good


def test_frames_of_different_things_do_not_agree(recorded):
    """Pictures of one place with the poses of another."""
    rng = np.random.default_rng(9)
    here, there = (right_frames(frame, CAMERA, rng) for frame in recorded[::2][:2])
    mixed = [
        attrs.evolve(a, view=View(b.view.pose @ a.view.pose, a.view.fov)) for a, b in zip(here, there, strict=True)
    ]
    shuffled = [attrs.evolve(mixed[k], view=mixed[-1 - k].view) for k in rng.permutation(len(mixed))]
    answer = check(Stated(shuffled))
    assert answer.verdict == "no agreement"
    assert "stands still" in answer.headline and not answer.code


def test_pictures_without_detail_do_not_agree_in_colour(in_the_room):
    """Every colour is the same, so only depth says anything."""
    frames = right_frames(in_the_room, CAMERA, np.random.default_rng(9))
    frames = [attrs.evolve(frame, colour=np.full_like(frame.colour, 0.5)) for frame in frames]
    answer = check(Stated(frames))
    assert answer.verdict == "no agreement" and "but not in colour" in answer.headline


def test_frames_that_cannot_be_compared_are_refused(in_the_room):
    frames = right_frames(in_the_room, CAMERA, np.random.default_rng(11))
    with pytest.raises(InputError, match="two or more"):
        Stated(frames[:1])
    with pytest.raises(InputError, match="one size"):
        Stated([frames[0], attrs.evolve(frames[1], depth=frames[1].depth[::2])])
    with pytest.raises(InputError, match="no pixel has depth"):
        Stated([frames[0], attrs.evolve(frames[1], depth=np.zeros_like(frames[1].depth))])


def test_a_folder_is_listed_as_it_was_read_and_its_sky_noted(recorded_sky):
    stated = read_stated([recorded_sky], SequenceOptions.of({"depth_scale": 0.001, "intrinsics": "60,60,39.5,29.5"}))
    answer = check(stated).as_json()
    by = {row["what"]: row["by"] for row in answer["assumptions"]}
    assert by["depth scale"] == by["intrinsics"] == "user" and "default" in by.values()
    assert any("--no-depth far" in note for note in answer["notes"])


@pytest.mark.parametrize(("apart", "rate_hz"), [(1, 10), (2, 20), (3, 1000)])
def test_of_a_long_folder_it_takes_24_frames_where_the_camera_moves_most(apart, rate_hz, tmp_path):
    """0.1 s apart, or nearer where the folder is shorter."""
    first, last = 11, 11 + 23 * apart
    for folder in ("color", "depth"):
        (tmp_path / folder).mkdir()
    poses = []
    for k in range(93):
        Image.fromarray(np.full((2, 2, 3), 90, np.uint8)).save(tmp_path / "color" / f"{k}.png")
        Image.fromarray(np.full((2, 2), 2000, np.uint16)).save(tmp_path / "depth" / f"{k}.png")
        fast = min(max(k, first), last)
        poses.append(f"{0.01 * fast + 0.001 * (k - fast)} 0 0 0 0 0 1\n")
    (tmp_path / "pose.txt").write_text("".join(poses), encoding="utf-8")
    said = {"depth_scale": 0.001, "intrinsics": "2,2,0.5,0.5", "frames_rate": rate_hz}
    found = [frame.view.pose.position_m[0] for frame in read_stated([tmp_path], SequenceOptions.of(said)).frames]
    assert found == pytest.approx([0.01 * k for k in range(first, last + 1, apart)])


@pytest.fixture
def recorded_sky(tmp_path):
    """A folder of the layout `numbered` whose upper third has no depth."""
    depth = np.full((60, 80), 2000, np.uint16)
    depth[:20] = 0
    for folder in ("color", "depth"):
        (tmp_path / folder).mkdir()
    colours = np.random.default_rng(1).integers(0, 255, (60, 80, 3), dtype=np.uint8)
    for k in range(3):
        Image.fromarray(colours).save(tmp_path / "color" / f"{k}.png")
        Image.fromarray(depth).save(tmp_path / "depth" / f"{k}.png")
    (tmp_path / "pose.txt").write_text("".join(f"{0.01 * k} 0 0 0 0 0 1\n" for k in range(3)), encoding="utf-8")
    return tmp_path
