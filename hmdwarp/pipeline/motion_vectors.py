"""Velocities from an engine's motion vectors and depth, in the shape of XR_EXT_frame_synthesis.

Source: OpenXR 1.1, XrFrameSynthesisInfoEXT; docs/feed.md has the units.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..geometry import Fov, Pose, View

Array = NDArray[np.float64]
# Scale and offset of the vectors' x, y, z; metres at z = 0 and at z = 1; seconds since the frame
# before; that frame's eye: pose, head_from_eye, angles.
NUMBERS = 3 + 3 + 2 + 1 + 18
# Halves are rounded within 2^-11 of their value, and what is computed from them as often again.
_RELATIVE, _ABSOLUTE = 2.0**-10, 2.0**-20


@attrs.frozen
class _InverseDepths:
    """What an engine's z stands for, in 1/m."""

    # At z = 0, and at z = 1.
    nearest: float
    farthest: float

    @classmethod
    def of(cls, near: float, far: float) -> _InverseDepths | None:
        """Return it for two distances, None for vectors without z."""
        return None if near == far else cls(1 / near, 1 / far)


def velocity_of(parts: Sequence[NDArray[Any]], view: View, inverse_depth: NDArray[Any]) -> NDArray[np.float16]:
    """Return (h, w, 4): m/s along the eye's axes, and 1 where something moves by itself.

    parts: the vectors, and a row of NUMBERS. view, inverse_depth: of the picture. Vectors of lower
    resolution are spread to the pixels around them whose depth is theirs. Errors: InputError.
    """
    # Whatever numbers come: what is not finite in the end does not move.
    with np.errstate(all="ignore"):
        vectors, told = _checked(parts)
        height, width = vectors.shape[:2]
        own = _nearest(inverse_depth.shape, (height, width))
        depth = inverse_depth[np.ix_(*own)].astype(np.float64)
        found = _velocity(vectors, told, view, depth)
        return found if (height, width) == inverse_depth.shape else _spread(found, depth, inverse_depth)


def _checked(parts: Sequence[NDArray[Any]]) -> tuple[Array, Array]:
    if len(parts) != 2 or parts[0].ndim != 3 or parts[1].shape != (1, NUMBERS):
        raise InputError(f"motion vectors: expected a picture of 4 numbers a pixel, and a row of {NUMBERS}")
    vectors, told = parts[0].astype(np.float64), parts[1][0].astype(np.float64)
    near, far, seconds = told[6:9]
    finite = np.isfinite(np.delete(told, (6, 7))).all()
    if not (finite and seconds > 0 and (near > 0 and far > 0 and near != far or near == far == 0)):
        raise InputError(
            f"motion vectors over {seconds:g} s, from {near:g} to {far:g} m: expected finite numbers, a time above 0, "
            "and two distances, or 0 and 0 for vectors of two numbers"
        )
    return np.nan_to_num(vectors[..., :3], posinf=0, neginf=0) * told[:3] + told[3:6], told


def _nearest(of: tuple[int, ...], to: tuple[int, ...]) -> list[NDArray[np.intp]]:
    """Return rows and columns of a picture that the centres of another's pixels lie in."""
    return [((np.arange(count) + 0.5) * many / count).astype(np.intp) for many, count in zip(of, to, strict=True)]


def _velocity(vectors: Array, told: Array, view: View, depth: Array) -> NDArray[np.float16]:
    before = View(Pose(told[9:12], told[12:16]), Fov(*told[23:27]), Pose(told[16:19], told[19:23]))
    has_depth, of_z = depth > 0, _InverseDepths.of(*told[6:8])
    here = _points(view.fov.tangents, *_centres(vectors.shape[:2]), np.where(has_depth, depth, 1.0))
    then_from_now = before.pose.relative_to(view.pose).inverse()
    # In the eye before: where it would have been had it stood still, and where the vectors say.
    still = then_from_now.rotation.apply(here.reshape(-1, 3)).reshape(here.shape) + then_from_now.position_m
    now = _ndc(view.fov.tangents, here, of_z)
    by_head = now - _ndc(before.fov.tangents, still, of_z)
    if of_z is None:
        # It had the depth that it would have, had it stood still.
        vectors = np.dstack([vectors[..., :2], by_head[..., 2]])
    place = now - vectors
    inverse = -1 / still[..., 2] if of_z is None else of_z.nearest + place[..., 2] * (of_z.farthest - of_z.nearest)
    # Behind the eye nothing was seen.
    then = _points(before.fov.tangents, place[..., 0], place[..., 1], np.where(inverse > 0, inverse, np.nan))
    rounding = _RELATIVE * np.abs(vectors) + _ABSOLUTE
    moves = has_depth & (np.abs(vectors - by_head) > rounding).any(axis=2) & np.isfinite(then).all(axis=2)
    velocity = np.zeros((*depth.shape, 4))
    back = then_from_now.rotation.inv()
    velocity[moves, :3] = back.apply((still - then)[moves]) / told[8]
    velocity[moves, 3] = 1
    return np.clip(velocity, -65504, 65504).astype(np.float16)


def _centres(shape: tuple[int, ...]) -> tuple[Array, Array]:
    """Return x and y of the pixels' centres, from -1 to 1, y down."""
    y, x = (2 * (np.arange(count) + 0.5) / count - 1 for count in shape)
    found = np.meshgrid(x, y)
    return found[0], found[1]


def _points(tangents: Array, x: Array, y: Array, inverse_depth: Array) -> Array:
    """Return points in the eye's axes."""
    left, right, down, up = tangents
    along = np.stack([left + (right - left) * (x + 1) / 2, up - (up - down) * (y + 1) / 2, -np.ones_like(x)], axis=-1)
    return along / inverse_depth[..., None]


def _ndc(tangents: Array, points: Array, of_z: _InverseDepths | None) -> Array:
    """Return x, y from -1 to 1, y down, and z as the engine has it, 0 without."""
    left, right, down, up = tangents
    inverse = -1 / points[..., 2]
    x, y = points[..., 0] * inverse, points[..., 1] * inverse
    z = np.zeros_like(x) if of_z is None else (inverse - of_z.nearest) / (of_z.farthest - of_z.nearest)
    return np.stack([2 * (x - left) / (right - left) - 1, 2 * (up - y) / (up - down) - 1, z], axis=-1)


def _spread(found: NDArray[np.float16], depth: Array, inverse_depth: NDArray[Any]) -> NDArray[np.float16]:
    """Return, for each pixel, the velocity of that of the four around it whose depth is nearest."""
    shape, best = inverse_depth.shape, np.full(inverse_depth.shape, np.inf)
    out = np.zeros((*shape, 4), np.float16)
    places = [(np.arange(many) + 0.5) * count / many - 0.5 for many, count in zip(shape, depth.shape, strict=True)]
    for down in (0, 1):
        for right in (0, 1):
            rows, columns = (
                np.clip(np.floor(place).astype(np.intp) + step, 0, count - 1)
                for place, step, count in zip(places, (down, right), depth.shape, strict=True)
            )
            apart = np.abs(depth[np.ix_(rows, columns)] - inverse_depth)
            nearer = apart < best
            out[nearer] = found[np.ix_(rows, columns)][nearer]
            best[nearer] = apart[nearer]
    return out
