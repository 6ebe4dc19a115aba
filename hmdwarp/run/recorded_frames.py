"""A replay of recorded frames: the display, the head and the refreshes that belong to them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from collections.abc import Sequence as Sequence_
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from ..errors import InputError
from ..geometry import Fov, GuardBand, Pose
from ..pipeline.build import refreshes_of
from ..pipeline.recorded_scene import RecordedScene, display_of
from ..poses import LoadedTrace, PoseTrack
from ..poses.quaternions import multiply, rotate
from ..scenes import Scene
from .options import RunOptions
from .schedule import Schedule

if TYPE_CHECKING:
    from ..pipeline.options import PipelineOptions
    from ..pipeline.recorded_server import RecordedServer
    from ..sources.sequences import Sequence
    from .log import ReplayLog

ONE_EYE = "recorded frames have one eye", "multi:eye=own looks into older frames alone"
_NOTHING = 1e-5  # what rounding leaves of two equal poses, in ms, degrees and metres
_WIDEST_RIM = 0.1  # of the picture's smaller side
_ANOTHER = 1.0  # pixel that the truth may be off before a reader is told


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


def recorded_notes(options: PipelineOptions, scene: Scene) -> list[str]:
    """Return what to say of recorded frames before anything else, nothing for a scene."""
    if not isinstance(scene, RecordedScene):
        return []
    return [about(scene.sequence, options), *_about_rim(scene.sequence)]


def _about_rim(sequence: Sequence) -> list[str]:
    """Return what to say of a rim without a picture, nothing where there is none."""
    ends = sequence.frames[0], sequence.frames[-1]
    rims = [frame.rim() for frame in ends]
    # A rim is where it is in all frames; what is wider is more likely a background.
    if not min(rims) or max(rims) - min(rims) > 1 or max(rims) > _WIDEST_RIM * min(ends[0].size):
        return []
    # The line beside it is blended with it.
    return [
        f"The outermost pixels of {ends[0].name} and {ends[1].name} hold one colour, up to {max(rims)} on a side. If "
        f"that is no picture, leave it out by --crop {max(rims) + 1}: it is warped and judged as if it were."
    ]


def recorded_entry(options: PipelineOptions, scene: Scene) -> dict[str, Any] | None:
    """Return the `recorded` of summary.json; None for a scene."""
    if not isinstance(scene, RecordedScene):
        return None
    sequence = scene.sequence
    return {
        "folder": str(sequence.path),
        "layout": sequence.layout,
        "frames": len(sequence.frames),
        "size": list(sequence.frames[0].size),
        "fov_deg": [round(angle, 2) for angle in _degrees(sequence.frames[0].fov)],
        "eye_distance_mm": options.eye_distance_mm,
    }


def _degrees(fov: Fov) -> tuple[float, float]:
    left, right, down, up = np.degrees(np.arctan(fov.tangents)).tolist()
    return right - left, up - down


def about(sequence: Sequence, options: PipelineOptions) -> str:
    """Return what takes the place of a renderer, how much of it is shown, and to which eyes."""
    (wide, high), (across, down) = sequence.frames[0].size, _degrees(sequence.frames[0].fov)
    told = [
        f"{len(sequence.frames)} recorded frames of {sequence.path} ({sequence.layout}) take the place of a renderer: "
        f"{wide}x{high} pixels, {across:.1f} x {down:.1f} degrees.",
        "A late frame was taken where the camera was.",
    ]
    guard = options.guard_factors
    told.append(
        "All of it is shown: there is no guard band."
        if guard == GuardBand()
        else f"The middle of it is shown, {_shown(sequence, options)}; the rest is a guard band of {guard.text}."
    )
    if options.eye_distance_mm:
        told.append(
            f"The left eye is the camera, and the right eye is shown the same frames, {options.eye_distance_mm:g} mm "
            "beside it."
        )
    else:
        told.append("One eye is shown, the camera's.")
    return " ".join(told)


def second_eye(rows: Sequence_[Mapping[str, Any]], holes: Mapping[int, float]) -> dict[str, float]:
    """Return the mean share of holes of the camera's eye and of the one beside it.

    rows: as of frames.csv. holes: of the other eye, by refresh.
    """
    of_camera = [row["hole_share"] for row in rows if row["eye"] == 0 and row["frame"] in holes]
    return {
        "camera_hole_share": math.fsum(of_camera) / len(of_camera),
        "hole_share": math.fsum(holes.values()) / len(holes),
    }


def about_second_eye(found: Mapping[str, float]) -> str:
    """Return how much more the eye beside the camera lacks."""
    return (
        "Nothing was recorded where the right eye is: it has times and holes, and all other figures are the camera's "
        f"eye's. The warp leaves {found['hole_share']:.2%} of the right eye's pixels empty, "
        f"{found['camera_hole_share']:.2%} of the left eye's."
    )


def _shown(sequence: Sequence, options: PipelineOptions) -> str:
    across, down = _degrees(display_of(sequence, options.guard_factors).left_fov)
    return f"{across:.1f} x {down:.1f} degrees"


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
