"""Indirect light of the whole scene."""

from __future__ import annotations

from typing import Any

from ...scenes import ATLAS
from . import BRIGHT_VIDEO, OWN, EyeSizes, Layer, layers


@layers.register
class Irradiance(Layer):
    """The light atlas of the surfaces: what each gets from the others and the sky.

    The amount is how many times a second it changes at most; every frame has the newest whole.
    """

    name = "irradiance"
    summary = "indirect light of all surfaces in one light atlas, whatever the eye sees"
    formats = ("rgba16f",)
    codings = (BRIGHT_VIDEO,)
    size_class = OWN
    drawn_by = "irradiance"
    per_frame = True
    # It is lit for the first frame of each update.
    builds_on_frames = True
    something = 10.0

    @classmethod
    def size(cls, sizes: EyeSizes) -> tuple[int, int]:
        return ATLAS

    @classmethod
    def pictures(cls, amount: Any) -> tuple[str, ...]:
        return cls.formats
