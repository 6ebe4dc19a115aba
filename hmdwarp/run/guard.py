"""The guard band that a run needs.

For `--guard auto`: from the head's motion in its trace while a frame is in transit.
"""

from __future__ import annotations

import math

import attrs
import numpy as np
from numpy.typing import NDArray

from ..geometry import Fov, Pose
from ..headsets import Headset
from ..options import AUTO
from ..pipeline.link_times import expected_age_ns
from ..poses import PoseSample, PoseTrack, load_trace
from ..poses.prediction import predict
from ..poses.quaternions import conjugate, rotate
from .options import RunOptions
from .schedule import Schedule, schedule_of

QUANTILE = 0.95
# A guard of 2 has four times the pixels; a second wide view (`--wide`) costs half a picture and
# reaches farther.
MOST = 2.0
NEAR_M = 1.0  # nearest surface considered; nearer ones enter the view from farther in
MOST_INSTANTS = 2000
_STEP = 100  # factors are rounded up to a hundredth

Array = NDArray[np.float64]


@attrs.frozen
class Guard:
    """The chosen guard band.

    factor: to draw with. wanted: the quantile over the refreshes; infinite where the head turns a
    side behind the eye.
    """

    factor: float
    wanted: float

    def __str__(self) -> str:
        flat = math.isfinite(self.wanted)
        needed = (
            f"a picture {self.wanted:.2f} times as large in tangents" if flat else "more than any flat picture holds"
        )
        told = f"Guard auto: to lose nothing at {QUANTILE:.0%} of the refreshes takes {needed}"
        if self.wanted <= MOST:
            return f"{told}; {self.factor:g} is drawn."
        return f"{told}; {MOST:g} is drawn, auto's most. A second wide view (--wide) reaches farther and costs less."


def settled(options: RunOptions, headset: Headset) -> tuple[RunOptions, tuple[str, ...]]:
    """Return the options with a number in place of guard `auto`, and notes on it.

    Errors: as load_trace and schedule_of.
    """
    if options.guard != AUTO:
        return options, ()
    track = load_trace(options.trace, options.trace_options).track
    schedule = schedule_of(track, options, options.rate_hz or headset.refresh_hz)
    found = guard_for(headset, track, schedule, options)
    return attrs.evolve(options, guard=found.factor), (str(found),)


def guard_for(headset: Headset, track: PoseTrack, schedule: Schedule, options: RunOptions) -> Guard:
    """Return the factor that holds the middles of the pictures' sides in 95 of 100 refreshes.

    All four sides of both eyes count, for scenery from 1 m to infinity. The server draws for its
    predicted or current pose, as in the run; the display shows the pose of the trace. The latency
    is that of the run, for a link with jitter the typical one.
    """
    age_ns = expected_age_ns(options, schedule.age_ns, schedule.rate_hz)
    stride = -(-schedule.count // MOST_INSTANTS)
    shown_ns = np.array(
        [schedule.first_ns + round(k * 1e9 / schedule.rate_hz) for k in range(0, schedule.count, stride)],
        dtype=np.int64,
    )
    shown = track.sample_many(shown_ns)
    drawn = [_drawn_for(track, t - age_ns, age_ns, options) for t in shown_ns.tolist()]
    needed = needed_factors(
        headset,
        (np.array([pose.pose.position_m for pose in drawn]), np.array([pose.pose.orientation_xyzw for pose in drawn])),
        (shown.position_m, shown.orientation_xyzw),
    )
    wanted = float(np.quantile(needed, QUANTILE, method="higher"))
    factor = min(MOST, math.ceil(max(wanted, 1) * _STEP - 1e-6) / _STEP) if math.isfinite(wanted) else MOST
    return Guard(factor, wanted)


def _drawn_for(track: PoseTrack, now_ns: int, age_ns: int, options: RunOptions) -> PoseSample:
    if options.predict == "none":
        return track.at(now_ns)
    return predict(track, now_ns, now_ns + age_ns, options.predict, options.horizon_ns)


def needed_factors(headset: Headset, drawn: tuple[Array, Array], shown: tuple[Array, Array]) -> Array:
    """Return how much larger, in tangents, each picture must be drawn: (n,) factors.

    1 for a head that has not moved, infinite where the middle of a side lies beside or behind the
    rendered eye. drawn, shown: head positions (n, 3) in metres and orientations (n, 4).
    """
    needed = np.ones(len(drawn[0]))
    for eye, view in enumerate(headset.views(Pose())):
        fov, head_from_eye = headset.fov(eye), view.pose.position_m
        for inverse_depth in (0.0, 1 / NEAR_M):
            needed = np.maximum(needed, _needed(fov, head_from_eye, inverse_depth, drawn, shown))
    return needed


def _needed(
    fov: Fov, head_from_eye: Array, inverse_depth: float, drawn: tuple[Array, Array], shown: tuple[Array, Array]
) -> Array:
    left, right, down, up = fov.tangents
    middles = np.array([(left, 0, -1), (right, 0, -1), (0, down, -1), (0, up, -1)])
    eyes = [
        position + rotate(turned, np.broadcast_to(head_from_eye, position.shape)) for position, turned in (drawn, shown)
    ]
    moved = (eyes[1] - eyes[0]) * inverse_depth
    most = np.ones(len(moved))
    for middle in middles:
        towards = rotate(shown[1], np.broadcast_to(middle, moved.shape)) + moved
        x, y, z = rotate(conjugate(drawn[1]), towards).T
        with np.errstate(divide="ignore", invalid="ignore"):
            sides = np.stack([x / -z / left, x / -z / right, y / -z / down, y / -z / up])
        most = np.maximum(most, np.where(z < 0, sides.max(axis=0), np.inf))
    return most
