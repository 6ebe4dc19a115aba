"""A recorded sequence: frames with depth, where each was taken, and the head's own motion."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...colour import srgb8_from_linear
from ...errors import InputError
from ...geometry import Fov, Pose, View
from ...poses import PoseTrack
from ...poses.assumptions import Assumption, By
from ..repairs import RepairChain
from .options import FAR

_JPEG = 8  # of 255: as far as a JPEG is off in a plain area next to an edge
# Facts that every recording has, as its assumptions name them.
INTRINSICS, DEPTH_SCALE, NO_DEPTH = "intrinsics", "depth scale", "no depth"
AXES, POSE, CLOCK = "camera axes", "camera pose", "frame clock"
FACTS = (INTRINSICS, DEPTH_SCALE, NO_DEPTH, AXES, POSE, CLOCK)
_OF_16_BITS = 65535
Pictures = tuple[NDArray[np.uint8], NDArray[np.float32]]


@attrs.frozen(eq=False)
class RecordedFrame:
    """A picture with depth, the instant and the view that it was taken for.

    Pixels are read at each access, and not kept.
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
    # Reads depth as its file has it, in its own unit; None where nothing else does than `read`.
    raw_depth: Callable[[], NDArray[Any]] | None = attrs.field(default=None, repr=False)

    @property
    def view(self) -> View:
        """Pose and field of view."""
        return View(self.pose, self.fov)

    def read(self) -> Pictures:
        """Return colour and depth_m, read from the file. Errors: InputError."""
        return self._read()

    def rim(self) -> int:
        """Return how many of the outermost pixels hold one colour, on the side with the most.

        0 where a side has none. Rectification leaves such a rim, and so does a plain background.
        """
        colour = self.colour.astype(np.int16)
        same = np.abs(colour - colour[0, 0]).max(axis=2) <= _JPEG
        lines = same.all(axis=1), same.all(axis=0)
        sides = [int(np.argmin(side)) for line in lines for side in (line, line[::-1])]  # up to the first that differs
        return max(sides) if min(sides) else 0

    def cropped(self, pixels: int) -> RecordedFrame:
        """Return the frame without its outermost pixels. Errors: InputError where none is left."""
        size = (self.size[0] - 2 * pixels, self.size[1] - 2 * pixels)
        if min(size) < 1:
            found = "x".join(map(str, self.size))
            raise InputError(f"--crop {pixels}: {self.name} has {found} pixels; expected to leave one or more")
        left, right, down, up = self.fov.tangents
        x, y = (
            pixels * (far - near) / count
            for near, far, count in ((left, right, self.size[0]), (down, up, self.size[1]))
        )
        inner = np.s_[pixels : pixels + size[1], pixels : pixels + size[0]]

        def read() -> Pictures:
            colour, depth_m = self._read()
            return np.ascontiguousarray(colour[inner]), np.ascontiguousarray(depth_m[inner])

        fov = Fov.from_tangents((left + x, right - x, down + y, up - y))
        return attrs.evolve(self, fov=fov, size=size, read=read)

    def far_without_depth(self) -> RecordedFrame:
        """Return the frame with what has colour and no depth infinitely far away."""

        def read() -> Pictures:
            colour, depth_m = self._read()
            return colour, np.where(depth_m <= 0, np.float32(np.inf), depth_m)

        return attrs.evolve(self, read=read)

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
    # Facts that all frames share, with who says them.
    assumptions: tuple[Assumption, ...] = ()

    def with_no_depth(self, meaning: str) -> Sequence:
        """Return the sequence with pixels without depth as `meaning` has it: FAR or HOLE."""
        if meaning != FAR:
            return self
        fact = Assumption(NO_DEPTH, "infinitely far", By.USER, "--no-depth")
        frames = tuple(frame.far_without_depth() for frame in self.frames)
        return attrs.evolve(self, frames=frames, assumptions=replaced(self.assumptions, fact))

    def repaired(self, repair: RepairChain) -> Sequence:
        """Return the sequence with its depth to be mended before a warp.

        Its frames are read as before.
        """
        if not repair.steps:
            return self
        note = f"The depth of late frames is mended by {repair.text}; the truth is what was recorded."
        return attrs.evolve(self, repair=repair, notes=(*self.notes, note))

    def cropped(self, pixels: int) -> Sequence:
        """Return the sequence without the outermost pixels of its frames. Errors: InputError."""
        if not pixels:
            return self
        note = f"The {pixels} outermost pixels of each picture are left out."
        frames = tuple(frame.cropped(pixels) for frame in self.frames)
        return attrs.evolve(self, frames=frames, notes=(*self.notes, note))

    @property
    def rate_hz(self) -> float:
        """Frames per second: one over the median step; 0 for a single frame."""
        steps = np.diff([frame.time_ns for frame in self.frames])
        return 1e9 / float(np.median(steps)) if len(steps) else 0.0


def replaced(facts: Iterable[Assumption], *by: Assumption) -> tuple[Assumption, ...]:
    """Return the facts, those of the same name replaced by others."""
    return tuple({fact.what: fact for fact in (*facts, *by)}.values())


def is_largest(depth: NDArray[Any]) -> NDArray[np.bool_]:
    """Return where integers are the largest of their type, which no camera measures.

    In a wider type that holds nothing larger, the largest of 16 bits is one too.
    """
    if depth.dtype.kind not in "iu" or not depth.size:
        return np.zeros(depth.shape, bool)
    most = int(depth.max())
    return np.asarray((depth == most) & (most in {np.iinfo(depth.dtype).max, _OF_16_BITS}))


def in_metres(depth: NDArray[Any], scale: float) -> NDArray[np.float32]:
    """Return depth in metres as float32; 0 where there is none, as in the largest of integers."""
    metres = depth.astype(np.float32) if scale == 1 else (depth * np.float64(scale)).astype(np.float32)
    return np.where(is_largest(depth) | np.isnan(metres), np.float32(0), metres)


def as_pictures(colour: NDArray[Any], depth_m: NDArray[np.float32]) -> Pictures:
    """Return the colour as bytes without alpha, and NaN for the depth where alpha is 0."""
    if colour.shape[2] == 4:
        depth_m = np.where(colour[..., 3] == 0, np.float32(np.nan), depth_m)
        colour = colour[..., :3]
    if colour.dtype != np.uint8:
        colour = srgb8_from_linear(colour)
    return np.ascontiguousarray(colour), depth_m
