"""Where the error is: planes have no silhouettes, steps do; the regions make up the picture."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.metrics import REGIONS, border_holes, near_discontinuity, pooled, psnr, region_of, region_sums

from .pictures import noise

SIZE = (64, 48)
HERE = View(Pose(), Fov.from_tangents((-1, 1, -0.75, 0.75)))
SAME = (HERE, HERE, SIZE)  # shown, rendered, and its size: nothing is beyond the border
FULL = np.ones((48, 64))


def regions(coverage: np.ndarray, depth: np.ndarray, *views) -> np.ndarray:
    """(h, w) the region of each pixel."""
    return region_of(coverage, depth, border_holes(coverage, depth, *views))


def plane(normal, distance_m: float) -> np.ndarray:
    """(h, w) inverse depth of the plane normal * p = -distance; 0 where it is not in view."""
    rays = View(Pose(), Fov.symmetric_deg(6.4, 4.8)).rays(SIZE)
    return np.maximum(-(rays @ np.asarray(normal, float)) / distance_m, 0).astype(np.float32)


slopes = st.floats(-math.tan(math.radians(80)), math.tan(math.radians(80)))


@settings(max_examples=40)
@given(slopes, slopes, slopes, st.floats(0.3, 10))
def test_neither_a_plane_however_slanted_nor_a_corner_of_two_is_an_edge(one, other, up, distance_m):
    """At 10 pixels per degree, up to 80 degrees on each axis: wherever a plane is before the eye,
    and where two walls meet at the picture's centre line.
    """
    left, right = plane((one, 0, 1), distance_m), plane((other, 0, 1), distance_m)
    for depth in (plane((one, up, 1), distance_m), np.maximum(left, right), np.minimum(left, right)):
        if (depth > 0).all():
            assert not near_discontinuity(depth).any()


@pytest.mark.parametrize("column", [1, 2, 20, 61, 62])
@pytest.mark.parametrize("behind", [0.0, 0.25, np.nan])
def test_two_pixels_on_each_side_of_a_step(column, behind):
    depth = np.full((48, 64), behind, np.float32)
    depth[:, column:] = 0.5
    near = near_discontinuity(depth)
    wanted = np.zeros(64, bool)
    wanted[max(0, column - 2) : column + 2] = True
    assert (near == wanted).all()
    assert (near_discontinuity(depth.T) == wanted[:, None]).all()


def test_a_pole_one_pixel_wide_is_seen_on_a_slanted_wall():
    wall = plane((3, 0, 1), 2.0)
    pole = wall.copy()
    pole[:, 30] *= 2
    near = near_discontinuity(pole)
    assert near[:, 28:33].all() and not near[:, :28].any() and not near[:, 33:].any()


def test_far_things_before_the_sky_are_no_edge_and_tiny_pictures_have_one_of_two_pixels():
    depth = np.zeros((48, 64), np.float32)
    depth[:, 30:] = 1 / 600
    assert not near_discontinuity(depth).any()
    assert near_discontinuity(depth * 2).any()
    for size in ((1, 1), (1, 2), (2, 1), (3, 1)):
        assert not near_discontinuity(np.ones(size, np.float32)).any()
        rising = np.arange(math.prod(size), dtype=np.float32).reshape(size)
        assert near_discontinuity(rising).any() == (rising.size == 2)


def test_a_hole_is_a_hole_also_at_a_silhouette():
    depth = np.zeros((48, 64), np.float32)
    depth[:, 20:] = 0.5
    coverage = FULL.copy()
    coverage[:, 20:30] = 0
    region = regions(coverage, depth, *SAME)
    assert (region[:, 20:30] == 1).all() and (region[:, 18:20] == 2).all()
    assert (region[:, :18] == 3).all() and (region[:, 30:] == 3).all()


def test_holes_are_at_the_border_where_the_frame_saw_nothing_of_the_surface():
    """A frame that shows the left half alone: holes right of it are at its border."""
    coverage = FULL.copy()
    coverage[10:20], coverage[0, 0] = 0, 0
    half = View(Pose(), Fov.from_tangents((-1, 0, -0.75, 0.75)))
    region = regions(coverage, np.zeros((48, 64), np.float32), HERE, half, (32, 48))
    assert (region[10:20, :32] == 1).all() and (region[10:20, 32:] == 0).all() and region[0, 0] == 1
    assert np.count_nonzero(region < 2) == 641


def test_regions_together_are_the_picture():
    """Pooled over the regions again, the squared errors give the picture's PSNR and FLIP.

    Nothing is counted twice or left out.
    """
    shown, truth = noise(1, SIZE), noise(2, SIZE)
    rng = np.random.default_rng(3)
    coverage, depth = rng.integers(0, 2, (48, 64)), np.zeros((48, 64), np.float32)
    depth[:, 20:] = 0.5
    flip_map = rng.random((48, 64)).astype(np.float32)
    mean = flip_map.mean(dtype=np.float64)
    left = View(Pose(), Fov.from_tangents((-1, 0.5, -0.75, 0.75)))
    region = regions(coverage, depth, HERE, left, (48, 48))
    figures = pooled([region_sums(shown, truth, region, flip_map)])
    shares = [figures[name]["share"] for name in REGIONS]
    assert all(shares) and sum(shares) == pytest.approx(1, abs=1e-12)
    mean_square = sum(figures[name]["share"] * 10 ** (-figures[name]["psnr_db"] / 10) for name in REGIONS)
    assert -10 * math.log10(mean_square) == pytest.approx(psnr(shown, truth), abs=1e-9)
    assert sum(figures[name]["share"] * figures[name]["flip"] for name in REGIONS) == pytest.approx(mean, abs=1e-9)


def test_pictures_are_pooled_before_the_logarithm():
    """A picture whose holes are 10 pixels counts a hundredth of one whose holes are 1000.

    DB are never averaged.
    """
    truth = np.zeros((48, 64, 3), np.uint8)
    zeros = np.zeros((48, 64), np.float32)

    def one(holes: int, error: int) -> dict:
        coverage, shown = np.ones(48 * 64), truth.copy()
        coverage[:holes] = 0
        shown.reshape(-1, 3)[:holes] = error
        return region_sums(shown, truth, regions(coverage.reshape(48, 64), zeros, *SAME), zeros)

    figures = pooled([one(1000, 10), one(10, 200)])["inside_holes"]
    mean_square = (1000 * 10**2 + 10 * 200**2) / 1010 / 255**2
    assert figures["psnr_db"] == pytest.approx(-10 * math.log10(mean_square))
    assert figures["share"] == pytest.approx(1010 / (2 * 48 * 64))


def test_an_empty_region_has_no_error():
    flat = np.zeros((48, 64), np.float32)
    figures = pooled([region_sums(noise(1, SIZE), noise(1, SIZE), regions(FULL, flat, *SAME), flat)])
    assert figures["border_holes"] == figures["inside_holes"] == {"share": 0.0, "psnr_db": None, "flip": None}
    assert figures["seen"] == {"share": 1.0, "psnr_db": 100.0, "flip": 0.0}
    assert pooled([])["silhouettes"] == {"share": None, "psnr_db": None, "flip": None}
