"""Made-up eyes for tests of the gaze: they rest in the world, follow, and leap.

A leap of A degrees takes 21 ms + 2.2 ms/degree (Carpenter 1988, Movements of the eyes).
"""

from __future__ import annotations

import math
import random

import numpy as np

from hmdwarp.poses import PoseTrack, minimum_jerk, quaternions

WIDEST_DEG = 25.0  # farther from straight ahead the head comes along


def with_eyes(track: PoseTrack, seed: int = 66) -> PoseTrack:
    """The track with a gaze; the same seed makes the same."""
    rng = random.Random(f"gaze {seed}")
    t = track.time_ns * 1e-9
    ahead = quaternions.rotate(track.orientation_xyzw, np.array([[0.0, 0.0, -1.0]]))
    world, now, at = np.empty((len(t), 3)), 0, ahead[0]
    while now < len(t):
        target = beside(rng, ahead[min(int(np.searchsorted(t, t[now] + 0.021)), len(t) - 1)])
        apart = max(math.acos(min(1.0, max(-1.0, float(at @ target)))), 1e-9)
        start_s = t[now] + 0.021 + 0.0022 * math.degrees(apart)
        landed = int(np.searchsorted(t, start_s))
        share = minimum_jerk((t[now:landed] - t[now]) / (start_s - t[now]))
        slid = np.sin((1 - share) * apart)[:, None] * at + np.sin(share * apart)[:, None] * target
        world[now:landed] = slid / math.sin(apart)
        now, turn_deg_s, rest_s = landed, 0.0, 0.0
        if rng.random() < 0.1:
            turn_deg_s, rest_s = 5 + 25 * rng.random(), 0.4 + 0.8 * rng.random()
        else:
            rest_s = 0.1 - 0.23 * math.log(1 - rng.random())
        axis = np.cross(target, beside(rng, target))
        end = int(np.searchsorted(t, start_s + rest_s))
        turned = np.radians(turn_deg_s) * (t[now:end] - start_s)
        across = np.cross(axis / np.linalg.norm(axis), target)
        followed = np.cos(turned)[:, None] * target + np.sin(turned)[:, None] * across
        wide = np.einsum("ij,ij->i", followed, ahead[now:end]) < math.cos(math.radians(WIDEST_DEG))
        end = now + (int(wide.argmax()) if wide.any() else len(wide))
        world[now:end] = followed[: end - now]
        at, now = world[end - 1] if end else at, end
    return track.evolve(gaze=quaternions.rotate(quaternions.conjugate(track.orientation_xyzw), world))


def beside(rng: random.Random, ahead: np.ndarray) -> np.ndarray:
    """A direction some degrees from another: small angles are the most common."""
    apart = min(1 - 6 * math.log(1 - rng.random()), 0.8 * WIDEST_DEG)
    way = 2 * math.pi * rng.random()
    right = np.cross(ahead, (0.0, 1.0, 0.0))
    right = right / max(float(np.linalg.norm(right)), 1e-6)
    aside = math.cos(way) * right + 0.7 * math.sin(way) * np.cross(right, ahead)  # more across than up
    found = ahead + math.tan(math.radians(apart)) * aside
    return found / np.linalg.norm(found)
