"""Notes on a foreign file: one line for each kind of thing, however often it occurs."""

from __future__ import annotations

from pathlib import Path


class Notes:
    """Gathers what was left out or replaced; the same thing twice is one line with a count."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._examples: dict[str, list[str]] = {}

    def add(self, what: str, example: str = "") -> None:
        """Note a fact. example: where it was met, which one line of many names."""
        found = self._examples.setdefault(what, [])
        if example not in found:
            found.append(example)

    def lines(self) -> list[str]:
        """Return one line for each fact, in the order in which they were first met."""
        return [f"{self._path.name}: {_line(what, examples)}" for what, examples in self._examples.items()]


def _line(what: str, examples: list[str]) -> str:
    first, count = examples[0], len(examples)
    if not first:
        return what
    return f"{what}: {first}" if count == 1 else f"{what}: {count} of them, such as {first}"
