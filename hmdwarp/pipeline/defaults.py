"""Defaults of a run that depend on its warp."""

from __future__ import annotations

from .. import client
from ..errors import InputError
from ..options import AUTO, DEFAULT_GUARD

# Of what colour and depth allow, the most accurate in docs/results.md for its time.
DEFAULT_WARP, DEFAULT_FILL = "iterative", "memory+pyramid"
# Errs short, see docs/results-link.md.
DEFAULT_PREDICTOR = "cautious"
_DEPTH = "rendered.inverse_depth"


def default_fill(warp: str) -> str:
    """Return the default fill of a warp: none where it reads colour alone, to send no depth for it.

    A name that no warp has gets the usual fill; who takes it says what is wrong.
    """
    if warp in (AUTO, DEFAULT_WARP):
        return DEFAULT_FILL
    try:
        chosen = client.parse_warp(warp)
    except InputError:
        return DEFAULT_FILL
    return DEFAULT_FILL if _DEPTH in chosen.entry.reads_for(chosen.settings) else "none"


def default_guard(warp: str) -> float:
    """Return the default guard band of a warp: 1 for none, which shows pictures as drawn."""
    return 1.0 if warp == "none" else DEFAULT_GUARD


def default_predictor(warp: str) -> str:
    """Return the default predictor of a warp: none for none, which shows latency as it is."""
    return "none" if warp == "none" else DEFAULT_PREDICTOR
