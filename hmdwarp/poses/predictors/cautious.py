"""Errs short: a speed that fades, and counts for less where it has just failed to foretell.

A prediction that leads the head overshoots where the head stops, and has to come back. So the speed
of the last moments fades with time, is followed for a limited horizon only, and is scaled by a
confidence. That comes from the predictor's own record: what the same speed a few moments ago
foretold for now, against what the head did. What it foretold too far counts more.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ...geometry import Pose
from .. import quaternions
from ..sample import Origin, PoseSample
from ..track import PoseTrack, Samples
from . import Predictor, hold, predictors

Array = NDArray[np.float64]

_MS = 1_000_000
WINDOW_NS = 30 * _MS  # that the speed is measured over
# Past predictions looked this far ahead, and ended this long ago. Longer ones react too late to a
# head that slows down; a single one is at the mercy of a tracker's noise.
TESTED_NS = 50 * _MS
ENDED_NS = (0, 20 * _MS, 40 * _MS)
# Fitted to 57 recordings of 19 people (EyeNavGS, Rutgers site: Ding et al. 2025, arXiv:2506.02380):
# the least mean error plus ten times the mean lead, from 50 to 800 ms and each as a share of the
# motion, among those that lead less than constant_velocity at each latency, and whose p95 error is
# at most 1 % more in nine of ten recordings.
FADES_NS = 200 * _MS  # time constant of turning
HORIZON_NS = 150 * _MS
MOVES_NS = 105 * _MS  # walking does not fade: it goes on for this long
WEIGHT_MISSED, WEIGHT_TOO_FAR = 0.25, 4.0  # of the squared errors of the past predictions

KNOWN_NS = max(ENDED_NS) + TESTED_NS + WINDOW_NS
_ENDED, _COUNT = np.array(ENDED_NS, np.int64), len(ENDED_NS)
# Before now: the two ends of the window, and of each past prediction now, then, and its window's.
_BACK_NS = np.concatenate([(0, WINDOW_NS), _ENDED, _ENDED + TESTED_NS, _ENDED + TESTED_NS + WINDOW_NS])


def turns_ns(ahead_ns: int) -> float:
    """Return how long the full speed would last to turn as far as the fading one does."""
    return -FADES_NS * float(np.expm1(-ahead_ns / FADES_NS))


def confidence(moving: Array, missed: Array) -> Array:
    """Return 0..1: how far to trust a motion, (n,).

    moving: what the present speed foretells for TESTED_NS, (n, 3), rotation vector or way. missed:
    by how much the last predictions for as long came out too far, (n, k, 3). 1 where they were
    right; the units do not matter.
    """
    squared = np.einsum("ni,ni->n", moving, moving)[:, None]
    moves = squared > 0
    along = np.maximum(np.einsum("nki,ni->nk", missed, moving), 0.0)
    too_far = along * (along / np.where(moves, squared, 1.0))
    doubt = WEIGHT_MISSED * np.einsum("nki,nki->nk", missed, missed) + WEIGHT_TOO_FAR * too_far
    total = squared[:, 0] + doubt.mean(axis=1)
    return squared[:, 0] / np.where(total > 0, total, 1.0)


def cautious(track: PoseTrack, now_ns: int, target_ns: int, horizon_ns: int) -> PoseSample:
    """Extrapolate the last sample at most `horizon_ns` ahead; HELD where no speed is known.

    That takes a whole window without a gap or jump. Repeated poses count once; a head that repeats
    its pose for TESTED_NS rests.
    """
    i = track.index_at(now_ns)
    if i < 0 or now_ns - int(track.time_ns[i]) > track.max_gap_ns:
        return hold(track, now_ns, target_ns, horizon_ns)
    recent, last_ns = _recent(track, i), int(track.time_ns[i])
    ahead_ns = min(target_ns - last_ns, horizon_ns)
    if ahead_ns <= 0 or recent.duration_ns < WINDOW_NS or last_ns - recent.end_ns >= TESTED_NS:
        return hold(track, now_ns, target_ns, horizon_ns)
    found = _extrapolated(recent, np.array([recent.end_ns]), ahead_ns)
    return PoseSample(target_ns, Pose(found.position_m[0], found.orientation_xyzw[0]), Origin.PREDICTED)


def _cautious_many(track: PoseTrack, now_ns: NDArray[np.int64], ahead_ns: int) -> Samples:
    return _extrapolated(track, now_ns, min(ahead_ns, HORIZON_NS))


def _recent(track: PoseTrack, i: int) -> PoseTrack:
    """Return the distinct poses up to sample i that are looked at, each at its first stamp."""
    first = max(track.index_at(int(track.time_ns[i]) - KNOWN_NS - TESTED_NS), 0)
    breaks = np.flatnonzero(track.broken[first:i])
    first = first + int(breaks[-1]) + 1 if len(breaks) else first
    part = slice(first, i + 1)
    recent = PoseTrack(
        track.time_ns[part], track.position_m[part], track.orientation_xyzw[part], max_gap_ns=track.max_gap_ns
    )
    return recent.without_repeats()


def _extrapolated(track: PoseTrack, now_ns: NDArray[np.int64], ahead_ns: int) -> Samples:
    """Extrapolate for `ahead_ns` from each of `now_ns`, (n,)."""
    asked = now_ns[:, None] - _BACK_NS
    found = track.sample_many(asked.ravel())
    q, p = found.orientation_xyzw.reshape(*asked.shape, 4), found.position_m.reshape(*asked.shape, 3)
    runs = track.run_of(asked.ravel()).reshape(asked.shape)
    known = (runs == runs[:, :1]) & (asked >= track.start_ns)

    def turn(first: slice, last: slice) -> Array:
        return quaternions.to_rotation_vector(quaternions.multiply(q[:, last], quaternions.conjugate(q[:, first])))

    def move(first: slice, last: slice) -> Array:
        return p[:, last] - p[:, first]

    turned = quaternions.from_rotation_vector(turns_ns(ahead_ns) / WINDOW_NS * _trusted(turn, known))
    return Samples(
        now_ns + ahead_ns,
        p[:, 0] + min(ahead_ns, MOVES_NS) / WINDOW_NS * _trusted(move, known),
        quaternions.multiply(turned, q[:, 0]),
        np.full(len(now_ns), Origin.PREDICTED, np.int8),
    )


def _trusted(way: Callable[[slice, slice], Array], known: NDArray[np.bool_]) -> Array:
    """Return the motion within the last window scaled by its confidence, (n, 3).

    way(first, last): between the poses at these places of _BACK_NS, (n, k, 3). known: where there
    are poses, (n, 2 + 3 k). A prediction from before what is known counts as wrong by its whole
    length.
    """
    now, before, ended, began, window = (
        slice(0, 1),
        slice(1, 2),
        *(slice(2 + i * _COUNT, 2 + (i + 1) * _COUNT) for i in range(3)),
    )
    share = TESTED_NS / WINDOW_NS
    moved = way(before, now)
    missed = np.where(known[:, window, None], share * way(window, began) - way(began, ended), share * moved)
    trust = confidence(share * moved[:, 0], missed)
    return np.where(known[:, before], trust[:, None] * moved[:, 0], 0.0)


predictor = predictors.register(
    Predictor(
        "cautious",
        "the speed of the last 30 ms fades, the sooner the more it has just overshot",
        "Gardner and McKenzie 1985, Forecasting Trends in Time Series: a damped trend; the confidence is our own",
        cautious,
        _cautious_many,
        HORIZON_NS,
    )
)
