"""Verdicts on claims: computed from one number for each setting by a stated rule."""

from __future__ import annotations

import enum
import math
from collections.abc import Iterable, Sequence
from typing import Protocol

import attrs


class Verdict(enum.Enum):
    """What the numbers say of a claim."""

    HOLDS = "holds"
    CONDITIONS = "holds under conditions"
    FAILS = "does not hold"
    UNKNOWN = "cannot be told"


class Rule(Protocol):
    """A test of one number."""

    def holds(self, value: float) -> bool:
        """Return whether the claim holds for the number."""
        ...

    def words(self, unit: str, scale: float) -> str:
        """Return the rule for a number that is written in `unit`, `scale` times the stored one."""
        ...


@attrs.frozen
class AtMost:
    """The number is `limit` or less."""

    limit: float

    def holds(self, value: float) -> bool:
        return value <= self.limit

    def words(self, unit: str, scale: float) -> str:
        return f"at most {_number(self.limit, unit, scale)}"


@attrs.frozen
class AtLeast:
    """The number is `limit` or more."""

    limit: float

    def holds(self, value: float) -> bool:
        return value >= self.limit

    def words(self, unit: str, scale: float) -> str:
        return f"at least {_number(self.limit, unit, scale)}"


@attrs.frozen
class Between:
    """The number lies from `low` to `high`, both included."""

    low: float
    high: float

    def holds(self, value: float) -> bool:
        return self.low <= value <= self.high

    def words(self, unit: str, scale: float) -> str:
        return f"from {_number(self.low, '', scale)} to {_number(self.high, unit, scale)}"


def _number(value: float, unit: str, scale: float) -> str:
    return f"{value * scale:g} {unit}".strip()


@attrs.frozen
class Finding:
    """The number of one setting, and whether the claim holds there."""

    row: str
    column: str
    # None where nothing could be measured; then `holds` is None too.
    value: float | None
    holds: bool | None

    @classmethod
    def of(cls, row: str, column: str, value: float | None, rule: Rule) -> Finding:
        """Judge a number; NaN and infinity count as not measured."""
        known = value if value is not None and math.isfinite(value) else None
        return cls(row, column, known, None if known is None else rule.holds(known))


def verdict_of(findings: Iterable[Finding]) -> Verdict:
    """Return the verdict: settings without a number do not count."""
    judged = {finding.holds for finding in findings if finding.holds is not None}
    if not judged:
        return Verdict.UNKNOWN
    if len(judged) == 2:
        return Verdict.CONDITIONS
    return Verdict.HOLDS if True in judged else Verdict.FAILS


def settings_text(findings: Sequence[Finding], holds: bool | None) -> str:
    """Return the settings whose findings are so, as in "sideways 0.25 m/s (200, 400 ms); rotate".

    The columns of a row are named unless all of them are so; rows with the same columns share them.
    "" where there are none.
    """
    all_columns: dict[str, list[str]] = {}
    columns: dict[str, list[str]] = {}
    for finding in findings:
        all_columns.setdefault(finding.row, []).append(finding.column)
        if finding.holds is holds:
            columns.setdefault(finding.row, []).append(finding.column)
    rows_of: dict[tuple[str, ...], list[str]] = {}
    for row, found in columns.items():
        named = () if found == all_columns[row] else tuple(found)
        rows_of.setdefault(named, []).append(row)
    return "; ".join(_together(rows) + (f" ({_together(named)})" if named else "") for named, rows in rows_of.items())


def _together(texts: Sequence[str]) -> str:
    """Join texts like "a 1 m" and "a 2 m" to "a 1, 2 m": what neighbours share is said once."""
    groups: list[tuple[str, str, list[str]]] = []
    for text in texts:
        words = text.split(" ")
        for at in range(len(words)):
            head, tail = " ".join(words[:at]), " ".join(words[at + 1 :])
            if groups and groups[-1][:2] == (head, tail) and _is_number(words[at]) and _is_number(groups[-1][2][0]):
                groups[-1][2].append(words[at])
                break
        else:
            at = next((place for place, word in enumerate(words) if _is_number(word)), 0)
            groups.append((" ".join(words[:at]), " ".join(words[at + 1 :]), [words[at]]))
    return " and ".join(" ".join(filter(None, (head, ", ".join(middle), tail))) for head, tail, middle in groups)


def _is_number(text: str) -> bool:
    return text.removesuffix("%").replace(".", "", 1).isdigit()
