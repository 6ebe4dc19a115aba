"""Repair complete: gaps get the depth of the surface that their colour belongs to."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.sources.repairs import parse_repairs

from .pictures import same, two_surfaces


def complete(colour, inverse, text="complete"):
    return parse_repairs(text).run(colour, inverse)


def guessed(colour: np.ndarray, inverse: np.ndarray, row: int, column: int) -> tuple[float, float]:
    """By its definition, in float64, walking from the pixel: the guess and its confidence."""
    high, wide = inverse.shape
    proposals = []
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            y, x, steps = row + down, column + right, 1
            while (down or right) and 0 <= y < high and 0 <= x < wide:
                if not np.isnan(inverse[y, x]):
                    distance = steps * np.hypot(down, right)
                    unlike = ((colour[y, x].astype(float) - colour[row, column]) ** 2).sum()
                    weight = (np.exp(-unlike / (2 * 0.08**2)) + 1e-3) / distance**2
                    proposals.append((float(inverse[y, x]), weight, distance))
                    break
                y, x, steps = y + down, x + right, steps + 1
    if not proposals:
        return np.nan, 0.0

    def belong(a: float, b: float) -> bool:
        return max(a, b) <= min(a, b) + 0.15 * (min(a, b) + 0.05)

    groups = [[p for p in proposals if belong(p[0], proposal[0])] for proposal in proposals]
    best = max(groups, key=lambda group: sum(weight for _, weight, _ in group))
    share = sum(weight for _, weight, _ in best)
    nearest = min(distance for _, _, distance in best) / max(high, wide) / 0.075
    confidence = share / sum(weight for _, weight, _ in proposals) * 2 ** -(nearest**2)
    return sum(value * weight for value, weight, _ in best) / share, min(max(confidence, 2**-10), 1 - 2**-10)


@pytest.mark.parametrize("seed", range(4))
def test_each_guess_is_what_the_definition_says(seed):
    """Pixel by pixel, by another route; float32 rounds eight products and sums by 2^-24 each."""
    rng = np.random.default_rng(seed)
    inverse = np.repeat(np.repeat(rng.uniform(0.1, 2, (4, 5)), 6, axis=0), 6, axis=1).astype(np.float32)[:22, :29]
    colour = rng.random((22, 29, 3)).astype(np.float32)
    inverse[rng.random(inverse.shape) < 0.7] = np.nan
    found = complete(colour, inverse)
    for row, column in np.argwhere(np.isnan(inverse)):
        value, confidence = guessed(colour, inverse, row, column)
        assert found.inverse_depth[row, column] == pytest.approx(value, rel=2e-5)
        assert found.confidence[row, column] == pytest.approx(confidence, rel=2e-4)


def test_measured_depth_stays_bit_for_bit():
    rng = np.random.default_rng(5)
    colour, inverse = two_surfaces(size=(700, 40))  # so large that gaps are closed on fewer pixels
    inverse[rng.random(inverse.shape) < 0.4] = np.nan
    found, known = complete(colour, inverse), ~np.isnan(inverse)
    assert np.array_equal(found.inverse_depth[known], inverse[known])
    assert (found.confidence[known] == 1).all() and (found.confidence[~known] < 1).all()


@pytest.mark.parametrize("size", [(96, 72), (641, 479)])
def test_a_gap_at_a_silhouette_goes_to_each_side_by_its_colour(size):
    """A ring around the disc's outline has no depth.

    Where gaps are closed on blocks, those that the outline crosses have one depth: at most a block
    on either side of it, along its 2 pi 0.3 high pixels.
    """
    colour, inverse = two_surfaces(size)
    rows, columns = np.indices(inverse.shape)
    radius = np.hypot(rows - 0.45 * size[1], columns - 0.55 * size[0])
    gap = np.abs(radius - 0.3 * size[1]) < 0.06 * size[1]
    found = complete(colour, np.where(gap, np.float32(np.nan), inverse))
    wrong = found.inverse_depth != inverse
    block = -(-max(size) // 320)
    assert wrong.sum() <= (block > 1) * 2 * block * 2 * np.pi * 0.3 * size[1]
    assert set(np.unique(found.inverse_depth)) == {np.float32(1), np.float32(0.25)}  # never between them


@pytest.mark.parametrize("slope", [0.0, 0.002, -0.004])
def test_a_gap_in_a_plane_is_closed_by_the_plane(slope):
    """Proposals lie on the plane, at most the gap's width away: off by slope * width at most."""
    inverse = (1 + slope * np.indices((40, 60))[1]).astype(np.float32)
    given = inverse.copy()
    given[15:25, 20:32] = np.nan
    found = complete(np.full((40, 60, 3), 0.5, np.float32), given).inverse_depth
    assert np.abs(found - inverse).max() <= abs(slope) * 12 + 1e-6


def test_the_sky_stays_infinitely_far_and_a_gap_next_to_it_may_join_it():
    """Depth of 0 /m is measured; a gap is neither near nor far until it is known."""
    above = np.indices((20, 30))[0] < 10
    inverse = np.where(above, 0, 0.5).astype(np.float32)
    colour = np.where(above[..., None], 0.9, 0.1).astype(np.float32) * np.ones(3, np.float32)
    given = inverse.copy()
    given[6:14] = np.nan
    assert same(complete(colour, given).inverse_depth, inverse)


def test_confidence_falls_with_distance_and_between_surfaces():
    """At the reach, 0.075 of the longer side, it is a half of the share; no share is lost here."""
    inverse, colour = np.full((40, 200), np.nan, np.float32), np.full((40, 200, 3), 0.5, np.float32)
    inverse[:, :50] = 0.5
    whole, parted = (complete(colour, inverse, text) for text in ("complete", "complete:least=0.5"))
    found = whole.confidence
    assert (np.diff(found[20, 50:]) <= 0).all()
    assert found[20, 49 + 15] == pytest.approx(0.5, rel=1e-6)
    assert not np.isnan(whole.inverse_depth).any()
    assert np.array_equal(np.isnan(parted.inverse_depth), found < 0.5), "least confidence leaves holes"
    inverse[:, 80:] = 2.0  # another surface, of the same colour: the middle may be either
    both = complete(colour, inverse).confidence
    assert both[20, 64] < found[20, 64] and both[20, 50] > 0.9
