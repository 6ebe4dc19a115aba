"""The picture itself."""

from __future__ import annotations

from . import Layer, layers


@layers.register
class Colour(Layer):
    """Linear light with coverage in alpha; a hole is (0, 0, 0, 0)."""

    name = "colour"
    summary = "the rendered picture: linear light, coverage in alpha"
    formats = ("rgba16f",)
    always = True
