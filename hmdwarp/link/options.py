"""The network of a run, from the texts of the command line to a link."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import attrs

from ..errors import InputError
from ..options import Declared, Number, Option, option
from .bandwidth import QUEUE_MS, Bandwidth
from .delays import DelayModel, delay_models
from .delays.constant import ConstantDelay
from .link import Link
from .loss import GilbertElliott


def parse_jitter(text: str) -> DelayModel:
    """Parse 'uniform:20'; '' is a constant delay. Errors: InputError."""
    name, _, argument = text.strip().partition(":")
    return delay_models.get(name.strip() or "constant").parse(argument.strip())


def parse_loss(text: str) -> GilbertElliott | None:
    """Parse 'p=0.02,r=0.3,good=0,bad=1', '0.02', 'none' or ''. Errors: InputError."""
    text = text.strip()
    if text in ("", "none"):
        return None
    wanted = "expected p=0.02,r=0.3 (and good=, bad= where they matter), a share such as 0.02, or none"
    if "=" not in text:
        share = _number(text, f"--loss '{text}'", wanted)
        if not 0 <= share <= 1:
            raise InputError(f"--loss '{text}': expected a share of the frames, from 0 to 1")
        return GilbertElliott(share, 1 - share)
    values = _pairs(text.split(","), f"--loss '{text}'", wanted, ("p", "r", "good", "bad"))
    if not {"p", "r"} <= values.keys():
        raise InputError(f"--loss '{text}': {wanted}")
    return GilbertElliott(**values)


def parse_bandwidth(text: str) -> Bandwidth | None:
    """Parse '50', '50,queue=100' or '' for no limit. Errors: InputError."""
    if not text.strip():
        return None
    rate, *more = text.split(",")
    wanted = "expected Mbit/s, such as 50, and the longest wait in ms where it matters, such as 50,queue=100"
    values = _pairs(more, f"--bandwidth '{text}'", wanted, ("queue",))
    return Bandwidth(_number(rate, f"--bandwidth '{text}'", wanted), values.get("queue", QUEUE_MS))


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


_DELAY_TRACE = Option("CSV of delays in ms, in place of the latency.", Path, name="delay_trace")


@attrs.frozen
class LinkOptions(Declared):
    """Delays, losses and bandwidth of the network.

    By default the latency alone.
    """

    # Of each frame.
    delay: DelayModel = option(
        ConstantDelay(),
        "Delays around the latency: uniform:MS or normal:MS (standard deviation); by default none.",
        name="jitter",
        kind=str,
        default="",
        beside=(_DELAY_TRACE,),
        parse=parse_jitter,
    )
    # Loss of frames, in bursts.
    loss: GilbertElliott | None = option(
        None,
        "Lost frames: a share, or bursts like p=0.02,r=0.3 (Gilbert-Elliott); by default none.",
        default="",
        numeric=True,
        parse=parse_loss,
    )
    # Rate and queue of the bottleneck.
    bandwidth: Bandwidth | None = option(
        None,
        "Bandwidth of the link; with ,queue=MS the longest wait before it; by default unlimited.",
        unit="Mbit/s",
        name="bandwidth",
        default="",
        numeric=True,
        parse=parse_bandwidth,
    )
    # The same seed gives the same network, whatever is sent through it.
    seed: int = option(0, "Random seed for jitter and packet loss.", name="link_seed", valid=Number(most=2**63 - 1))

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields whose options were set.

        said: jitter: NAME:MS with a name of delay_models, such as uniform:20, normal:15.
        delay_trace: a file of delays, see `delays.trace`. loss: p=0.02,r=0.3 (and good=, bad=), see
        `GilbertElliott`; a number alone: that share of frames, independently; none. bandwidth:
        Mbit/s, and optionally the longest wait in the queue: 50,queue=100.
        Errors: InputError.
        """
        path = said.get("delay_trace")
        if path is None:
            return super().values_of(said)
        if said.get("jitter"):
            raise InputError(
                f"--jitter '{said['jitter']}' beside --delay-trace: the trace says every delay; leave one of them out"
            )
        return {**super().values_of(said), "delay": delay_models.get("trace").parse(str(path))}

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
        """Return a bound on the frames in transit, of any size, if one is sent each refresh.

        Queued frames were sent within the last queue_ms, one more is being transferred, and the
        delay of the others began within the longest delay; one is about to enter.
        """
        waiting = math.ceil(self.bandwidth.queue_ns * 1e-9 * rate_hz) + 2 if self.bandwidth is not None else 0
        return waiting + math.ceil(self.delay.longest_ns(latency_ns) * 1e-9 * rate_hz) + 2

    def check(self, latency_ns: int) -> None:
        """Check the delays against the latency. Errors: InputError for an impossible network."""
        self.delay.check(latency_ns)

    def delays(self, latency_ns: int) -> Iterator[int]:
        """Yield the delay of each frame in ns. Errors: as `check`."""
        import numpy as np

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
        import numpy as np

        losses = self.loss.samples(np.random.default_rng([self.seed, 1])) if self.loss is not None else None
        return Link(self.delays(latency_ns), losses, self.bandwidth, discard=discard, wasted=wasted, receive=receive)
