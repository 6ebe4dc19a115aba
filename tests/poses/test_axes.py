"""Axes of files: stated, assumed, contradicted by the motion, or taken from it."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hmdwarp.base import InputError
from hmdwarp.poses import PoseTrack, TraceOptions, load_trace
from hmdwarp.poses.reading.axes import Axes, parse_axes, presets

from .traces import WRITERS, found, kinds, rows, same_motion, save, write

# Matrices, angles and changes of axes round a few times at 2e-16; the angle of a turn near zero has
# the square root of that, some 1e-8.
ROUNDED = 1e-7
BASES = [
    np.eye(3)[list(order)] * np.array(signs)[:, None]
    for order in itertools.permutations(range(3))
    for signs in itertools.product((1.0, -1.0), repeat=3)
]
WALK = load_trace("walk").track  # a person who walks; both recordings have a neck, as people have
LOOK = load_trace("look-around").track  # a person who stands and looks
UP, AHEAD = np.array([0, 1.0, 0]), np.array([0, 0, -1.0])


def in_axes(track: PoseTrack, axes: Axes) -> PoseTrack:
    """The track as a file with those axes holds it, by matrices: the reader goes by quaternions."""
    turned = axes.world.T @ Rotation.from_quat(track.orientation_xyzw).as_matrix() @ axes.head
    return track.evolve(
        position_m=track.position_m @ axes.world, orientation_xyzw=Rotation.from_matrix(turned).as_quat()
    )


def written(folder: Path, track: PoseTrack, **changes) -> Path:
    return write(folder / "head.csv", rows(track), **changes)


def crown_and_gaze(track: PoseTrack) -> np.ndarray:
    turn = Rotation.from_quat(track.orientation_xyzw)
    return np.stack([turn.apply(UP)[:, 1], turn.apply(AHEAD)[:, 1]], axis=1)


def seen_alike(a: PoseTrack, b: PoseTrack) -> bool:
    """Both heads are as upright, look as far up or down, and walk towards their gaze alike.

    What is left is a turn about the vertical and a mirror image, which no motion shows.
    """

    def ahead(track: PoseTrack) -> np.ndarray:
        way = np.diff(track.position_m, axis=0)
        gaze = Rotation.from_quat(track.orientation_xyzw[:-1]).apply(AHEAD)
        return np.einsum("ni,ni->n", way, gaze)

    return np.allclose(crown_and_gaze(a), crown_and_gaze(b), atol=1e-9) and np.allclose(ahead(a), ahead(b), atol=1e-9)


@given(world=st.sampled_from(BASES), head=st.sampled_from(BASES), track=st.sampled_from([WALK, LOOK]))
def test_no_permutation_of_axes_is_read_wrong_in_silence(tmp_path_factory, world, head, track):
    """Every signed permutation of a person's axes is read as it was, or the motion names the axes
    that read it right.
    """
    if np.linalg.det(world) * np.linalg.det(head) < 0:
        return  # no rotation carries a left-handed head into a right-handed world
    path = written(tmp_path_factory.mktemp("axes"), in_axes(track, Axes(world, head)))
    loaded = load_trace(path)
    assert seen_alike(loaded.track, track) or "axes-contradicted" in kinds(loaded)
    assert "assumed" in loaded.axes
    if "axes-contradicted" in kinds(loaded):
        named = found(loaded, "axes-contradicted").done.split("--axes '")[1].split("'")[0]
        right = load_trace(path, TraceOptions(axes=named))
        assert seen_alike(right.track, track)
        assert kinds(right) == kinds(loaded) - {"axes-contradicted"}


@pytest.mark.parametrize("name", presets.names())
def test_a_preset_reads_files_with_its_axes(tmp_path, name):
    axes = presets.get(name)
    scale = axes.metres_per_unit or 1.0
    file = in_axes(WALK, axes)
    path = written(tmp_path, file.evolve(position_m=file.position_m / scale))
    stated = load_trace(path, TraceOptions(axes=name))
    assert same_motion(stated.track, WALK, atol=ROUNDED)
    assert stated.axes.startswith(f"{name} (world=") and "as --axes" in stated.axes
    assert not kinds(stated) & {"axes-contradicted", "place-implausible"}
    if name not in ("openxr", "arkit"):
        defect = next(d for d in load_trace(path).defects if d.kind in ("axes-contradicted", "place-implausible"))
        assert "--axes" in defect.done or "--scale 0.01" in defect.done


def test_left_and_right_hand_are_named_where_motion_cannot_tell(tmp_path):
    """A z-up world whose head looks along x is ROS, or Unreal's mirror image."""
    path = written(tmp_path, in_axes(WALK, presets.get("ros")))
    defect = found(load_trace(path), "axes-contradicted")
    assert "ros" in defect.done and "unreal" in defect.done and "cannot tell" in defect.done


def test_axes_are_stated_for_world_and_head_apart(tmp_path):
    words = "world=x,z,y head=x,-y,z"
    path = written(tmp_path, in_axes(WALK, parse_axes(words)))
    for text in (words, "head=x,-y,z; world=x,z,y", "TUM-RGBD", "tum rgbd"):
        assert same_motion(load_trace(path, TraceOptions(axes=text)).track, WALK, atol=ROUNDED)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("tum-rgb", "did you mean 'tum-rgbd'"),
        ("world=x,y", "three different ones"),
        ("world=x,y,z head=x,y,-z", "left-handed"),
        ("head=x,y,-z up", "expected a preset"),
        ("head=x,y,q", "axis 'q'"),
        ("12", "expected a preset"),
        ("", "expected a preset"),
    ],
)
def test_axes_that_are_none_are_refused(tmp_path, text, said):
    with pytest.raises(InputError, match=said):
        load_trace(written(tmp_path, WALK), TraceOptions(axes=text))


def test_a_tilt_goes_with_axes(tmp_path):
    tilt = Rotation.from_euler("X", 12, degrees=True)
    leaning = WALK.evolve(
        position_m=tilt.apply(WALK.position_m.copy()),
        orientation_xyzw=(tilt * Rotation.from_quat(WALK.orientation_xyzw)).as_quat(),
    )
    path = written(tmp_path, in_axes(leaning, presets.get("unity")))
    up = ",".join(map(repr, tilt.apply(UP).tolist()))
    assert same_motion(load_trace(path, TraceOptions(axes="unity", up=up)).track, WALK, atol=ROUNDED)


def test_the_tilt_advice_never_turns_the_world_of_a_head_that_is_turned_too(tmp_path):
    path = written(tmp_path, in_axes(LOOK, presets.get("ros")))
    assert "tilt" not in kinds(load_trace(path))
    assert "tilt" not in kinds(load_trace(path, TraceOptions(axes="ros")))


def test_notes_name_what_motion_does_not_show(tmp_path):
    """A head that turns on the spot without a neck may look anywhere."""
    still = LOOK.evolve(position_m=np.tile([0.0, 1.6, 0.0], (len(LOOK), 1)))
    assert "others fit the motion nearly as well" in load_trace(written(tmp_path, still)).axes
    assert "the motion agrees" in load_trace(written(tmp_path, LOOK)).axes


@pytest.mark.parametrize("name", WRITERS)
def test_a_file_of_ours_states_its_axes(tmp_path, name):
    loaded = load_trace(save(LOOK, tmp_path / "head", name))
    assert loaded.axes == "openxr (world=x,y,-z head=x,y,-z), stated by the file" and not loaded.axes_assumed


def test_a_comment_states_the_axes(tmp_path):
    file = in_axes(WALK, presets.get("aria"))
    path = written(tmp_path, file, header="# axes: aria\ntime,x,y,z,qx,qy,qz,qw")
    loaded = load_trace(path)
    assert same_motion(loaded.track, WALK, atol=ROUNDED)
    assert loaded.axes.endswith("stated by the file") and not kinds(loaded) & {"axes-contradicted", "tilt"}


def test_a_clock_that_no_tracker_has_is_named_with_the_unit_that_fits(tmp_path):
    for unit, rate in (("us", "9e+04"), ("s", "0.09")):
        table = rows(WALK, stamp=lambda ns: repr(ns / 1e6))  # milliseconds
        path = write(tmp_path / "head.csv", table, header=f"time {unit},x,y,z,qx,qy,qz,qw")
        loaded = load_trace(path)
        defect = found(loaded, "rate-implausible")
        assert "--time-unit ms" in defect.done and rate in defect.what
        right = load_trace(path, TraceOptions(time_unit="ms"))
        assert right.track.rate_hz == pytest.approx(90, rel=1e-3) and "rate-implausible" not in kinds(right)


@pytest.mark.parametrize(
    ("metres", "said"),
    [
        (0.01, "takes the positions as centimetres"),
        (0.001, "takes the positions as millimetres"),
        (0.3048, "takes it as feet"),  # by its height, if the floor is there
    ],
)
def test_a_head_where_none_is_is_named_with_the_scale_that_fits(tmp_path, metres, said):
    path = written(tmp_path, WALK.evolve(position_m=WALK.position_m / metres))
    defect = found(load_trace(path), "place-implausible")
    assert f"--scale {metres:g} {said}" in defect.done
    assert "place-implausible" not in kinds(load_trace(path, TraceOptions(scale=metres)))


def test_gravity_columns_decide_which_way_is_up(tmp_path):
    """A head that stays as it is may lie on its back, for all that its motion says."""
    still = WALK.evolve(orientation_xyzw=WALK.orientation_xyzw[:1].repeat(len(WALK), axis=0))
    file = in_axes(still, parse_axes("world=x,z,y head=x,z,y"))
    table = [[*r, "0.0", "0.0", "-9.81"] for r in rows(file)]
    header = "time,x,y,z,qx,qy,qz,qw,gravity_x_world,gravity_y_world,gravity_z_world"
    defect = found(load_trace(write(tmp_path / "head.csv", table, header=header)), "axes-contradicted")
    assert "gravity columns" in defect.what
