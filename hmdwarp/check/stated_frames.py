"""Frames as they are stated: their numbers, read from files before their meaning is known."""

from __future__ import annotations

import functools
import math
import sys
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import InputError
from ..geometry import View
from ..poses.assumptions import Assumption
from ..poses.reading.axes import parse_axes
from ..sources import sequences
from ..sources.sequences import RecordedFrame, SequenceOptions

Array = NDArray[np.float64]
LEFT, RIGHT = 0, 1
MOST = 24  # frames that are compared
_APART_NS = 10**8  # between two of them, where there are more
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


class Stated:
    """Two or more frames, ready to be compared.

    assumptions: how a folder was read, with who says each fact. notes: what its depth suggests.
    Errors: InputError for fewer than two, for different sizes, and for depth that has no number.
    """

    def __init__(
        self, frames: Sequence[StatedFrame], assumptions: Sequence[Assumption] = (), notes: Sequence[str] = ()
    ) -> None:
        if len(frames) < 2:
            raise InputError(f"{len(frames)} frame: two or more are needed, of the same things from two places")
        shape = frames[0].depth.shape
        self.frames, self.assumptions, self.notes = frames, assumptions, notes
        self.depths = [frame.depth[np.isfinite(frame.depth) & (frame.depth != 0)] for frame in frames]  # what is known
        for frame, known in zip(frames, self.depths, strict=True):
            if frame.depth.shape != shape or frame.colour.shape[:2] != shape:
                raise InputError(
                    f"{frame.name}: colour {frame.colour.shape}, depth {frame.depth.shape}: expected {shape} as in "
                    f"{frames[0].name}; frames of one camera have one size"
                )
            if not len(known):
                raise InputError(f"{frame.name}: no pixel has depth")
        # Whether all numbers may be of a depth buffer; whether some are below 0, as in NDC.
        self.may_be_buffer = all(bool((np.abs(known) <= 1 + 1e-6).all()) for known in self.depths)
        self.signed = any(bool((frame.depth < 0).any()) for frame in frames)
        # As stated: (n, 3) positions, (n, 4) quaternions, (n, 4) tangents left, right, down, up.
        self.position = np.array([frame.view.pose.position_m for frame in frames])
        self.orientation = np.array([frame.view.pose.orientation_xyzw for frame in frames])
        self.tangents = np.array([frame.view.fov.tangents for frame in frames])
        # Matrices and positions that a reading makes of the poses: most readings share them.
        self.poses_read: dict[tuple[str, bool, str, bool, float], tuple[Array, Array]] = {}
        # (n,) seconds from the first frame; None where times lack or do not rise.
        times = np.array(
            [math.nan if frame.time_ns is None else frame.time_ns - (frames[0].time_ns or 0) for frame in frames]
        )
        self.seconds = times / 1e9 if (np.diff(times) >= 0).all() and times[-1] > 0 else None
        # (n,) index of the frame of the other eye at that instant; None without pairs of eyes.
        place = {(one.time_ns, one.eye): k for k, one in enumerate(frames)}
        pairs = [None if frame.eye is None else place.get((frame.time_ns, 1 - frame.eye)) for frame in frames]
        self.other_eye = None if None in pairs else np.array(pairs)
        # Indices of the frames of each eye, in the order of time.
        eyes = np.array([frame.eye or 0 for frame in frames])
        self.tracks = [np.flatnonzero(eyes == eye) for eye in np.unique(eyes)]
        # The frames at full resolution, and at about COARSE_PX pixels of width.
        self.fine, self.coarse = self._sheet(1, _FINE_BLUR), self._sheet(max(1, shape[1] // COARSE_PX), _COARSE_BLUR)

    @cached_property
    def interval_s(self) -> float | None:
        """Seconds between frames; None where the motion between them is not known."""
        from scipy.interpolate import CubicSpline
        from scipy.spatial.transform import Rotation

        if self.seconds is None or min(map(len, self.tracks)) < _TRACK:
            return None
        between = np.concatenate([np.diff(self.seconds[track]) for track in self.tracks])
        if not (between > 0).all():
            return None
        # How far frames lie off a smooth curve through the others, in what they move.
        off, distance = [], np.median(np.abs(np.concatenate(self.depths)))
        for track in self.tracks:
            turns = Rotation.from_quat(self.orientation[track])
            turned = (turns[len(track) // 2].inv() * turns).as_rotvec()
            curve, times = np.hstack([turned, self.position[track] / distance]), self.seconds[track]
            for k in range(1, len(track) - 1):
                rest = np.delete(np.arange(len(track)), k)
                error = np.linalg.norm(CubicSpline(times[rest], curve[rest])(times[k]) - curve[k])
                off.append(error / max(float(np.linalg.norm(curve[k + 1] - curve[k - 1])), 1e-12))
        return float(np.median(between)) if np.median(off) <= _UNSTEADY else None

    def _sheet(self, step: int, blur: tuple[float, float]) -> Sheet:
        from scipy.ndimage import gaussian_filter

        height, width = (side // step * step for side in self.frames[0].depth.shape)
        colours = (frame.colour[:height, :width].astype(np.float64) for frame in self.frames)
        grey = np.array([colour @ (0.299, 0.587, 0.114) for colour in colours])
        grey = grey.reshape(len(grey), height // step, step, width // step, step).mean(axis=(2, 4))
        fine, mean = (gaussian_filter(grey, (0, radius, radius)) for radius in blur)
        picture = fine - mean
        picture /= max(picture.std(), 1e-9)
        depth = np.array([frame.depth[step // 2 : height : step, step // 2 : width : step] for frame in self.frames])
        depth = np.where((depth > 0) | ((depth < 0) & self.signed), depth, np.nan).astype(np.float64)
        cleared = depth == 1
        if self.may_be_buffer and (np.isfinite(depth) & ~cleared).any(axis=(1, 2)).all():
            depth[cleared] = np.nan  # a buffer has sky at its far plane, where it is not
        around = [depth[:, y : y - 1 or None, x : x - 1 or None] for y in (0, 1) for x in (0, 1)]
        low, high = functools.reduce(np.minimum, around), functools.reduce(np.maximum, around)
        smooth = np.zeros(depth.shape, bool)
        with np.errstate(invalid="ignore", divide="ignore"):
            # What a buffer holds of far things is near 1.
            size = np.minimum(np.abs(low), 1 - high) if self.may_be_buffer else low
            smooth[:, :-1, :-1] = high - low <= _EDGE * size
            return Sheet(picture, depth, 1 / depth, smooth)


def read_stated(paths: Sequence[Path], options: SequenceOptions | None = None) -> Stated:
    """Return recorded frames as they are stated.

    Parameters
    ----------
    paths : sequence of Path
        A folder, or two (left and right eye; assumptions and notes are those of the first). Of more
        than 24 frames, those where the camera moves most.
    options : SequenceOptions, optional
        Facts that the files do not say.

    Raises
    ------
    InputError
        As sequences.open, and as Stated.
    """
    if len(paths) > 2:
        raise InputError(f"{' '.join(map(str, paths))}: expected a folder, or two: of the left and the right eye")
    opened = [sequences.open(path, options) for path in paths]
    if len(opened[0]) != len(opened[-1]):
        have = f"{paths[0]} has {len(opened[0])} frames and {paths[1]} {len(opened[1])}"
        raise InputError(f"{have}: expected one of each eye for each instant")
    found: list[StatedFrame] = []
    for k in _chosen(opened[0].frames):
        for eye, sequence in enumerate(opened):
            frame, number = sequence[k], eye if len(paths) > 1 else None
            colour, depth = frame.read()
            found.append(StatedFrame(frame.name, colour, depth.astype(np.float64), frame.view, frame.time_ns, number))
    return Stated(found, opened[0].assumptions, sequences.depth_notes(opened[0]))


def _chosen(frames: Sequence[RecordedFrame]) -> range:
    """Return the places of at most MOST frames, evenly apart, where the camera moves most."""
    if len(frames) <= MOST:
        return range(len(frames))
    between = float(np.median(np.diff([frame.time_ns for frame in frames])))
    step = min(max(1, round(_APART_NS / max(between, 1.0))), len(frames) // MOST)
    place = np.array([frame.pose.position_m for frame in frames])
    turn = np.array([frame.pose.rotation_matrix.ravel() for frame in frames])
    moved, turned = (np.linalg.norm(np.diff(poses, axis=0), axis=1) for poses in (place, turn))
    ways = sum(length / max(length.mean(), sys.float_info.min) for length in (moved, turned))
    way = np.concatenate([[0.0], np.cumsum(ways)])
    span = (MOST - 1) * step
    start = int(np.argmax(way[span:] - way[: len(way) - span]))
    return range(start, start + span + 1, step)


METRES, BUFFER = "metres", "buffer"
_AS_STATED = "openxr"  # axes of what hmdwarp reads
# Of the presets of --axes, one of each that has other axes of the camera.
AXES = (_AS_STATED, "opencv", "unity", "ros", "unreal", "aria", "euroc")
_MIRROR = np.diag([1.0, 1.0, -1.0])
_HALF = 0.25  # pixels about half of one in both directions: what is off by as much is a convention


@functools.cache
def eye_axes(name: str) -> Array:
    """Return (3, 3): OpenXR's axes of the eye in those of the file, one a row."""
    return parse_axes(name).head


@attrs.frozen
class Reading:
    """What is assumed about frames; the defaults are what hmdwarp reads."""

    order: str = "xyzw"  # order of the quaternion: xyzw, or wxyz
    inverse: bool = False  # whether the pose takes points of the world to the eye
    axes: str = _AS_STATED  # of eye and world: a name of AXES, or right,up,forward
    colour_rows_up: bool = False  # whether the rows run from bottom to top
    depth_rows_up: bool = False
    eyes_swapped: bool = False  # whether each frame has the other eye's pose
    # Inverse depth in 1/m = offset + factor * (base - end) * ray ** along. The base is 1 / number
    # for METRES, the number for BUFFER; `ray` is the length of the ray to the plane z = -1.
    kind: str = METRES
    factor: float = 1.0
    end: float = 0.0  # the base of what is farthest
    offset: float = 0.0  # the inverse depth there
    along: float = 0.0  # 0: along z; 1: along the ray
    # How far the middles of the pixels lie right of and below where the field of view has them,
    # in pixels of the full resolution.
    pixel_x: float = 0.0
    pixel_y: float = 0.0
    wide_x: float = 1.0  # tangents of the view over those of the stated field of view: focal lengths stated over true
    wide_y: float = 1.0
    late_s: float = 0.0  # the instant of the picture after that of its pose, seconds
    # Faults that no answer names; fitted to tell one apart from them. Of the camera in its pose,
    # rad; of the lens, per squared tangent; of the depth's picture in the colour's: its tangents
    # over those, and pixels; of the depth of each frame, a logarithm.
    turn_x: float = 0.0
    turn_y: float = 0.0
    turn_z: float = 0.0
    bend: float = 0.0
    depth_wide: float = 1.0
    depth_x: float = 0.0
    depth_y: float = 0.0
    scales: tuple[float, ...] = ()

    @property
    def is_half_a_pixel(self) -> bool:
        """Whether the middles of the pixels lie about half a pixel off in both directions."""
        x, y = self.pixel_x, self.pixel_y
        return _HALF < abs(x + y) / 2 < 3 * _HALF and abs(x - y) < 2 * _HALF

    def poses(self, stated: Stated) -> tuple[Array, Array]:
        """Return the matrices (n, 3, 3) and positions (n, 3) of world_from_eye."""
        from scipy.interpolate import CubicSpline
        from scipy.spatial.transform import Rotation, RotationSpline

        key = (self.order, self.inverse, self.axes, self.eyes_swapped, self.late_s)
        if key not in stated.poses_read:
            orientation, place = stated.orientation, stated.position
            turn = Rotation.from_quat(orientation[:, [1, 2, 3, 0]] if self.order == "wxyz" else orientation).as_matrix()
            if self.inverse:
                turn = turn.transpose(0, 2, 1)
                place = -np.einsum("nij,nj->ni", turn, place)
            eye = eye_axes(self.axes)
            if not np.array_equal(eye, np.eye(3)):
                turn = turn @ eye.T
                if np.linalg.det(eye) < 0:  # which of the world's axes is turned around makes no difference
                    turn, place = _MIRROR @ turn, place @ _MIRROR
            if self.eyes_swapped:
                assert stated.other_eye is not None
                turn, place = turn[stated.other_eye], place[stated.other_eye]
            if self.late_s:  # on smooth curves through the poses
                assert stated.seconds is not None
                turned, placed = np.empty_like(turn), np.empty_like(place)
                for track in stated.tracks:
                    times, rotations = stated.seconds[track], Rotation.from_matrix(turn[track])
                    turned[track] = RotationSpline(times, rotations)(times + self.late_s).as_matrix()
                    placed[track] = CubicSpline(times, place[track])(times + self.late_s)
                turn, place = turned, placed
            stated.poses_read[key] = turn, place
        turn, place = stated.poses_read[key]
        if self.turn_x or self.turn_y or self.turn_z:
            turn = turn @ Rotation.from_rotvec((self.turn_x, self.turn_y, self.turn_z)).as_matrix()
        return turn, place

    def inverse_depth(self, base: Array, ray: Array) -> Array:
        """Return the inverse depth, NaN for none.

        base: one over the numbers as stated for METRES, the numbers for BUFFER.
        """
        scaled = (base - self.end) * self.factor
        if self.along:
            scaled = scaled * ray**self.along
        return scaled + self.offset if self.offset else scaled

    def base(self, inverse_depth: Array, ray: Array) -> Array:
        """Return the base that has an inverse depth: the inverse of inverse_depth()."""
        scaled = (inverse_depth - self.offset) / self.factor
        return (scaled / ray**self.along if self.along else scaled) + self.end
