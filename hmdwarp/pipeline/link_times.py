"""Latency in refreshes: how old frames are when they are seen, and how many exist at once."""

from __future__ import annotations

import math

from ..frames import EyeSizes, Needs
from ..gpu.context import Gpu
from ..link import LinkOptions
from .options import PipelineOptions
from .sizes import check_room

# A latency within this of a whole number of refreshes counts as that number: 16.67 ms is one
# refresh at 60 Hz, not a little more.
_SAME_REFRESH = 1e-3


def latency_ns(options: PipelineOptions) -> int:
    """Return the motion-to-photon latency that the options set."""
    return round(options.latency_ms * 1e6)


def refreshes_of(latency_ms: float, rate_hz: float) -> int:
    """Return how many refreshes after drawing a frame is shown: the first one after it arrives."""
    return math.ceil(latency_ms * 1e-3 * rate_hz - _SAME_REFRESH)


def frames_held(options: PipelineOptions, rate_hz: float, needs: Needs) -> int:
    """Return the largest number of frames alive at once, as held_over does."""
    return held_over(options.client_link, options.latency_ms, rate_hz, needs)


def held_over(link: LinkOptions, latency_ms: float, rate_hz: float, needs: Needs) -> int:
    """Return the largest number of frames alive at once over a link.

    Counts frames in transit, the one shown, the one being drawn, and the older ones that warps
    read.
    """
    sends_hz = link.sends_hz(rate_hz)
    if link.is_plain:
        # Those sent since the refresh before, less the latency.
        return refreshes_of(latency_ms + 1e3 / rate_hz, sends_hz) + 1 + needs.others.past
    return link.most_under_way(round(latency_ms * 1e6), sends_hz) + 2 + needs.others.past


def expected_age_ns(options: PipelineOptions, plain_ns: int, rate_hz: float) -> int:
    """Return the mean age of a frame when it is seen, as age_over_ns does."""
    return age_over_ns(options.client_link, options.latency_ms, plain_ns, rate_hz)


def age_over_ns(link: LinkOptions, latency_ms: float, plain_ns: int, rate_hz: float) -> int:
    """Return the mean age of a frame over a link when it is seen.

    plain_ns: the age over a link that only delays, of a frame drawn at a refresh.
    """
    stays_ns = max(0.0, 1e9 / link.sends_hz(rate_hz) - 1e9 / rate_hz)
    newest_ns = plain_ns if link.is_plain else link.typical_ns(round(latency_ms * 1e6))
    return newest_ns + round(stays_ns / 2)


def check_held(gpu: Gpu, options: PipelineOptions, needs: Needs, sizes: EyeSizes, rate_hz: float) -> None:
    """Check that the largest number of frames alive at once fits. Errors: as check_room."""
    check_room(gpu, needs, sizes, options.guard_band, frames_held(options, rate_hz, needs), options.latency_ms)
