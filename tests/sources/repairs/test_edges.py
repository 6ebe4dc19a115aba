"""Repair edges: depth meets its colour, and nothing lies between two surfaces."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from hmdwarp.sources.repairs import parse_repairs, repairs
from hmdwarp.sources.repairs.edges import depth_offset

from .pictures import moved, same, two_surfaces

SETTINGS = repairs.get("edges").Settings()


def edges(colour, inverse, text="edges"):
    return parse_repairs(text).run(colour, inverse)


@pytest.mark.parametrize(("down", "right"), [(0, 0), (1, 0), (0, -1), (2, 3), (-5, 4), (-1, -5)])
def test_moved_depth_is_moved_back(down, right):
    """Whole pixels are found exactly; every depth that stayed in the picture is the true one."""
    colour, inverse = two_surfaces()
    given = moved(inverse, down, right)
    assert depth_offset(colour, given, SETTINGS) == (-down, -right)
    found = edges(colour, given)
    known = ~np.isnan(found.inverse_depth)
    assert np.array_equal(found.inverse_depth[known], inverse[known])
    assert np.array_equal(known, ~np.isnan(moved(given, -down, -right)))


def test_nothing_is_moved_without_evidence():
    """Too far off, a best offset at the very end of the search may not be the best there is.

    Of noise alone, or one colour, no offset stands out; and a setting may ask for more, or none.
    """
    colour, inverse = two_surfaces()
    for right in (6, 8):
        assert depth_offset(colour, moved(inverse, 0, right), SETTINGS) == (0, 0)
    noise = np.random.default_rng(3).random((*inverse.shape, 3)).astype(np.float32)
    for plain in (noise, np.full_like(noise, 0.5), 0.01 * noise):
        assert depth_offset(plain, inverse, SETTINGS) == (0, 0)
    given = moved(inverse, 0, 3)
    for text in ("edges:most=0", "edges:evidence=1000"):
        assert same(edges(colour, given, text).inverse_depth, given)


@pytest.mark.parametrize("mixture", [(0.6,), (0.8, 0.5), (0.85, 0.6), (0.4, 0.3)])
def test_flying_pixels_lose_their_depth_and_no_others_do(mixture):
    """A column or two between a surface at 1 /m and one at 0.25 /m; NaN counts 0, the rest 1.

    Each is 15 % and 0.05 * 15 % /m beyond one side and short of the other within two pixels.
    """
    inverse = np.full((30, 40), 0.25, np.float32)
    inverse[:, :20] = 1
    inverse[:, 20 : 20 + len(mixture)] = mixture
    found = edges(np.full((30, 40, 3), 0.5, np.float32), inverse)
    flying = np.isnan(found.inverse_depth)
    assert flying[:, 20 : 20 + len(mixture)].all() and flying.sum() == 30 * len(mixture)
    assert np.array_equal(found.inverse_depth[~flying], inverse[~flying])
    assert np.array_equal(found.confidence, (~flying).astype(np.float32))


def is_between(inverse: np.ndarray, row: int, column: int) -> bool:
    """By its definition: two pixels opposite each other, one nearer and one farther than it."""

    def at(y, x):
        return inverse[y, x] if 0 <= y < len(inverse) and 0 <= x < inverse.shape[1] else np.nan

    def limit(r):
        return r + np.float32(0.15) * (r + np.float32(0.05))

    here = inverse[row, column]
    for reach, (down, right) in itertools.product((1, 2), itertools.product((-1, 0, 1), repeat=2)):
        near, far = at(row + reach * down, column + reach * right), at(row - reach * down, column - reach * right)
        if near > limit(here) and here > limit(far):
            return True
    return False


@pytest.mark.parametrize("seed", range(4))
def test_removed_depth_is_that_of_the_definition(seed):
    """On random steps, pixel by pixel: the arrays take only pixels near a jump, and miss none."""
    rng = np.random.default_rng(seed)
    inverse = rng.choice(np.array([0, 0.2, 0.22, 0.5, 1, 3, np.nan], np.float32), (17, 23))
    inverse[:8] = np.repeat(inverse[:8, ::4], 4, axis=1)[:, :23]  # broader surfaces above
    found = edges(np.zeros((17, 23, 3), np.float32), inverse, "edges:most=0")
    with np.errstate(invalid="ignore"):
        wanted = np.array([[is_between(inverse, y, x) for x in range(23)] for y in range(17)])
    assert np.array_equal(np.isnan(found.inverse_depth), wanted | np.isnan(inverse))
