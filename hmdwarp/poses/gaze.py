"""Where the eyes look: known late like the head, held or predicted; what a recording has of it."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from ..geometry import Pose
from . import quaternions
from .track import SACCADE_DEG_S, Gaze, PoseSample, PoseTrack

_WINDOW_NS = 50_000_000  # of known motion, as of the head's predictor constant_velocity
_HORIZON_NS = 100_000_000  # beyond it a pursuit has long been corrected by a leap
_UNKNOWN = (np.nan,) * 3


def foreseen_gaze(track: PoseTrack, now_ns: int, ahead_ns: int = 0, head: Pose | None = None) -> Gaze | None:
    """Return the gaze so long after an instant, as known at that instant; None where it is not.

    head: in whose axes, by default the one at that instant. Eyes rest on things: what they look at
    stays where it is in the world, however the head turns. A pursuit goes on at its speed there,
    for 100 ms at most. After a leap it is held too: nothing before a leap says where it goes.
    """
    now = _in_world(track, now_ns)
    if now is None:
        return None
    before = _in_world(track, now_ns - _WINDOW_NS) if ahead_ns > 0 else None
    if before is not None and not _leapt(track, now_ns):
        now = now + (now - before) * min(ahead_ns, _HORIZON_NS) / _WINDOW_NS
        now = now / np.linalg.norm(now)
    x, y, z = ((head or track.at(now_ns).pose).rotation_matrix.T @ now).tolist()
    return x, y, z


def _in_world(track: PoseTrack, time_ns: int) -> NDArray[np.float64] | None:
    sample = track.at(time_ns)
    return None if sample.gaze is None else sample.pose.rotation_matrix @ np.array(sample.gaze)


def _leapt(track: PoseTrack, now_ns: int) -> bool:
    """Return whether the eyes leapt in the world, or were lost, in the window before an instant."""
    assert track.gaze is not None, "it is known"
    seen = slice(max(track.index_at(now_ns - _WINDOW_NS), 0), track.index_at(now_ns) + 1)
    world = quaternions.rotate(track.orientation_xyzw[seen], track.gaze[seen])
    return not np.isfinite(world).all() or bool((_speeds(world, track.time_ns[seen]) > SACCADE_DEG_S).any())


def _speeds(gaze: NDArray[np.float64], time_ns: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return degrees a second from each direction to the next, (n - 1,); NaN where not known."""
    turned = np.arccos(np.clip(np.einsum("ij,ij->i", gaze[1:], gaze[:-1]), -1, 1))
    return np.asarray(np.degrees(turned) / (np.diff(time_ns) * 1e-9))


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
    fast = np.nan_to_num(_speeds(track.gaze, track.time_ns)) > SACCADE_DEG_S
    leaps = int(np.count_nonzero(fast & ~np.concatenate([[False], fast[:-1]])))
    middle, far = (float(np.percentile(aside, at)) for at in (50, 95))
    return GazeFacts(float(known.mean()), (middle, far), leaps / max(track.duration_ns * 1e-9, 1e-9))
