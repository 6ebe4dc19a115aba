"""What a client that misses refreshes is given, and what the misses cost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import attrs

from ..errors import InputError

MEASURED = "measured"
SHOWS = (TURNED, STANDS) = ("turned", "stands")
GOVERNED = (ON, BOTH) = ("on", "both")
_WANTED = (
    "expected warp=MS, warp=FILE or warp=measured, and where they matter ,budget=MS and ,show=turned or stands and "
    ",governor=on or both"
)
_MOST_MS = 60_000.0
# The share of stale refreshes among the measured ones may differ by so much without a word.
_ALIKE = 0.05
# Of a refresh: a time of exactly so many periods, given in decimals, is not one refresh more.
_ROUNDING = 1e-6


@attrs.frozen
class Misses:
    """How long the client works on a picture, and what is seen when it is late."""

    # Of both eyes, one for each refresh, repeated when they end; () for as long as it took here.
    times_ms: tuple[float, ...]
    # None for the display's period.
    budget_ms: float | None = None
    # Whether a picture is turned to the newest head at each refresh.
    turns: bool = True
    # Whether the run is beside one that keeps the warp that it began with.
    beside: bool = False

    def refreshes(self, took_ms: float, period_ms: float) -> int:
        """Return at which refresh a picture is first seen; 1 for the one it was to be made for.

        The client begins a period before that one, and hands over at most once in a period.
        """
        budget_ms = self.budget_ms or period_ms
        return 1 + max(0, math.ceil((took_ms - budget_ms) / period_ms - _ROUNDING))


def parse_misses(text: str) -> Misses | None:
    """Parse 'warp=20', 'warp=times.csv,budget=8,show=stands' or 'warp=measured'; '' is None.

    A file has one number of milliseconds a line. Errors: InputError.
    """
    if not text.strip():
        return None
    said: dict[str, str] = {}
    for part in text.split(","):
        name, _, value = (bit.strip() for bit in part.partition("="))
        if name not in ("warp", "budget", "show", "governor") or name in said or not value:
            raise InputError(f"--miss '{text}': {_WANTED}")
        said[name] = value
    show, governor = said.get("show", TURNED), said.get("governor", ON)
    if "warp" not in said or show not in SHOWS or governor not in GOVERNED:
        raise InputError(f"--miss '{text}': {_WANTED}")
    budget_ms = _milliseconds(said["budget"], text) if "budget" in said else None
    if budget_ms is not None and not 0 < budget_ms <= _MOST_MS:
        raise InputError(f"--miss '{text}': budget {said['budget']}: expected a number above 0, at most {_MOST_MS:g}")
    return Misses(_times(said["warp"], text), budget_ms, show == TURNED, governor == BOTH)


def _times(value: str, text: str) -> tuple[float, ...]:
    if value == MEASURED:
        return ()
    try:
        number = float(value)
    except ValueError:
        from ..link.delays.trace import read_delays

        return tuple(read_delays(Path(value), "time"))
    if not 0 <= number <= _MOST_MS:
        raise InputError(f"--miss '{text}': warp {value}: expected 0 to {_MOST_MS:g} ms")
    return (number,)


def _milliseconds(value: str, text: str) -> float:
    try:
        return float(value)
    except ValueError:
        raise InputError(f"--miss '{text}': {_WANTED}") from None


class MissTally:
    """What the misses of a run cost, in bounded memory."""

    def __init__(self) -> None:
        self._refreshes = self._stale = self._longest = self._run = 0
        self._last_deg, self._squares = 0.0, 0.0

    def add(self, stale: bool, off_deg: float) -> None:
        """Add the next refresh.

        stale: whether it showed a picture again. off_deg: the angle between the head that the
        picture was shown for and the head at that refresh.
        """
        if self._refreshes:
            self._squares += (off_deg - self._last_deg) ** 2
        self._last_deg = off_deg
        self._refreshes += 1
        self._stale += stale
        self._run = self._run + 1 if stale else 0
        self._longest = max(self._longest, self._run)

    def as_dict(self) -> dict[str, Any]:
        """Return its part of summary.json, of one refresh at least.

        stale_share: 0..1. longest_stale: refreshes in a row without a new picture. judder_deg: RMS
        of the change of that angle from each refresh to the next; 0 for a single refresh.
        """
        judder = math.sqrt(self._squares / max(1, self._refreshes - 1))
        return {
            "stale_share": self._stale / self._refreshes,
            "longest_stale": self._longest,
            "judder_deg": judder,
        }


def miss_figures(stale: Sequence[bool], off_deg: Sequence[float]) -> dict[str, Any]:
    """Return what the misses of a run cost: as MissTally of these refreshes."""
    tally = MissTally()
    for one, off in zip(stale, off_deg, strict=True):
        tally.add(one, off)
    return tally.as_dict()


def about_misses(entry: dict[str, Any]) -> str:
    """Return the `miss` of summary.json as a sentence or two."""
    how = "was turned to the newest head" if entry["show"] == TURNED else "stood as it was"
    clock = "as measured here, not the same in every run" if entry["times"] == MEASURED else "as given"
    return f"The client misses refreshes: {_told(entry)}. A late picture {how}; the client's times are {clock}."


def about_without(name: str, entry: dict[str, Any]) -> str:
    """Return the `miss` of a run that kept the warp `name` as a sentence."""
    return f"Without the governor, with {name} throughout: {_told(entry)}."


def _told(entry: dict[str, Any]) -> str:
    share, measured = entry["stale_share"], entry["stale_share_measured"]
    of_measured = f" ({100 * measured:.1f} % of the measured ones)" if abs(share - measured) > _ALIKE else ""
    return (
        f"{100 * share:.1f} % showed a picture again{of_measured}, at most {entry['longest_stale']} in a row; "
        f"judder {entry['judder_deg']:.3f} deg RMS"
    )
