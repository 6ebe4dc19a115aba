"""Which body each pixel belongs to, and how the bodies move."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...geometry import Pose, RigidState
from . import Layer, layers

if TYPE_CHECKING:
    import moderngl

_BODY_NUMBERS = 16


@attrs.frozen(eq=False)
class BodyIds:
    """The bodies of a picture."""

    # r16ui of the picture's size: 0 for what stands still, else 1 + index into `bodies`.
    numbers: moderngl.Texture
    # How each body moved when the picture was drawn.
    bodies: tuple[RigidState, ...] = ()


@layers.register
class Ids(Layer):
    """A BodyIds."""

    name = "ids"
    summary = "the rigid body each pixel belongs to, and how the bodies move"
    formats = ("r16ui",)
    drawn_by = "motion"

    @classmethod
    def textures(cls, data: BodyIds) -> Iterable[moderngl.Texture]:
        return (data.numbers,)

    @classmethod
    def numbers(cls, data: BodyIds) -> NDArray[np.float64]:
        """Return a row for each body: pose, velocity, angular velocity, acceleration."""
        rows = [
            np.concatenate(
                [
                    body.pose.position_m,
                    body.pose.orientation_xyzw,
                    body.velocity_m_s,
                    body.angular_velocity_rad_s,
                    body.acceleration_m_s2,
                ]
            )
            for body in data.bodies
        ]
        return np.array(rows, np.float64).reshape(-1, _BODY_NUMBERS)

    @classmethod
    def misfit(cls, pictures: Sequence[NDArray[Any]], numbers: NDArray[Any] | None) -> str:
        if numbers is None or numbers.shape[1] != _BODY_NUMBERS:
            return f"its bodies are missing: expected rows of {_BODY_NUMBERS} numbers"
        highest = int(pictures[0].max())
        if highest > len(numbers):
            return f"a pixel of body {highest}, and there are {len(numbers)} bodies"
        if (np.abs(np.linalg.norm(numbers[:, 3:7], axis=1) - 1) > 1e-3).any():
            return "a body's quaternion is not of length 1"
        return ""

    @classmethod
    def made(cls, sent: Sequence[Any], numbers: NDArray[Any] | None, amount: Any, drawn_ns: int) -> BodyIds:
        assert numbers is not None, "misfit() says so"
        bodies = [RigidState(Pose(row[:3], row[3:7]), row[7:10], row[10:13], row[13:]) for row in numbers]
        return BodyIds(sent[0], tuple(bodies))
