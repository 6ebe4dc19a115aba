"""Strategies that check or read their own settings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...base import InputError
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
    published = (
        "MeshWarp with a field of view of 120 degrees in 4K: about 246 Mbit/s (Lu and Rowe 2025, QUASAR, Robot "
        "Lab, 60 Hz); OpenWarp: under 2 % more power than TimeWarp, and preferred by people (XRgo, MMSys 2025)"
    )
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


CLIENTS = ("none", "rotation")


@strategies.register
class Proxy(Strategy):
    """Two links in series; `proxy:client=rotation` for a client that turns the picture."""

    name = "proxy"
    summary = (
        "a proxy near the client gets pictures with depth and warps them for the newest pose that it knows; the client "
        "shows its picture, or turns it (proxy:client=rotation)"
    )
    crosses = "colour, depth and layers of effects to the proxy, from there colour"
    client = "shows the picture, or turns it as the head has turned"
    late = "everything, by the second link alone; what was hidden, by both"
    classes = (1,)
    source = "Yoo 2010, as told by the 2014 thesis"
    warp = CLIENTS[0]
    fill = "none"
    more = {"proxy": True}

    @classmethod
    def options(cls, settings: str) -> dict[str, Any]:
        """Return the options of a run that it sets. settings: '' or 'client=rotation'."""
        key, _, client = (part.strip() for part in (settings or f"client={cls.warp}").partition("="))
        if key != "client" or client not in CLIENTS:
            raise InputError(
                f"strategy '{cls.name}:{settings}': expected client={' or client='.join(CLIENTS)}; what the proxy does "
                "say --proxy-latency, --proxy-warp and --proxy-fill"
            )
        return {**super().options(""), "warp": client}
