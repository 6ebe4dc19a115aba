"""Rotation: the finished picture, turned as the head has turned."""

from __future__ import annotations

from . import Strategy, strategies


@strategies.register
class Rotation(Strategy):
    """What headsets call reprojection or timewarp without depth."""

    name = "rotation"
    summary = "the server sends the finished picture, and the client turns it as the head has turned"
    crosses = "colour"
    client = "turns the picture"
    late = "where the head is; which way it looks is not"
    classes = (1, 2, 3)
    source = "van Waveren 2016, The Asynchronous Time Warp for Virtual Reality on Consumer Hardware"
    warp = "rotation"
    fill = "none"
