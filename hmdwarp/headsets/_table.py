"""A TOML table that is asked for each key by its type, and says by its full name which one is wrong."""

from __future__ import annotations

import math

from ..errors import InputError


class Table:
    """`data` as tomllib gives it; `prefix` is where it lies in the file ("panel."). Errors: InputError naming the key."""

    def __init__(self, data: object, prefix: str = "") -> None:
        if not isinstance(data, dict):
            raise InputError(f"{prefix.rstrip('.')} is {data!r}: wanted a table of keys")
        self._data, self._prefix = data, prefix
        self._read: dict[str, Table | None] = {}

    def __contains__(self, key: str) -> bool:
        return key in self._data

    def table(self, key: str) -> Table:
        """The table inside this one, the same object each time."""
        value = self._get(key)
        if self._read[key] is None:
            self._read[key] = Table(value, f"{self._prefix}{key}.")
        return self._read[key]  # type: ignore[return-value]

    def text(self, key: str) -> str:
        """A text that is not empty."""
        value = self._get(key)
        if not isinstance(value, str) or not value.strip():
            raise InputError(f"{self._prefix}{key} is {value!r}: wanted a text")
        return value

    def number(self, key: str) -> float:
        """A finite number."""
        value = self._get(key)
        if not _is_number(value):
            raise InputError(f"{self._prefix}{key} is {value!r}: wanted a finite number")
        return float(value)  # type: ignore[arg-type]

    def numbers(self, key: str, count: int | None = None) -> tuple[float, ...]:
        """Finite numbers, `count` of them (or any)."""
        value = self._get(key)
        if not isinstance(value, list) or not all(map(_is_number, value)) or count not in (None, len(value)):
            raise InputError(f"{self._prefix}{key} is {value!r}: wanted a list of {'' if count is None else f'{count} '}finite numbers")
        return tuple(map(float, value))

    def refuse_unread(self) -> None:
        """Refuse keys nobody asked for: a misspelt one would otherwise be taken for left out."""
        for key in self._data:
            if key not in self._read:
                raise InputError(f"unknown key {self._prefix}{key}")
            if self._read[key] is not None:
                self._read[key].refuse_unread()

    def _get(self, key: str) -> object:
        if key not in self._data:
            raise InputError(f"the key {self._prefix}{key} is missing; hmdwarp/headsets/rift-dk1.toml has them all")
        self._read.setdefault(key, None)
        return self._data[key]


def _is_number(value: object) -> bool:
    if isinstance(value, int) and not isinstance(value, bool):
        return abs(value) < 2**63  # as TOML has it; a longer one would overflow as a float
    return isinstance(value, float) and math.isfinite(value)
