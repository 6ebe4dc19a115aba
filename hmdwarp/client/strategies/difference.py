"""Difference image: the client draws a simplified scene, the server sends what it lacks."""

from __future__ import annotations

from . import Strategy, strategies


@strategies.register
class Difference(Strategy):
    """`difference:warped=off` is the source's own form, as late as an imposter."""

    name = "difference"
    summary = "the server sends what the full picture has more than a simplified scene, which the client draws"
    crosses = "the difference of two pictures"
    client = "draws a simplified scene at the newest pose, adds the difference"
    late = "detail; what the late picture did not see stays simplified"
    classes = (2, 3)
    source = "Levoy 1995, Polygon-Assisted JPEG and MPEG Compression of Synthetic Images"
    warp = "difference"
    fill = "none"
