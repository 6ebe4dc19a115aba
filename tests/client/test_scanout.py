"""Warps that follow the scan-out. Every row has the view of its own instant, by the float64 twin's
SLERP; before and behind the lens."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest
from panels import panel_of, world_before
from reference.fused import fused
from reference.scanout import scanned_out
from scipy.spatial.transform import Rotation
from worlds import World, assert_equals_twin, shown_by, twin_of

from hmdwarp.client import parse_warp
from hmdwarp.client.warps import Output, warps
from hmdwarp.geometry import Pose, View
from hmdwarp.headsets import load_headset

FOLLOWING = [name for name in warps.names() if warps.get(name).scans_out]
WITH_TWIN_AT_PLACES = [name for name in FOLLOWING if name != "iterative"]
SIZES = [(67, 53), (1, 1), (129, 2)]


def later(view: View, degrees: float = 5.0, step_m: float = 0.02, seed: int = 1) -> View:
    """The view at the end of scan-out: a turn and a step away. 5 degrees in 16.7 ms are 300 a
    second."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    turn = Rotation.from_rotvec(axis / np.linalg.norm(axis) * math.radians(degrees))
    pose = Pose(view.pose.position_m + rng.normal(scale=step_m, size=3), (view.pose.rotation * turn).as_quat())
    return View(pose, view.fov)


def scanned(gpu, world: World, spec: str, last: View | None) -> np.ndarray:
    """(h, w, 4) what the warp shows on a display that lights up row by row, bottom row first."""
    entry = parse_warp(spec).entry
    world.bring(gpu, entry)
    inputs = attrs.evolve(world.inputs(entry), shown_last=last)
    return shown_by(gpu, spec, inputs, world.shown_size, Output(scanout=True))[0]


@pytest.mark.parametrize("name", WITH_TWIN_AT_PLACES)
@pytest.mark.parametrize("seed", range(3))
def test_every_row_has_its_own_view(gpu, name, seed):
    size = SIZES[seed]
    world = World(gpu, 20 + seed, size)
    last = later(world.shown_view, seed=seed)
    got = scanned(gpu, world, name, last)
    wanted = scanned_out(world.asked(parse_warp(name).settings), last, twin_of(name))
    assert_equals_twin(got, wanted, 0.9)


@pytest.mark.parametrize(("eye", "name"), [(k % 2, name) for k, name in enumerate(WITH_TWIN_AT_PLACES)])
def test_fused_every_row_of_the_panel_has(gpu, name, eye):
    headset, panel_size = load_headset("rift-dk1"), (61, 47)
    world = world_before(gpu, headset, eye, 30 + eye, (67, 53))
    last = later(world.shown_view, seed=eye)
    got = panel_of(gpu, world, name, headset, eye, panel_size, last)
    wanted = fused(world.asked(parse_warp(name).settings), twin_of(name), headset, eye, panel_size, last)
    assert_equals_twin(got, wanted, 0.7)


@pytest.mark.parametrize("name", FOLLOWING)
def test_a_head_that_rests_during_scan_out_sees_the_same_at_once(gpu, name):
    """No parabola is left. The very bits of the warp without scan-out, or those of a float32
    more."""
    world = World(gpu, 3, (67, 53))
    at_once = world.warp(gpu, name)
    for last in (None, world.shown_view):
        got = scanned(gpu, world, name, last)
        same = (got == at_once).all(axis=-1)
        assert same.mean() > 0.99, "the first and the middle pose differ by a last bit, so a place may round to another"


def test_the_first_row_is_the_top_one(gpu):
    """The display lights up from the top. There the picture is that of the first view, at the
    bottom that of the last."""
    world = World(gpu, 5, (64, 301), moved=False)
    last = View(world.shown_view.pose @ Pose((0, 0, 0), (0, math.sin(0.025), 0, math.cos(0.025))), world.shown_view.fov)
    got = scanned(gpu, world, "rotation", last)
    first_at_once = world.warp(gpu, "rotation")
    world.shown_view = last
    last_at_once = world.warp(gpu, "rotation")
    # A row is 1/602 of the scan-out away from the ends: 2.9 degrees / 602 are 0.004 pixels of this
    # view, its noise changes by 1 a pixel.
    assert np.median(np.abs(got[-1] - first_at_once[-1])) < 0.02 < np.median(np.abs(got[-1] - last_at_once[-1]))
    assert np.median(np.abs(got[0] - last_at_once[0])) < 0.02 < np.median(np.abs(got[0] - first_at_once[0]))
