"""The time from a head's motion to the picture that answers it, by its parts."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median
from typing import Self

import attrs

from .tally import TransitStats


@attrs.frozen
class ResponseTime:
    """What a shown frame took, in ms; the response time is the sum of the parts.

    render, encode, decode, warp: measured work, of both eyes. round_trip: the network's delay, from asking for a frame to its
    arrival, without what its size adds. transfer: size over bandwidth. queue: waiting for frames before it, at the bottleneck or for
    the decoder. What the display adds (waiting for its refresh) is none of these.
    """

    render_ms: float = 0.0
    encode_ms: float = 0.0
    queue_ms: float = 0.0
    transfer_ms: float = 0.0
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
        """From how the frame came through the link and what was measured at both ends."""
        queue_ms = (transit.queue_ns + transit.hold_ns) / 1e6
        return cls(
            render_ms, encode_ms, queue_ms, transit.transfer_ns / 1e6, transit.delay_ns / 1e6, decode_ms, warp_ms
        )

    @property
    def total_ms(self) -> float:
        return sum(self.parts().values())

    def parts(self) -> dict[str, float]:
        """Each part by its name, in the order in which they happen."""
        return attrs.asdict(self)


def medians(times: Sequence[ResponseTime]) -> dict[str, float] | None:
    """The median of each part and of the totals (which is not the sum of the parts' medians); None where no frame was shown."""
    if not times:
        return None
    out = {name: median(getattr(one, name) for one in times) for name in ResponseTime().parts()}
    return {**out, "total_ms": median(one.total_ms for one in times)}
