"""Facts by which a file was read, each with who says it: shared by traces and recorded frames."""

from __future__ import annotations

from enum import StrEnum
from typing import TypeVar

import attrs

T = TypeVar("T")


class By(StrEnum):
    """Who says a fact; the first that does is believed."""

    OPTION = "option"
    FILE = "file"
    LAYOUT = "layout"  # that of the format or data set


@attrs.frozen
class Assumption:
    """One fact: a unit, intrinsics, an order of numbers, axes, a clock."""

    what: str
    value: str
    by: By


def first_stated(*values: T | None) -> tuple[T | None, By]:
    """Return the first value that is there, of those of By in their order, and who says it."""
    return next(((value, by) for value, by in zip(values, By, strict=True) if value), (None, By.LAYOUT))
