"""The link: frames enter when they are drawn, and the newest that has arrived comes out."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Generic, Self, TypeVar

import attrs

from ..base import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike  # help does not wait for it

Payload = TypeVar("Payload")


@attrs.frozen
class TransitStats:
    """How one frame passed through the link."""

    # 0 for the first frame sent.
    number: int
    sent_ns: int
    size_bytes: int = 0  # as the sender declared it
    # Before it was sent; 0 where the latency includes them, like decode_ns.
    render_ns: int = 0
    encode_ns: int = 0
    queue_ns: int = 0  # before the encoder, and before its first bit left
    transfer_ns: int = 0  # from the first bit to the last: its size over the rate
    delay_ns: int = 0  # on the network
    # Until the frames before it arrived and were decoded, where a decoder needs them.
    hold_ns: int = 0
    decode_ns: int = 0

    def parts_ns(self) -> dict[str, int]:
        """Return what it spent its time on, in order."""
        names = {"network": "delay"}
        parts = ("render", "encode", "queue", "transfer", "network", "hold", "decode")
        return {name: getattr(self, f"{names.get(name, name)}_ns") for name in parts}

    @property
    def ready_ns(self) -> int:
        """The instant from which it can be shown."""
        at_server = self.render_ns + self.encode_ns + self.queue_ns
        return self.sent_ns + at_server + self.transfer_ns + self.delay_ns + self.hold_ns + self.decode_ns


@attrs.frozen
class Tally:
    """Counts of frames; every frame drawn is in exactly one field.

    drawn = dropped + sent, sent = lost + undecodable + late + superseded + shown + under_way.
    """

    dropped: int = 0  # the queue at the bottleneck was full
    lost: int = 0  # on the network
    undecodable: int = 0  # arrived, but a frame that it refers to did not
    late: int = 0  # arrived after a newer one was on the screen
    # By the first refresh that could have shown it, a newer one had arrived too.
    superseded: int = 0
    shown: int = 0  # each once, however many refreshes it stayed
    under_way: int = 0  # still in transit at the last refresh

    def as_dict(self) -> dict[str, int]:
        """Return the counts for summary.json.

        drawn: frames passed to the link. sent: those that entered the network. never_shown: drawn
        in vain, without those that may still arrive. Then the fields.
        """
        fields = attrs.asdict(self)
        drawn = sum(fields.values())
        sums = {"drawn": drawn, "sent": drawn - self.dropped, "never_shown": drawn - self.shown - self.under_way}
        return {**sums, **fields}


@attrs.frozen
class ResponseTime:
    """The time that a shown frame took, in ms; the response time is the sum of the parts.

    The display's share (waiting for its refresh) is not included.
    """

    # Measured work for both eyes, like encode, decode and warp.
    render_ms: float = 0.0
    encode_ms: float = 0.0
    queue_ms: float = 0.0  # waiting for earlier frames, at the bottleneck or for the decoder
    transfer_ms: float = 0.0  # size over bandwidth
    # The network's delay from the request for a frame to its arrival, without what its size adds.
    round_trip_ms: float = 0.0
    decode_ms: float = 0.0
    warp_ms: float = 0.0

    @classmethod
    def of(cls, transit: TransitStats, **work_ms: float) -> Self:
        """Return the parts from the frame's transit and the times measured at both ends."""
        queue_ms = (transit.queue_ns + transit.hold_ns) / 1e6
        ways = {"transfer_ms": transit.transfer_ns / 1e6, "round_trip_ms": transit.delay_ns / 1e6}
        return cls(queue_ms=queue_ms, **ways, **work_ms)

    def parts(self) -> dict[str, float]:
        """Return each part by its name, in the order in which they happen."""
        return attrs.asdict(self)


def figures_of_parts(rows: ArrayLike) -> dict[str, float] | None:
    """Return the figures of frames' response times; None where no frame was shown.

    rows: of ResponseTime.parts. The mean of each part and total_ms, the mean of the sums: the parts
    add up to it. Beside them median_ms and p95_ms of the sums, which those of the parts would not
    add up to.
    """
    import numpy as np

    table = np.asarray(rows, dtype=np.float64)
    if not len(table):
        return None
    means, totals = table.mean(axis=0), table.sum(axis=1)
    return {
        **dict(zip(ResponseTime().parts(), map(float, means), strict=True)),
        "total_ms": float(means.sum()),
        "median_ms": float(np.median(totals)),
        "p95_ms": float(np.percentile(totals, 95)),
    }


class Link(Generic[Payload]):
    """Delay and drop frames; return the newest that has arrived, in order of sending.

    A frame is never early, and a newer one that is due is never passed over. Frames may overtake
    each other on the network but not on the screen. When nothing arrives, the last one stays.

    delays: of each frame in ns, 0 or more. losses: whether each is lost; None for none. Both
    advance once a frame, whatever its fate, so that the same seed makes the same network for frames
    of any size.

    receive: the decoder, called with each frame that arrives, in order of sending, because a
    decoder needs the earlier ones; False means undecodable. A frame then waits for them, and a lost
    one counts as missing from the instant it would have arrived. in_order: False where it needs no
    other frames. decoding: how long, in ns, the decoder takes for a frame, one after the other.

    discard: called with each frame that the client received and that can no longer be shown.
    wasted: called with those it never received: dropped and lost ones at once, undecodable ones,
    those in transit at the end; None for `discard`. Each frame goes to one of them, once.

    settled: called once with each frame whose fate is known: the frame, whether the client received
    it, and the instant when the sender hears of that: the news takes as long as the frame, and
    never gets lost. A lost frame is settled when it is sent, before `wasted`; one in transit at the
    end never is.

    Errors: ValueError for times that run backwards and for a negative delay or size, which are
    mistakes of the caller.
    """

    def __init__(
        self,
        delays: Iterator[int],
        losses: Iterator[bool] | None = None,
        bandwidth: Bandwidth | None = None,
        *,
        discard: Callable[[Payload], object] = lambda frame: None,
        wasted: Callable[[Payload], object] | None = None,
        receive: Callable[[Payload], bool] | None = None,
        decoding: Callable[[Payload], int] = lambda frame: 0,
        settled: Callable[[Payload, bool, int], object] = lambda frame, arrived, heard_ns: None,
        in_order: bool = True,
    ) -> None:
        self._has_order = receive is not None and in_order
        self._delays, self._losses, self._bandwidth = delays, losses, bandwidth
        self._discard, self._wasted, self._receive = discard, wasted or discard, receive
        self._decoding, self._settled = decoding, settled
        # When the sender first learns of a loss that no key frame has repaired.
        self._heard_ns: int | None = None
        # Heaps: ready_ns, then number, which is unique. On the network, and in the decoder.
        self._under_way: list[tuple[int, int, TransitStats, Payload]] = []
        self._decoded: list[tuple[int, int, TransitStats, Payload]] = []
        # When encoder, bottleneck and decoder are idle.
        self._encoder_ns = self._decoder_ns = 0
        self._free_ns: int | None = None
        # Like those that arrive: its number, its transit, and the frame.
        self._shown: tuple[int, TransitStats, Payload] | None = None
        self._counts = dict.fromkeys(attrs.fields_dict(Tally), 0)
        self._drawn = self._last_ready_ns = 0
        self._last_sent_ns: int | None = None
        self._last_asked_ns: int | None = None

    def __len__(self) -> int:
        """Return how many frames are held, in transit or shown."""
        return len(self._under_way) + len(self._decoded) + (self._shown is not None)

    def delay_by(self, delays: Iterator[int]) -> None:
        """Use these delays for frames sent from now on."""
        self._delays = delays

    @property
    def tally(self) -> Tally:
        """The fates of all frames so far; readable after `close`."""
        return Tally(**self._counts)

    @property
    def transit(self) -> TransitStats | None:
        """Transit statistics of the shown frame; None before the first."""
        return self._shown[1] if self._shown is not None else None

    def send(
        self,
        frame: Payload,
        now_ns: int,
        size_bytes: int = 0,
        key: bool = True,
        render_ns: int = 0,
        encode_ns: int = 0,
    ) -> TransitStats:
        """Send a frame from the server; return what it will go through, if it gets through.

        size_bytes: as coded. key: whether it can be decoded without those before it. render_ns,
        encode_ns: how long the server works on it from now on; it encodes one after the other.
        """
        if self._last_sent_ns is not None and now_ns < self._last_sent_ns:
            raise ValueError(f"sent at {now_ns} ns after one sent at {self._last_sent_ns} ns")
        delay_ns, is_lost = next(self._delays), self._losses is not None and next(self._losses)
        if min(delay_ns, size_bytes, render_ns, encode_ns) < 0:
            raise ValueError(
                f"a frame of {size_bytes} bytes with a delay of {delay_ns} ns, rendered in {render_ns} ns and "
                f"encoded in {encode_ns} ns"
            )
        waits_ns = max(0, self._encoder_ns - (now_ns + render_ns))
        self._encoder_ns = now_ns + render_ns + waits_ns + encode_ns
        queue_ns, transfer_ns, taken = 0, 0, True
        if (limit := self._bandwidth) is not None:
            queue_ns = 0 if self._free_ns is None else max(0, self._free_ns - self._encoder_ns)
            taken = queue_ns <= limit.queue_ns
            if taken:
                transfer_ns = limit.transfer_ns(size_bytes)
                self._free_ns = self._encoder_ns + queue_ns + transfer_ns
        self._last_sent_ns = now_ns
        queue_ns += waits_ns
        transit = TransitStats(self._drawn, now_ns, size_bytes, render_ns, encode_ns, queue_ns, transfer_ns, delay_ns)
        if self._has_order:  # a decoder needs the frames before it
            hold_ns = max(0, self._last_ready_ns - transit.ready_ns) if transit.number else 0
            transit = attrs.evolve(transit, hold_ns=hold_ns)
            self._last_ready_ns = transit.ready_ns
        self._drawn += 1
        if key:
            self._heard_ns = None
        if taken and not is_lost:
            self._counts["under_way"] += 1
            heapq.heappush(self._under_way, (transit.ready_ns, transit.number, transit, frame))
            return transit
        self._counts["lost" if taken else "dropped"] += 1
        heard_ns = transit.ready_ns + delay_ns
        self._heard_ns = heard_ns if self._heard_ns is None else min(self._heard_ns, heard_ns)
        self._settled(frame, False, heard_ns)
        self._wasted(frame)
        return transit

    def newest(self, now_ns: int) -> Payload | None:
        """Return the newest frame that has arrived by now, None before the first."""
        if self._last_asked_ns is not None and now_ns < self._last_asked_ns:
            raise ValueError(f"asked at {now_ns} ns after {self._last_asked_ns} ns")
        self._last_asked_ns = now_ns
        if arrived := self._arrived(now_ns):
            self._take(arrived)
        return self._shown[2] if self._shown is not None else None

    def needs_key(self, now_ns: int) -> bool:
        """Return whether the sender knows of a missing frame and has sent no key frame since.

        The news takes as long to return as the missing frame would have travelled.
        """
        return self._heard_ns is not None and self._heard_ns <= now_ns

    def close(self) -> None:
        """Pass every frame still held to `wasted` or `discard`; the tally stays."""
        held, shown = sorted([*self._decoded, *self._under_way], key=lambda one: one[:2]), self._shown
        self._under_way, self._decoded, self._shown = [], [], None
        for *_, frame in held:
            self._wasted(frame)
        if shown is not None:
            self._discard(shown[2])

    def _arrived(self, now_ns: int) -> list[tuple[int, TransitStats, Payload]]:
        """Return the frames that have been decoded since the last call, in sending order."""
        while self._under_way and self._under_way[0][0] <= now_ns:
            _, _, transit, frame = heapq.heappop(self._under_way)
            received = self._receive is None or self._receive(frame)
            self._settled(frame, received, transit.ready_ns + transit.delay_ns)
            if not received:
                self._leave("undecodable")
                self._wasted(frame)
                continue
            if decode_ns := self._decoding(frame):
                waits_ns = max(0, self._decoder_ns - transit.ready_ns)
                self._decoder_ns = transit.ready_ns + waits_ns + decode_ns
                transit = attrs.evolve(transit, hold_ns=transit.hold_ns + waits_ns, decode_ns=decode_ns)
            heapq.heappush(self._decoded, (transit.ready_ns, transit.number, transit, frame))
        arrived = []
        while self._decoded and self._decoded[0][0] <= now_ns:
            arrived.append(heapq.heappop(self._decoded)[1:])
        return sorted(arrived)  # no two have the same number

    def _take(self, arrived: list[tuple[int, TransitStats, Payload]]) -> None:
        """Show the newest, which may already be shown; discard the others, oldest first."""
        shown = self._shown
        newer = shown is None or arrived[-1][0] > shown[0]
        if newer:
            self._shown = arrived.pop()
            self._leave("shown")
        for number, *_ in arrived:
            self._leave("late" if shown is not None and number < shown[0] else "superseded")
        leaving = [*arrived, shown] if newer and shown is not None else arrived
        for *_, frame in sorted(leaving):
            self._discard(frame)

    def _leave(self, what: str) -> None:
        self._counts["under_way"] -= 1
        self._counts[what] += 1


# A common buffer size of routers; without a limit, delay and memory would grow for ever.
QUEUE_MS = 250.0


@attrs.frozen
class Bandwidth:
    """The limits of the bottleneck. Errors: InputError for a number out of range.

    A frame that meets a free bottleneck is never dropped, whatever its size.
    """

    mbit: float  # rate in Mbit/s (1e6 bits)
    # A frame that would wait longer than this before its first bit leaves is dropped.
    queue_ms: float = QUEUE_MS

    def __attrs_post_init__(self) -> None:
        if not (math.isfinite(self.mbit) and 1e-3 <= self.mbit <= 1e6):
            raise InputError(
                f"--bandwidth {self.mbit:g} Mbit/s: expected 0.001 to 1000000; leave it out for a link without a limit"
            )
        if not 0 <= self.queue_ms <= 60_000:
            raise InputError(f"--queue {self.queue_ms:g} ms: expected the longest wait of a frame, 0 to 60000 ms")

    @property
    def queue_ns(self) -> int:
        """The longest wait in ns."""
        return round(self.queue_ms * 1e6)

    def transfer_ns(self, size_bytes: int) -> int:
        """Return the time from the first bit to the last."""
        return round(size_bytes * 8e3 / self.mbit)


# Two instants this close are one: replays round theirs to whole nanoseconds.
_SAME_INSTANT_NS = 1000
# A display's rate within this of a multiple of the server's is that multiple.
_SAME_RATE = 1e-3


class Pacer:
    """Say when the server draws: at every n-th refresh if the display's rate is n times its own.

    Otherwise freely, by a clock of its own that starts at the first refresh: between refreshes, and
    several times in one where the server is the faster of the two.

    server_hz: None for the display's rate, which is every refresh.
    """

    def __init__(self, server_hz: float | None, display_hz: float) -> None:
        ratio = display_hz / (server_hz or display_hz)
        self._every = round(ratio) if abs(ratio - round(ratio)) <= _SAME_RATE * ratio and ratio > 0.5 else None
        self._hz = server_hz or display_hz
        # After a stall older instants are passed over, so that the server does not draw them all.
        self._most = math.ceil(self._hz / display_hz) + 1
        self._first_ns: int | None = None
        self._refreshes = self._drawn = 0

    def due(self, now_ns: int) -> list[int]:
        """Return the instants since the last call, oldest first; call it once a refresh."""
        self._refreshes += 1
        if self._every is not None:
            return [now_ns] if (self._refreshes - 1) % self._every == 0 else []
        if self._first_ns is None:
            self._first_ns = now_ns
        count = math.floor((now_ns - self._first_ns + _SAME_INSTANT_NS) * 1e-9 * self._hz) + 1
        first, self._drawn = max(self._drawn, count - self._most), max(self._drawn, count)
        return [min(now_ns, self._first_ns + round(number * 1e9 / self._hz)) for number in range(first, count)]


@attrs.frozen
class GilbertElliott:
    """A network in a good or a bad state.

    Each frame is lost with the probability of the state; then the state may change. It starts in
    the good one. In the long run (r good + p bad) / (p + r) of all frames are lost. r = 1 - p with
    bad = 1 loses each frame independently with probability p. Errors: InputError.
    Source: Gilbert 1960, Capacity of a burst-noise channel; Elliott 1963, Estimates of error rates
    for codes on burst-noise channels.
    """

    p: float  # probability of good to bad after a frame
    r: float  # probability of bad to good after a frame: a bad state lasts 1/r frames on average
    # Share of frames lost in each state.
    good: float = 0.0
    bad: float = 1.0

    def __attrs_post_init__(self) -> None:
        for name, value in attrs.asdict(self).items():
            if not 0 <= value <= 1:  # NaN too
                raise InputError(f"loss with {name}={value:g}: expected a probability from 0 to 1")

    @property
    def mean(self) -> float:
        """The share of frames lost in the long run."""
        return (self.r * self.good + self.p * self.bad) / (self.p + self.r) if self.p else self.good

    def samples(self, rng: np.random.Generator) -> Iterator[bool]:
        """Yield whether each frame is lost, endlessly."""
        is_bad = False
        while True:
            yield bool(rng.random() < (self.bad if is_bad else self.good))
            is_bad = bool(rng.random() < self.p) if not is_bad else not rng.random() < self.r
