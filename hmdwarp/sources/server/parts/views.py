"""Further pictures of an eye, from places that it may come to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ....gpu.textures import SCALAR, allocate, download, flip_rows
from ..passes import ScenePasses
from ..view_choice import Motion, chosen, moved
from . import parts
from ._base import DrawContext, Drawing, Part

if TYPE_CHECKING:
    import moderngl

    from ....frames import EyeImage
    from ....geometry import View

# The choice is made at this part of the resolution, on both axes.
_COARSE = 8


@parts.register
class Views(Part):
    """Whole pictures, drawn without layers, from the places that `view_choice` takes.

    They are chosen once for each frame, by the first eye's depth, and are as far from each eye. How
    fast the head moves is taken from the frame before.
    """

    name = "views"
    order = 130

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        plain = context.colour
        self._passes = ScenePasses(context.gpu, context.scene, plain.buffers, colour=False, moving=plain.moving)
        self._depth: moderngl.Texture | None = None
        self._before: tuple[NDArray[np.float64], int] | None = None
        self._ways: list[NDArray[np.float64]] = []

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        """Choose the places for the frame; there is no layer that the eyes share."""
        first, place = views[0], np.mean([view.pose.position_m for view in views], axis=0)
        before, self._before = self._before, (place, drawing.time_ns)
        passed_s = (drawing.time_ns - before[1]) * 1e-9 if before is not None else 0.0
        velocity = (place - before[0]) / passed_s if before is not None and passed_s > 0 else np.zeros(3)
        motion = Motion.of(first, velocity, drawing.age_ns * 1e-9)
        size = (max(1, drawing.size[0] // _COARSE), max(1, drawing.size[1] // _COARSE))
        count = drawing.needs.get("views", 0)
        self._ways = (
            chosen(first, size, motion, count, lambda view: self._depth_of(view, size, drawing.time_ns))
            if count
            else []
        )
        return {}

    def _depth_of(self, view: View, size: tuple[int, int], time_ns: int) -> NDArray[np.float64]:
        if self._depth is None or self._depth.size != size:
            self._release()
            self._depth = allocate(self.context.gpu.gl, size, SCALAR)
        self._passes.draw(view, self.context.framebuffers.over(self._depth), time_ns)
        return flip_rows(download(self._depth)).astype(np.float64)

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        views = [moved(eye.view, way) for way in self._ways]
        return eye.having(
            views=tuple(self.context.draw(view, eye.size, drawing.of_light(view, eye.size)) for view in views)
        )

    def _release(self) -> None:
        if self._depth is not None:
            self._depth.release()

    def close(self) -> None:
        self._passes.close()
        self._release()
