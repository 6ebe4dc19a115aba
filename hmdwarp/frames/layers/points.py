"""Points of the scene's surfaces for a client that keeps them."""

from __future__ import annotations

import attrs

from . import Delivered, layers


@attrs.frozen(order=True)
class Cloud:
    """Points that are delivered little by little."""

    # Bytes of each frame, at most, before they are packed.
    budget: int = 60_000
    # Points that the client has room for.
    room: int = 1 << 20
    # Distance of points in pixels of the shown picture, where all have arrived.
    spacing: float = 1.0


@layers.register
class Points(Delivered):
    """A PointUpdate for each Cloud. The amount is the frozenset of them."""

    name = "points"
    summary = "new points of the surfaces that the head may see, packed: what lacks most first"
    drawn_by = "points"
    something = frozenset({Cloud()})
