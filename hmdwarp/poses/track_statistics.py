"""Statistics of a head track: rate, gaps, speeds, and motion within 20 to 800 ms."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from . import quaternions
from .prediction import HORIZON_NS, WINDOW_NS, predict_many
from .sample import Origin
from .track import PoseTrack

_MS = 1_000_000
GRID_NS = 5 * _MS  # 200 Hz
MOST_INSTANTS = 200_000  # 1000 s at 200 Hz: longer tracks are sampled at evenly spaced instants
LATENCIES_MS = (20, 50, 100, 200, 400, 600, 800)
SPEED_PERCENTILES = (50, 95, 99, 99.9)
ERROR_PERCENTILES = (50, 95, 99)


@attrs.frozen
class Gap:
    """A stretch without samples, from `start_ns`, lasting `length_ns`."""

    start_ns: int
    length_ns: int


@attrs.frozen
class ErrorRow:
    """Angles in degrees between the head and its estimate from `latency_ms` before.

    Percentiles are ERROR_PERCENTILES. All values are NaN where the track is too short for the
    latency.
    """

    latency_ms: int
    held: tuple[float, ...]  # without prediction
    cav: tuple[float, ...]  # constant angular velocity
    capped: tuple[float, ...]  # constant angular velocity for at most 100 ms
    mean: tuple[float, float, float]  # of held, cav and capped, in that order
    count: int  # instants


@attrs.frozen
class Analysis:
    """Everything `hmdwarp trace info` prints about motion."""

    samples: int
    duration_s: float
    rate_hz: float
    mean_rate_hz: float
    repeated_share: float
    gaps: list[Gap]
    jumps: int
    angular_speed_deg_s: tuple[float, ...]  # at SPEED_PERCENTILES
    linear_speed_m_s: tuple[float, ...]  # at SPEED_PERCENTILES
    errors: list[ErrorRow]  # one row per latency


def analyse(track: PoseTrack, latencies_ms: tuple[int, ...] = LATENCIES_MS) -> Analysis:
    """Return the figures of a track.

    Repeated poses are removed first; nothing is measured across a gap or jump.
    """
    motion = track.without_repeats()
    steps = np.diff(track.time_ns)
    gaps = np.flatnonzero(steps > track.max_gap_ns)
    duration_s = track.duration_ns / 1e9
    angular, linear = speeds(motion)
    return Analysis(
        samples=len(track),
        duration_s=duration_s,
        rate_hz=track.rate_hz,
        mean_rate_hz=(len(track) - 1) / duration_s if duration_s else 0.0,
        repeated_share=1 - len(motion) / len(track),
        gaps=[Gap(int(track.time_ns[i]), int(steps[i])) for i in gaps],
        jumps=len(track.jumps),
        angular_speed_deg_s=_percentiles(np.degrees(angular), SPEED_PERCENTILES),
        linear_speed_m_s=_percentiles(linear, SPEED_PERCENTILES),
        errors=[error_row(motion, latency) for latency in latencies_ms],
    )


def speeds(track: PoseTrack) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return angular (rad/s) and linear (m/s) speeds.

    Central differences over 10 ms on a 200 Hz grid.
    """
    now = _instants(track, GRID_NS, GRID_NS)
    now = now[_joined(track, now - GRID_NS, now + GRID_NS)]
    before, after = track.sample_many(now - GRID_NS), track.sample_many(now + GRID_NS)
    seconds = 2 * GRID_NS * 1e-9
    angle = quaternions.angle_between(before.orientation_xyzw, after.orientation_xyzw)
    return angle / seconds, np.linalg.norm(after.position_m - before.position_m, axis=1) / seconds


def error_row(track: PoseTrack, latency_ms: int) -> ErrorRow:
    """Return the angles between the head at t and its estimates from t - latency."""
    latency = latency_ms * _MS
    now = _instants(track, latency + WINDOW_NS, 0)
    now = now[_joined(track, now - latency - WINDOW_NS, now)]
    truth = track.sample_many(now).orientation_xyzw
    then = now - latency
    guesses = (
        track.sample_many(then).orientation_xyzw,
        predict_many(track, then, latency),
        predict_many(track, then, min(latency, HORIZON_NS)),
    )
    errors = [np.degrees(quaternions.angle_between(guess, truth)) for guess in guesses]
    held, cav, capped = (_percentiles(e, ERROR_PERCENTILES) for e in errors)
    means = [float(e.mean()) if len(e) else float("nan") for e in errors]
    return ErrorRow(latency_ms, held, cav, capped, (means[0], means[1], means[2]), len(now))


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
    breaks = np.concatenate([[0], np.cumsum(track.broken)])

    def last_sample(t: NDArray[np.int64]) -> NDArray[np.int64]:
        return np.clip(np.searchsorted(track.time_ns, t, side="right") - 1, 0, len(track) - 1)

    whole = breaks[last_sample(start_ns)] == breaks[last_sample(end_ns)]
    return whole & (track.sample_many(end_ns).origin != Origin.HELD)


def _percentiles(values: NDArray[np.float64], wanted: tuple[float, ...]) -> tuple[float, ...]:
    if not len(values):
        return tuple(float("nan") for _ in wanted)
    return tuple(float(v) for v in np.percentile(values, wanted))
