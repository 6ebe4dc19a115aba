"""Environment map: everything around the eye, in which the head turns freely."""

from __future__ import annotations

from . import Strategy, strategies


@strategies.register
class Environment(Strategy):
    """The eye may turn by any angle without a border coming into view."""

    name = "environment"
    summary = "the server sends a cube map around the eye, and the client looks into it"
    crosses = "a cube map"
    client = "turns the cube map"
    late = "where the head is; which way it looks is not"
    classes = (1, 2, 3)
    source = "the 2014 thesis, section 3.3; Chen 1995, QuickTime VR"
    warp = "environment"
    fill = "none"
