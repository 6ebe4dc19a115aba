"""Iterative: pixels of mixed colours along a silhouette move with the thing in front."""

from __future__ import annotations

import numpy as np

from hmdwarp.geometry import Pose

from .rendered_pictures import square_before_a_wall, warped


def antialiased_thing(left: float, right: float) -> np.ndarray:
    """(60, 60, 4): white from left to right before 0.2; each pixel is the mean of its area."""
    x = np.arange(60)
    share = np.clip(np.minimum(x + 1, right) - np.maximum(x, left), 0, 1)
    return np.tile(np.append(np.repeat(0.2 + 0.8 * share[:, None], 3, axis=1), np.ones((60, 1)), axis=1), (60, 1, 1))


def test_mixed_pixels_move_with_the_thing_in_front(gpu):
    """Its sides lie at 20.4 and 40.3, so pixels 20 and 40 are mixed; the latter's centre is wall.

    Moved by 12 pixels, and the wall by 3: at 43 - 3 = 37 such a pixel of the wall would be seen.
    """
    colour, depth = antialiased_thing(20.4, 40.3), square_before_a_wall(np.s_[:, 20:40])[1]
    truth = antialiased_thing(20.4 - 12, 40.3 - 12)
    now, before = (
        warped(gpu, spec, colour, depth, Pose((0.4, 0, 0))) for spec in ("iterative", "iterative:fringe=own")
    )
    seen = now[..., 3] == 1
    assert seen[:, 7:29].all()
    assert np.abs(now - truth)[seen].max() <= 2.0**-9
    assert before[0, 28, 3] == 0
    assert np.abs(before[:, 37, 0] - colour[0, 40, 0]).max() <= 2.0**-9  # a ghost on the wall


def test_a_silhouette_moves_smoothly_where_surfaces_part_by_less_than_a_pixel(gpu):
    """Each step moves the thing by 0.03 pixels, so 0.024 of the contrast of 0.8, and a sheet of 0.7
    pixels stretches that by less than 1.5. Without a sheet a mixed pixel of 0.3 leaps at once.
    """
    colour, depth = antialiased_thing(20.4, 40.3), square_before_a_wall(np.s_[:, 20:40])[1]

    def largest_step(spec: str) -> float:
        moved = [warped(gpu, spec, colour, depth, Pose((x, 0, 0)))[30, 15:45] for x in np.arange(0, 0.03, 0.001)]
        return np.abs(np.diff(moved, axis=0)).max()

    assert largest_step("iterative") < 1.5 * 0.024
    assert largest_step("iterative:sheet=0") > 0.2
