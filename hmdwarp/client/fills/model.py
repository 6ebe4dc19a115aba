"""The client draws a reduced model of the scene into the holes."""

from __future__ import annotations

from typing import Literal

import attrs

from ..drawn_scenes import share_of
from ..inputs import PassInputs, ShownPicture
from . import fills
from ._base import Fill

SHARE = 0.2  # of the scene's triangles, of every fill with a client's model


@attrs.frozen
class ModelSettings:
    # Share of the scene's triangles that the client draws, 0 to 1.
    share: float = share_of(SHARE)
    # Scale of its textures' resolution on both axes, 0 to 1.
    texture: float = share_of(1.0)
    # off: the bare albedo, for a client that does not shade.
    light: Literal["baked", "off"] = "baked"


@fills.register
class Model(Fill):
    """Draw the client's own triangles; the depth buffer keeps them to the holes.

    The thesis's three savings: fewer triangles, smaller textures, no shading.
    """

    name = "model"
    summary = "the client draws a model with a fifth of the triangles into the holes, lit as baked"
    reads = ("shown.colour", "client.model")
    writes = ("shown.colour", "shown.inverse_depth")
    source = "the 2014 thesis's client-side model; Garland and Heckbert 1997, Hoppe 1999 (quadric decimation)"
    complete = True
    Settings = ModelSettings
    variants = ("share=0.05",)

    def prepare(self) -> None:
        chosen = self.settings
        self._model = self.model(chosen.share, lit=chosen.light == "baked", texture=chosen.texture)
        self._model.reserve(self.shown_size)

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        self._model.draw_holes(inputs.middle, picture, into, inputs.shown_ns)
