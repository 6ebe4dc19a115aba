"""Names to things: one file in a package is one entry, found by looking, imported when asked for.

The command line, the contract tests, the bench and the README table all read the same registries, so adding a warp,
fill, scene, lens or trace format is one new file and nothing else.
"""

from __future__ import annotations

import difflib
import importlib
import pkgutil
from collections.abc import Iterator
from typing import Generic, TypeVar

from .errors import UnknownNameError

T = TypeVar("T")


def unknown_name(kind: str, name: str, known: list[str]) -> UnknownNameError:
    """The error for `name`, offering the nearest of `known`."""
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.4)
    hint = f"did you mean '{near[0]}'? " if near else ""
    return UnknownNameError(f"unknown {kind} '{name}': {hint}known are {', '.join(known)}")


class Registry(Generic[T]):
    """Entries of one kind, one per public module of `package`; a module registers the entry named like itself.

    Names come from file names alone, so listing them imports nothing (the command line needs them for --help).
    Modules whose name starts with an underscore are helpers, not entries.
    """

    def __init__(self, kind: str, package: str) -> None:
        self.kind, self.package = kind, package
        self._entries: dict[str, T] = {}

    def register(self, entry: T) -> T:
        """Class decorator (or plain call) that files `entry` under `entry.name`; a second one of that name is refused."""
        name = entry.name  # type: ignore[attr-defined]
        if name in self._entries:
            raise ValueError(f"{self.kind} '{name}' is registered twice")
        self._entries[name] = entry
        return entry

    def names(self) -> list[str]:
        """All known names, sorted; imports only the package itself."""
        path = importlib.import_module(self.package).__path__
        found = {m.name for m in pkgutil.iter_modules(path) if not m.name.startswith("_")}
        return sorted(found | set(self._entries))

    def get(self, name: str) -> T:
        """The entry called `name`. Errors: UnknownNameError with the nearest known name."""
        if name not in self._entries:
            if name not in self.names():
                raise unknown_name(self.kind, name, self.names())
            importlib.import_module(f"{self.package}.{name}")
            if name not in self._entries:
                raise ValueError(f"{self.package}.{name} registers no {self.kind} called '{name}'")
        return self._entries[name]

    def __iter__(self) -> Iterator[T]:
        return (self.get(name) for name in self.names())
