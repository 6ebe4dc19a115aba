"""Repairs where a frame is taken over: warp_image, Warper and hmdwarp warp."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp import Fov, Pose, View, Warper, warp_image
from hmdwarp.image import usable_warps
from hmdwarp.sources.repairs import parse_repairs

SIZE = (40, 30)
VIEW = View(Pose(), Fov.from_tangents((-1.0, 1.0, -0.75, 0.75)))
BESIDE = View(Pose((0.1, 0, 0)), VIEW.fov)


def camera_picture() -> tuple[np.ndarray, np.ndarray]:
    """Colour in bytes; depth with a gap, a corner at 0 and one at NaN."""
    rng = np.random.default_rng(0)
    colour = rng.integers(0, 256, (30, 40, 3), dtype=np.uint8)
    depth = np.full((30, 40), 2.0)
    depth[:, 25:] = 5.0
    depth[8:20, 10:18] = 0
    depth[0, 0] = np.nan
    return colour, depth


@pytest.mark.parametrize("warp", usable_warps())
def test_coverage_is_the_confidence_of_the_depth(warp, gpu):
    """Seen from where it was taken: 1 if measured, else that of the guess, in half floats."""
    colour, depth = camera_picture()
    out = warp_image(colour, depth, VIEW, VIEW, warp, "none", repair="complete", gpu=gpu)
    with np.errstate(divide="ignore"):
        inverse = np.where(depth > 0, 1 / depth, np.nan)
    found = parse_repairs("complete").run((colour / 255).astype(np.float32), inverse)
    assert np.abs(out.coverage - found.confidence).max() <= 2.0**-11
    assert (out.coverage[depth > 0] == 1).all() and (out.coverage[~(depth > 0)] < 1).all()
    assert np.array_equal(out.colour, colour) and out.hole_share == 0


@pytest.mark.parametrize("warp", usable_warps())
def test_guessed_depth_counts_less_wherever_it_goes(warp, gpu):
    """Elsewhere: a hole has coverage 0 and no colour, all else more than 0 and at most 1."""
    colour, depth = camera_picture()
    colour = np.maximum(colour, 1)
    out = warp_image(colour, depth, VIEW, BESIDE, warp, "none", repair="complete", gpu=gpu)
    assert ((out.coverage >= 0) & (out.coverage <= 1)).all()
    assert np.array_equal(out.coverage == 0, (out.colour == 0).all(axis=2))
    assert out.hole_share == (out.coverage == 0).mean()
    assert (out.coverage < 1).sum() > (out.coverage == 0).sum()  # some of it was guessed
    filled = warp_image(colour, depth, VIEW, BESIDE, warp, "pyramid", repair="complete", gpu=gpu)
    assert np.array_equal(filled.coverage[out.coverage > 0], out.coverage[out.coverage > 0])
    assert (filled.coverage[out.coverage == 0] == 1).all()


def test_a_gap_is_neither_near_nor_infinitely_far():
    """0 m, NaN or a mask: repaired, the gap moves with the wall around it; else it is a hole."""
    wall = np.full((30, 40), 2.0)
    rng = np.random.default_rng(1)
    colour = rng.integers(0, 256, (30, 40, 3), dtype=np.uint8)
    whole = warp_image(colour, wall, VIEW, BESIDE, fill="none")
    gap = np.zeros((30, 40), bool)
    gap[10:20, 10:20] = True
    for given in (np.where(gap, 0, wall), np.where(gap, np.nan, wall), np.ma.array(wall, mask=gap)):
        found = warp_image(colour, given, VIEW, BESIDE, fill="none", repair="complete", depth=True)
        assert np.array_equal(found.colour, whole.colour)
        seen = found.coverage > 0
        assert found.depth_m is not None and np.abs(found.depth_m[seen] - 2).max() < 2e-3
        bare = warp_image(colour, given, VIEW, BESIDE, fill="none")
        assert bare.hole_share > found.hole_share == whole.hole_share
        assert set(np.unique(bare.coverage)) == {0, 1}


@pytest.mark.parametrize("repair", ["edges", "complete", "edges+complete"])
def test_pixels_without_colour_gain_none(repair):
    """By alpha or by a mask, whatever its depth: it stays a hole, and guides nothing."""
    colour, depth = camera_picture()
    alpha = np.full((30, 40, 1), 255, np.uint8)
    alpha[5:12] = 0
    out = warp_image(np.concatenate([colour, alpha], axis=2), depth, VIEW, VIEW, "forward", "none", repair=repair)
    assert (out.coverage[5:12] == 0).all() and (out.colour[5:12] == 0).all()
    nothing = warp_image(np.concatenate([colour, 0 * alpha], axis=2), depth, VIEW, VIEW, fill="none", repair=repair)
    assert (nothing.coverage == 0).all() and nothing.hole_share == 1
    gap = warp_image(colour, np.zeros((30, 40)), VIEW, BESIDE, fill="none", repair=repair)
    assert (gap.coverage == 0).all() and (gap.colour == 0).all()


def test_a_warper_repairs_each_picture_and_the_others():
    colour, depth = camera_picture()
    with Warper(SIZE, warp="multi", fill="none", repair="edges+complete") as warper:
        assert warper.repair.text == "edges+complete"
        for _ in range(2):
            out = warper.warp(colour, depth, VIEW, BESIDE, others=[(colour, depth, VIEW)])
            assert (
                set(out.time_ms) == {"repair", "upload", "warp", "carry", "download", "host"}
                and out.time_ms["repair"] > 0
            )
        bare = warper.warp(colour, np.where(depth > 0, depth, 3), VIEW, BESIDE, others=[(colour, depth, VIEW)])
        assert 0 < out.coverage[out.coverage > 0].min() < 1 and (bare.coverage > 0).any()
