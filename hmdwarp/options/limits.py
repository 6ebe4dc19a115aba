"""Limits of an option's value: validators for attrs fields, and the names that registries offer."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

import attrs

from ..errors import InputError, listed

_PACKAGE = Path(__file__).resolve().parent.parent


def names_in(folder: str, pattern: str = "*.py", without: Collection[str] = ()) -> str:
    """Return the entries of a registry for a help text.

    Reads file names alone, so that --help imports nothing.
    """
    names = (p.stem for p in (_PACKAGE / folder).glob(pattern) if not p.stem.startswith("_"))
    return ", ".join(sorted(name for name in names if name not in without))


def _as_float(value: float) -> float:
    """Return infinity for a whole number that is too large."""
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


@attrs.frozen
class Number:
    """Check that a value, or each of a tuple, is None, or finite and within the limits.

    Errors: InputError.
    """

    least: float = 0.0
    most: float = math.inf
    # Whether the lower limit is exclusive.
    above: bool = False

    def words(self, unit: str = "") -> str:
        """Return the limits in words, for errors and tables."""
        least = f"{'above' if self.above else 'of at least'} {self.least:g}{unit}"
        return f"{least} and at most {self.most:g}{unit}" if math.isfinite(self.most) else least

    def __call__(self, _: object, field: attrs.Attribute[Any], value: Any) -> None:
        for number in value if isinstance(value, tuple) else (value,):
            if number is None:
                continue
            found = _as_float(number)
            least_met = found > self.least if self.above else found >= self.least
            if not (math.isfinite(found) and found <= self.most and least_met):
                name, unit = _name_of(field)
                kind = "a number" if math.isfinite(self.most) else "a finite number"
                if any(declared.kind is int for declared in field.metadata.get("options", ())[:1]):
                    kind = "a whole number"
                raise InputError(f"{name} {found:g}{unit}: expected {kind} {self.words(unit)}")


def _name_of(field: attrs.Attribute[Any]) -> tuple[str, str]:
    """Return the name and unit (" ms") by which the user knows a field."""
    declared = field.metadata.get("options", ())
    if not declared:
        return field.name, ""
    unit = f" {declared[0].unit}" if declared[0].unit else ""
    return declared[0].named(field.name).flag, unit


def one_of(*known: str) -> Callable[[object, attrs.Attribute[Any], str | None], None]:
    """Return a validator that raises InputError for any text not in the list; None is left out."""

    def check(_: object, field: attrs.Attribute[Any], value: str | None) -> None:
        if value is not None and value not in known:
            raise InputError(f"{_name_of(field)[0]} '{value}': expected {listed(known, 'or')}")

    return check
