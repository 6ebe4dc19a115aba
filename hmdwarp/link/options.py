"""The network of a run, from the texts of the command line to a link."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import attrs

from ..base import Declared, InputError, Number, Option, one_of, option
from .delays import ConstantDelay, DelayModel, delay_models
from .link import QUEUE_MS, Bandwidth, GilbertElliott, Link

ALL, CHANGES = "all", "changes"
FIXED, SUM = "fixed", "sum"


def _jitter(text: str) -> DelayModel:
    name, _, argument = text.strip().partition(":")
    return delay_models.get(name.strip() or "constant").parse(argument.strip())


def _loss(text: str) -> GilbertElliott | None:
    if text.strip() in ("", "none"):
        return None
    expected = "expected a share of the frames, from 0 to 1, or none; bursts have an option of their own, --loss-burst"
    wrong = InputError(f"--loss '{text}': {expected}")
    share = _number(text, wrong)
    if not 0 <= share <= 1:
        raise wrong
    return GilbertElliott(0, 1, good=share)  # each frame alone, the first too


def _bandwidth(text: str) -> Bandwidth | None:
    expected = "expected Mbit/s, such as 50; the longest wait before it has an option of its own, --queue"
    return Bandwidth(_number(text, InputError(f"--bandwidth '{text}': {expected}"))) if text.strip() else None


def _number(text: str, wrong: InputError) -> float:
    try:
        return float(text.encode("ascii"))
    except ValueError:
        raise wrong from None


_DELAY_TRACE = Option("CSV of delays in ms, in place of the latency.", Path, name="delay_trace")
_LOSS_BURST = Option(
    "Mean number of frames lost in a row (Gilbert-Elliott); by default each is lost independently.",
    float,
    name="loss_burst",
    metavar="FRAMES",
)
_QUEUE = Option(
    f"Milliseconds that a frame waits at most before the bandwidth; by default {QUEUE_MS:g}. Later ones are dropped.",
    float,
    name="queue",
    metavar="MS",
)


@attrs.frozen
class LinkOptions(Declared):
    """Delays, losses and bandwidth of the network, and which frames the server sends through it.

    By default the latency alone, and a frame for each refresh.
    """

    heading = "Link"
    # Of each frame.
    delay: DelayModel = option(
        ConstantDelay(),
        "Delays around the latency: uniform:MS or normal:MS (standard deviation); by default none.",
        name="jitter",
        kind=str,
        default="",
        beside=(_DELAY_TRACE,),
        parse=_jitter,
    )
    loss: GilbertElliott | None = option(
        None,
        "Share of the frames that is lost, such as 0.02; by default none.",
        default="",
        metavar="SHARE",
        numeric=True,
        beside=(_LOSS_BURST,),
        parse=_loss,
    )
    # Rate and queue of the bottleneck.
    bandwidth: Bandwidth | None = option(
        None,
        "Bandwidth of the link in Mbit/s; by default unlimited.",
        unit="Mbit/s",
        name="bandwidth",
        default="",
        metavar="MBIT",
        numeric=True,
        beside=(_QUEUE,),
        parse=_bandwidth,
    )
    # The same seed gives the same network, whatever is sent through it.
    seed: int = option(0, "Random seed for jitter and packet loss.", name="link_seed", valid=Number(most=2**63 - 1))
    response: str = option(
        FIXED,
        "fixed: a picture is as old as the latency says; sum: rendering, encoding and decoding come on top, as "
        "measured.",
        valid=one_of(FIXED, SUM),
    )
    # None for the display's own. See Pacer.
    server_rate_hz: float | None = option(
        None,
        "Frames that the server draws per second; by default one for each refresh.",
        valid=Number(least=0.1, most=1000),
    )
    send: str = option(
        ALL,
        "all frames; or changes: only where something moved by itself, or by half a pixel as the head did.",
        valid=one_of(ALL, CHANGES),
    )

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields whose options were set. Errors: InputError."""
        values, path = super().values_of(said), said.get("delay_trace")
        burst, queue_ms = said.get("loss_burst"), said.get("queue")
        if path is not None:
            if said.get("jitter"):
                raise InputError(
                    f"--jitter '{said['jitter']}' beside --delay-trace: the trace says every delay; leave one of them "
                    "out"
                )
            values["delay"] = delay_models.get("trace").parse(str(path))
        if burst is not None:
            if values.get("loss") is None:
                raise InputError(
                    f"--loss-burst {burst:g} without --loss: expected the share of the frames that is lost too"
                )
            values["loss"] = _in_bursts(values["loss"].mean, burst)
        if queue_ms is not None:
            if values.get("bandwidth") is None:
                raise InputError(
                    f"--queue {queue_ms:g} ms without --bandwidth: expected that too, as nothing waits without a limit"
                )
            values["bandwidth"] = attrs.evolve(values["bandwidth"], queue_ms=queue_ms)
        return values

    @property
    def is_plain(self) -> bool:
        """Whether every frame takes exactly the latency and arrives."""
        return attrs.evolve(self, seed=0, server_rate_hz=None, send=ALL) == LinkOptions()

    def longest_ns(self, latency_ns: int) -> int:
        """Return a bound on the time from drawing to arrival.

        Without the transfer of bytes, and without stages whose time is measured.
        """
        waiting_ns = self.bandwidth.queue_ns if self.bandwidth is not None else 0
        return self.delay.longest_ns(latency_ns) + waiting_ns

    def most_under_way(self, latency_ns: int, rate_hz: float) -> int:
        """Return a bound on the frames in transit, of any size, if one is sent each refresh.

        Queued frames were sent within the last queue_ms, one more is being transferred, and the
        delay of the others began within the longest delay; one is about to enter.
        """
        waiting = math.ceil(self.bandwidth.queue_ns * 1e-9 * rate_hz) + 2 if self.bandwidth is not None else 0
        return waiting + math.ceil(self.delay.longest_ns(latency_ns) * 1e-9 * rate_hz) + 2

    def delays(self, latency_ns: int) -> Iterator[int]:
        """Yield the delay of each frame in ns. Errors: as DelayModel.check."""
        import numpy as np

        self.delay.check(latency_ns)
        return self.delay.samples(latency_ns, np.random.default_rng([self.seed, 0]))

    def link(self, latency_ns: int, **how: Any) -> Link[Any]:
        """Return a new link through this network. how: what Link calls. Errors: as `delays`."""
        import numpy as np

        losses = self.loss.samples(np.random.default_rng([self.seed, 1])) if self.loss is not None else None
        return Link(self.delays(latency_ns), losses, self.bandwidth, **how)


def _in_bursts(mean: float, frames: float) -> GilbertElliott:
    """Return a network that loses the share `mean` of all frames, so many in a row on average."""
    if not 1 <= frames <= 1e6:
        raise InputError(f"--loss-burst {frames:g}: expected 1 to 1000000 frames")
    most = frames / (frames + 1)
    if mean > most:
        raise InputError(
            f"--loss {mean:g} with --loss-burst {frames:g}: expected a share of at most {most:.3g}, as a frame "
            "arrives between two bursts; use longer bursts or a smaller share"
        )
    return GilbertElliott(mean / (frames * (1 - mean)), 1 / frames)
