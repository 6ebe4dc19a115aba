"""Layered depth image: behind each surface the next one, from the same view."""

from __future__ import annotations

from . import Strategy, strategies


@strategies.register
class Layered(Strategy):
    """What was hidden behind one surface comes along."""

    name = "layered"
    summary = "the server sends the surfaces behind the first ones too, and the client warps all of them"
    crosses = "colour and depth of several layers of one view"
    client = "warps the layers and keeps the nearest"
    late = "what was hidden behind all layers"
    classes = (3,)
    source = "the 2014 thesis, section 3.5; Shade et al. 1998, Layered Depth Images"
    warp = "layered"
