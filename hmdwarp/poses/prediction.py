"""Prediction of the head from past motion, and how far it misses.

And where the eyes look: known as late as the head, and held.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import InputError
from ..geometry import Pose
from . import quaternions
from .assumptions import assumption_rows
from .predictors import Predictor, predictors
from .reading.cleaning import LoadedTrace
from .track import Gaze, Origin, PoseSample, PoseTrack

Array = NDArray[np.float64]

KNOWN_NS = 50_000_000  # of motion before a prediction, as of the head's predictor constant_velocity


def known_gaze(track: PoseTrack, now_ns: int, head: Pose) -> Gaze | None:
    """Return the gaze at an instant in the axes of a head; None where it is not known.

    What eyes look at stays where it is in the world.
    """
    sample = track.at(now_ns)
    if sample.gaze is None:
        return None
    x, y, z = (head.rotation_matrix.T @ (sample.pose.rotation_matrix @ np.array(sample.gaze))).tolist()
    return x, y, z


def gaze_of(samples: Sequence[PoseSample]) -> Array | None:
    """Return the gaze of poses, (n, 3), NaN where it is not known; None where it never is."""
    if all(sample.gaze is None for sample in samples):
        return None
    return np.array([(math.nan,) * 3 if sample.gaze is None else sample.gaze for sample in samples])


ERROR_PERCENTILES = (50, 95, 99)


def predict(
    track: PoseTrack, now_ns: int, target_ns: int, method: str | Predictor = "cautious", horizon_ns: int | None = None
) -> PoseSample:
    """Return the head pose at `target_ns` as known at `now_ns`; ignore every sample after `now_ns`.

    A target at or before the last known sample is looked up, not predicted. The gaze is the last
    known one, held in the world.

    Parameters
    ----------
    track : PoseTrack
    now_ns, target_ns : int
    method : Predictor or str
        A predictor or its name.
    horizon_ns : int, optional
        How far ahead of the last sample at most; beyond it the pose stays constant. The
        predictor's own by default.

    Raises
    ------
    UnknownNameError, InputError
        For no predictor's name; for a negative horizon.
    """
    predictor = predictors.get(method) if isinstance(method, str) else method
    horizon_ns = predictor.horizon_ns if horizon_ns is None else horizon_ns
    if horizon_ns < 0:
        raise InputError(f"prediction horizon {horizon_ns / 1e6:g} ms: expected 0 or more")
    now_ns, target_ns = operator.index(now_ns), operator.index(target_ns)
    i = track.index_at(now_ns)
    if i >= 0 and target_ns <= int(track.time_ns[i]):
        return track.at(target_ns)
    sample, known_ns = predictor.predict(track, now_ns, target_ns, horizon_ns), min(now_ns, int(track.time_ns[i]))
    return sample if track.gaze is None else attrs.evolve(sample, gaze=known_gaze(track, known_ns, sample.pose))


_MS = 1_000_000
GRID_NS = 5 * _MS  # 200 Hz
MOST_INSTANTS = 200_000  # 1000 s at 200 Hz: longer tracks are sampled at evenly spaced instants
LATENCIES_MS = (20, 50, 100, 200, 400, 600, 800)
SPEED_PERCENTILES = (50, 95, 99, 99.9)


def analyse(track: PoseTrack, latencies_ms: tuple[int, ...] = LATENCIES_MS) -> dict[str, Any]:
    """Return what `trace info --json` prints of the motion, none of it across a gap or jump.

    Speeds, at SPEED_PERCENTILES, and errors leave out repeated poses; percentiles are keys such as
    p95, NaN without any.
    """
    motion, steps = track.without_repeats(), np.diff(track.time_ns)
    gaps, duration_s = np.flatnonzero(steps > track.max_gap_ns), track.duration_ns / 1e9
    angular, linear = speeds(motion)
    known = None if track.gaze is None else {"known": float(np.isfinite(track.gaze).all(axis=1).mean())}
    return {
        "samples": len(track), "repeated_share": 1 - len(motion) / len(track), "duration_s": duration_s,
        "rate_hz": track.rate_hz, "mean_rate_hz": (len(track) - 1) / duration_s if duration_s else 0.0,
        "gaps": [{"start_s": int(track.time_ns[i]) / 1e9, "length_s": int(steps[i]) / 1e9} for i in gaps],
        "jumps": len(track.jumps), "gaze": known,
        "angular_speed_deg_s": _percentiles(np.degrees(angular), SPEED_PERCENTILES),
        "linear_speed_m_s": _percentiles(linear, SPEED_PERCENTILES),
        "errors_deg": [error_row(motion, latency) for latency in latencies_ms],
    }  # fmt: skip


def speeds(track: PoseTrack) -> tuple[Array, Array]:
    """Return angular (rad/s) and linear (m/s) speeds: differences over 10 ms, every 5 ms."""
    now = _instants(track, GRID_NS, GRID_NS)
    now = now[_joined(track, now - GRID_NS, now + GRID_NS)]
    before, after = track.sample_many(now - GRID_NS), track.sample_many(now + GRID_NS)
    seconds = 2 * GRID_NS * 1e-9
    angle = quaternions.angle_between(before.orientation_xyzw, after.orientation_xyzw)
    return angle / seconds, np.linalg.norm(after.position_m - before.position_m, axis=1) / seconds


def error_row(track: PoseTrack, latency_ms: int) -> dict[str, Any]:
    """Return the angles between the head at t and its predictions from t - latency.

    By predictor, each once, by how far it looks ahead: mean, and ERROR_PERCENTILES, in degrees.
    count: of instants.
    """
    latency = latency_ms * _MS
    now = _instants(track, latency + KNOWN_NS, 0)
    now = now[_joined(track, now - latency - KNOWN_NS, now)]
    truth = track.sample_many(now).orientation_xyzw
    then = now - latency
    row: dict[str, Any] = {"latency_ms": latency_ms, "count": len(now)}
    for predictor in sorted(predictors, key=lambda p: p.horizon_ns):
        predicted = predictor.predict_many(track, then, latency).orientation_xyzw
        missed = np.linalg.norm(np.degrees(quaternions.vector_between(truth, predicted)), axis=-1)
        mean = float(missed.mean()) if len(missed) else math.nan
        row |= {predictor.name: {"mean": mean, **_percentiles(missed, ERROR_PERCENTILES)}}
    return row


def _instants(track: PoseTrack, before_ns: int, after_ns: int) -> NDArray[np.int64]:
    """Return a 200 Hz grid that leaves room at both ends, thinned to MOST_INSTANTS."""
    first, last = track.start_ns + before_ns, track.end_ns - after_ns
    if last < first:
        return np.empty(0, np.int64)
    stride = GRID_NS * -(-((last - first) // GRID_NS + 1) // MOST_INSTANTS)
    return np.arange(first, last + 1, stride, dtype=np.int64)


def _joined(track: PoseTrack, start_ns: NDArray[np.int64], end_ns: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return where neither end lies within a gap, and no gap or jump lies between."""
    if len(track) < 2:
        return np.zeros(len(start_ns), bool)
    known = track.sample_many(end_ns).origin != Origin.HELD
    return np.asarray((track.run_of(start_ns) == track.run_of(end_ns)) & known)


def _percentiles(values: Array, wanted: tuple[float, ...]) -> dict[str, float]:
    found = np.percentile(values, wanted).tolist() if len(values) else [math.nan] * len(wanted)
    return {f"p{percent:g}": value for percent, value in zip(wanted, found, strict=True)}


def trace_as_json(loaded: LoadedTrace, figures: dict[str, Any]) -> dict[str, Any]:
    """Return what `trace info --json` prints. figures: of `analyse`."""
    return {
        "trace": str(loaded.path), "format": loaded.format, "origin": loaded.track.origin, "axes": loaded.axes,
        "columns": loaded.columns, "clock": loaded.time_unit, "clock_starts_s": loaded.track.epoch_ns / 1e9, **figures,
        "segments": [attrs.asdict(segment) for segment in loaded.segments],
        "assumptions": assumption_rows(loaded.assumptions),
        "defects": [attrs.asdict(defect) for defect in loaded.defects],
    }  # fmt: skip
