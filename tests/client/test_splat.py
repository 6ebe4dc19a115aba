"""Footprints: no cracks, each pixel in its place, and a bounded cost."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.geometry import Pose, View, WarpMap

from .rendered_pictures import FOV, warped


def centres(size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """x and y of the pixel centres, 0 to 1 over the picture."""
    y, x = np.mgrid[: size[1], : size[0]]
    return (x + 0.5) / size[0], (y + 0.5) / size[1]


def ramps(size: tuple[int, int]) -> np.ndarray:
    """A picture that says where each of its points is."""
    x, y = centres(size)
    return np.stack([x, y, np.zeros_like(x), np.ones_like(x)], axis=-1)


def splatted(gpu, depth, colour, shown: Pose, shown_size=None, spec="splat") -> np.ndarray:
    return warped(gpu, spec, np.asarray(colour), np.asarray(depth), shown, shown_size=shown_size)


def places(size, depth_of_shown: np.ndarray, shown: Pose) -> np.ndarray:
    """(h, w, 2) where in the rendered picture, 0 to 1, each shown pixel's point is, its inverse
    depth in the shown view given.
    """
    high, wide = depth_of_shown.shape
    y, x = np.mgrid[:high, :wide] + 0.5
    backward = WarpMap.between(View(shown, FOV), (wide, high), View(Pose(), FOV), size)
    return backward.apply(np.stack([x, y], axis=-1), depth_of_shown)[0] / size


@pytest.mark.parametrize("closer", [1.3, 2.0, 3.7, 20.0])
def test_a_plane_that_comes_closer_has_no_cracks_and_is_smooth(gpu, closer):
    """From 2 m to 2 m / closer: the middle of the picture, magnified.

    Each pixel where it belongs to a hundredth of a rendered one.
    """
    size, moved = (64, 48), 2 - 2 / closer
    shown = Pose((0.013, -0.007, -moved))
    out = splatted(gpu, np.full(size[::-1], 0.5), ramps(size), shown)
    assert (out[..., 3] == 1).all()
    wanted = places(size, np.full(size[::-1], 0.5 * closer), shown)
    # Half floats below 1 are off by 2^-11.
    assert np.abs(out[..., :2] - wanted).max() * 64 < 0.01 + 64 * 2.0**-11


@pytest.mark.parametrize("reach", [1, 4, 16])
def test_one_pixel_covers_no_more_than_its_reach(gpu, reach):
    """A single drawn pixel before an eye that sees it 60 pixels wide.

    2 reach of them, and no more work than that.
    """
    out = splatted(gpu, np.full((1, 1), 0.5), np.ones((1, 1, 4)), Pose((0, 0, -1e-3)), (60, 60), f"splat:reach={reach}")
    assert (out[..., 3] == 1).sum() == (2 * reach) ** 2
    assert (out[30 - reach : 30 + reach, 30 - reach : 30 + reach, 3] == 1).all()
