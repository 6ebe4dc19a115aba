"""Holes that one eye has and the other has not, against a brute-force count through points in the
world.
"""

import numpy as np
import pytest

from hmdwarp.errors import InputError
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.metrics import Mismatch, SharedSurface

FOV = Fov(-0.7, 0.6, -0.5, 0.55)
SIZE = (61, 47)
LEFT, RIGHT = View(Pose((-0.032, 0, 0)), FOV), View(Pose((0.032, 0, 0)), FOV)
FAR = np.zeros((47, 61), np.float32)
FULL = np.ones((47, 61))


def board_depth(view: View, board_m: float, wall_m: float) -> np.ndarray:
    """(h, w) top row first: a board 0.4 m wide before a wall, both square to the view."""
    rays = view.rays(SIZE)
    x = rays[..., 0] * board_m + view.pose.position_m[0]
    return np.where(np.abs(x) < 0.2, 1 / board_m, 1 / wall_m).astype(np.float32)[::-1]


def brute(left_holes: np.ndarray, right_holes: np.ndarray, board_m: float, wall_m: float) -> Mismatch:
    """Each left ray to its point in the world.

    The right eye sees it unless the board is in the way. Rows as pictures have them.
    """
    seen = one_eyed = 0
    rays = LEFT.rays(SIZE)[::-1]
    for row in range(SIZE[1]):
        for column in range(SIZE[0]):
            depth_m = board_m if abs(rays[row, column, 0] * board_m - 0.032) < 0.2 else wall_m
            point = rays[row, column] * depth_m + LEFT.pose.position_m
            tangent = (point - RIGHT.pose.position_m) / depth_m
            if depth_m == wall_m and abs(tangent[0] * board_m + 0.032) < 0.2:
                continue
            px, py, _ = FOV.pixel_from_tangent(SIZE) @ (tangent[0], tangent[1], 1)
            if not (0 <= px < SIZE[0] and 0 <= py < SIZE[1]):
                continue
            there = SIZE[1] - 1 - int(py), int(px)
            # What the nearest pixel's own ray meets is what the other eye's picture has there.
            if (abs(RIGHT.rays(SIZE)[0, there[1], 0] * board_m + 0.032) < 0.2) != (depth_m == board_m):
                continue
            seen += 1
            one_eyed += bool(left_holes[row, column]) != bool(right_holes[there])
    return Mismatch(seen, one_eyed)


@pytest.mark.parametrize(("board_m", "wall_m"), [(0.5, 3.0), (1.0, 1.3)])
def test_against_points_in_the_world(board_m, wall_m):
    shared = SharedSurface(LEFT, RIGHT, board_depth(LEFT, board_m, wall_m), board_depth(RIGHT, board_m, wall_m))
    rng = np.random.default_rng(1)
    left, right = (rng.random((47, 61)) < 0.3 for _ in range(2))
    assert shared.compare(~left, ~right) == brute(left, right, board_m, wall_m)
    assert 0 < shared.compare(FULL, FULL).seen_by_both < FULL.size
    # Blind in the right eye: every shared pixel rivals, and no other.
    blind = shared.compare(FULL, FULL * 0)
    assert blind.one_eyed == blind.seen_by_both and blind.share == 1


def test_at_infinity_both_eyes_see_the_same_pixels():
    shared = SharedSurface(LEFT, RIGHT, FAR, np.full_like(FAR, np.nan))
    coverage = FULL.copy()
    coverage[5, 7] = 0
    assert shared.compare(coverage, FULL) == Mismatch(FULL.size, 1)
    assert shared.compare(coverage, coverage) == Mismatch(FULL.size, 0)
    about = View(Pose((0, 0, 0), (0, 1, 0, 0)), FOV)
    assert SharedSurface(LEFT, about, FAR, FAR).compare(FULL, FULL).share is None
    for compare in (lambda: SharedSurface(LEFT, RIGHT, FAR, FAR[:-1]), lambda: shared.compare(FULL, FULL[:-1])):
        with pytest.raises(InputError, match="expected"):
            compare()


def test_a_near_slanted_wall_is_one_surface():
    """Half a pixel beside, its inverse depth differs by a hundredth."""
    walls = [(1 - 0.8 * view.rays(SIZE)[::-1, :, 0]) / (1 + 0.8 * view.pose.position_m[0]) for view in (LEFT, RIGHT)]
    assert SharedSurface(LEFT, RIGHT, *walls).compare(FULL, FULL).seen_by_both > 0.9 * FULL.size
