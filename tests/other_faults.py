"""Frames with faults that no convention of `hmdwarp check` is, found by rays in float64."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np
from reference.raycast import cast_quads, cast_spheres, nearest
from scipy.spatial.transform import Rotation
from wrong_frames import hand_held

from hmdwarp.check import StatedFrame
from hmdwarp.geometry import Fov, Pose, View

SIZE, FOV = (96, 72), Fov.symmetric(np.deg2rad(72), np.deg2rad(57))
FRAMES, RATE_HZ = 16, 30
Way = Callable[[np.ndarray], np.ndarray]


def box(centre: np.ndarray, half: np.ndarray) -> list[np.ndarray]:
    """Return the six sides of a box as (centre, right, up)."""
    sides = []
    for axis in range(3):
        x, right, up = (half[one % 3] * np.eye(3)[one % 3] for one in (axis, axis + 1, axis + 2))
        sides += [np.stack([centre + sign * x, right, up]) for sign in (-1, 1)]
    return sides


class World:
    """A room with boxes and balls, of a pattern in space: all places look different."""

    def __init__(self, rng: np.random.Generator) -> None:
        half = rng.uniform((2.5, 1.2, 2.5), (4, 1.6, 4))
        places = [rng.uniform(-0.7, 0.7, 3) * half for _ in range(9)]
        places = [one for one in places if np.hypot(*one[[0, 2]]) > 1.3]  # the camera is in the middle
        quads = box(np.zeros(3), half)
        for one in places[::2]:
            quads += box(one, rng.uniform(0.1, 0.4, 3))
        self.quads = np.array(quads) + np.eye(3)[0][:, None] * (0, 1.4, 0)
        self.spheres = np.array([(*(one + (0, 1.4, 0)), rng.uniform(0.15, 0.4)) for one in [half * 9, *places[1::2]]])
        waves = rng.normal(size=(24, 3))
        self.waves = waves * (np.geomspace(2, 25, 24) / np.linalg.norm(waves, axis=1))[:, None]
        self.phases, self.colours = rng.uniform(0, 2 * np.pi, 24), 14 * rng.normal(size=(24, 3))

    def seen(self, pose: Pose, tangents: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return colour (h, w, 3) and depth along -z (h, w) where tangents (h, w, 2) look."""
        rays = np.concatenate([tangents, -np.ones_like(tangents[..., :1])], axis=-1) @ pose.rotation_matrix.T
        casts = ((cast_quads, self.quads), (cast_spheres, self.spheres))
        hits = nearest(*(cast(shapes, pose.position_m, rays.reshape(-1, 3)) for cast, shapes in casts))
        depth = 1 / hits.inverse_depth.reshape(tangents.shape[:2])
        light = np.cos((pose.position_m + rays * depth[..., None]) @ self.waves.T + self.phases) @ self.colours
        return np.clip(128 + light, 0, 255), depth


@attrs.frozen(eq=False)
class Fault:
    """What is otherwise than stated: of pixels' tangents, of the depth, of the poses."""

    lens: Way = lambda tangents: tangents  # where the camera looks
    depth_lens: Way | None = None  # where depth does, if elsewhere
    depth_place: Pose = Pose()  # of the depth's camera in the colour's
    stated: Pose = Pose()  # of what is tracked, in the camera
    late_s: float = 0.0  # poses are of so long before
    depth: Callable[[np.ndarray, int, np.random.Generator], np.ndarray] = lambda depth, k, rng: depth

    def frames(self, seed: int, head_at: Callable[[int], Pose] | None = None) -> list[StatedFrame]:
        """Return frames of a random room and motion, with noise of depth and colour."""
        rng = np.random.default_rng([7, seed])
        world, head_at = World(rng), head_at or hand_held(rng)
        left, right, down, up = FOV.tangents
        x, y = ((np.arange(count) + 0.5) / count for count in SIZE)
        grid = np.stack(np.meshgrid(left + x * (right - left), up - y * (up - down)), axis=-1)
        elsewhere, found = Pose(rng.normal(size=3), Rotation.random(random_state=rng).as_quat()), []
        for k in range(FRAMES):
            time_ns = round(k / RATE_HZ * 1e9)
            pose, then = head_at(time_ns), head_at(time_ns - round(self.late_s * 1e9))
            colour, depth = world.seen(pose, self.lens(grid))
            if self.depth_lens or self.depth_place != Pose():
                depth = world.seen(pose @ self.depth_place, (self.depth_lens or self.lens)(grid))[1]
            depth = self.depth(1 / (1 / depth + rng.normal(0, 0.001, depth.shape)), k, rng)
            colour = np.clip(colour + rng.normal(0, 2, colour.shape), 0, 255).astype(np.uint8)
            found.append(StatedFrame(str(k), colour, depth, View(elsewhere @ then @ self.stated, FOV), time_ns))
        return found


def bent(k1: float, k2: float = 0.0) -> Way:
    """Return a lens after Brown: its pixels lie where tangents times (1 + k1 r^2 + k2 r^4) do."""

    def lens(seen: np.ndarray) -> np.ndarray:
        true = seen
        for _ in range(50):
            squared = (true**2).sum(axis=-1, keepdims=True)
            true = seen / (1 + k1 * squared + k2 * squared**2)
        return true

    return lens


def turned(x: float, y: float, z: float) -> Pose:
    return Pose(orientation_xyzw=Rotation.from_euler("xyz", (x, y, z), degrees=True).as_quat())


TURNS = ((0, 2, 0), (3, 0, 0), (0, 0, 5), (4, -6, 3), (-9, 15, 0))
FAULTS = {
    **{f"cut off at {m} m": Fault(depth=lambda z, k, rng, m=m: np.minimum(z, m)) for m in (1.5, 2.0, 2.5, 3.0)},
    **{
        f"scales, {s}": Fault(depth=lambda z, k, rng, s=s: z * np.exp(rng.normal(0, s)))
        for s in (0.03, 0.06, 0.12, 0.3)
    },
    "a scale that drifts": Fault(depth=lambda z, k, rng: z * (1 + 0.02 * k)),
    "two scales in turn": Fault(depth=lambda z, k, rng: z * 1.1 ** (k % 2)),
    **{f"lens, k1 {k}": Fault(lens=bent(*k)) for k in ((-0.3, 0.08), (-0.15,), (-0.08,), (0.1,), (0.2,), (0.4,))},
    **{f"depth {w} as wide": Fault(depth_lens=lambda seen, w=w: w * seen) for w in (0.8, 0.93, 1.07, 1.25)},
    **{f"depth off by {off}": Fault(depth_lens=lambda seen, off=off: seen + off) for off in ((-0.1, 0), (0.03, 0.05))},
    "depth's camera 5 cm beside": Fault(depth_place=Pose((0.05, 0, 0))),
    "depth's camera turned": Fault(depth_place=turned(1, -3, 1)),
    **{f"turned by {turn}": Fault(stated=turned(*turn)) for turn in TURNS},
    **{f"late by {late} s": Fault(late_s=late) for late in (-0.3, -0.2, -0.1, 0.1, 0.15, 0.2, 0.3)},
    "tracked 12 cm beside": Fault(stated=Pose((0.08, -0.05, 0.07))),
}
