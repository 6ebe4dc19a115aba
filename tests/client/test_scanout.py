"""Warps that follow the scan-out. Every row has the view of its own instant, by the float64 twin's
SLERP; before and behind the lens."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from panels import panel_of, world_before
from reference.fused import fused
from reference.scanout import direction_error, scanned_out
from scipy.spatial.transform import Rotation
from strategies import QUATERNIONS, vectors
from worlds import World, assert_equals_twin, read, twin_of

from hmdwarp.client import parse_warp
from hmdwarp.client.warps import Output, warps
from hmdwarp.geometry import Fov, Pose, View, WarpMap
from hmdwarp.gpu import Canvas
from hmdwarp.headsets import load_headset

FOLLOWING = [name for name in warps.names() if warps.get(name).scans_out]
WITH_TWIN_AT_PLACES = ["none", "shift", "rotation", "planar", "environment"]
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
    choice = parse_warp(spec)
    world.bring(gpu, choice.entry)
    warp = choice.entry(gpu, world.size, world.shown_size, choice.settings, Output(scanout=True))
    canvas = Canvas(gpu.gl, world.shown_size)
    warp.run(attrs.evolve(world.inputs(choice.entry), shown_last=last), canvas)
    gpu.gl.memory_barrier()
    out = read(canvas.texture)
    warp.close()
    canvas.release()
    return out


@pytest.mark.parametrize("name", WITH_TWIN_AT_PLACES)
@pytest.mark.parametrize("seed", range(3))
def test_every_row_has_its_own_view(gpu, name, seed):
    size = SIZES[seed]
    world = World(gpu, 20 + seed, size)
    last = later(world.shown_view, seed=seed)
    got = scanned(gpu, world, name, last)
    wanted = scanned_out(world.asked(parse_warp(name).settings), last, twin_of(name))
    assert_equals_twin(got, wanted, 0.9)


@pytest.mark.parametrize("name", WITH_TWIN_AT_PLACES)
@pytest.mark.parametrize("eye", [0, 1])
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


@pytest.mark.parametrize("name", FOLLOWING)
def test_holes_are_black_and_nothing_is_nan(gpu, name):
    world = World(gpu, 4, (67, 53))
    got = scanned(gpu, world, name, later(world.shown_view, degrees=20))
    assert np.isfinite(got).all()
    assert set(np.unique(got[..., 3])) <= {0.0, 1.0}
    assert (got[got[..., 3] == 0] == 0).all()


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


FOV = Fov(-0.8, 0.7, -0.6, 0.9)


@given(QUATERNIONS, vectors(st.floats(-1, 1)), st.floats(0, 0.5), vectors(st.floats(-0.05, 0.05)), st.floats(0, 1))
def test_the_parabola_stays_within_its_bound(start, axis, angle, step, t):
    """The map by the parabola through three instants against the map of the instant itself, as
    directions: float64 on both sides."""
    axis = np.array(axis) + (0, 0, 2)
    first = View(Pose((1, 2, 3), start), FOV)
    turn = Rotation.from_rotvec(axis / np.linalg.norm(axis) * angle)
    last = View(Pose(first.pose.position_m + step, (first.pose.rotation * turn).as_quat()), FOV)
    rendered = View(Pose((1.1, 2, 3), (0.1, 0, 0, 1)), FOV)
    size = (90, 80)
    maps = [
        WarpMap.between(View(first.pose.towards(last.pose, share), FOV), size, rendered, size)
        for share in (0, 0.5, 1, t)
    ]

    def parabola(a, m, b):
        square = 2 * (a + b - 2 * m)
        return a + t * (b - a - square) + t * t * square

    to_direction = np.linalg.inv(FOV.pixel_from_tangent(size))  # pixels of the rendered view to directions, (x, y, 1)
    pixels = np.array([[0, 0, 1], [90, 0, 1], [0, 80, 1], [90, 80, 1], [45, 40, 1.0]])
    rays = np.linalg.norm(pixels @ to_direction.T, axis=-1)
    difference = (pixels @ (parabola(*(m.H for m in maps[:3])) - maps[3].H).T) @ to_direction.T
    assert (np.linalg.norm(difference, axis=-1) <= direction_error(first, last) * rays + 1e-13).all()
    assert np.abs(parabola(*(m.e for m in maps[:3])) - maps[3].e).max() <= 1e-12, "positions are linear, so e is"
