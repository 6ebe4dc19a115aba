"""Proxy: a machine near the client warps, and the client shows the finished picture."""

from __future__ import annotations

from typing import Any

from ...errors import InputError
from . import Strategy, strategies

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
