"""What is fixed to the head."""

from __future__ import annotations

from . import SHOWN, Layer, layers


@layers.register
class Overlay(Layer):
    """Premultiplied light of what is fixed to the head, for the shown field of view and size."""

    name = "overlay"
    summary = "what is fixed to the head, as a picture of its own that is never warped"
    formats = ("rgba16f",)
    size_class = SHOWN
    drawn_by = "overlay"
    apart = True
