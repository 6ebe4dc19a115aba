"""Synthetic eyes on a head's motion: fixations, pursuits, and leaps (saccades) between them.

What is looked at stands still in the world, or is followed: the eyes turn against the head. A leap
of A degrees takes 21 ms + 2.2 ms/degree (Bahill, Clark and Stark 1975, The main sequence, a tool
for studying human eye movements; the line is that of Carpenter 1988, Movements of the eyes). Most
leaps are below 15 degrees (Bahill, Adler and Stark 1975, Most naturally occurring human saccades
have magnitudes of 15 degrees or less); fixations of a scene last 330 ms on average (Rayner 1998,
Eye movements in reading and information processing). Pursuits go at up to 30 degrees a second
(Robinson 1965, The mechanics of human smooth pursuit eye movement).
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from . import quaternions
from .track import PoseTrack

Array = NDArray[np.float64]

LEAP_BASE_S, LEAP_PER_DEG_S = 0.021, 0.0022
_LEAST_LEAP_DEG, _MEAN_LEAP_DEG = 1.0, 6.0
_LEAST_FIXATION_S, _MEAN_FIXATION_S = 0.1, 0.33
_PURSUIT_SHARE, _PURSUIT_S, _PURSUIT_DEG_S = 0.1, (0.4, 1.2), (5.0, 30.0)
# Farther from straight ahead the head comes along; the eyes go back to where it points.
_WIDEST_DEG = 25.0


def with_gaze(track: PoseTrack, seed: int, profile: Callable[[Array], Array]) -> PoseTrack:
    """Return the track with a gaze. profile: 0 to 1 over the share of a leap's time."""
    rng = random.Random(f"gaze {seed}")
    t = track.time_ns * 1e-9
    heads = np.array([[0.0, 0.0, -1.0]])
    ahead = quaternions.rotate(track.orientation_xyzw, heads)
    world, now, at = np.empty((len(t), 3)), 0, ahead[0]
    while now < len(t):
        aim = int(np.searchsorted(t, t[now] + LEAP_BASE_S))
        target = _beside(rng, ahead[min(aim, len(t) - 1)])
        leap_s = LEAP_BASE_S + LEAP_PER_DEG_S * math.degrees(_angle(at, target))
        landed = int(np.searchsorted(t, t[now] + leap_s))
        share = profile((t[now:landed] - t[now]) / leap_s)
        world[now:landed] = _slerp(at, target, share)
        now, start_s, at = landed, t[now] + leap_s, target
        turn_deg_s, rest_s = _rest(rng)
        axis = np.cross(target, _beside(rng, target))
        end = int(np.searchsorted(t, start_s + rest_s))
        turned = np.radians(turn_deg_s) * (t[now:end] - start_s)
        followed = _turned(target, axis / np.linalg.norm(axis), turned)
        wide = np.einsum("ij,ij->i", followed, ahead[now:end]) < math.cos(math.radians(_WIDEST_DEG))
        end = now + (int(wide.argmax()) if wide.any() else len(wide))
        world[now:end] = followed[: end - now]
        at, now = world[end - 1] if end else at, end
    gaze = quaternions.rotate(quaternions.conjugate(track.orientation_xyzw), world)
    how = track.origin.replace(" --seconds", " --gaze --seconds")
    return track.evolve(gaze=gaze, origin=how)


def _rest(rng: random.Random) -> tuple[float, float]:
    """Return how fast the eyes follow something, 0 for what stands still, and for how long."""
    if rng.random() < _PURSUIT_SHARE:
        return _between(rng, *_PURSUIT_DEG_S), _between(rng, *_PURSUIT_S)
    return 0.0, _LEAST_FIXATION_S - (_MEAN_FIXATION_S - _LEAST_FIXATION_S) * math.log(1 - rng.random())


def _beside(rng: random.Random, ahead: Array) -> Array:
    """Return a direction some degrees from another: small angles are the most common."""
    apart = min(_LEAST_LEAP_DEG - _MEAN_LEAP_DEG * math.log(1 - rng.random()), 0.8 * _WIDEST_DEG)
    way = _between(rng, 0, 2 * math.pi)
    right = np.cross(ahead, (0.0, 1.0, 0.0))
    right = right / max(float(np.linalg.norm(right)), 1e-6)
    aside = math.cos(way) * right + 0.7 * math.sin(way) * np.cross(right, ahead)  # more across than up
    found = ahead + math.tan(math.radians(apart)) * aside
    return np.asarray(found / np.linalg.norm(found))


def _between(rng: random.Random, low: float, high: float) -> float:
    return low + (high - low) * rng.random()


def _angle(a: Array, b: Array) -> float:
    return math.acos(min(1.0, max(-1.0, float(a @ b))))


def _slerp(a: Array, b: Array, share: Array) -> Array:
    angle = max(_angle(a, b), 1e-9)
    found = np.sin((1 - share) * angle)[:, None] * a + np.sin(share * angle)[:, None] * b
    return np.asarray(found / math.sin(angle))


def _turned(direction: Array, axis: Array, angles: Array) -> Array:
    """Return a direction turned about an axis at a right angle to it."""
    return np.asarray(np.cos(angles)[:, None] * direction + np.sin(angles)[:, None] * np.cross(axis, direction))
