"""Indirect light as an atlas of the scene's surfaces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....frames import EyeImage
from ....geometry import View
from ....scenes import ATLAS, indirect_atlas
from . import DrawContext, Drawing, Part, parts


@parts.register
class Irradiance(Part):
    """Solved anew for the first frame of each update; the frames until the next carry it too.

    Without lamps it is black: all light is baked.
    """

    name = "irradiance"
    order = 130
    of_client = True

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._update: int | None = None
        self._atlas: NDArray[np.float16] = np.zeros((*ATLAS[::-1], 4), np.float16)

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        return eye

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        scene = self.context.scene
        # The thousandth keeps frames that are drawn at the very rate of the updates apart.
        update = int(drawing.time_ns * drawing.needs["irradiance"] * 1e-9 + 1e-3)
        if scene.lamps and update != self._update:
            self._atlas, self._update = indirect_atlas(scene, drawing.time_ns), update
        into = self.context.acquire(ATLAS, depth=False).colour
        into.write(self._atlas.tobytes())
        return {"irradiance": into}
