"""The numbers that experiments judge, from the figures of a cell's runs."""

from __future__ import annotations

import math
from collections.abc import Sequence

from .experiment import Value
from .run_kinds import Figures

# Shares below this are a few pixels: their ratios say nothing.
LEAST_SHARE = 1e-4


def only(name: str) -> Value:
    """Return the figure of the only run."""

    def value(runs: Sequence[Figures]) -> float | None:
        (run,) = runs
        return run.get(name)

    return value


def change(name: str) -> Value:
    """Return the figure of the last run less that of the first."""

    def value(runs: Sequence[Figures]) -> float | None:
        first, last = runs[0].get(name), runs[-1].get(name)
        return None if first is None or last is None else last - first

    return value


def ratio(name: str, of: str = "") -> Value:
    """Return the figure of the last run over `of`, by default the same figure, of the first."""

    def value(runs: Sequence[Figures]) -> float | None:
        first, last = runs[0].get(of or name), runs[-1].get(name)
        return None if last is None or not first else last / first

    return value


def least_growth(name: str) -> Value:
    """Return the least ratio of a share to that of the run before it."""

    def value(runs: Sequence[Figures]) -> float | None:
        shares = [run.get(name) for run in runs]
        known = [share for share in shares if share is not None and share >= LEAST_SHARE]
        if len(known) < len(shares):
            return None
        return min(after / before for before, after in zip(known, known[1:], strict=False))

    return value


def least_step(name: str) -> Value:
    """Return the least difference of a figure from that of the run before it."""

    def value(runs: Sequence[Figures]) -> float | None:
        found = [run.get(name) for run in runs]
        known = [one for one in found if one is not None]
        if len(known) < len(found):
            return None
        return min(after - before for before, after in zip(known, known[1:], strict=False))

    return value


def closed(left: str, whole: str) -> Value:
    """Return the part of the holes `whole` that the last run does not leave; None for none."""

    def value(runs: Sequence[Figures]) -> float | None:
        there, left_over = runs[-1].get(whole), runs[-1].get(left)
        if there is None or left_over is None or there < LEAST_SHARE:
            return None
        return 1 - left_over / there

    return value


def relative_time(stage: str, to: str, expected: float) -> Value:
    """Return the time of a stage of the last run over `to` of the first, over what is expected.

    1 is the thesis's own ratio.
    """

    def value(runs: Sequence[Figures]) -> float | None:
        found = ratio(f"{stage}_ms", f"{to}_ms")(runs)
        return None if found is None else found / expected

    return value


def growth_exponent(name: str) -> Value:
    """Return n where the figure grows as pixels to the power of n, from first run to last."""

    def value(runs: Sequence[Figures]) -> float | None:
        grown, pixels = ratio(name)(runs), ratio("pixels")(runs)
        return None if not grown or not pixels else math.log(grown) / math.log(pixels)

    return value


def share_of(mbit_s: float) -> Value:
    """Return the rate of the only run's stream over that of a link."""

    def value(runs: Sequence[Figures]) -> float | None:
        rate = only("full_size_mbit_s")(runs)
        return None if rate is None else rate / mbit_s

    return value


def not_known(runs: Sequence[Figures]) -> float | None:
    """Return None: the program has no such thing."""
    return None
