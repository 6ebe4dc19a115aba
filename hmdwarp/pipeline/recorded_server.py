"""A recorded sequence in the place of a renderer: it gives the frame that was taken."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence as Several
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..colour import linear_from_srgb
from ..frames import EyeImage, Frame, Needs
from ..geometry import Guard, View, inverse_depth_from_metres
from ..gpu.context import Gpu
from ..gpu.textures import upload
from ..poses import Origin, PoseSample
from ..repairs import RepairChain
from ..scenes import Scene
from ..sequences import RecordedFrame, Sequence
from ..server import Server, Target

Size = tuple[int, int]
# Decoded frames that are kept: those under way, and the truth beside them; fewer of large ones.
_KEPT, _LEAST_KEPT, _KEPT_BYTES = 32, 4, 500_000_000
_PIXEL_BYTES = 8 + 4
_NONE = -1.0
AS_RECORDED = RepairChain()


def empty_scene(sequence: Sequence) -> Scene:
    """Return a scene of that name without anything in it, as recorded frames have none."""
    everywhere = np.array([[-np.inf] * 3, [np.inf] * 3])
    first = sequence.frames[0].pose
    return Scene(sequence.name, f"recorded frames ({sequence.layout})", (), viewpoint=first, walk_bounds_m=everywhere)


class RecordedServer(Server):
    """A Server whose pictures are recorded frames, with the exact pose and field of view of each.

    What it is asked to look at is ignored, and so is a guard band: a recording is as wide as it is.
    Pixels without depth keep their colour. The sequence's repair mends late frames, the truth stays
    as it was recorded. One eye. Another size than the recording's is made by averaging light and
    taking the nearest depth.
    """

    def __init__(self, gpu: Gpu, sequence: Sequence) -> None:
        super().__init__(gpu, empty_scene(sequence))
        self._sequence = sequence
        self._times = [frame.time_ns for frame in sequence.frames]
        wide, high = sequence.frames[0].size
        fit = _KEPT_BYTES // (wide * high * _PIXEL_BYTES)
        self._pixels = lru_cache(min(max(fit, _LEAST_KEPT), _KEPT))(_pixels)

    def taken_before(self, time_ns: int) -> RecordedFrame:
        """Return the last frame at or before an instant; the first one before all."""
        return self._sequence.frames[max(0, bisect_right(self._times, time_ns) - 1)]

    def nearest_to(self, time_ns: int) -> RecordedFrame:
        """Return the frame nearest to an instant, the earlier of two."""
        before = bisect_right(self._times, time_ns) - 1
        beside = [i for i in (before, before + 1) if 0 <= i < len(self._times)]
        return self._sequence.frames[min(beside, key=lambda i: (abs(self._times[i] - time_ns), i))]

    def draw(self, view: View, size: Size, into: Target | None = None, time_ns: int = 0) -> EyeImage:
        """Return the frame nearest to the instant: the truth of that instant."""
        return self._image(self.nearest_to(time_ns), size, into)

    def draw_frame(
        self,
        views: Several[View],
        drawn_ns: int,
        size: Size,
        guard: Guard = 1.0,
        needs: Needs | None = None,
        shown_size: Size | None = None,
        age_ns: int = 0,
        pictures: bool = True,
    ) -> Frame:
        """Return the last frame that was taken by now; its picture is always there."""
        taken = self.taken_before(drawn_ns)
        head = PoseSample(taken.time_ns, taken.pose, Origin.MEASURED)
        return Frame((self._image(taken, size, repair=self._sequence.repair),), taken.time_ns, head)

    def _image(
        self, taken: RecordedFrame, size: Size, into: Target | None = None, repair: RepairChain = AS_RECORDED
    ) -> EyeImage:
        target = into if into is not None else self.acquire(size)
        colour, inverse_depth = self._pixels(taken, size, repair)
        upload(target.colour, colour)
        upload(target.inverse_depth, inverse_depth)
        return EyeImage(taken.view, target.colour, target.inverse_depth, drawn_ns=taken.time_ns)


def _pixels(taken: RecordedFrame, size: Size, repair: RepairChain) -> tuple[NDArray[np.float16], NDArray[np.float32]]:
    """Return linear light (h, w, 4) and inverse depth (h, w) of a frame in (w, h) pixels."""
    colour, depth_m = taken.read()
    light = linear_from_srgb(colour).astype(np.float32)
    inverse: NDArray[np.floating] = inverse_depth_from_metres(depth_m)
    if repair.steps:
        inverse = repair.run(colour * np.float32(1 / 255), inverse).inverse_depth
    if size != taken.size:
        light, inverse = _averaged(light, size), _nearest(inverse, size)
    covered = np.ones((*light.shape[:2], 1), np.float32)
    rgba = np.concatenate([light, covered], axis=2).astype(np.float16)
    return rgba, np.where(np.isnan(inverse), _NONE, inverse).astype(np.float32)


def _averaged(light: NDArray[np.float32], size: Size) -> NDArray[np.float32]:
    from PIL import Image

    channels = (Image.fromarray(light[..., i]).resize(size, Image.Resampling.BOX) for i in range(3))
    return np.stack([np.asarray(channel) for channel in channels], axis=2)


def _nearest(inverse: NDArray[np.floating], size: Size) -> NDArray[np.floating]:
    (rows, columns), (wide, high) = inverse.shape, size
    row, column = ((np.arange(n) + 0.5) * m / n for n, m in ((high, rows), (wide, columns)))
    return inverse[row.astype(int)[:, None], column.astype(int)]
