"""The time from a head's motion to the picture that responds to it, by parts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Self

import attrs

from .tally import TransitStats

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


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
    return figures_of_parts([list(one.parts().values()) for one in times])


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
