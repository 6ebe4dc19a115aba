"""A recorded sequence: frames with depth, where each was taken, and the head's own motion."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..colour import srgb8_from_linear
from ..geometry import Fov, Pose, View
from ..poses import PoseTrack
from ..repairs import RepairChain

Pictures = tuple[NDArray[np.uint8], NDArray[np.float32]]


@attrs.frozen(eq=False)
class RecordedFrame:
    """A picture with depth, the instant and the view that it was taken for.

    Pixels are read when they are asked for, and not kept.
    """

    # Of its file, for messages.
    name: str
    # Since the first frame of its sequence.
    time_ns: int
    # World_from_eye in the axes of OpenXR.
    pose: Pose
    fov: Fov
    # (w, h) in pixels.
    size: tuple[int, int]
    _read: Callable[[], Pictures] = attrs.field(repr=False)

    @property
    def view(self) -> View:
        """Pose and field of view."""
        return View(self.pose, self.fov)

    def read(self) -> Pictures:
        """Return colour and depth_m, read from the file. Errors: InputError."""
        return self._read()

    @property
    def colour(self) -> NDArray[np.uint8]:
        """(h, w, 3) uint8 sRGB, row 0 at the top; read at each access."""
        return self._read()[0]

    @property
    def depth_m(self) -> NDArray[np.float32]:
        """(h, w) metres along -z; 0 or NaN is no depth, inf infinitely far; read at each access."""
        return self._read()[1]


@attrs.frozen(eq=False)
class Sequence:
    """Recorded frames in the order of their instants; all of one size."""

    name: str
    path: Path
    # Name of the reader.
    layout: str
    frames: tuple[RecordedFrame, ...]
    # The recorded motion of the camera, world_from_head, from the first frame to the last: their
    # poses, and those between that the files have.
    track: PoseTrack
    # What a user must know, one sentence each.
    notes: tuple[str, ...] = ()
    # What mends the depth of a frame before it is warped.
    repair: RepairChain = RepairChain()

    def repaired(self, repair: RepairChain) -> Sequence:
        """Return the sequence with its depth to be mended before a warp.

        Its frames are read as before.
        """
        if not repair.steps:
            return self
        note = f"The depth of late frames is mended by {repair.text}; the truth is what was recorded."
        return attrs.evolve(self, repair=repair, notes=(*self.notes, note))

    @property
    def rate_hz(self) -> float:
        """Frames per second: one over the median step; 0 for a single frame."""
        steps = np.diff([frame.time_ns for frame in self.frames])
        return 1e9 / float(np.median(steps)) if len(steps) else 0.0


def in_metres(depth: NDArray[Any], scale: float) -> NDArray[np.float32]:
    """Return depth in metres as float32."""
    return depth.astype(np.float32) if scale == 1 else (depth * np.float64(scale)).astype(np.float32)


def as_pictures(colour: NDArray[Any], depth_m: NDArray[np.float32]) -> Pictures:
    """Return the colour as bytes without alpha, and no depth where alpha is 0."""
    if colour.shape[2] == 4:
        depth_m = np.where(colour[..., 3] == 0, np.float32(np.nan), depth_m)
        colour = colour[..., :3]
    if colour.dtype != np.uint8:
        colour = srgb8_from_linear(colour)
    return np.ascontiguousarray(colour), depth_m
