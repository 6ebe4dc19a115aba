"""A replay of recorded frames: the display, the head and the refreshes that belong to them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from ..errors import InputError
from ..geometry import Pose
from ..headsets import Headset
from ..pipeline.build import refreshes_of
from ..poses import LoadedTrace, PoseTrack
from ..poses.quaternions import multiply, rotate
from .options import RunOptions
from .schedule import Schedule

if TYPE_CHECKING:
    from ..pipeline.recorded_server import RecordedServer
    from ..sequences import Sequence
    from .log import ReplayLog

CAMERA = "camera"
ONE_EYE = "recorded frames have one eye", "multi:eye=own looks into older frames alone"
_SAME_FOV = 1e-6  # rad, far below a pixel
_NOTHING = 1e-5  # what rounding leaves of two equal poses, in ms, degrees and metres
_ANOTHER = 1.0  # pixel that the truth may be off before a reader is told


def display_of(sequence: Sequence) -> Headset:
    """Return a display of one eye, that shows what the camera sees.

    Errors: InputError for frames of several fields of view.
    """
    first = sequence.frames[0]
    for frame in sequence.frames:
        if np.abs(np.subtract(frame.fov.tangents, first.fov.tangents)).max() > _SAME_FOV:
            raise InputError(
                f"{sequence.path}: {first.name} and {frame.name} have different fields of view: expected one for all, "
                "as the display has; replay those of each camera by themselves"
            )
    return Headset(
        CAMERA,
        f"the camera of {sequence.name}",
        str(sequence.path),
        first.size,
        (0.1, 0.1 * first.size[1] / first.size[0]),
        sequence.rate_hz or 1.0,
        0.0,
        first.fov,
        None,
        one_eye=True,
    )


def own_trace(sequence: Sequence) -> LoadedTrace:
    """Return the recording's own motion as a trace."""
    return LoadedTrace(sequence.track, sequence.path, sequence.layout, [], [], "", "", axes_assumed=False)


def beside(trace: LoadedTrace, sequence: Sequence) -> LoadedTrace:
    """Return a head that begins where the camera does, cut off when the recording ends."""
    track, start = trace.track, sequence.frames[0].pose
    turn, first = start @ Pose((0, 0, 0), track.orientation_xyzw[0]).inverse(), track.position_m[0]
    kept = track.time_ns - track.start_ns <= sequence.frames[-1].time_ns
    turned = np.array(turn.orientation_xyzw)
    moved = PoseTrack(
        track.time_ns[kept] - track.start_ns,
        start.position_m + rotate(turned, track.position_m[kept] - first),
        multiply(turned, track.orientation_xyzw[kept]),
        name=track.name,
        origin=track.origin,
        axes=track.axes,
        epoch_ns=track.epoch_ns + track.start_ns,
        max_gap_ns=track.max_gap_ns,
    )
    return attrs.evolve(trace, track=moved)


def schedule_at_frames(sequence: Sequence, options: RunOptions) -> Schedule:
    """Return refreshes at the instants of the frames, where the truth is what was recorded.

    The first is at the requested start, or when the first frame can have arrived. Errors:
    InputError if none is left.
    """
    times, rate_hz = [frame.time_ns for frame in sequence.frames], sequence.rate_hz
    if len(times) < 2:
        raise InputError(f"{sequence.path}: one frame; expected two or more: one that is late, and what is seen then")
    longest_ns = options.client_link.longest_ns(round(options.latency_ms * 1e6))
    age = refreshes_of(longest_ns / 1e6, rate_hz)
    first = next((i for i, at in enumerate(times) if i >= age and at >= options.start_s * 1e9), len(times))
    if first == len(times):
        raise InputError(
            f"{sequence.path}: its {len(times)} frames last {times[-1] * 1e-9:.3f} s: with --latency "
            f"{options.latency_ms:g} ms and --start {options.start_s:g} s none is left to show; use a shorter latency, "
            "an earlier start, or say how fast they were taken by --frames-rate"
        )
    seconds = math.inf if options.seconds is None else options.seconds
    end = next((i for i, at in enumerate(times) if at >= times[first] + seconds * 1e9), len(times))
    return Schedule(
        times[first], rate_hz, max(1, end - first), age, instants_ns=tuple(times[first - age : max(end, first + 1)])
    )


def truth_offsets(server: RecordedServer, log: ReplayLog) -> dict[str, Any]:
    """Return how far the truth is from what was shown: time_ms, turn_deg, move_m; median and most.

    The truth is the recorded frame nearest to the shown instant.
    """
    rows = [(moment.shown_ns, moment.shown.pose, server.nearest_to(moment.shown_ns)) for moment in log.moments]
    columns = {
        "time_ms": [(frame.time_ns - shown_ns) * 1e-6 for shown_ns, _, frame in rows],
        "turn_deg": [math.degrees(_turn(frame.pose, pose)) for _, pose, frame in rows],
        "move_m": [float(np.linalg.norm(frame.pose.position_m - pose.position_m)) for _, pose, frame in rows],
    }
    return {name: _median_and_most(np.abs(values)) for name, values in columns.items()}


def _turn(one: Pose, other: Pose) -> float:
    x, y, z, w = one.relative_to(other).unit_quaternion
    return 2 * math.atan2(math.sqrt(x * x + y * y + z * z), abs(w))


def _median_and_most(values: Iterable[float]) -> dict[str, float]:
    found = np.asarray(values)
    return {"median": round(float(np.median(found)), 6), "most": round(float(found.max()), 6)}


def about(sequence: Sequence) -> list[str]:
    """Return what a reader of the results must know, one sentence each."""
    path, count = sequence.path, len(sequence.frames)
    return [
        f"{count} recorded frames of {path} ({sequence.layout}) take the place of a renderer. One eye is shown, the "
        "camera's; a late frame is as wide as the camera's picture, and taken where the camera was.",
        *sequence.notes,
    ]


def about_truth(offsets: dict[str, Any], pixels_per_degree: float, *, is_own: bool) -> str:
    """Return what the truth is, in a sentence or two."""
    said = ", ".join(
        f"{offsets[name]['median']:.{digits}f} {unit} (at most {offsets[name]['most']:.{digits}f})"
        for name, unit, digits in (("time_ms", "ms", 1), ("turn_deg", "degrees", 2), ("move_m", "m", 3))
    )
    if not any(offset["most"] > _NOTHING for offset in offsets.values()):
        return "The truth is the recorded frame of the shown instant itself."
    told = f"The truth is the recorded frame nearest to the shown instant, off by {said} in the median."
    if offsets["turn_deg"]["median"] * pixels_per_degree <= _ANOTHER and is_own:
        return told
    return f"{told} That is another view than the one shown: the figures count this difference as error."
