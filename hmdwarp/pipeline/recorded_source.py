"""Recorded frames as a source: their display, their head, and notes on them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from collections.abc import Sequence as Several
from functools import cached_property
from typing import Any, Self

import attrs
import numpy as np

from ..errors import InputError
from ..geometry import Fov, GuardBand, Pose
from ..gpu.context import Gpu
from ..headsets import CameraDisplay, camera_display
from ..poses import LoadedTrace, PoseTrack
from ..poses.assumptions import unstated
from ..poses.quaternions import multiply, rotate
from ..poses.track import Moment
from ..sources import sequences
from ..sources.repairs import parse_repairs
from ..sources.sequences import Sequence
from .options import RECORDING, PipelineOptions
from .recorded_renderer import MomentOf, RecordedRenderer
from .source import Options, Source, nothing

Size = tuple[int, int]
_SAME_PLACE_M = 1e-4  # of a right eye: at 0.5 m less than 0.02 degrees, below a pixel
_SAME_FOV = 1e-6  # rad, far below a pixel
LEAST_SHOWN = 16  # pixels on each side that a guard band must leave
_WIDEST_RIM = 0.1  # of the picture's smaller side


class RecordingSource(Source):
    """Recorded frames in the place of a scene; the display is the camera.

    guard: of the shown part. eye_distance_mm: how far a right eye sits beside the camera; 0 for
    none.
    """

    kind = RECORDING

    def __init__(self, sequence: Sequence, guard: GuardBand | None = None, eye_distance_mm: float = 0.0) -> None:
        self.sequence, self._guard, self._eye_distance_mm = sequence, guard or GuardBand(), eye_distance_mm
        first = sequence.frames[0].pose
        summary = f"recorded frames ({sequence.layout})"
        self.scene = nothing(sequence.name, summary, viewpoint=first, notes=sequence.notes)
        self.instants_ns = tuple(frame.time_ns for frame in sequence.frames)
        self.assumptions = sequence.assumptions
        self.entry = {
            "folder": str(sequence.path),
            "layout": sequence.layout,
            "frames": len(sequence.frames),
            "size": list(sequence.frames[0].size),
            "fov_deg": [round(angle, 2) for angle in _degrees(sequence.frames[0].fov)],
            "eye_distance_mm": eye_distance_mm,
            "noise_floor_db": sequence.noise_floor_db,
        }

    @classmethod
    def opened(cls, options: PipelineOptions) -> Self:
        """Return the recorded frames that the options name. Errors: as sequences.open."""
        assert options.frames is not None
        sequence = sequences.open(options.frames, options.sequence_options).repaired(parse_repairs(options.repair))
        return cls(sequence, options.guard_factors, options.eye_distance_mm)

    @cached_property
    def headset(self) -> CameraDisplay:
        """The camera's display. Errors: as display_of; InputError for a right eye elsewhere."""
        beside_m = self.sequence.right_m
        if self._eye_distance_mm and beside_m and abs(self._eye_distance_mm * 1e-3 - beside_m) > _SAME_PLACE_M:
            raise InputError(
                f"--eye-distance {self._eye_distance_mm:g}: {self.sequence.path} has a right eye "
                f"{beside_m * 1e3:.4g} mm beside; expected that, or 0 for one eye"
            )
        return display_of(self.sequence, self._guard, self._eye_distance_mm * 1e-3)

    @property
    def title(self) -> str:
        """Its kind and name, for messages."""
        return f"recorded frames '{self.scene.name}'"

    @property
    def notes(self) -> list[str]:
        """What takes the place of a renderer, what is assumed of it, what its frames suggest."""
        return [self.about, *unstated(self.assumptions), *self._suggested]

    @cached_property
    def _suggested(self) -> list[str]:
        return [*_about_rim(self.sequence), *sequences.depth_notes(self.sequence)]

    @property
    def about(self) -> str:
        """What takes the place of a renderer, how much of it is shown, and to which eyes."""
        sequence, guard = self.sequence, self._guard
        (wide, high), (across, down) = sequence.frames[0].size, _degrees(sequence.frames[0].fov)
        shown = "{:.1f} x {:.1f} degrees".format(*_degrees(display_of(sequence, guard).eyes[0].fov))
        sentences = [
            f"{len(sequence.frames)} recorded frames of {sequence.path} ({sequence.layout}) take the place of a "
            f"renderer: {wide}x{high} pixels, {across:.1f} x {down:.1f} degrees.",
            "A late frame was taken where the camera was.",
            "All of it is shown: there is no guard band."
            if guard == GuardBand()
            else f"The middle of it is shown, {shown}; the rest is a guard band of {guard.text}.",
            f"The left eye is the camera, and the right eye is shown the same frames, {self._eye_distance_mm:g} mm "
            "beside it."
            if self._eye_distance_mm
            else "One eye is shown, the camera's.",
        ]
        if sequence.noise_floor_db is not None:
            sentences.append(f"Its noise floor is {sequence.noise_floor_db:g} dB, by camera.json.")
        return " ".join(sentences)

    def fitted(self, options: Options) -> Options:
        """Return the options with the sizes of the frames.

        The shown picture has as many pixels as that part of the recording, or those of --size; late
        frames have those of all that was recorded, at the same scale.
        """
        (wide, high), shown = self.sequence.frames[0].size, self.headset.eye_size_px
        size = options.size or shown
        rendered = (round(wide * size[0] / shown[0]), round(high * size[1] / shown[1]))
        return attrs.evolve(options, size=size, rendered_size=None if rendered == size else rendered)

    def head(self, trace: LoadedTrace | None) -> LoadedTrace:
        """Return the recording's own motion, or a head that begins where the camera does."""
        sequence = self.sequence
        if trace is not None:
            return _beside(trace, sequence)
        return LoadedTrace(sequence.track, sequence.path, sequence.layout, [], [], "", "", axes_assumed=False)

    def renderer(self, gpu: Gpu, options: PipelineOptions, moment_of: MomentOf = Moment) -> RecordedRenderer:
        """Return what gives the frames; mirrors and edges are as they were recorded."""
        return RecordedRenderer(gpu, self.scene, self.sequence, moment_of)


def display_of(sequence: Sequence, guard: GuardBand | None = None, eye_distance_m: float = 0.0) -> CameraDisplay:
    """Return a display that shows what the camera sees.

    guard: shows the middle of it alone, so that the rest is a guard band. eye_distance_m: how far a
    right eye sits beside the camera; 0 for none.
    Errors: InputError for frames of several fields of view, and for a guard that leaves next to
    nothing.
    """
    first = sequence.frames[0]
    for frame in sequence.frames:
        if np.abs(np.subtract(frame.fov.tangents, first.fov.tangents)).max() > _SAME_FOV:
            raise InputError(
                f"{sequence.path}: {first.name} and {frame.name} have different fields of view: expected one for all, "
                "as the display has; replay those of each camera by themselves"
            )
    fov, size = _middle_of(first.fov, first.size, guard or GuardBand())
    hidden = first.hidden.polygons if first.hidden is not None else ()
    return camera_display(str(sequence.path), fov, size, sequence.rate_hz or 1.0, eye_distance_m, hidden)


def _middle_of(fov: Fov, size: Size, guard: GuardBand) -> tuple[Fov, Size]:
    """Return the part of a field of view that a guard band leaves, in whole pixels."""
    tangents, kept, sides = fov.tangents, [], []
    for axis, factor in enumerate((guard.x, guard.y)):
        low, high = tangents[2 * axis : 2 * axis + 2]
        left = round(size[axis] / factor)
        if left < min(LEAST_SHOWN, size[axis]):
            raise InputError(
                f"{guard} leaves {left} of the {size[axis]} recorded pixels on one axis: expected at least "
                f"{LEAST_SHOWN}; use a smaller guard"
            )
        # As much to either side of the camera's axis as the guard band says.
        before = round((size[axis] - left) * abs(low) / (abs(low) + abs(high)))
        per_pixel = (high - low) / size[axis]
        kept.append(left)
        sides += [low + before * per_pixel, low + (before + left) * per_pixel]
    return (fov, size) if tuple(kept) == size else (Fov.from_tangents(sides), (kept[0], kept[1]))


def _beside(trace: LoadedTrace, sequence: Sequence) -> LoadedTrace:
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
        gaze=None if track.gaze is None else track.gaze[kept],
    )
    return attrs.evolve(trace, track=moved)


def _about_rim(sequence: Sequence) -> list[str]:
    """Return what to say of a rim without a picture, nothing where there is none."""
    ends = sequence.frames[0], sequence.frames[-1]
    rims = [frame.rim() for frame in ends]
    # A rim is where it is in all frames; what is wider is more likely a background.
    if not min(rims) or max(rims) - min(rims) > 1 or max(rims) > _WIDEST_RIM * min(ends[0].size):
        return []
    # The adjacent line is blended with it.
    return [
        f"The outermost pixels of {ends[0].name} and {ends[1].name} hold one colour, up to {max(rims)} on a side. If "
        f"that is no picture, leave it out by --crop {max(rims) + 1}: it is warped and judged as if it were."
    ]


def _degrees(fov: Fov) -> tuple[float, float]:
    left, right, down, up = np.degrees(np.arctan(fov.tangents)).tolist()
    return right - left, up - down


def second_eye(rows: Several[Mapping[str, Any]], found: Mapping[str, Mapping[int, float]]) -> dict[str, float]:
    """Return the mean share of holes of the camera's eye and of the other one.

    And their PSNR, where what the other eye saw was recorded. rows: as of frames.csv. found: of the
    other eye, by column and refresh.
    """
    entry = {}
    for name, values in ((name, values) for name, values in found.items() if values):
        of_camera = [row[name] for row in rows if row["eye"] == 0 and row["frame"] in values]
        entry[f"camera_{name}"] = math.fsum(of_camera) / len(of_camera)
        entry[name] = math.fsum(values.values()) / len(values)
    return entry


def about_second_eye(found: Mapping[str, float]) -> str:
    """Return how much more the other eye lacks."""
    told = "Nothing was recorded where the right eye is: it has times and holes, and"
    if "psnr_db" in found:
        told = (
            f"The right eye has {found['psnr_db']:.2f} dB and the left one {found['camera_psnr_db']:.2f} dB, from the "
            "left eye's frames alone;"
        )
    return (
        f"{told} all other figures are the camera's eye's. The warp leaves {found['hole_share']:.2%} of the right "
        f"eye's pixels empty, {found['camera_hole_share']:.2%} of the left eye's."
    )
