"""The network of a run, from the texts of the command line to a link."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Self

import attrs
import numpy as np

from ..errors import InputError
from .bandwidth import QUEUE_MS, Bandwidth
from .delays import DelayModel, delay_models
from .delays.constant import ConstantDelay
from .link import Link
from .loss import GilbertElliott

_MOST_SEED = 2**63


@attrs.frozen
class LinkOptions:
    """A network: how long frames take, which are lost, how much fits through.

    By default the latency alone.
    """

    delay: DelayModel = attrs.field(factory=ConstantDelay)
    loss: GilbertElliott | None = None
    bandwidth: Bandwidth | None = None
    # Random seed of jitter and loss; the same one makes the same network, whatever is sent through
    # it.
    seed: int = 0

    def __attrs_post_init__(self) -> None:
        if not 0 <= self.seed < _MOST_SEED:
            raise InputError(f"seed {self.seed}: wanted a whole number, 0 or more")

    @classmethod
    def parse(
        cls, *, jitter: str = "", delay_trace: Path | None = None, loss: str = "", bandwidth: str = "", seed: int = 0
    ) -> Self:
        """Return the network that the texts of the options describe, "" or None for the default.

        jitter: NAME:MS with a name of delay_models, such as uniform:20, normal:15. delay_trace: a
        file of delays, see `delays.trace`. loss: p=0.02,r=0.3 (and good=, bad=), see
        `GilbertElliott`; a number alone: that share of frames, independently; none. bandwidth:
        Mbit/s, and the longest wait in the queue where it matters: 50,queue=100. Errors:
        InputError.
        """
        if delay_trace is not None and jitter:
            raise InputError(
                f"jitter '{jitter}' beside a delay trace: the trace says every delay; leave one of them out"
            )
        delay = delay_models.get("trace").parse(str(delay_trace)) if delay_trace is not None else parse_jitter(jitter)
        return cls(delay, parse_loss(loss), parse_bandwidth(bandwidth), seed)

    @property
    def is_plain(self) -> bool:
        """Whether every frame takes exactly the latency and arrives."""
        return attrs.evolve(self, seed=0) == LinkOptions()

    def longest_ns(self, latency_ns: int) -> int:
        """Return a bound on the time from sending to arrival, without the transfer of bytes."""
        return self.delay.longest_ns(latency_ns) + (self.bandwidth.queue_ns if self.bandwidth is not None else 0)

    def typical_ns(self, latency_ns: int) -> int:
        """Return the mean delay, without queue and transfer."""
        return self.delay.typical_ns(latency_ns)

    def most_under_way(self, latency_ns: int, rate_hz: float) -> int:
        """Return a bound on the frames under way, of any size, if one is sent each refresh.

        Those that wait came within the last queue_ms, one more is being transferred, and the delay
        of the others began within the longest delay; one is about to enter.
        """
        waiting = math.ceil(self.bandwidth.queue_ns * 1e-9 * rate_hz) + 2 if self.bandwidth is not None else 0
        return waiting + math.ceil(self.delay.longest_ns(latency_ns) * 1e-9 * rate_hz) + 2

    def check(self, latency_ns: int) -> None:
        """Check the delays against the latency. Errors: InputError for an impossible network."""
        self.delay.check(latency_ns)

    def delays(self, latency_ns: int) -> Iterator[int]:
        """Yield the delay of each frame in ns. Errors: as `check`."""
        self.check(latency_ns)
        return self.delay.samples(latency_ns, np.random.default_rng([self.seed, 0]))

    def link(
        self,
        latency_ns: int,
        discard: Callable[[Any], None] = lambda frame: None,
        wasted: Callable[[Any], None] | None = None,
        receive: Callable[[Any], bool] | None = None,
    ) -> Link:
        """Return a new link through this network; see `Link` for the callbacks.

        Errors: as `check`.
        """
        losses = self.loss.samples(np.random.default_rng([self.seed, 1])) if self.loss is not None else None
        return Link(self.delays(latency_ns), losses, self.bandwidth, discard=discard, wasted=wasted, receive=receive)


def parse_jitter(text: str) -> DelayModel:
    """Parse 'uniform:20'; '' is a constant delay. Errors: InputError."""
    name, _, argument = text.strip().partition(":")
    return delay_models.get(name.strip() or "constant").parse(argument.strip())


def parse_loss(text: str) -> GilbertElliott | None:
    """Parse 'p=0.02,r=0.3,good=0,bad=1', '0.02', 'none' or ''. Errors: InputError."""
    text = text.strip()
    if text in ("", "none"):
        return None
    wanted = "wanted p=0.02,r=0.3 (and good=, bad= where they matter), a share such as 0.02, or none"
    if "=" not in text:
        share = _number(text, f"loss '{text}'", wanted)
        if not 0 <= share <= 1:
            raise InputError(f"loss '{text}': wanted a share of the frames, from 0 to 1")
        return GilbertElliott(share, 1 - share)
    values = _pairs(text.split(","), f"loss '{text}'", wanted, ("p", "r", "good", "bad"))
    if not {"p", "r"} <= values.keys():
        raise InputError(f"loss '{text}': {wanted}")
    return GilbertElliott(**values)


def parse_bandwidth(text: str) -> Bandwidth | None:
    """Parse '50', '50,queue=100' or '' for no limit. Errors: InputError."""
    if not text.strip():
        return None
    rate, *more = text.split(",")
    wanted = "wanted Mbit/s, such as 50, and the longest wait in ms where it matters, such as 50,queue=100"
    values = _pairs(more, f"bandwidth '{text}'", wanted, ("queue",))
    return Bandwidth(_number(rate, f"bandwidth '{text}'", wanted), values.get("queue", QUEUE_MS))


def _pairs(parts: list[str], found: str, wanted: str, names: tuple[str, ...]) -> dict[str, float]:
    out: dict[str, float] = {}
    for part in parts:
        name, _, value = (bit.strip() for bit in part.partition("="))
        if name not in names or name in out:
            raise InputError(f"{found}: {wanted}")
        out[name] = _number(value, found, wanted)
    return out


def _number(text: str, found: str, wanted: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{found}: {wanted}") from None
