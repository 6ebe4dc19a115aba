"""Facts by which a file was read, each with who says it: shared by traces and recorded frames."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
from typing import TypeVar

import attrs

from .options import Euler

T = TypeVar("T")


class By(StrEnum):
    """Who says a fact; the first that does is believed."""

    USER = "user"  # by an option
    FILE = "file"
    FORMAT = "format"  # the documents of the format, layout or data set
    DEFAULT = "default"


Fact = StrEnum("Fact", "COLUMNS ORIENTATION POSE LENGTH AXES UP CLOCK")  # what is assumed of a trace
DIRECTION = ("world from head", "head from world")  # of poses as they are, and of inverse ones


@attrs.frozen
class Assumption:
    """One fact: a unit, intrinsics, an order of numbers, axes, a clock."""

    what: str
    value: str
    by: By
    option: str = ""  # that states it, as it is typed, such as "--axes"; "" where none does

    @property
    def source(self) -> str:
        """Return who says it, in words, with the option where it is a default."""
        remedy = f"; set with {self.option}" if self.option and self.by is By.DEFAULT else ""
        return f"{'default' if self.by is By.DEFAULT else f'by the {self.by}'}{remedy}"

    def __str__(self) -> str:
        return f"{self.what}: {self.value} ({self.source})"


def assumption_rows(assumptions: Iterable[Assumption]) -> list[dict[str, str]]:
    """Return the list `assumptions` of summary.json and of --json: what, value, by, option."""
    return [attrs.asdict(assumption, value_serializer=lambda _, __, value: str(value)) for assumption in assumptions]


def unstated(assumptions: Iterable[Assumption]) -> list[str]:
    """Return a note on the facts that are assumed; none where there are none."""
    found = [
        f"{assumption.what} {assumption.value}{assumption.option and f' (override with {assumption.option})'}"
        for assumption in assumptions
        if assumption.by is By.DEFAULT
    ]
    return [f"Assumed (not stated in the files): {'; '.join(found)}."] if found else []


def first_stated(*values: T | None) -> tuple[T | None, By]:
    """Return the first value that is there, of user, file and format, and who says it."""
    sources = (By.USER, By.FILE, By.FORMAT)
    return next(((value, by) for value, by in zip(values, sources, strict=True) if value), (None, By.DEFAULT))


# Who says what axes a file has, in words.
AXES_BY = {
    By.USER: "as --axes says", By.FILE: "stated by the file", By.FORMAT: "by the format", By.DEFAULT: "assumed",
}  # fmt: skip


@attrs.frozen
class Defect:
    """One kind of defect in a file and its repair: nothing is dropped or changed silently."""

    kind: str  # a stable identifier for programs
    what: str  # a description for people
    done: str  # the repair
    count: int = 1
    line: int | None = None  # the first line concerned, from 1

    def __str__(self) -> str:
        place = "" if self.line is None else f" (line {self.line}{' first' if self.count > 1 else ''})"
        return f"{self.what}{place}: {self.done}"


@attrs.frozen
class Layout:
    """Which columns to read, their meaning, and who says so."""

    time: int | None  # column index
    # columns of x y z w; with `matrix` nine numbers row by row; with `euler` its angles
    orientation: tuple[int, ...]
    matrix: str = ""  # how its numbers were ordered, in words; "": none
    euler: Euler | None = None
    rest: int | None = None  # column that completes the clock: what is over whole seconds
    rest_unit: str = "ns"  # a key of `times.UNITS_NS`
    position: tuple[int, int, int] | None = None  # columns of x y z
    # columns of x y z of a direction in the head's axes, or of x y z w of one's turn in the world
    gaze: tuple[int, ...] = ()
    columns_by: By = By.FILE
    order_by: By = By.FILE  # of the numbers of an orientation
    unit: str | None = None  # a key of `times.UNITS_NS`, or None to guess
    unit_by: By = By.FILE  # where there is one
    device: int | None = None  # column that identifies the device of each row
    axes: str = "openxr"  # what `parse_axes` takes
    axes_by: By = By.DEFAULT
    gravity_down: tuple[float, ...] = (0.0, 0.0, 0.0)  # down in the file's world; zeros: it does not say
    scale: float = 1.0  # metres per unit
    scale_by: By = By.DEFAULT
    inverse: bool = False  # poses are head from world
    direction_by: By = By.DEFAULT
    clock_ignored: bool = False  # --trace-rate replaces the time column
    caveats: tuple[Defect, ...] = ()  # defects of every file of the format

    @property
    def order(self) -> str:
        return "".join(part for _, part in sorted(zip(self.orientation, "xyzw", strict=True)))
