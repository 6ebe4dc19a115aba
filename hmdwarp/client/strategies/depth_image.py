"""Depth image: one picture with depth, which the client warps."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...errors import InputError
from ..variants import parse_warp
from . import Strategy, strategies

_DEPTH = "rendered.inverse_depth"


@strategies.register
class DepthImage(Strategy):
    """What a run does unless another strategy is chosen; warp and fill are free."""

    name = "depth_image"
    summary = "the server sends a picture with depth, and the client warps it; --warp and --fill say how"
    crosses = "colour and depth; layers of effects"
    client = "warps the picture and fills the holes"
    late = "what was hidden"
    classes = (2, 3)
    source = "the 2014 thesis, section 3.4"
    warp = ""

    @classmethod
    def check(cls, said: Mapping[str, Any]) -> None:
        """Check that the warp reads depth. Errors: as parse_warp; InputError if it does not."""
        if said.get("warp") in (None, "auto"):
            return
        warp = parse_warp(said["warp"])
        if _DEPTH not in warp.entry.reads_for(warp.settings):
            raise InputError(
                f"--strategy {cls.name} with --warp {warp}: that warp reads no depth; choose a warp that does, or "
                "leave --strategy out"
            )
