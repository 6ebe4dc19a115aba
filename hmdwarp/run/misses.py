"""What a client that misses refreshes is given, and what the misses cost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import attrs

from ..errors import InputError
from ..link.delays.trace import read_delays
from ..options import Declared, Number, one_of, option

MEASURED = "measured"
SHOWS = (TURNED, STANDS) = ("turned", "stands")  # in summary.json
ON_MISS = (TURN, HOLD) = ("turn", "hold")
_MOST_MS = 60_000.0
# The share of stale refreshes among the measured ones may differ by so much without a word.
_ALIKE = 0.05
# Of a refresh: a time of exactly so many periods, given in decimals, is not one refresh more.
_ROUNDING = 1e-6


def parse_client_time(text: str) -> tuple[float, ...] | None:
    """Parse '20', 'times.csv' or 'measured'; '' is None, measured is ().

    A file has one number of milliseconds a line. Errors: InputError.
    """
    text = text.strip()
    if not text:
        return None
    if text == MEASURED:
        return ()
    try:
        number = float(text)
    except ValueError:
        if not Path(text).suffix and not Path(text).exists():
            raise InputError(
                f"--client-time '{text}': expected milliseconds, a CSV file of them, or {MEASURED}"
            ) from None
        return tuple(read_delays(Path(text), "time"))
    if not 0 <= number <= _MOST_MS:
        raise InputError(f"--client-time {text}: expected 0 to {_MOST_MS:g} ms")
    return (number,)


@attrs.frozen
class Misses(Declared):
    """How long the client works on a picture, and what is seen when it is late."""

    heading = "A client that is late"
    # Of both eyes, one for each refresh, repeated when they end; () for as long as it takes here,
    # None for a client that is always in time.
    times_ms: tuple[float, ...] | None = option(
        None,
        "Milliseconds that the client takes for a picture: a number, a CSV file with one for each refresh, or "
        "measured. By default it is never late.",
        name="client_time",
        default="",
        parse=parse_client_time,
    )
    # None for the display's period.
    budget_ms: float | None = option(
        None,
        "Milliseconds that the client has for a picture; by default a refresh.",
        name="client_budget",
        valid=Number(above=True, most=_MOST_MS),
    )
    on_miss: str = option(
        TURN,
        "What a late client shows: turn its last picture to the newest head, or hold it as it was.",
        valid=one_of(*ON_MISS),
    )
    compare_governor: bool = option(
        False, "With --client-time and --warp auto: also run without the governor, and compare the two."
    )

    def __attrs_post_init__(self) -> None:
        set_without = {
            "--client-budget": self.budget_ms is not None,
            "--on-miss": self.on_miss != TURN,
            "--compare-governor": self.compare_governor,
        }
        for name, is_set in set_without.items():
            if is_set and not self.on:
                raise InputError(f"{name} without --client-time: the client is always in time then")

    @property
    def on(self) -> bool:
        """Whether the client takes time at all."""
        return self.times_ms is not None

    @property
    def turns(self) -> bool:
        """Whether a late picture is turned to the newest head at each refresh."""
        return self.on_miss == TURN

    def refreshes(self, took_ms: float, period_ms: float) -> int:
        """Return at which refresh a picture is first seen; 1 for the one it was to be made for.

        The client begins a period before that one, and hands over at most once in a period.
        """
        budget_ms = self.budget_ms or period_ms
        return 1 + max(0, math.ceil((took_ms - budget_ms) / period_ms - _ROUNDING))


class MissTally:
    """What the misses of a run cost, in bounded memory."""

    def __init__(self) -> None:
        self._refreshes = self._stale = self._longest = self._run = 0
        self._last_deg, self._squares = 0.0, 0.0

    def add(self, stale: bool, off_deg: float) -> None:
        """Add the next refresh.

        stale: whether it showed a picture again. off_deg: the angle by which things were seen off
        their place.
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
