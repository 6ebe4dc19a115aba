"""The time from a head's motion to the picture that responds to it, by parts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Self

import attrs

from ..errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike  # help does not wait for it


@attrs.frozen
class ResponseTime:
    """The time that a shown frame took, in ms; the response time is the sum of the parts.

    The display's share (waiting for its refresh) is not included.
    """

    # Measured work for both eyes, like encode, decode and warp.
    render_ms: float = 0.0
    encode_ms: float = 0.0
    # Waiting for earlier frames, at the bottleneck or for the decoder.
    queue_ms: float = 0.0
    # Size over bandwidth.
    transfer_ms: float = 0.0
    # The network's delay from the request for a frame to its arrival, without what its size adds.
    round_trip_ms: float = 0.0
    decode_ms: float = 0.0
    warp_ms: float = 0.0

    @classmethod
    def of(
        cls,
        transit: TransitStats,
        *,
        render_ms: float = 0.0,
        encode_ms: float = 0.0,
        decode_ms: float = 0.0,
        warp_ms: float = 0.0,
    ) -> Self:
        """Return the parts from the frame's transit and the times measured at both ends."""
        queue_ms = (transit.queue_ns + transit.hold_ns) / 1e6
        return cls(
            render_ms, encode_ms, queue_ms, transit.transfer_ns / 1e6, transit.delay_ns / 1e6, decode_ms, warp_ms
        )

    @property
    def total_ms(self) -> float:
        """The response time."""
        return sum(self.parts().values())

    def parts(self) -> dict[str, float]:
        """Return each part by its name, in the order in which they happen."""
        return attrs.asdict(self)


def response_figures(times: Sequence[ResponseTime]) -> dict[str, float] | None:
    """Return the figures of frames' response times; None where no frame was shown.

    The mean of each part and total_ms, the mean of the sums: the parts add up to it. Beside them
    median_ms and p95_ms of the sums, which those of the parts would not add up to.
    """
    return figures_of_parts([list(time.parts().values()) for time in times])


def figures_of_parts(rows: ArrayLike) -> dict[str, float] | None:
    """Return response_figures of rows with the parts in their order."""
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


MEASURED = "measured"
_MOST_MS = 60_000.0
_WANTED = "expected fixed, sum, or sum:render=8,encode=5,decode=4 with milliseconds, or measured, for each"


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

    @property
    def given_ns(self) -> int:
        """The sum of those that are given."""
        return sum(round(given * 1e6) for given in attrs.astuple(self) if given is not None)

    def taken_ns(self, measured_ms: Mapping[str, float], share: float) -> Iterator[int]:
        """Yield what each stage takes, in their order.

        measured_ms: by name; 0 where nothing was measured. share: of the pixels of the full
        resolution; given times are in proportion.
        """
        for name, given in attrs.asdict(self).items():
            yield round((measured_ms.get(name, 0.0) if given is None else given * share) * 1e6)


def parse_response(text: str) -> StageTimes | None:
    """Parse 'sum', 'sum:render=8,encode=5,decode=measured'; 'fixed' or '' is None.

    With one time given, stages that are not named take none. Errors: InputError.
    """
    name, colon, rest = (bit.strip() for bit in text.partition(":"))
    if name in ("", "fixed") and not colon:
        return None
    if name != "sum":
        raise InputError(f"--response '{text}': {_WANTED}")
    if not colon:
        return StageTimes()
    times: dict[str, float | None] = dict.fromkeys(attrs.fields_dict(StageTimes), 0.0)
    said = set[str]()
    for part in rest.split(","):
        stage, _, value = (bit.strip() for bit in part.partition("="))
        if stage not in times or stage in said:
            raise InputError(f"--response '{text}': {_WANTED}")
        said.add(stage)
        try:
            times[stage] = None if value == MEASURED else float(value.encode("ascii"))
        except ValueError:
            raise InputError(f"--response '{text}': {_WANTED}") from None
    return StageTimes(**times)


@attrs.frozen
class Tally:
    """Counts of frames; every frame drawn is in exactly one field.

    drawn = dropped + sent, sent = lost + undecodable + late + superseded + shown + under_way.
    """

    # The queue at the bottleneck was full.
    dropped: int = 0
    # On the network.
    lost: int = 0
    # Arrived, but a frame that it refers to did not.
    undecodable: int = 0
    # Arrived after a newer one was on the screen.
    late: int = 0
    # By the first refresh that could have shown it, a newer one had arrived too.
    superseded: int = 0
    # Each once, however many refreshes it stayed.
    shown: int = 0
    # Still in transit at the last refresh.
    under_way: int = 0

    @property
    def sent(self) -> int:
        """Frames that entered the network."""
        return self.lost + self.undecodable + self.late + self.superseded + self.shown + self.under_way

    @property
    def drawn(self) -> int:
        """Frames passed to the link."""
        return self.dropped + self.sent

    @property
    def never_shown(self) -> int:
        """Frames that were drawn in vain, without those that may still arrive."""
        return self.drawn - self.shown - self.under_way

    def as_dict(self) -> dict[str, int]:
        """Return the counts for summary.json: drawn, sent, never_shown, then the fields."""
        return {"drawn": self.drawn, "sent": self.sent, "never_shown": self.never_shown, **attrs.asdict(self)}


@attrs.frozen
class TransitStats:
    """How one frame passed through the link."""

    # 0 for the first frame sent.
    number: int
    sent_ns: int
    # As the sender declared it.
    size_bytes: int = 0
    # Before it was sent; 0 where the latency includes them, like decode_ns.
    render_ns: int = 0
    encode_ns: int = 0
    # Before the encoder, and before its first bit left.
    queue_ns: int = 0
    # From the first bit to the last: its size over the rate.
    transfer_ns: int = 0
    # On the network.
    delay_ns: int = 0
    # Until the frames before it arrived and were decoded, where a decoder needs them.
    hold_ns: int = 0
    decode_ns: int = 0

    def parts_ns(self) -> dict[str, int]:
        """Return what it spent its time on, in order."""
        return {
            "render": self.render_ns,
            "encode": self.encode_ns,
            "queue": self.queue_ns,
            "transfer": self.transfer_ns,
            "network": self.delay_ns,
            "hold": self.hold_ns,
            "decode": self.decode_ns,
        }

    @property
    def ready_ns(self) -> int:
        """The instant from which it can be shown."""
        return self.sent_ns + sum(self.parts_ns().values())
