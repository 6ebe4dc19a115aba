"""Options of a proxy, a machine near the client that warps for it, and defaults of a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

import attrs

from .. import client
from ..errors import InputError
from ..link import LinkOptions, StageTimes
from ..link.codec import Coding
from ..options import AUTO, DEFAULT_GUARD, Declared, Number, names_in, option, options_of

# Of what colour and depth allow, the most accurate in docs/results.md for its time.
DEFAULT_WARP, DEFAULT_FILL = "iterative", "memory+pyramid"
# Errs short, see docs/results-link.md.
DEFAULT_PREDICTOR = "cautious"
_DEPTH = "rendered.inverse_depth"


def default_fill(warp: str) -> str:
    """Return the default fill of a warp: none where it reads colour alone, to send no depth for it.

    A name that no warp has gets the usual fill; who takes it says what is wrong.
    """
    if warp in (AUTO, DEFAULT_WARP):
        return DEFAULT_FILL
    try:
        chosen = client.parse_warp(warp)
    except InputError:
        return DEFAULT_FILL
    return DEFAULT_FILL if _DEPTH in chosen.entry.reads_for(chosen.settings) else "none"


def default_guard(warp: str) -> float:
    """Return the default guard band of a warp: 1 for none, which shows pictures as drawn."""
    return 1.0 if warp == "none" else DEFAULT_GUARD


def default_predictor(warp: str) -> str:
    """Return the default predictor of a warp: none for none, which shows latency as it is."""
    return "none" if warp == "none" else DEFAULT_PREDICTOR


# Of the whole way, the part before the proxy, where only the whole is given.
_SHARE = 0.75


@attrs.frozen
class ProxyOptions(Declared):
    """A proxy between server and client. Options that are not named here are the client's.

    Errors: InputError for a value out of range.
    """

    heading = "Proxy"
    on: bool = option(
        False,
        "A proxy warps: it gets frames from the server, and sends the client the finished picture for the newest pose "
        "that it knows. --latency, codec, loss and bandwidth are then those of the link to the client.",
        name="proxy",
    )
    # Poses go the other way; as everywhere, the latency is that of both ways together.
    latency_ms: float = option(
        300.0,
        "Milliseconds from drawing a frame on the server to its arrival at the proxy.",
        unit="ms",
        name="proxy_latency",
        valid=Number(),
    )
    warp: str = option(DEFAULT_WARP, f"Warp on the proxy: {names_in('client/warps')}.", name="proxy_warp")
    fill: str = option(
        attrs.Factory(lambda self: default_fill(self.warp), takes_self=True),
        f"Fill on the proxy: {names_in('client/fills')}, or several with +. [default: {DEFAULT_FILL}; none where its "
        "warp reads colour alone]",
        kind=str,
        default=None,
        name="proxy_fill",
    )
    guard: float = option(
        DEFAULT_GUARD,
        "Guard band of the frames from the server, around the picture that the proxy sends.",
        name="proxy_guard",
        valid=Number(least=1.0),
    )
    codec: str = option(
        "none",
        f"Codec between server and proxy, at its own quality: {names_in('link/codec/codecs')}.",
        name="proxy_codec",
    )

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields whose options were set. Errors: InputError for one without a proxy."""
        for offered in options_of(cls):
            if said.get(offered.name) not in (None, offered.default) and not said.get("proxy"):
                raise InputError(
                    f"{offered.flag} {said[offered.name]}: there is no proxy; add --proxy, or leave it out"
                )
        return super().values_of(said)

    def within(self, total_ms: float) -> Self:
        """Return the same proxy on a way of that latency, which it divides as by default: 3 to 1.

        What remains of the total is that of the link to the client.
        """
        return attrs.evolve(self, latency_ms=_SHARE * total_ms)

    @property
    def coding(self) -> Coding:
        """How frames are coded on their way to the proxy."""
        return Coding(self.codec)

    def links(self, network: LinkOptions) -> tuple[LinkOptions, LinkOptions]:
        """Return the link from the server to the proxy, and the one from there to the client.

        The server's rate, and the time that it takes to render, belong to the first; the proxy
        sends a picture at each refresh, and takes the time that it needs. All else is the second's.
        """
        stages = network.response
        first = LinkOptions(
            server_rate_hz=network.server_rate_hz,
            response=None if stages is None else StageTimes(render=stages.render),
        )
        last = attrs.evolve(
            network, server_rate_hz=None, response=None if stages is None else attrs.evolve(stages, render=None)
        )
        return first, last

    def longest_ms(self, network: LinkOptions) -> float:
        """Return how long frames are under way to the proxy at most, 0 without a proxy."""
        first, _ = self.links(network)
        return first.longest_ns(round(self.latency_ms * 1e6)) / 1e6 if self.on else 0.0

    def __str__(self) -> str:
        passes = self.warp if self.fill == "none" else f"{self.warp} + {self.fill}"
        return f"The proxy gets frames {self.latency_ms:g} ms after they were drawn and runs {passes}"
