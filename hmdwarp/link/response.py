"""The time from a head's motion to the picture that responds to it, by parts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import attrs

from .tally import TransitStats


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


def medians(times: Sequence[ResponseTime]) -> dict[str, float] | None:
    """Return the median of each part and of the totals, None if no frame was shown.

    The median total is not the sum of the parts' medians.
    """
    if not times:
        return None
    from statistics import median  # not at the top: --help reads this package's options

    out = {name: median(getattr(one, name) for one in times) for name in ResponseTime().parts()}
    return {**out, "total_ms": median(one.total_ms for one in times)}
