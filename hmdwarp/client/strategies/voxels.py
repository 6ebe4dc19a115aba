"""Voxels: finished pictures, lit from a grid of voxels that all users of a server share."""

from __future__ import annotations

from typing import Any

from . import Strategy, strategies


@strategies.register
class Voxels(Strategy):
    """For scenes whose light moves. Warp and fill are free; settings are those of the light."""

    name = "voxels"
    summary = (
        "the server sends a picture with depth, lit from a grid of voxels that all its users share, and the client "
        "warps it; --warp and --fill say how; at none of nine measured settings nearer than a late picture"
    )
    crosses = "colour and depth; colour alone for a warp that reads no depth"
    client = "shows the picture, or warps it and fills the holes"
    late = "what was hidden, and all light"
    classes = (1, 2, 3)
    source = "Crassin et al. 2013, CloudLight"
    warp = ""

    @classmethod
    def options(cls, settings: str) -> dict[str, Any]:
        """Return the options of a run that it sets. settings: of the light."""
        return {"indirect": f"{cls.name}:{settings}" if settings else cls.name}
