"""The fates of frames."""

from __future__ import annotations

import attrs


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
