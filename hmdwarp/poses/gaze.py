"""Where the eyes look: known late like the head, held or predicted; what a recording has of it."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from .track import SACCADE_DEG_S, Gaze, PoseSample, PoseTrack

_WINDOW_NS = 50_000_000  # of known motion, as of the head's predictor constant_velocity
_HORIZON_NS = 100_000_000  # beyond it a pursuit has long been corrected by a leap
_UNKNOWN = (np.nan,) * 3


def foreseen_gaze(track: PoseTrack, now_ns: int, ahead_ns: int = 0) -> Gaze | None:
    """Return the gaze so long after an instant, as known at that instant; None where it is not.

    A pursuit goes on at its speed, for 100 ms at most. What leaps or rests is held: nothing before
    a leap says where it goes.
    """
    now = track.gaze_at(now_ns)
    before = track.gaze_at(now_ns - _WINDOW_NS)
    if now is None or before is None or ahead_ns <= 0:
        return now
    a, b = np.array(before), np.array(now)
    if np.degrees(np.arccos(min(1.0, float(a @ b)))) > SACCADE_DEG_S * _WINDOW_NS * 1e-9 or _leapt(track, now_ns):
        return now
    ahead = b + (b - a) * min(ahead_ns, _HORIZON_NS) / _WINDOW_NS
    x, y, z = (ahead / np.linalg.norm(ahead)).tolist()
    return x, y, z


def _leapt(track: PoseTrack, now_ns: int) -> bool:
    """Return whether the eyes leapt or were lost within the window before an instant."""
    assert track.gaze is not None, "it is known"
    first, last = track.index_at(now_ns - _WINDOW_NS), track.index_at(now_ns)
    seen = slice(max(first, 0), last + 1)
    return not np.isfinite(track.gaze[seen]).all() or bool((_speeds(track)[seen][:-1] > SACCADE_DEG_S).any())


def _speeds(track: PoseTrack) -> NDArray[np.float64]:
    """Return degrees a second from each sample to the next, (n - 1,); NaN where not known."""
    assert track.gaze is not None, "it is known"
    turned = np.arccos(np.clip(np.einsum("ij,ij->i", track.gaze[1:], track.gaze[:-1]), -1, 1))
    return np.asarray(np.degrees(turned) / (np.diff(track.time_ns) * 1e-9))


def gaze_of(samples: Sequence[PoseSample]) -> NDArray[np.float64] | None:
    """Return the gaze of poses, (n, 3), NaN where it is not known; None where it never is."""
    if all(sample.gaze is None for sample in samples):
        return None
    return np.array([_UNKNOWN if sample.gaze is None else sample.gaze for sample in samples])


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
    fast = np.nan_to_num(_speeds(track)) > SACCADE_DEG_S
    leaps = int(np.count_nonzero(fast & ~np.concatenate([[False], fast[:-1]])))
    middle, far = (float(np.percentile(aside, at)) for at in (50, 95))
    return GazeFacts(float(known.mean()), (middle, far), leaps / max(track.duration_ns * 1e-9, 1e-9))
