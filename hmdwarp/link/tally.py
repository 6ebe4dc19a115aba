"""What became of each frame, so that none is lost without a word."""

from __future__ import annotations

import attrs


@attrs.frozen
class Tally:
    """Counts of frames; every frame drawn is in exactly one of those that have no sum.

    drawn = dropped + sent, sent = lost + undecodable + late + superseded + shown + under_way.

    dropped: the queue at the bottleneck was full. lost: on the network. undecodable: arrived, but what its coding builds on did not.
    late: a newer one had been on the screen before it came. superseded: by the first refresh that could have shown it a newer one was
    there too. shown: each once, however many refreshes it stayed. under_way: not there yet at the last refresh.
    """

    dropped: int = 0
    lost: int = 0
    undecodable: int = 0
    late: int = 0
    superseded: int = 0
    shown: int = 0
    under_way: int = 0

    @property
    def sent(self) -> int:
        """Frames that the network took."""
        return self.lost + self.undecodable + self.late + self.superseded + self.shown + self.under_way

    @property
    def drawn(self) -> int:
        """Frames handed to the link."""
        return self.dropped + self.sent

    def as_dict(self) -> dict[str, int]:
        """For summary.json: drawn, sent, then what became of them."""
        return {"drawn": self.drawn, "sent": self.sent, **attrs.asdict(self)}


@attrs.frozen
class TransitStats:
    """How one frame came through, all in ns: queue_ns before its first bit went, transfer_ns from the first to the last (its size over
    the rate), delay_ns on the network, hold_ns until the frames before it had come too, where those are needed.

    number: 0 for the first frame handed to the link. size_bytes: as the sender said.
    """

    number: int
    sent_ns: int
    size_bytes: int = 0
    queue_ns: int = 0
    transfer_ns: int = 0
    delay_ns: int = 0
    hold_ns: int = 0

    @property
    def ready_ns(self) -> int:
        """When it can be shown."""
        return self.sent_ns + self.queue_ns + self.transfer_ns + self.delay_ns + self.hold_ns
