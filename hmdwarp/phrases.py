"""Plurals and lists, as sentences need them."""

from __future__ import annotations

from collections.abc import Sequence

_IRREGULAR = {"person": "people"}


def counted(number: int, word: str) -> str:
    """Return "1 person" or "3 ratings"."""
    return f"{number} {word if number == 1 else _IRREGULAR.get(word, word + 's')}"


def listed(names: Sequence[str], word: str = "and") -> str:
    """Return "a, b and c"; "" for no names."""
    return f" {word} ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))
