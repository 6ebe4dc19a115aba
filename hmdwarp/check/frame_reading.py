"""A reading: what the numbers of frames are taken to mean."""

from __future__ import annotations

import functools

import attrs
import numpy as np

from ..poses.reading.axes import parse_axes
from .stated_frames import Array, Stated

METRES, BUFFER = "metres", "buffer"
AS_STATED = "openxr"  # axes of what hmdwarp reads
# Of the presets of --axes, one of each that has other axes of the camera.
AXES = (AS_STATED, "opencv", "unity", "ros", "unreal", "aria", "euroc")
_MIRROR = np.diag([1.0, 1.0, -1.0])


@functools.cache
def eye_axes(name: str) -> Array:
    """Return (3, 3): OpenXR's axes of the eye in those of the file, one a row."""
    return parse_axes(name).head


@attrs.frozen
class Reading:
    """What is assumed about frames; the defaults are what hmdwarp reads."""

    # Order of the quaternion: xyzw, or wxyz.
    order: str = "xyzw"
    # Whether the pose takes points of the world to the eye.
    inverse: bool = False
    # Of eye and world: a name of AXES, or right,up,forward.
    axes: str = AS_STATED
    # Whether the rows run from bottom to top.
    colour_rows_up: bool = False
    depth_rows_up: bool = False
    # Whether each frame has the other eye's pose.
    eyes_swapped: bool = False
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
    # Logarithms of how much wider the picture is than its field of view, about the camera's axis.
    wide_x: float = 0.0
    wide_y: float = 0.0
    # The instant of the picture after that of its pose, seconds.
    late_s: float = 0.0

    def poses(self, stated: Stated) -> tuple[Array, Array]:
        """Return the matrices (n, 3, 3) and positions (n, 3) of world_from_eye."""
        turn, place = _poses(stated, self.order, self.inverse, self.axes, self.eyes_swapped)
        return _moved(stated, turn, place, self.late_s) if self.late_s else (turn, place)

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


def _poses(stated: Stated, order: str, inverse: bool, axes: str, eyes_swapped: bool) -> tuple[Array, Array]:
    from scipy.spatial.transform import Rotation

    orientation, place = stated.orientation, stated.position
    if order == "wxyz":
        orientation = orientation[:, [1, 2, 3, 0]]
    turn = Rotation.from_quat(orientation).as_matrix()
    if inverse:
        turn = turn.transpose(0, 2, 1)
        place = -np.einsum("nij,nj->ni", turn, place)
    eye = eye_axes(axes)
    if not np.array_equal(eye, np.eye(3)):
        turn = turn @ eye.T
        if np.linalg.det(eye) < 0:  # which of the world's axes is turned around makes no difference
            turn, place = _MIRROR @ turn, place @ _MIRROR
    if eyes_swapped:
        assert stated.other_eye is not None
        turn, place = turn[stated.other_eye], place[stated.other_eye]
    return turn, place


def _moved(stated: Stated, turn: Array, place: Array, late_s: float) -> tuple[Array, Array]:
    """Return the poses of `late_s` later, on smooth curves through them."""
    from scipy.interpolate import CubicSpline
    from scipy.spatial.transform import Rotation, RotationSpline

    times = stated.seconds
    assert times is not None
    turned, placed = np.empty_like(turn), np.empty_like(place)
    for track in stated.tracks:
        later = times[track] + late_s
        turned[track] = RotationSpline(times[track], Rotation.from_matrix(turn[track]))(later).as_matrix()
        placed[track] = CubicSpline(times[track], place[track])(later)
    return turned, placed
