"""Model: the client has the scene and draws it."""

from __future__ import annotations

from . import Strategy, strategies


@strategies.register
class Model(Strategy):
    """Whole, reduced (`model:share=0.2`), or progressively (`model:arrives=progressive`)."""

    name = "model"
    summary = "the client has the scene, whole, reduced or as it arrives, and draws it; no picture is sent"
    crosses = "the scene: once, or in pieces, what is seen first"
    client = "draws the scene at the newest pose"
    late = "nothing but what has not arrived"
    classes = (3,)
    source = "the 2014 thesis, section 3.1 (GLX, partial models)"
    warp = "model"
    fill = "none"
