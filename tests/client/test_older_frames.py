"""Late frames that are averaged: a near wall before a far one, each with a pattern of its own."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from golden_pictures import assert_golden, sheet
from scipy.spatial.transform import Rotation

from hmdwarp import Fov, Pose, View, Warper

SIZE = W, H = 128, 96
FOV = Fov(*np.arctan([-1, 1, -0.75, 0.75]))
NEAR_M, FAR_M, EDGE_M = 1.5, 4.0, 0.3
SHOWN = View(
    Pose(position_m=(0.05, 0.02, 0.01), orientation_xyzw=tuple(Rotation.from_euler("yx", [3, 1], True).as_quat())), FOV
)
LINEAR = np.float32


def view(k: int, turn_deg: float = 0.0) -> View:
    turned = Rotation.from_euler("y", 0.4 * k + turn_deg, True)
    return View(Pose(position_m=(-0.011 * k, 0.003 * k, 0.0), orientation_xyzw=tuple(turned.as_quat())), FOV)


def drawn(of: View, near: bool = True, off_m: float = 0.0):
    """Return linear colour and depth in metres, row 0 at the top."""
    x, y = np.meshgrid(-1 + (np.arange(W) + 0.5) / W * 2, 0.75 - (np.arange(H) + 0.5) / H * 1.5)
    way = np.stack([x, y, -np.ones_like(x)], -1).reshape(-1, 3)
    start, way = np.asarray(of.pose.position_m), Rotation.from_quat(of.pose.orientation_xyzw).apply(way)
    depth, colour = np.full(W * H, np.inf), np.zeros((W * H, 3))
    for z, edge in ((FAR_M, np.inf), (NEAR_M, EDGE_M if near else -np.inf)):
        far = (-z - start[2]) / way[:, 2]
        x, y = ((start + far[:, None] * way)[:, k] for k in (0, 1))
        hit = x < edge
        tone = 0.4 + 0.2 * np.sin(40 / z * (x + off_m)) * np.sin(34 / z * y + z)
        depth[hit], colour[hit] = far[hit], (tone[:, None] * (1, 0.8, 0.3 * z / NEAR_M))[hit]
    return colour.reshape(H, W, 3).astype(LINEAR), depth.reshape(H, W).astype(LINEAR)


def noisy(colour, seed: int, by: float = 0.03):
    return (colour + np.random.default_rng(seed).normal(0, by, colour.shape)).clip(0.01).astype(LINEAR)


@functools.cache
def warper(frames: int) -> Warper:
    return Warper(SIZE, warp=f"iterative:frames={frames}", fill="none", depth=True)


def warped(frames: int, newest, older=(), shown: View = SHOWN):
    others = [(*picture, of) for picture, of in older]
    return warper(frames).warp(*newest, view(0), shown, others=others, encoding="linear")


def sharpness(colour, where) -> float:
    across, down = np.diff(colour[..., 1], axis=1)[:-1], np.diff(colour[..., 1], axis=0)[:, :-1]
    return float((across**2 + down**2)[where[:-1, :-1]].mean())


def test_noise_falls_and_the_average_looks_as_before(tmp_path):
    """Of three frames with like noise the mean has less than two thirds of it."""
    newest = noisy(drawn(view(0))[0], 1), drawn(view(0))[1]
    older = [((noisy(drawn(view(k))[0] * (1 - 0.1 * k), 1 + k), drawn(view(k))[1]), view(k)) for k in (1, 2)]
    alone, found, truth = warped(1, newest), warped(3, newest, older), drawn(SHOWN)[0]
    covered = np.asarray(alone.coverage) > 0.5
    assert np.array_equal(covered, np.asarray(found.coverage) > 0.5), "what is a hole stays one"
    off, off_alone = (np.asarray(one.colour)[covered] - truth[covered] for one in (found, alone))
    assert off.std() < 0.8 * off_alone.std(), (off.std(), off_alone.std())
    pair = np.dstack([found.colour, covered])[::-1], 1 / np.where(covered, found.depth_m, np.inf)[::-1]
    assert_golden("effects/older_frames", sheet(pair), tmp_path)


def test_an_eye_that_has_not_moved_sees_the_newest_frame_to_the_last_bit():
    newest = noisy(drawn(view(0))[0], 1), drawn(view(0))[1]
    older = [((noisy(drawn(view(1))[0], 2), drawn(view(1))[1]), view(1))]
    found = warped(3, newest, older, shown=view(0))
    assert np.array_equal(np.asarray(found.colour), np.asarray(warped(1, newest, shown=view(0)).colour))


def test_light_is_the_newest_frames():
    newest, bright = drawn(view(0)), [((drawn(view(k))[0] * 1.6, drawn(view(k))[1]), view(k)) for k in (1, 2)]
    alone, found = (np.asarray(warped(*asked).colour) for asked in ((1, newest), (3, newest, bright)))
    # Of a block that the older frames saw in part, the rest may differ: by less than one of 255.
    assert np.abs(found - alone).mean() < 1 / 255
    assert abs(found.mean() / alone.mean() - 1) < 2e-3


@pytest.mark.parametrize("off_deg", [0.4, 0.8, 1.5, 3.0])
def test_frames_that_lie_off_do_not_blur(off_deg):
    """Poses that are off by half a pixel to five, which is half a period of the pattern."""
    newest, wrong = drawn(view(0)), [(drawn(view(k)), view(k, off_deg)) for k in (1, 2)]
    alone, found = (np.asarray(warped(*asked).colour) for asked in ((1, newest), (3, newest, wrong)))
    where = np.zeros((H, W), bool)
    where[10:-10, 10:56] = True  # of one wall, which every frame saw
    # Half a pixel off the mean has 0.97 of the squared slope of these waves; cubics differ by 0.01.
    assert sharpness(found, where) > 0.96 * sharpness(alone, where)


def test_what_stood_in_front_before_is_not_seen_again():
    gone = [(drawn(view(k)), view(k)) for k in (1, 2)]
    newest = drawn(view(0), near=False)
    alone, found = (np.asarray(warped(*asked).colour) for asked in ((1, newest), (3, newest, gone)))
    behind = np.s_[:, : W // 3]  # where the near wall was
    assert np.abs(found - alone)[behind].max() < 2e-3, "half floats"
