"""From a file's axes to OpenXR's: +x right, +y up, -z forward."""

from __future__ import annotations

import math

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from .. import quaternions

_AXES = {"x": (1.0, 0, 0), "y": (0, 1.0, 0), "z": (0, 0, 1.0)}
# right, up, forward of the turn by a quarter (or half) that lifts the named axis to +y and moves
# everything else as little as possible.
_LIFTS = {"y": "x,y,-z", "-y": "x,-y,z", "z": "x,z,y", "-z": "x,-z,-y", "x": "-y,x,-z", "-x": "y,-x,-z"}


@attrs.frozen(eq=False)
class Axes:
    """Axes of a file, relative to OpenXR's."""

    # (3, 3), rows are OpenXR's right, up and back in the file's axes, for world and head alike
    basis: NDArray[np.float64]
    # xyzw, a turn of the world alone that follows (gravity set upright; the head's own axes stay)
    tilt: NDArray[np.float64] | None = None
    up: str = "y"  # which file axis is up

    def apply(self, position: NDArray[np.float64] | None, orientation: NDArray[np.float64]) -> None:
        """Convert positions (n, 3) and quaternions (n, 4), in place.

        Under a change of basis B a rotation about v by an angle becomes one about B v by det(B)
        times the angle; a left-handed file (det -1) needs no other treatment.
        """
        if not np.array_equal(self.basis, np.eye(3)):
            orientation[:, :3] = orientation[:, :3] @ (round(np.linalg.det(self.basis)) * self.basis).T
            if position is not None:
                position[:] = position @ self.basis.T
        if self.tilt is not None:
            orientation[:] = quaternions.multiply(self.tilt, orientation)
            if position is not None:
                position[:] = quaternions.rotate(self.tilt, position)


def from_words(text: str) -> Axes:
    """Return the axes of "right,up,forward", for instance "-y,z,x": x points forward, z up."""
    rows = []
    for word in text.split(","):
        sign, letter = (-1.0, word[1:]) if word.startswith("-") else (1.0, word.removeprefix("+"))
        if letter not in _AXES:
            raise InputError(f"axis '{word}': expected x, y or z, with or without a sign")
        rows.append(np.array(_AXES[letter]) * sign)
    basis = np.array(rows)
    if basis.shape != (3, 3) or abs(abs(np.linalg.det(basis)) - 1) > 1e-9:
        raise InputError(f"axes '{text}': expected three different ones, right,up,forward, for instance x,z,y")
    basis[2] *= -1  # OpenXR's z points back
    return Axes(basis, up=text.split(",")[1].removeprefix("+"))


def parse_axes(text: str) -> Axes:
    """Parse `--up`: an axis (y, z, -z, ..), three axes "right,up,forward", or three numbers.

    An axis: world and head are both turned so that it becomes +y; for z that is (x, y, z) -> (x, z,
    -y). Three axes: all of them stated, left-handed ones included. Three numbers: the direction
    that is really up in a y-up file whose gravity is tilted; only the world is turned, by the
    smallest angle.
    Errors: InputError.
    """
    text = text.strip().lower().removeprefix("+")
    if text in _LIFTS:
        return from_words(_LIFTS[text])
    fields = [f.strip() for f in text.split(",")]
    try:
        return _upright(np.array([float(f) for f in fields])) if len(fields) == 3 else _refuse(text)
    except ValueError:
        return from_words(",".join(fields)) if len(fields) == 3 else _refuse(text)


def _refuse(text: str) -> Axes:
    raise InputError(
        f"up '{text}': expected an axis (y, z, -z, x ...), three as right,up,forward (x,z,y), or three numbers "
        "(0.04,0.95,0.3)"
    )


def _upright(up: NDArray[np.float64]) -> Axes:
    length = float(np.linalg.norm(up))
    if not (math.isfinite(length) and length > 1e-6):
        raise InputError(f"up {up.tolist()}: expected a direction that is not zero")
    up = up / length
    # The half-way quaternion from up to +y; straight down has no smallest turn, x is taken.
    half = np.array([-up[2], 0.0, up[0], 1.0 + up[1]]) if up[1] > -1 + 1e-12 else np.array([1.0, 0, 0, 0])
    return Axes(np.eye(3), tilt=half / np.linalg.norm(half))
