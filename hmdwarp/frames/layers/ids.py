"""Which body each pixel belongs to, and how the bodies move."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs

from . import Layer, layers

if TYPE_CHECKING:
    from collections.abc import Iterable

    import moderngl

    from ...geometry import RigidState


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
