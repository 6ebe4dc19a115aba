"""Panels: flat pictures such as text and menus, with a place and a size instead of a depth."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from ..errors import SceneError, in_brief
from ..geometry import Pose, View, is_a, real
from ._mesh import Texture
from .shapes import Quad

MOST_PANELS = 15  # a headset's runtime composes 16 layers at least, of which one is the picture


def _pictures(value: Any) -> tuple[Texture, ...]:
    found = value if isinstance(value, tuple | list) else (value,)
    return tuple(each if isinstance(each, Texture) else Texture("panel", each, repeat=False) for each in found)


def _size(value: Any) -> tuple[float, float]:
    try:
        width, height = map(float, value)
    except (TypeError, ValueError, OverflowError) as error:
        raise SceneError(f"a panel's size is {in_brief(value)}: expected width and height in metres") from error
    if not (0 < width < np.inf and 0 < height < np.inf):
        raise SceneError(f"a panel is {width:g} x {height:g} m: expected finite lengths above 0")
    return width, height


@attrs.frozen(eq=False)
class Panel:
    """A picture in the world or fixed to the head, seen from its front: +z of its pose.

    Errors: SceneError for pictures of another shape or type, and for a size that is not above 0.
    """

    # (h, w, 3 or 4) uint8 sRGB, the top row first; or several, which take turns.
    pictures: tuple[Texture, ...] = attrs.field(converter=_pictures)
    # Of its middle: world_from_panel, or head_from_panel.
    pose: Pose = attrs.field(validator=is_a(Pose))
    # Width along the pose's x, height along its y, in metres.
    size_m: tuple[float, float] = attrs.field(converter=_size)
    head_locked: bool = False
    # Whether what is nearer in the picture hides it.
    occluded: bool = False
    # How long each picture stays.
    seconds: float = attrs.field(default=1.0, converter=real)

    def __attrs_post_init__(self) -> None:
        if not self.pictures or not 0 < self.seconds < np.inf:
            raise SceneError(
                f"a panel of {len(self.pictures)} pictures for {self.seconds:g} s each: expected one or more, and a "
                "finite time above 0"
            )

    def showing(self, time_ns: int) -> int:
        """Return which of its pictures it shows at an instant."""
        return int(time_ns // max(1, round(self.seconds * 1e9))) % len(self.pictures)

    def eye_from_panel(self, view: View) -> Pose:
        """Return where it is to an eye, without passing the world's origin."""
        return self.pose.relative_to(view.head_from_eye if self.head_locked else view.pose)

    def away_m(self, view: View) -> float:
        """Return how far its middle is from an eye."""
        return float(np.linalg.norm(self.eye_from_panel(view).position_m))

    @property
    def quad(self) -> Quad:
        """The rectangle, in the panel's own axes."""
        width, height = self.size_m
        return Quad((0.0, 0.0, 0.0), (width / 2, 0.0, 0.0), (0.0, height / 2, 0.0))
