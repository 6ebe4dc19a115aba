"""The network of a run, from the texts of the command line to a link."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import attrs

from ..errors import InputError
from ..options import Declared, Number, Option, one_of, option
from .delays import ConstantDelay, DelayModel, delay_models
from .link import QUEUE_MS, Bandwidth, GilbertElliott, Link

ALL, CHANGES = "all", "changes"
DROP, RESOLUTION = "drop", "resolution"
_MOST_MS = 60_000.0


@attrs.frozen
class StageTimes:
    """The time of each stage for a frame of the full resolution, in ms; None for what it took here.

    Errors: InputError for a number out of range.
    """

    render: float | None = None
    encode: float | None = None
    decode: float | None = None

    def __attrs_post_init__(self) -> None:
        for name, given in attrs.asdict(self).items():
            if given is not None and not 0 <= given <= _MOST_MS:
                raise InputError(f"response {name}={given:g}: expected 0 to {_MOST_MS:g} ms")

    def taken_ns(self, measured_ms: Mapping[str, float], share: float) -> Iterator[int]:
        """Yield what each stage takes, in their order.

        measured_ms: by name; 0 where nothing was measured. share: of the pixels of the full
        resolution; given times are in proportion.
        """
        for name, given in attrs.asdict(self).items():
            yield round((measured_ms.get(name, 0.0) if given is None else given * share) * 1e6)


def _response(text: str) -> StageTimes | None:
    """Parse 'sum', 'sum:render=8,encode=5,decode=measured'; 'fixed' or '' is None.

    With one time given, stages that are not named take none.
    """
    wrong = InputError(
        f"--response '{text}': expected fixed, sum, or sum:render=8,encode=5,decode=4 with milliseconds, or measured, "
        "for each"
    )
    name, colon, rest = (bit.strip() for bit in text.partition(":"))
    if name in ("", "fixed") and not colon:
        return None
    if name != "sum":
        raise wrong
    if not colon:
        return StageTimes()
    times: dict[str, float | None] = dict.fromkeys(attrs.fields_dict(StageTimes), 0.0)
    said = set[str]()
    for part in rest.split(","):
        stage, _, value = (bit.strip() for bit in part.partition("="))
        if stage not in times or stage in said:
            raise wrong
        said.add(stage)
        times[stage] = None if value == "measured" else _number(value, wrong)
    return StageTimes(**times)


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
    # What adds to a frame's way besides the network; None: the latency is all of it.
    response: StageTimes | None = option(
        None,
        "fixed: a picture is as old as the latency says; sum: rendering, encoding and decoding come on top, as "
        "measured, or as in sum:render=8,encode=5,decode=4.",
        default="fixed",
        parse=_response,
    )
    # None for the display's own. See Pacer.
    server_rate_hz: float | None = option(
        None,
        "Frames that the server draws per second; by default one for each refresh.",
        valid=Number(least=0.1, most=1000),
    )
    send: str = option(
        ALL,
        "all frames; or changes: only those in which something moved by more than half a pixel.",
        valid=one_of(ALL, CHANGES),
    )
    # See Overload.
    overload: str = option(
        DROP,
        "Where frames cannot keep up: drop some of them; or resolution: lower it first.",
        valid=one_of(DROP, RESOLUTION),
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
        return attrs.evolve(self, seed=0, server_rate_hz=None, send=ALL, overload=DROP) == LinkOptions()

    def overload_at(self, display_hz: float) -> Overload | None:
        """Return what lowers the resolution, None where frames are dropped."""
        if self.overload == DROP:
            return None
        queue_ms = self.bandwidth.queue_ms if self.bandwidth is not None else QUEUE_MS
        return Overload(round(1e9 / self.sends_hz(display_hz)), round(queue_ms * 1e6))

    def sends_hz(self, display_hz: float) -> float:
        """Return the server's rate for this display."""
        return self.server_rate_hz or display_hz

    def longest_ns(self, latency_ns: int) -> int:
        """Return a bound on the time from drawing to arrival.

        Without the transfer of bytes, and without stages whose time is measured.
        """
        waiting_ns = self.bandwidth.queue_ns if self.bandwidth is not None else 0
        return self.delay.longest_ns(latency_ns) + self._given_ns + waiting_ns

    def typical_ns(self, latency_ns: int) -> int:
        """Return the mean time, without queue, transfer and stages whose time is measured."""
        return self.delay.typical_ns(latency_ns) + self._given_ns

    @property
    def _given_ns(self) -> int:
        given = attrs.astuple(self.response) if self.response is not None else ()
        return sum(round(ms * 1e6) for ms in given if ms is not None)

    def most_under_way(self, latency_ns: int, rate_hz: float) -> int:
        """Return a bound on the frames in transit, of any size, if one is sent each refresh.

        Queued frames were sent within the last queue_ms, one more is being transferred, and the
        delay of the others began within the longest delay; one is about to enter.
        """
        waiting = math.ceil(self.bandwidth.queue_ns * 1e-9 * rate_hz) + 2 if self.bandwidth is not None else 0
        longest_ns = self.delay.longest_ns(latency_ns) + self._given_ns
        return waiting + math.ceil(longest_ns * 1e-9 * rate_hz) + 2

    def check(self, latency_ns: int) -> None:
        """Check the delays against the latency, and the options against each other.

        Errors: InputError for an impossible network, and for an overload that cannot come.
        """
        if self.overload == RESOLUTION and self.bandwidth is None and self.response is None:
            raise InputError(f"--overload {RESOLUTION}: nothing can be overloaded; give --bandwidth or --response sum")
        self.delay.check(latency_ns)

    def delays(self, latency_ns: int) -> Iterator[int]:
        """Yield the delay of each frame in ns. Errors: as `check`."""
        import numpy as np

        self.check(latency_ns)
        return self.delay.samples(latency_ns, np.random.default_rng([self.seed, 0]))

    def link(self, latency_ns: int, **how: Any) -> Link[Any]:
        """Return a new link through this network. how: what Link calls. Errors: as `check`."""
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


# Of the full resolution, along each axis: 1, 0.64, 0.42 and 0.25 of its pixels.
SCALES = (1.0, 0.8, 0.65, 0.5)
# After so long without a wait it is tried higher; longer after each attempt that failed.
_PATIENCE_NS, _MOST_PATIENCE_NS = 1_000_000_000, 16_000_000_000
# The slowest stage may take this share of a period at the higher resolution.
_ROOM = 0.8


class Overload:
    """Lower the resolution as soon as a frame has to wait for the one before, and raise it later.

    Down: one step when a frame waits for longer than a period (or half the longest queue, if that
    is less), so before frames are dropped, or when the server is still busy at an instant. What
    already waits gets the time to leave before the next step, unless the wait grows on.

    Up: one step after a second without a wait, if the slowest stage is expected to have room for
    more pixels. After each step up that had to be taken back the patience doubles, to 16 s at most.

    period_ns: of the server. queue_ns: the longest wait at the bottleneck.
    """

    def __init__(self, period_ns: int, queue_ns: int) -> None:
        self.period_ns, self.queue_ns = period_ns, queue_ns
        self.changes = self._level = 0
        # No step down before this instant, unless frames wait for longer than this.
        self._settled_ns: int | None = None
        self._waited_ns = 0
        # Since when nothing has waited, and when it was last raised.
        self._clear_ns: int | None = None
        self._raised_ns: int | None = None
        self._patience_ns = _PATIENCE_NS

    @property
    def scale(self) -> float:
        """The share of the full width and height that the next frame has."""
        return SCALES[self._level]

    def sent(self, now_ns: int, waits_ns: int, slowest_ns: int) -> None:
        """Note how long a frame of the present scale waits, and the time of its slowest stage."""
        if waits_ns > min(self.period_ns, self.queue_ns // 2):
            self.lower(now_ns, waits_ns)
        elif waits_ns:
            self._clear_ns = None
        elif self._clear_ns is None:
            self._clear_ns = now_ns
        elif now_ns - self._clear_ns >= self._patience_ns and self._level:
            grown = SCALES[self._level - 1] / self.scale
            if slowest_ns * grown * grown <= _ROOM * self.period_ns:
                self._raised_ns = self._clear_ns = now_ns
                self._level, self.changes = self._level - 1, self.changes + 1

    def lower(self, now_ns: int, waits_ns: int) -> None:
        """Go down a step, as a frame or the server at that instant has to wait for so long."""
        self._clear_ns = None
        is_settling = self._settled_ns is not None and now_ns < self._settled_ns
        if self._level + 1 == len(SCALES) or (is_settling and waits_ns <= self._waited_ns):
            return
        if self._raised_ns is not None and now_ns - self._raised_ns < self._patience_ns:
            self._patience_ns = min(2 * self._patience_ns, _MOST_PATIENCE_NS)
        self._raised_ns = None
        self._settled_ns, self._waited_ns = now_ns + waits_ns + self.period_ns, waits_ns
        self._level, self.changes = self._level + 1, self.changes + 1


def scaled_size(size: tuple[int, int], scale: float) -> tuple[int, int]:
    """Return (w, h) at a scale, at least one pixel each."""
    return max(1, math.floor(size[0] * scale + 0.5)), max(1, math.floor(size[1] * scale + 0.5))
