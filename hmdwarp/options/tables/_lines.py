"""Find the lines of keys in a TOML file, which tomllib does not keep.

cattrs, pydantic and msgspec check values as well, but offer neither the lines nor these hints.
"""

from __future__ import annotations

import bisect
import re

from ._table import Path

_STRING = re.compile(
    r'"""(?:\\.|[^\\])*?"""(?:"{0,2})' r"|'''.*?'''(?:'{0,2})" r'|"(?:\\.|[^"\\])*"' r"|'[^']*'",
    re.DOTALL,
)
_KEY = re.compile(r"[A-Za-z0-9_-]+|\"(?:\\.|[^\"\\])*\"|'[^']*'")
_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_SPACE = re.compile(r"[ \t]*")
_SCALAR = re.compile(r"[^,\]}\n#]*")


class LineFinder:
    """Lines of the keys of a TOML text."""

    def __init__(self, text: str) -> None:
        """Scan a text that tomllib parses without an error."""
        self._text, self._at = text, 0
        self._ends = [match.start() for match in re.finditer("\n", text)]
        self._lines: dict[Path, int] = {}
        self._counts: dict[Path, int] = {}  # tables so far in each array of tables
        self._table: Path = ()
        self._scan()

    def line(self, path: Path) -> int:
        """Return the line of a key, from 1 on; for a missing key that of its table, or 1."""
        for length in range(len(path), 0, -1):
            found = self._lines.get(path[:length])
            if found is not None:
                return found
        return 1

    def _scan(self) -> None:
        try:
            while self._skip(_BLANK) < len(self._text):
                self._header() if self._text[self._at] == "[" else self._pair(self._table)
        except (IndexError, RecursionError, ValueError):
            return  # partial results are better than none

    def _header(self) -> None:
        start, is_array = self._at, self._text.startswith("[[", self._at)
        self._at += 2 if is_array else 1
        keys = self._keys()
        path: Path = ()
        for number, key in enumerate(keys, 1):
            path = (*path, key)
            last = number == len(keys)
            if is_array and last:
                self._counts[path] = self._counts.get(path, 0) + 1
                self._note(path, start)
            if path in self._counts:
                path = (*path, self._counts[path] - 1)
            self._note(path, start)
        self._at = self._text.index("]", self._at) + (2 if is_array else 1)
        self._table = path

    def _pair(self, table: Path) -> None:
        start, path = self._at, table
        for key in self._keys():
            path = (*path, key)
            self._note(path, start)
        self._at = self._text.index("=", self._at) + 1
        self._skip(_SPACE)
        self._value(path)

    def _keys(self) -> list[str]:
        keys = []
        while True:
            self._skip(_SPACE)
            found = _KEY.match(self._text, self._at)
            if found is None:
                raise ValueError
            keys.append(_plain(found[0]))
            self._at = found.end()
            self._skip(_SPACE)
            if self._text[self._at] != ".":
                return keys
            self._at += 1

    def _value(self, path: Path) -> None:
        first = self._text[self._at]
        if first in "\"'":
            self._skip(_STRING)
        elif first in "[{":
            self._within(path, "]" if first == "[" else "}")
        else:
            self._skip(_SCALAR)

    def _within(self, path: Path, end: str) -> None:
        """Scan an array or an inline table."""
        self._at += 1
        number = 0
        while self._skip(_BLANK) < len(self._text) and self._text[self._at] != end:
            if self._text[self._at] == ",":
                self._at += 1
            elif end == "]":
                self._note((*path, number), self._at)
                self._value((*path, number))
                number += 1
            else:
                self._pair(path)
        self._at += 1

    def _skip(self, pattern: re.Pattern[str]) -> int:
        found = pattern.match(self._text, self._at)
        if found is None:
            raise ValueError
        self._at = found.end()
        return self._at

    def _note(self, path: Path, at: int) -> None:
        self._lines.setdefault(path, bisect.bisect_left(self._ends, at) + 1)


def _plain(key: str) -> str:
    """Strip quotes. A key with escapes, which is rare, gets the line of its table."""
    return key[1:-1] if key[0] in "\"'" else key
