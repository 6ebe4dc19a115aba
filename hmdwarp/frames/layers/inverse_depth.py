"""How far each pixel of the picture is."""

from __future__ import annotations

from . import Layer, layers


@layers.register
class InverseDepth(Layer):
    """1/m along the eye's -z; 0 is infinitely far, -1 a hole."""

    name = "inverse_depth"
    summary = "inverse depth of the rendered picture in 1/m, -1 in holes"
    formats = ("r32f",)
    always = True
