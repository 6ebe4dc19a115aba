"""Faults of a file that its motion reveals: impossible motions, and a wrong up axis."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import quaternions

# The fastest recorded head turns reach about 800 deg/s and 6 m/s; a jump is far beyond that and too
# large to be noise.
JUMP_SPEED_RAD_S = np.radians(2000)
JUMP_ANGLE_RAD = np.radians(20)
JUMP_SPEED_M_S = 15.0
JUMP_DISTANCE_M = 0.25
_BLOCK = 1_000_000


def find_jumps(
    time_ns: NDArray[np.int64], orientation: NDArray[np.float64], position: NDArray[np.float64] | None
) -> NDArray[np.int64]:
    """Return indices i whose step to row i + 1 is a teleport.

    Too far and too fast, in angle or place.
    """
    found = []
    for a in range(0, len(time_ns) - 1, _BLOCK):  # in blocks: the temporaries of 10^7 rows would double the memory
        b = min(a + _BLOCK, len(time_ns) - 1)
        seconds = np.diff(time_ns[a : b + 1]) * 1e-9
        angle = quaternions.angle_between(orientation[a:b], orientation[a + 1 : b + 1])
        jump = (angle > JUMP_ANGLE_RAD) & (angle > JUMP_SPEED_RAD_S * seconds)
        if position is not None:
            distance = np.linalg.norm(np.diff(position[a : b + 1], axis=0), axis=1)
            jump |= (distance > JUMP_DISTANCE_M) & (distance > JUMP_SPEED_M_S * seconds)
        found.append(np.flatnonzero(jump) + a)
    return np.concatenate(found) if found else np.empty(0, np.int64)


def gravity_axis(orientation: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the direction in the world, (3,), that is up for the head.

    None if the motion is ambiguous.

    People turn and nod far more than they tilt their heads sideways, so the axis through the ears
    stays level: up is the direction it has the smallest component in. That is trusted if this
    component is small (5 %, an rms roll of 13 degrees) and the next direction has five times as
    much, and 5 % at least (the head has turned). At most 100,000 rows, evenly spaced, are used.
    """
    q = orientation[:: max(1, len(orientation) // 100_000)]
    if len(q) < 100:
        return None
    right = quaternions.rotate(q, np.array([[1.0, 0, 0]]))
    share, axes = np.linalg.eigh(right.T @ right / len(q))
    if not share[0] < 0.05 < share[1] or share[1] < 5 * share[0]:
        return None
    axis = axes[:, 0]
    crown = quaternions.rotate(q, np.array([[0, 1.0, 0]])).mean(axis=0)
    return axis if axis @ crown >= 0 else -axis
