"""Prediction of the head from past motion; how far it misses, and whether it leads or lags.

And where the eyes look: known late like the head, held or predicted.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..geometry import Pose
from . import quaternions
from .assumptions import assumption_rows
from .predictors import Predictor, predictors
from .reading.cleaning import LoadedTrace
from .track import SACCADE_DEG_S, Gaze, Origin, PoseSample, PoseTrack

Array = NDArray[np.float64]

KNOWN_NS = 50_000_000  # of motion before a prediction, as of the head's predictor constant_velocity
_HORIZON_NS = 100_000_000  # beyond it a pursuit has long been corrected by a leap


def foreseen_gaze(track: PoseTrack, now_ns: int, ahead_ns: int = 0, head: Pose | None = None) -> Gaze | None:
    """Return the gaze so long after an instant, as known at that instant; None where it is not.

    head: in whose axes, by default the one at that instant. What eyes look at stays where it is in
    the world. A pursuit goes on at its speed there, for 100 ms at most; after a leap it is held.
    """
    now = _in_world(track, now_ns)
    if now is None:
        return None
    before = _in_world(track, now_ns - KNOWN_NS) if ahead_ns > 0 else None
    if before is not None and track.gaze is not None:
        seen = slice(max(track.index_at(now_ns - KNOWN_NS), 0), track.index_at(now_ns) + 1)
        world = quaternions.rotate(track.orientation_xyzw[seen], track.gaze[seen])
        # Eyes that leapt in the window, or were lost, say nothing of where they go.
        if np.isfinite(world).all() and not (_speeds(world, track.time_ns[seen]) > SACCADE_DEG_S).any():
            now = now + (now - before) * min(ahead_ns, _HORIZON_NS) / KNOWN_NS
            now = now / np.linalg.norm(now)
    x, y, z = ((head or track.at(now_ns).pose).rotation_matrix.T @ now).tolist()
    return x, y, z


def _in_world(track: PoseTrack, time_ns: int) -> Array | None:
    sample = track.at(time_ns)
    return None if sample.gaze is None else sample.pose.rotation_matrix @ np.array(sample.gaze)


def _speeds(gaze: Array, time_ns: NDArray[np.int64]) -> Array:
    turned = np.arccos(np.clip(np.einsum("ij,ij->i", gaze[1:], gaze[:-1]), -1, 1))
    return np.asarray(np.degrees(turned) / (np.diff(time_ns) * 1e-9))


def gaze_of(samples: Sequence[PoseSample]) -> Array | None:
    """Return the gaze of poses, (n, 3), NaN where it is not known; None where it never is."""
    if all(sample.gaze is None for sample in samples):
        return None
    return np.array([(math.nan,) * 3 if sample.gaze is None else sample.gaze for sample in samples])


@attrs.frozen
class GazeFacts:
    """What `hmdwarp trace info` says of where the eyes look."""

    known: float  # share of the samples
    aside_deg: tuple[float, float]  # from straight ahead, median and 95th percentile
    leaps_s: float  # a second

    def __str__(self) -> str:
        aside = " and ".join(f"{degrees:.1f}" for degrees in self.aside_deg)
        return (
            f"known in {self.known:.1%} of the samples; p50 and p95 {aside} degrees from straight ahead; "
            f"{self.leaps_s:.1f} leaps of over {SACCADE_DEG_S:g} degrees a second each second"
        )


def gaze_facts(track: PoseTrack) -> GazeFacts | None:
    """Return the facts; None for a track without gaze."""
    if track.gaze is None:
        return None
    known = np.isfinite(track.gaze).all(axis=1)
    aside = np.degrees(np.arccos(np.clip(-track.gaze[known, 2], -1, 1)))
    fast = np.nan_to_num(_speeds(track.gaze, track.time_ns)) > SACCADE_DEG_S
    leaps = int(np.count_nonzero(fast & ~np.concatenate([[False], fast[:-1]])))
    middle, far = (float(np.percentile(aside, at)) for at in (50, 95))
    return GazeFacts(float(known.mean()), (middle, far), leaps / max(track.duration_ns * 1e-9, 1e-9))


ERROR_PERCENTILES = (50, 95, 99)
# A head that has turned or moved less than this has no direction: trackers that write three
# decimals step by 0.1 degrees.
STILL_DEG = 0.2
_FAR = 95  # percentile of lead and lag


def predict(
    track: PoseTrack, now_ns: int, target_ns: int, method: str | Predictor = "cautious", horizon_ns: int | None = None
) -> PoseSample:
    """Return the head pose at `target_ns` as known at `now_ns`; ignore every sample after `now_ns`.

    method: a predictor or its name. horizon_ns: how far ahead of the last sample at most, by
    default the predictor's own; beyond it the pose stays constant. A target at or before the last
    known sample is looked up, not predicted. The gaze is the last known one, held in the world.
    Errors: UnknownNameError; InputError for a negative horizon.
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
    return sample if track.gaze is None else attrs.evolve(sample, gaze=foreseen_gaze(track, known_ns, 0, sample.pose))


@attrs.frozen
class PredictionErrors:
    """Angles of many predictions, in degrees; NaN without any. See `signed_lead`."""

    mean: float
    percentiles: tuple[float, ...]  # at ERROR_PERCENTILES
    lead_share: float  # of the predictions that lead by more than STILL_DEG
    lead: float  # 95th percentile of the lead; 0 where it lags
    lag: float  # 95th percentile of the lag; 0 where it leads


def turn_errors(known: Array, actual: Array, predicted: Array) -> PredictionErrors:
    """Return angles of heads (n, 4): known when predicting, the actual ones, those predicted."""
    missed, moved = (np.degrees(quaternions.vector_between(*pair)) for pair in ((actual, predicted), (known, actual)))
    if not len(missed):
        return PredictionErrors(math.nan, (math.nan,) * len(ERROR_PERCENTILES), math.nan, math.nan, math.nan)
    lengths, lead = np.linalg.norm(missed, axis=-1), signed_lead(missed, moved, STILL_DEG)
    return PredictionErrors(
        mean=float(lengths.mean()), percentiles=_percentiles(lengths, ERROR_PERCENTILES),
        lead_share=float(np.mean(lead > STILL_DEG)), lead=max(0.0, float(np.percentile(lead, _FAR))),
        lag=max(0.0, float(np.percentile(-lead, _FAR))),
    )  # fmt: skip


def signed_lead(missed: Array, moved: Array, still: float) -> Array:
    """Return how far each prediction leads the head, (n,); negative where it lags behind.

    That is the part of the error along the head's own motion: missed (n, 3) is the rotation vector
    or way from the actual head to the predicted one, moved (n, 3) that from the known head to the
    actual one, in the world. A head that has moved less than `still` goes nowhere: whatever its
    prediction moves is lead.
    """
    length = np.linalg.norm(moved, axis=-1)
    at_rest = length < still
    along = np.einsum("ij,ij->i", missed, moved) / np.where(at_rest, 1.0, length)
    # From rest to rest: what is left of the error once the head's own jitter is taken off.
    return np.asarray(np.where(at_rest, np.linalg.norm(missed + moved, axis=-1), along))


_MS = 1_000_000
GRID_NS = 5 * _MS  # 200 Hz
MOST_INSTANTS = 200_000  # 1000 s at 200 Hz: longer tracks are sampled at evenly spaced instants
LATENCIES_MS = (20, 50, 100, 200, 400, 600, 800)
SPEED_PERCENTILES = (50, 95, 99, 99.9)


@attrs.frozen
class ErrorRow:
    """Angles between the head and its predictions of `latency_ms` before; NaN in a short track."""

    latency_ms: int
    errors: dict[str, PredictionErrors]  # by predictor, each once, by how far it looks ahead
    count: int  # instants


@attrs.frozen
class Analysis:
    """Everything `hmdwarp trace info` prints about motion."""

    samples: int
    duration_s: float
    rate_hz: float
    mean_rate_hz: float
    repeated_share: float
    gaps: list[dict[str, float]]  # stretches without samples: start_s, length_s
    jumps: int
    angular_speed_deg_s: tuple[float, ...]  # at SPEED_PERCENTILES
    linear_speed_m_s: tuple[float, ...]  # at SPEED_PERCENTILES
    errors: list[ErrorRow]  # one row per latency
    gaze: GazeFacts | None = None  # None for a track without


def analyse(track: PoseTrack, latencies_ms: tuple[int, ...] = LATENCIES_MS) -> Analysis:
    """Return the figures of a track without repeated poses, none across a gap or jump."""
    motion = track.without_repeats()
    steps = np.diff(track.time_ns)
    gaps = np.flatnonzero(steps > track.max_gap_ns)
    duration_s = track.duration_ns / 1e9
    angular, linear = speeds(motion)
    return Analysis(
        samples=len(track), duration_s=duration_s, rate_hz=track.rate_hz,
        mean_rate_hz=(len(track) - 1) / duration_s if duration_s else 0.0, repeated_share=1 - len(motion) / len(track),
        gaps=[{"start_s": int(track.time_ns[i]) / 1e9, "length_s": int(steps[i]) / 1e9} for i in gaps],
        jumps=len(track.jumps),
        angular_speed_deg_s=_percentiles(np.degrees(angular), SPEED_PERCENTILES),
        linear_speed_m_s=_percentiles(linear, SPEED_PERCENTILES),
        errors=[error_row(motion, latency) for latency in latencies_ms], gaze=gaze_facts(track),
    )  # fmt: skip


def speeds(track: PoseTrack) -> tuple[Array, Array]:
    """Return angular (rad/s) and linear (m/s) speeds: differences over 10 ms, every 5 ms."""
    now = _instants(track, GRID_NS, GRID_NS)
    now = now[_joined(track, now - GRID_NS, now + GRID_NS)]
    before, after = track.sample_many(now - GRID_NS), track.sample_many(now + GRID_NS)
    seconds = 2 * GRID_NS * 1e-9
    angle = quaternions.angle_between(before.orientation_xyzw, after.orientation_xyzw)
    return angle / seconds, np.linalg.norm(after.position_m - before.position_m, axis=1) / seconds


def error_row(track: PoseTrack, latency_ms: int) -> ErrorRow:
    """Return the angles between the head at t and its predictions from t - latency."""
    latency = latency_ms * _MS
    now = _instants(track, latency + KNOWN_NS, 0)
    now = now[_joined(track, now - latency - KNOWN_NS, now)]
    truth = track.sample_many(now).orientation_xyzw
    then = now - latency
    known = track.sample_many(then).orientation_xyzw
    errors = {
        predictor.name: turn_errors(known, truth, predictor.predict_many(track, then, latency).orientation_xyzw)
        for predictor in sorted((p for p in predictors if not p.alias_of), key=lambda p: p.horizon_ns)
    }
    return ErrorRow(latency_ms, errors, len(now))


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


def _percentiles(values: Array, wanted: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(np.percentile(values, wanted).tolist()) if len(values) else (math.nan,) * len(wanted)


def trace_as_json(loaded: LoadedTrace, figures: Analysis) -> dict[str, Any]:
    """Return what `trace info --json` prints; percentiles are keys such as p95."""
    rows: list[dict[str, Any]] = []
    for row in figures.errors:
        rows.append({"latency_ms": row.latency_ms})
        for name, one in row.errors.items():
            found = {"mean": one.mean, **_by_name(one.percentiles, ERROR_PERCENTILES), "lead_share": one.lead_share}
            rows[-1][name] = found | {"lead_p95": one.lead, "lag_p95": one.lag}
    rates = ("samples", "repeated_share", "duration_s", "rate_hz", "mean_rate_hz")
    return {
        **{"trace": str(loaded.path), "format": loaded.format, "origin": loaded.track.origin},
        **{"axes": loaded.axes, "columns": loaded.columns},
        **{name: getattr(figures, name) for name in rates},
        **{"clock": loaded.time_unit, "clock_starts_s": loaded.track.epoch_ns / 1e9},
        **{"gaps": figures.gaps, "jumps": figures.jumps},
        "gaze": None if figures.gaze is None else attrs.asdict(figures.gaze),
        "angular_speed_deg_s": _by_name(figures.angular_speed_deg_s, SPEED_PERCENTILES),
        "linear_speed_m_s": _by_name(figures.linear_speed_m_s, SPEED_PERCENTILES),
        "errors_deg": rows,
        "segments": [attrs.asdict(segment) for segment in loaded.segments],
        "assumptions": assumption_rows(loaded.assumptions),
        "defects": [attrs.asdict(defect) for defect in loaded.defects],
    }


def _by_name(values: tuple[float, ...], which: tuple[float, ...]) -> dict[str, float]:
    return {f"p{percent:g}": value for percent, value in zip(which, values, strict=True)}
