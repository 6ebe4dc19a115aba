"""Late frames that are averaged: a near wall before a far one, each with a pattern of its own."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from scipy.ndimage import convolve1d, map_coordinates, maximum_filter
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


def rays(of: View):
    x, y = np.meshgrid(-1 + (np.arange(W) + 0.5) / W * 2, 0.75 - (np.arange(H) + 0.5) / H * 1.5)
    way = np.stack([x, y, -np.ones_like(x)], -1).reshape(-1, 3)
    return np.asarray(of.pose.position_m), Rotation.from_quat(of.pose.orientation_xyzw).apply(way)


def drawn(of: View, near: bool = True, off_m: float = 0.0):
    """Return linear colour and depth in metres, row 0 at the top."""
    start, way = rays(of)
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


def by_parabolas(image, u, v):
    """Return samples of Lagrange's parabolas through three pixels of the nearest row and column."""
    near_u, near_v = np.floor(u + 0.5).astype(int), np.ceil(v - 0.5).astype(int)  # rows are counted from the top

    def at(row, column):
        return image[np.clip(near_v + row, 0, H - 1), np.clip(near_u + column, 0, W - 1)]

    def parabola(three, t):
        shares = t * (t - 1) / 2, 1 - t**2, t * (t + 1) / 2
        return sum(share[..., None] * texel for share, texel in zip(shares, three, strict=True))

    off_u, off_v, middle = u - near_u, v - near_v, at(0, 0)
    row, column = ([at(*(k * step for step in way)) for k in (-1, 0, 1)] for way in ((0, 1), (1, 0)))
    found = parabola(row, off_u) + parabola(column, off_v) - middle
    beside = [np.where((off < 0)[..., None], three[0], three[2]) for off, three in ((off_u, row), (off_v, column))]
    return np.clip(found, np.minimum(middle, np.minimum(*beside)), np.maximum(middle, np.maximum(*beside)))


def twin(newest, inverse_depth, older):
    """Return the average in float64: places through world space, blocks by sums of arrays."""
    covered, (start, way) = np.isfinite(inverse_depth), rays(SHOWN)
    metres = np.where(covered, 1 / np.maximum(inverse_depth, 1e-9), 1.0).reshape(-1, 1)
    points, total, count = start + way * metres, newest.astype(float), np.ones((H, W, 1))

    def in_blocks(values):
        sampled = np.where((covered_here & every)[..., None], values, 0.0)
        found = sampled.reshape(H // 8, 8, W // 8, 8, -1).sum((1, 3))
        return convolve1d(convolve1d(found, [1, 2, 1], axis=0, mode="constant"), [1, 2, 1], axis=1, mode="constant")

    def light(colour):
        return np.sqrt(np.maximum(colour @ [0.25, 0.5, 0.25], 0))

    every = np.zeros((H, W), bool)
    every[1::2, ::2] = True  # every second pixel, of rows counted from the bottom
    slopes = np.zeros((H, W, 2))
    own = light(newest)
    slopes[1:-1, 1:-1, 0] = (own[1:-1, 2:] - own[1:-1, :-2]) / 2
    slopes[1:-1, 1:-1, 1] = (own[:-2, 1:-1] - own[2:, 1:-1]) / 2
    beside = covered.copy()
    beside[[0, -1]] = beside[:, [0, -1]] = False
    for axis in (0, 1):
        for step in (1, -1):
            beside &= np.roll(covered, step, axis)
    slopes[~beside] = 0
    for (colour, depth), of in older:
        x, y, z = (
            Rotation.from_quat(of.pose.orientation_xyzw)
            .inv()
            .apply(points - np.asarray(of.pose.position_m))
            .T.reshape(3, H, W)
        )
        u, v, expected = (x / -z + 1) / 2 * W - 0.5, (0.75 - y / -z) / 1.5 * H - 0.5, -1 / z
        inside = (z < 0) & (u > -0.5) & (u < W - 0.5) & (v > -0.5) & (v < H - 0.5)
        held = 1 / depth.astype(float)
        nearest = maximum_filter(held, footprint=[[0, 1, 0], [1, 1, 1], [0, 1, 0]], mode="constant")
        held = np.where(nearest - held > 0.03 * (held + 0.02), nearest, held)
        there = held[np.clip(np.rint(v), 0, H - 1).astype(int), np.clip(np.rint(u), 0, W - 1).astype(int)]
        covered_here = covered & inside & (abs(there - expected) <= 0.03 * (np.minimum(there, expected) + 0.02))
        found = by_parabolas(colour.astype(float), u, v)
        off = own - light(found)
        mass = np.maximum(in_blocks(np.ones((H, W, 1))), 1e-3)
        mean, dark = in_blocks(newest - found) / mass, in_blocks(off[..., None]) / mass
        moved = in_blocks(slopes * off[..., None]) - in_blocks(slopes) * dark
        xx, yy = (in_blocks(slopes[..., k, None] ** 2)[..., 0] + 2e-4 * mass[..., 0] for k in (0, 1))
        xy = in_blocks(slopes[..., :1] * slopes[..., 1:])[..., 0]
        shift = np.linalg.solve(np.stack([xx, xy, xy, yy], -1).reshape(H // 8, W // 8, 2, 2), moved[..., None])[..., 0]
        apart = (in_blocks(off[..., None] ** 2) - dark**2 * mass)[..., 0] / (xx + yy)
        by_shift = 0.5 * (shift**2).sum(-1) / 0.35**2 + 2 * np.maximum(apart - 2.5, 0)
        weight = np.exp(-1.5 * dark[..., 0] ** 2 / 0.08**2 - by_shift)
        rows, columns = np.meshgrid((np.arange(H) + 0.5) / 8 - 0.5, (np.arange(W) + 0.5) / 8 - 0.5, indexing="ij")
        smooth = [
            map_coordinates(one, [rows, columns], order=1, mode="nearest")
            for one in (*np.moveaxis(mean, -1, 0), weight)
        ]
        share = (covered_here * smooth[3])[..., None]
        total, count = total + share * (found + np.stack(smooth[:3], -1)), count + share
    return np.maximum(total / count, 0)


def test_it_is_the_average_that_float64_finds_by_another_route():
    newest = noisy(drawn(view(0))[0], 1), drawn(view(0))[1]
    older = [((noisy(drawn(view(k))[0] * (1 - 0.1 * k), 1 + k), drawn(view(k))[1]), view(k)) for k in (1, 2)]
    alone, found = warped(1, newest), warped(3, newest, older)
    covered = np.asarray(alone.coverage) > 0.5
    assert np.array_equal(covered, np.asarray(found.coverage) > 0.5), "what is a hole stays one"
    depth = np.asarray(alone.depth_m)
    expected = twin(np.asarray(alone.colour), np.where(covered & (depth > 0), 1 / depth, np.nan), older)
    off = abs(np.asarray(found.colour) - expected).max(-1)[covered]
    assert abs(np.asarray(alone.colour) - expected).max(-1)[covered].mean() > 0.01, "the older frames matter here"
    # Half floats hold the looked-up colours, their means and the result: 2^-11 of 0.6 each, three
    # times. A place within rounding of a limit (3 % of depth, the border) may fall either way.
    assert np.mean(off > 1e-3) < 5e-3
    assert np.median(off) < 3e-4


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
