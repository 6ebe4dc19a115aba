"""Facts by which a file was read, each with who says it: shared by traces and recorded frames."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
from typing import TypeVar

import attrs

T = TypeVar("T")


class By(StrEnum):
    """Who says a fact; the first that does is believed."""

    USER = "user"  # by an option
    FILE = "file"
    FORMAT = "format"  # the documents of the format, layout or data set
    MOTION = "motion"
    NOBODY = "nobody"


@attrs.frozen
class Assumption:
    """One fact: a unit, intrinsics, an order of numbers, axes, a clock."""

    what: str
    value: str
    by: By
    option: str = ""  # that states it, as it is typed, such as "--axes"; "" where none does

    @property
    def source(self) -> str:
        """Return who says it, in words, with the option where that is nobody."""
        remedy = f"; {self.option} states it" if self.option and self.by in (By.NOBODY, By.MOTION) else ""
        return f"{'nobody says so' if self.by is By.NOBODY else f'by the {self.by}'}{remedy}"

    def __str__(self) -> str:
        return f"{self.what}: {self.value} ({self.source})"


def assumption_rows(assumptions: Iterable[Assumption]) -> list[dict[str, str]]:
    """Return the list `assumptions` of summary.json and of --json: what, value, by, option."""
    return [attrs.asdict(assumption, value_serializer=lambda _, __, value: str(value)) for assumption in assumptions]


def unstated(assumptions: Iterable[Assumption]) -> list[str]:
    """Return a note on the facts that nobody says; none where there are none."""
    found = [
        f"{assumption.what} {assumption.value}{assumption.option and f' ({assumption.option} states it)'}"
        for assumption in assumptions
        if assumption.by is By.NOBODY
    ]
    return [f"Assumed, as nobody says it: {'; '.join(found)}."] if found else []


def first_stated(*values: T | None) -> tuple[T | None, By]:
    """Return the first value that is there, of user, file and format, and who says it."""
    sources = (By.USER, By.FILE, By.FORMAT)
    return next(((value, by) for value, by in zip(values, sources, strict=True) if value), (None, By.NOBODY))
