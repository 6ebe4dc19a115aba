"""Recorded frames in the place of a scene: their display and head, and what gives them."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence as Several
from functools import cached_property, lru_cache
from typing import Any

import attrs
import numpy as np

from ..base import InputError
from ..frames import EyeImage, Frame
from ..geometry import Fov, Guard, GuardBand, Pose, View, guarded_eyes, inverse_depth_from_metres
from ..gpu import Gpu
from ..headsets import Headset, camera_display
from ..poses import LoadedTrace, Origin, PoseSample
from ..poses.assumptions import unstated
from ..poses.quaternions import multiply, rotate
from ..poses.track import Moment
from ..scenes import Scene
from ..sources import sequences
from ..sources.array_passes import SRGB8, Arrays, Scaling
from ..sources.repairs import RepairChain
from ..sources.sequences import RecordedFrame, Sequence
from ..sources.server import Renderer, Target
from .options import RECORDING, PipelineOptions
from .source import MomentOf, Options, Source, nothing

Size = tuple[int, int]
# Decoded frames that are kept: those under way, and the truth next to them; fewer of large ones.
_KEPT, _LEAST_KEPT, _KEPT_BYTES = 32, 4, 500_000_000
_PIXEL_BYTES = 3 + 4
_AS_RECORDED = RepairChain()
_NOTHING = 1e-5  # what rounding leaves of two equal poses, in ms, degrees and metres
_ANOTHER = 1.0  # pixel that the truth may be off without a note
_SAME_FOV = 1e-6  # rad, far below a pixel
LEAST_SHOWN = 16  # pixels on each side that a guard band must leave
_WIDEST_RIM = 0.1  # of the picture's smaller side


class RecordedRenderer(Renderer):
    """A renderer whose pictures are recorded, with the exact pose and field of view of each.

    The requested view is ignored: a late frame is all that the camera took, for every eye
    the same picture, and the truth that part of it which the display shows. Pixels without depth
    keep their colour. The sequence's repair mends late frames, the truth stays as it was recorded.
    Another size than the recording's is made by averaging light and taking the nearest depth.

    moment_of: where the recording is at an instant; by default it is played once, from 0.
    """

    def __init__(self, gpu: Gpu, scene: Scene, sequence: Sequence, moment_of: MomentOf = Moment) -> None:
        super().__init__(gpu, scene)
        self._sequence, self._moment_of = sequence, moment_of
        self._times = [frame.time_ns for frame in sequence.frames]
        fit = _KEPT_BYTES // (math.prod(sequence.frames[0].size) * _PIXEL_BYTES)
        self._pixels = lru_cache(min(max(fit, _LEAST_KEPT), _KEPT))(_pixels)

    def taken_by(self, moment: Moment) -> RecordedFrame:
        """Return the last frame that has been seen by then, in the direction of playing."""
        if moment.is_backwards:
            at = min(bisect_left(self._times, moment.since_ns), len(self._times) - 1)
        else:
            at = max(0, bisect_right(self._times, moment.since_ns) - 1)
        return self._sequence.frames[at]

    def content(self, time_ns: int) -> object:
        """Return which frame has been taken by then."""
        return self.taken_by(self._moment_of(time_ns)).time_ns

    def nearest_to(self, time_ns: int) -> RecordedFrame:
        """Return the frame nearest to an instant, the earlier of two."""
        before = bisect_right(self._times, time_ns) - 1
        beside = [i for i in (before, before + 1) if 0 <= i < len(self._times)]
        return self._sequence.frames[min(beside, key=lambda i: (abs(self._times[i] - time_ns), i))]

    def draw(self, view: View, size: Size, into: Target | None = None, time_ns: int = 0) -> EyeImage:
        """Return the frame nearest to the instant, as far as the view reaches: its truth."""
        return self._image(self.nearest_to(self._moment_of(time_ns).since_ns), view.fov, size, into)

    def draw_frame(
        self, views: Several[View], drawn_ns: int, size: Size, guard: Guard = 1.0, *_: object, **__: object
    ) -> Frame:
        """Return the last frame that was taken by now, all of it, always with its picture."""
        moment, rendered = self._moment_of(drawn_ns), guarded_eyes(views, guard, size)[1]
        taken = self.taken_by(moment)
        taken_ns = drawn_ns - abs(moment.since_ns - taken.time_ns)
        image = self._image(taken, taken.fov, rendered, repair=self._sequence.repair)
        image = attrs.evolve(image, drawn_ns=taken_ns)
        return Frame((image,) * len(views), taken_ns, PoseSample(taken_ns, taken.pose, Origin.MEASURED))

    def truth_facts(
        self, shown: Several[tuple[int, Pose]], missing: int, pixels_per_degree: float, *, own_head: bool
    ) -> tuple[dict[str, Any], str]:
        """Return how far the truth is from what was shown, and that in a sentence or two.

        truth_offset: median and most of time_ms, turn_deg and move_m. The truth is the recorded
        frame nearest to the shown instant.
        """
        rows = []
        for shown_ns, pose in shown:
            frame = self.nearest_to(shown_ns)
            move_m = float(np.linalg.norm(frame.pose.position_m - pose.position_m))
            rows.append((abs(frame.time_ns - shown_ns) * 1e-6, math.degrees(frame.pose.angle_to(pose)), move_m))
        offsets, parts = {}, []
        units = (("time_ms", "ms", 1), ("turn_deg", "degrees", 2), ("move_m", "m", 3))
        for (name, unit, digits), column in zip(units, zip(*rows, strict=True), strict=True):
            middle, most = round(float(np.median(column)), 6), round(max(column), 6)
            offsets[name] = {"median": middle, "most": most}
            parts.append(f"{middle:.{digits}f} {unit} (at most {most:.{digits}f})")
        facts = {"eyes": 1, "truth_offset": offsets}
        if not any(offset["most"] > _NOTHING for offset in offsets.values()):
            return facts, "The truth is the recorded frame of the shown instant itself."
        text = f"The truth is the recorded frame nearest to the shown instant, off by {', '.join(parts)} in the median."
        if offsets["turn_deg"]["median"] * pixels_per_degree > _ANOTHER or not own_head:
            text += " That is another view than the one shown: the figures count this difference as error."
        return facts, text

    def _image(
        self, taken: RecordedFrame, fov: Fov, size: Size, into: Target | None = None, repair: RepairChain = _AS_RECORDED
    ) -> EyeImage:
        target = into if into is not None else self.acquire(size)
        self.take_in(self._pixels(taken, fov, size, repair), target)
        view = attrs.evolve(taken.view, fov=fov)
        return EyeImage(view, target.colour, target.inverse_depth, drawn_ns=taken.time_ns)


def _pixels(taken: RecordedFrame, fov: Fov, size: Size, repair: RepairChain) -> Arrays:
    """Return a frame in (w, h) pixels: whole ones of it as they are.

    fov: what they show, within that of the frame.
    """
    colour, depth = taken.read()
    if repair.steps:
        depth = repair.run(colour * np.float32(1 / 255), inverse_depth_from_metres(depth)).inverse_depth
    # The field of view in the pixels of the frame, where a millionth of one is rounding.
    (wide, high), (left, right, down, up) = taken.size, taken.fov.tangents.tolist()
    west, east, south, north = fov.tangents.tolist()
    columns = [(side - left) * wide / (right - left) for side in (west, east)]
    rows = [(up - side) * high / (up - down) for side in (north, south)]
    box = tuple(round(at, 6) for at in (columns[0], rows[0], columns[1], rows[1]))
    left, top, right, bottom = math.floor(box[0]), math.floor(box[1]), math.ceil(box[2]), math.ceil(box[3])
    scaling = None
    if box != (left, top, right, bottom) or size != (right - left, bottom - top) or taken.hidden is not None:
        seen_rows = None if taken.hidden is None else taken.hidden.rows(fov, size)
        scaling = Scaling(size, (box[0] - left, box[1] - top, box[2] - left, box[3] - top), seen_rows)
    part = np.s_[top:bottom, left:right]
    return Arrays(colour[part], SRGB8, depth[part], is_inverse=bool(repair.steps), is_apart=True, scaling=scaling)


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

    @cached_property
    def headset(self) -> Headset:
        """A display that shows what the camera sees, or the middle of it that the guard leaves.

        Errors: InputError for frames of several fields of view, and for a guard that leaves next to
        nothing.
        """
        sequence, guard, first = self.sequence, self._guard, self.sequence.frames[0]
        for frame in sequence.frames:
            if np.abs(np.subtract(frame.fov.tangents, first.fov.tangents)).max() > _SAME_FOV:
                raise InputError(
                    f"{sequence.path}: {first.name} and {frame.name} have different fields of view: expected one for "
                    "all, as the display has; replay those of each camera by themselves"
                )
        kept, sides, axes = [], [], first.fov.tangents.reshape(2, 2)
        for (low, high), pixels, factor in zip(axes, first.size, (guard.x, guard.y), strict=True):
            left = round(pixels / factor)
            if left < min(LEAST_SHOWN, pixels):
                raise InputError(
                    f"{guard} leaves {left} of the {pixels} recorded pixels on one axis: expected at least "
                    f"{LEAST_SHOWN}; use a smaller guard"
                )
            # As much to either side of the camera's axis as the guard band says, in whole pixels.
            before, per_pixel = round((pixels - left) * abs(low) / (abs(low) + abs(high))), (high - low) / pixels
            kept.append(left)
            sides += [low + before * per_pixel, low + (before + left) * per_pixel]
        size, hidden = (kept[0], kept[1]), first.hidden.polygons if first.hidden is not None else ()
        fov = first.fov if size == first.size else Fov.from_tangents(sides)
        rate_hz, right_m = sequence.rate_hz or 1.0, self._eye_distance_mm * 1e-3
        return camera_display(str(sequence.path), fov, size, rate_hz, right_m, hidden)

    @cached_property
    def notes(self) -> list[str]:
        """What takes the place of a renderer, what is assumed of it, what its frames suggest."""
        ends = self.sequence.frames[0], self.sequence.frames[-1]
        rims, found = [frame.rim() for frame in ends], [self.about, *unstated(self.assumptions)]
        # A rim is where it is in all frames; what is wider is more likely a background.
        if min(rims) and max(rims) - min(rims) <= 1 and max(rims) <= _WIDEST_RIM * min(ends[0].size):
            found.append(  # the adjacent line is blended with it
                f"The outermost pixels of {ends[0].name} and {ends[1].name} hold one colour, up to {max(rims)} on a "
                f"side. If that is no picture, leave it out by --crop {max(rims) + 1}: it is warped and judged as if "
                "it were."
            )
        return [*found, *sequences.depth_notes(self.sequence)]

    @property
    def about(self) -> str:
        """What takes the place of a renderer, how much of it is shown, and to which eyes."""
        sequence, guard, floor_db = self.sequence, self._guard, self.sequence.noise_floor_db
        (wide, high), (across, down) = sequence.frames[0].size, _degrees(sequence.frames[0].fov)
        shown = "All of it is shown: there is no guard band."
        if guard != GuardBand():
            part = "{:.1f} x {:.1f} degrees".format(*_degrees(self.headset.eyes[0].fov))
            shown = f"The middle of it is shown, {part}; the rest is a guard band of {guard.text}."
        eyes = "One eye is shown, the camera's."
        if right_mm := self._eye_distance_mm:
            eyes = f"The left eye is the camera, and the right eye is shown the same frames, {right_mm:g} mm beside it."
        return (
            f"{len(sequence.frames)} recorded frames of {sequence.path} ({sequence.layout}) take the place of a "
            f"renderer: {wide}x{high} pixels, {across:.1f} x {down:.1f} degrees. A late frame was taken where the "
            f"camera was. {shown} {eyes}"
            + ("" if floor_db is None else f" Its noise floor is {floor_db:g} dB, by camera.json.")
        )

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
        sequence, start = self.sequence, self.sequence.frames[0].pose
        if trace is None:
            return LoadedTrace(sequence.track, sequence.path, sequence.layout, [], [], "", "", axes_assumed=False)
        track = trace.track
        turned = np.array((start @ Pose((0, 0, 0), track.orientation_xyzw[0]).inverse()).orientation_xyzw)
        # It ends where the recording does.
        end = int(np.searchsorted(track.time_ns, track.start_ns + sequence.frames[-1].time_ns, side="right"))
        moved = track.evolve(
            time_ns=track.time_ns[:end] - track.start_ns,
            position_m=start.position_m + rotate(turned, track.position_m[:end] - track.position_m[0]),
            orientation_xyzw=multiply(turned, track.orientation_xyzw[:end]),
            epoch_ns=track.epoch_ns + track.start_ns,
            max_gap_ns=track.max_gap_ns,
            jumps=[at for at in track.jumps if at < end - 1],
            gaze=None if track.gaze is None else track.gaze[:end],
        )
        return attrs.evolve(trace, track=moved)

    def renderer(self, gpu: Gpu, options: PipelineOptions, moment_of: MomentOf = Moment) -> RecordedRenderer:
        """Return what gives the frames; mirrors and edges are as they were recorded."""
        return RecordedRenderer(gpu, self.scene, self.sequence, moment_of)


def _degrees(fov: Fov) -> tuple[float, float]:
    left, right, down, up = np.degrees(np.arctan(fov.tangents)).tolist()
    return right - left, up - down
