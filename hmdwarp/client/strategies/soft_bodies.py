"""Soft bodies: what deforms is drawn by the client, the rest is a warped picture."""

from __future__ import annotations

from . import Strategy, strategies


@strategies.register
class SoftBodies(Strategy):
    """In a scene where nothing deforms it is a depth image."""

    name = "soft_bodies"
    summary = "the server sends a picture with depth; the client warps it, and draws what deforms as it is now"
    crosses = "colour and depth; the deforming meshes once"
    client = "warps the picture, draws what deforms in the picture's light"
    late = "what was hidden, and light"
    classes = (2, 3)
    source = "the 2014 thesis, section 7"
    warp = "iterative"
    more = {"effects": "soft_bodies"}
