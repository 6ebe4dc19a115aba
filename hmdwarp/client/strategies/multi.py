"""Several depth images: those that the client has anyway."""

from __future__ import annotations

from . import Strategy, strategies


@strategies.register
class Multi(Strategy):
    """The other eye and older frames cost no traffic."""

    name = "multi"
    summary = "the client warps several pictures with depth, the other eye's and older ones, and composites them"
    crosses = "colour and depth"
    client = "warps several pictures and keeps the nearest"
    late = "what was hidden from all of them"
    classes = (3,)
    source = "the 2014 thesis, section 3.5"
    warp = "multi"
