"""Frames as they are stated: the numbers before anybody knows what they mean."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..geometry import View

Array = NDArray[np.float64]
LEFT, RIGHT = 0, 1
_TRACK, _UNSTEADY = 5, 0.15  # fewest frames with a curve; how far they may lie off it, in their motion
COARSE_PX = 96  # width of the pictures on which the conventions are told apart
_FINE_BLUR, _COARSE_BLUR = (0.7, 6.0), (0.8, 8.0)  # pixels: detail below is noise, shade above is exposure
_EDGE = 0.1  # neighbours that differ by more than this share lie at an edge


@attrs.frozen(eq=False)
class StatedFrame:
    """One frame as a file has it."""

    name: str
    colour: NDArray[np.uint8]  # (h, w, 3), top row first
    depth: Array  # (h, w) numbers of any unit and encoding; NaN and 0 are none
    view: View
    time_ns: int | None = None
    eye: int | None = None  # LEFT or RIGHT, of frames that come in pairs


@attrs.frozen(eq=False)
class Sheet:
    """Pictures and depth of all frames at one resolution."""

    picture: Array  # (n, h, w) brightness without its mean and its finest detail, deviation 1
    numbers: Array  # (n, h, w) depth as stated, NaN for none
    inverse: Array  # (n, h, w) one over it
    smooth: NDArray[np.bool_]  # (n, h, w) whether the four pixels from here right and down are one surface


@attrs.frozen(eq=False)
class Stated:
    """Two or more frames, ready to be compared.

    Errors: InputError for fewer than two, for different sizes, and for depth that has no number.
    """

    frames: Sequence[StatedFrame]

    def __attrs_post_init__(self) -> None:
        if len(self.frames) < 2:
            raise InputError(f"{len(self.frames)} frame: two or more are needed, of the same things from two places")
        for one in self.frames:
            shape = self.frames[0].depth.shape
            if one.depth.shape != shape or one.colour.shape[:2] != shape:
                raise InputError(
                    f"{one.name}: colour {one.colour.shape}, depth {one.depth.shape}: expected {shape} as in "
                    f"{self.frames[0].name}; frames of one camera have one size"
                )
            if not (np.isfinite(one.depth) & (one.depth != 0)).any():
                raise InputError(f"{one.name}: no pixel has depth")

    @property
    def position(self) -> Array:
        """(n, 3) as stated."""
        return np.array([one.view.pose.position_m for one in self.frames])

    @property
    def orientation(self) -> Array:
        """(n, 4) quaternions as stated."""
        return np.array([one.view.pose.orientation_xyzw for one in self.frames])

    @cached_property
    def tangents(self) -> Array:
        """(n, 4) left, right, down, up."""
        return np.array([one.view.fov.tangents for one in self.frames])

    @cached_property
    def seconds(self) -> Array | None:
        """(n,) from the first frame; None where times lack or do not rise."""
        times = [one.time_ns for one in self.frames if one.time_ns is not None]
        if len(times) < len(self.frames):
            return None
        seconds: Array = (np.array(times, dtype=np.int64) - times[0]) / 1e9
        return seconds if (np.diff(seconds) >= 0).all() and seconds[-1] > 0 else None

    @cached_property
    def other_eye(self) -> NDArray[np.int64] | None:
        """(n,) index of the frame of the other eye at that instant; None without pairs of eyes."""
        place = {(one.time_ns, one.eye): k for k, one in enumerate(self.frames)}
        pairs = [None if one.eye is None else place.get((one.time_ns, 1 - one.eye)) for one in self.frames]
        return None if None in pairs else np.array(pairs)

    @cached_property
    def tracks(self) -> list[NDArray[np.int64]]:
        """Indices of the frames of each eye, in the order of time."""
        eyes = np.array([one.eye or 0 for one in self.frames])
        return [np.flatnonzero(eyes == eye) for eye in np.unique(eyes)]

    @cached_property
    def interval_s(self) -> float | None:
        """Seconds between frames; None where the motion between them is not known."""
        if self.seconds is None or min(map(len, self.tracks)) < _TRACK:
            return None
        between = np.concatenate([np.diff(self.seconds[one]) for one in self.tracks])
        if not (between > 0).all() or self._unsteady() > _UNSTEADY:
            return None
        return float(np.median(between))

    def _unsteady(self) -> float:
        """Return how far frames lie off a smooth curve through the others, in what they move."""
        from scipy.interpolate import CubicSpline
        from scipy.spatial.transform import Rotation

        assert self.seconds is not None
        off = []
        depth = np.abs(np.concatenate([one.depth[np.isfinite(one.depth) & (one.depth != 0)] for one in self.frames]))
        for one in self.tracks:
            turns = Rotation.from_quat(self.orientation[one])
            turned = (turns[len(one) // 2].inv() * turns).as_rotvec()
            curve, times = np.hstack([turned, self.position[one] / np.median(depth)]), self.seconds[one]
            for k in range(1, len(one) - 1):
                rest = np.delete(np.arange(len(one)), k)
                error = np.linalg.norm(CubicSpline(times[rest], curve[rest])(times[k]) - curve[k])
                off.append(error / max(float(np.linalg.norm(curve[k + 1] - curve[k - 1])), 1e-12))
        return float(np.median(off))

    @cached_property
    def may_be_buffer(self) -> bool:
        """Whether all numbers lie within those of a depth buffer."""
        return all(bool((np.abs(one.depth[np.isfinite(one.depth)]) <= 1 + 1e-6).all()) for one in self.frames)

    @cached_property
    def signed(self) -> bool:
        """Whether depth has numbers below 0, as clip space from -1 has."""
        return any(bool((one.depth < 0).any()) for one in self.frames)

    @cached_property
    def fine(self) -> Sheet:
        """The frames at full resolution."""
        return self._sheet(1, _FINE_BLUR)

    @cached_property
    def coarse(self) -> Sheet:
        """The frames at about COARSE_PX pixels of width."""
        return self._sheet(max(1, self.frames[0].depth.shape[1] // COARSE_PX), _COARSE_BLUR)

    def _sheet(self, step: int, blur: tuple[float, float]) -> Sheet:
        from scipy.ndimage import gaussian_filter

        height, width = (side // step * step for side in self.frames[0].depth.shape)
        grey = np.array([one.colour[:height, :width].astype(np.float64) @ (0.299, 0.587, 0.114) for one in self.frames])
        grey = grey.reshape(len(grey), height // step, step, width // step, step).mean(axis=(2, 4))
        fine, mean = (gaussian_filter(grey, (0, radius, radius)) for radius in blur)
        picture = fine - mean
        picture /= max(picture.std(), 1e-9)
        depth = np.array([one.depth[step // 2 : height : step, step // 2 : width : step] for one in self.frames])
        depth = np.where((depth > 0) | ((depth < 0) & self.signed), depth, np.nan).astype(np.float64)
        around = np.stack([depth[:, y : y - 1 or None, x : x - 1 or None] for y in (0, 1) for x in (0, 1)])
        low, high = around.min(axis=0), around.max(axis=0)
        smooth = np.zeros(depth.shape, bool)
        with np.errstate(invalid="ignore", divide="ignore"):
            # What a buffer holds of far things is near 1.
            size = np.minimum(np.abs(low), 1 - high) if self.may_be_buffer else low
            smooth[:, :-1, :-1] = high - low <= _EDGE * size
            return Sheet(picture, depth, 1 / depth, smooth)
