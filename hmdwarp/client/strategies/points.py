"""Points: the client keeps points of what was seen, and projects them."""

from __future__ import annotations

from . import Strategy, strategies


@strategies.register
class Points(Strategy):
    """What is on the client is never late; what comes into view first has to cross."""

    name = "points"
    summary = "the server sends new points of what the head may see; the client keeps and projects all of them"
    crosses = "points of surfaces, each once"
    client = "projects its points as discs at the newest pose, fills the cracks"
    late = "what was not sent yet"
    classes = (3,)
    source = "the 2014 thesis, section 3.1 [14]"
    warp = "points"
    fill = "pyramid"
