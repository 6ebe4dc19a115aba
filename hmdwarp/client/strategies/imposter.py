"""Imposter: the finished picture, shown as it is."""

from __future__ import annotations

from . import Strategy, strategies


@strategies.register
class Imposter(Strategy):
    """What a video stream does without any compensation."""

    name = "imposter"
    summary = "the server sends the finished picture, and the client shows it"
    crosses = "colour"
    client = "shows the picture"
    late = "everything"
    classes = (1, 2, 3)
    source = "the 2014 thesis, section 3.2"
    warp = "none"
    fill = "none"
