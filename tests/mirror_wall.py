"""A painted wall that mirrors a world behind it: pictures whose two layers are known."""

from __future__ import annotations

import numpy as np

from hmdwarp.geometry import Fov, Pose, View

SIZE = (160, 128)
FOV = Fov(-0.7, 0.7, -0.6, 0.6)
STRAIGHT = View(Pose(), FOV)
# As far apart in pixels as eyes and a walking head are in a picture of full size.
OTHERS = tuple(View(Pose(at), FOV) for at in ((0.2, 0.0, 0.0), (0.05, -0.15, 0.0), (-0.1, 0.1, 0.05)))
SHOWN = View(Pose((0.15, 0.06, 0.0)), FOV)
WALL_M, IMAGE_M = 1.5, 4.0  # a mirror on a wall across the view, and the mirrored world behind it


def waves(points: np.ndarray, per_m: float, seed: int) -> np.ndarray:
    """(..., 3) light of 0 to 1 that varies along x and y, the same from everywhere."""
    rng = np.random.default_rng(seed)
    total = sum(
        np.sin(points[..., :2] @ (per_m * rng.uniform(-1, 1, 2)) + rng.uniform(0, 6))[..., None]
        * rng.uniform(0.5, 1, 3)
        for _ in range(6)
    )
    return 0.5 + 0.5 * np.tanh(4 * total)  # patches with edges, as pictures have


def picture(view: View, share: float, size: tuple[int, int] = SIZE) -> tuple[np.ndarray, np.ndarray]:
    """(h, w, 4) and inverse depth of a painted wall that mirrors `share` of the image behind it."""
    rays = view.rays(size)
    eye = view.pose.position_m
    on_wall, on_image = (eye + rays * (far + eye[2]) for far in (WALL_M, IMAGE_M))
    light = 0.3 * waves(on_wall, 8.0, 1) + share * waves(on_image, 6.0, 2)
    depth = np.full(rays.shape[:2], 1 / (WALL_M + eye[2]))
    return np.concatenate([light, np.ones((*depth.shape, 1))], axis=-1), depth
