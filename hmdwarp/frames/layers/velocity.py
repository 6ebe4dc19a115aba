"""How fast each pixel of what deforms moves."""

from __future__ import annotations

from . import VECTORS, Layer, layers


@layers.register
class Velocity(Layer):
    """m/s along the eye's axes (rgb) of what deforms (coverage)."""

    name = "velocity"
    summary = "velocity in m/s of each pixel of what deforms"
    formats = ("rgba16f",)
    codings = (VECTORS,)
    drawn_by = "motion"
