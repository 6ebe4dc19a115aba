"""A recorded sequence in the place of a renderer: it gives the frame that was taken."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Mapping
from collections.abc import Sequence as Several
from functools import lru_cache
from typing import Any

import attrs
import numpy as np

from ..frames import EyeImage, Frame, Needs
from ..geometry import Fov, Guard, Pose, View, guarded_eyes, inverse_depth_from_metres
from ..gpu.context import Gpu
from ..poses import Origin, PoseSample
from ..poses.track import Moment
from ..scenes import Scene
from ..sources.array_passes import SRGB8, Arrays, Scaling
from ..sources.repairs import RepairChain
from ..sources.sequences import RecordedFrame, Sequence
from ..sources.server import Renderer, Target

Size = tuple[int, int]
Box = tuple[float, float, float, float]
# Decoded frames that are kept: those under way, and the truth next to them; fewer of large ones.
_KEPT, _LEAST_KEPT, _KEPT_BYTES = 32, 4, 500_000_000
_PIXEL_BYTES = 3 + 4
AS_RECORDED = RepairChain()
_NOTHING = 1e-5  # what rounding leaves of two equal poses, in ms, degrees and metres
_ANOTHER = 1.0  # pixel that the truth may be off without a note


MomentOf = Callable[[int], Moment]


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
        # Gives the truth of the right eye; None where that was not recorded.
        self.right = RecordedRenderer(gpu, scene, sequence.right, moment_of) if sequence.right else None
        self._times = [frame.time_ns for frame in sequence.frames]
        wide, high = sequence.frames[0].size
        fit = _KEPT_BYTES // (wide * high * _PIXEL_BYTES)
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
        self,
        views: Several[View],
        drawn_ns: int,
        size: Size,
        guard: Guard = 1.0,
        needs: Needs | None = None,
        shown_size: Size | None = None,
        age_ns: int = 0,
        pictures: bool | None = True,
    ) -> Frame:
        """Return the last frame that was taken by now, all of it, always with its picture."""
        moment, rendered = self._moment_of(drawn_ns), guarded_eyes(views, guard, size)[1]
        taken = self.taken_by(moment)
        taken_ns = drawn_ns - abs(moment.since_ns - taken.time_ns)
        image = self._image(taken, taken.fov, rendered, repair=self._sequence.repair)
        image = attrs.evolve(image, drawn_ns=taken_ns)
        return Frame((image,) * len(views), taken_ns, PoseSample(taken_ns, taken.pose, Origin.MEASURED))

    def close(self) -> None:
        """Free the pools, those of the right eye too."""
        super().close()
        if self.right is not None:
            self.right.close()

    def truth_facts(
        self, shown: Several[tuple[int, Pose]], missing: int, pixels_per_degree: float, *, own_head: bool
    ) -> tuple[dict[str, Any], str]:
        """Return how far the truth is from what was shown, and that in a sentence or two.

        truth_offset: median and most of time_ms, turn_deg and move_m. The truth is the recorded
        frame nearest to the shown instant.
        """
        rows = [(shown_ns, pose, self.nearest_to(shown_ns)) for shown_ns, pose in shown]
        columns = {
            "time_ms": [(frame.time_ns - shown_ns) * 1e-6 for shown_ns, _, frame in rows],
            "turn_deg": [math.degrees(_turn(frame.pose, pose)) for _, pose, frame in rows],
            "move_m": [float(np.linalg.norm(frame.pose.position_m - pose.position_m)) for _, pose, frame in rows],
        }
        offsets = {name: _median_and_most(np.abs(values)) for name, values in columns.items()}
        return {"eyes": 1, "truth_offset": offsets}, _about_truth(offsets, pixels_per_degree, own_head)

    def _image(
        self, taken: RecordedFrame, fov: Fov, size: Size, into: Target | None = None, repair: RepairChain = AS_RECORDED
    ) -> EyeImage:
        target = into if into is not None else self.acquire(size)
        self.take_in(self._pixels(taken, fov, size, repair), target)
        view = attrs.evolve(taken.view, fov=fov)
        return EyeImage(view, target.colour, target.inverse_depth, drawn_ns=taken.time_ns)


def _turn(one: Pose, other: Pose) -> float:
    x, y, z, w = one.relative_to(other).unit_quaternion
    return 2 * math.atan2(math.sqrt(x * x + y * y + z * z), abs(w))


def _median_and_most(values: Iterable[float]) -> dict[str, float]:
    found = np.asarray(values)
    return {"median": round(float(np.median(found)), 6), "most": round(float(found.max()), 6)}


def _about_truth(offsets: Mapping[str, Mapping[str, float]], pixels_per_degree: float, own_head: bool) -> str:
    parts = ", ".join(
        f"{offsets[name]['median']:.{digits}f} {unit} (at most {offsets[name]['most']:.{digits}f})"
        for name, unit, digits in (("time_ms", "ms", 1), ("turn_deg", "degrees", 2), ("move_m", "m", 3))
    )
    if not any(offset["most"] > _NOTHING for offset in offsets.values()):
        return "The truth is the recorded frame of the shown instant itself."
    text = f"The truth is the recorded frame nearest to the shown instant, off by {parts} in the median."
    if offsets["turn_deg"]["median"] * pixels_per_degree <= _ANOTHER and own_head:
        return text
    return f"{text} That is another view than the one shown: the figures count this difference as error."


def _pixels(taken: RecordedFrame, fov: Fov, size: Size, repair: RepairChain) -> Arrays:
    """Return a frame in (w, h) pixels: whole ones of it as they are.

    fov: what they show, within that of the frame.
    """
    colour, depth = taken.read()
    if repair.steps:
        depth = repair.run(colour * np.float32(1 / 255), inverse_depth_from_metres(depth)).inverse_depth
    box = _box(taken, fov)
    left, top, right, bottom = math.floor(box[0]), math.floor(box[1]), math.ceil(box[2]), math.ceil(box[3])
    scaling = None
    if box != (left, top, right, bottom) or size != (right - left, bottom - top) or taken.hidden is not None:
        seen_rows = None if taken.hidden is None else taken.hidden.rows(fov, size)
        scaling = Scaling(size, (box[0] - left, box[1] - top, box[2] - left, box[3] - top), seen_rows)
    part = np.s_[top:bottom, left:right]
    return Arrays(colour[part], SRGB8, depth[part], is_inverse=bool(repair.steps), is_apart=True, scaling=scaling)


def _box(taken: RecordedFrame, fov: Fov) -> Box:
    """Return left, top, right and bottom of a field of view in the pixels of the frame."""
    (wide, high), (left, right, down, up) = taken.size, taken.fov.tangents.tolist()
    of = fov.tangents.tolist()
    columns = [(side - left) * wide / (right - left) for side in of[:2]]
    rows = [(up - side) * high / (up - down) for side in (of[3], of[2])]
    # A millionth of a pixel is rounding: whole pixels are taken as they are.
    found = [round(at, 6) for at in (columns[0], rows[0], columns[1], rows[1])]
    return found[0], found[1], found[2], found[3]
