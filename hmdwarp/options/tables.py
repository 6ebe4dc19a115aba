"""TOML files that people write: a getter per type; errors name file, line and key."""

from __future__ import annotations

import bisect
import difflib
import math
import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

import attrs

from ..errors import InputError, listed
from .documents import DocumentError, parse_toml
from .named_files import TABLE, text_in

KeyPath = tuple[str | int, ...]
_NEEDED = object()  # no default: the key is required


def quoted(value: object) -> str:
    """Format a value of a file for messages: one line of limited length."""
    try:
        return _shortened(repr(value))
    except ValueError:  # Python does not print integers of more than 4300 digits
        return "a number beyond all bounds"


class KeyFault(InputError):
    """A wrong key in a file.

    path: of the key from the top of the file: keys, and indices from 0 within arrays.
    """

    def __init__(self, text: str, path: KeyPath) -> None:
        super().__init__(text)
        self.path = path


class Table:
    """A table of a TOML file.

    Each getter takes a default for an optional key. Errors: KeyFault naming the key.
    """

    def __init__(self, data: object, path: KeyPath = (), example: str = "") -> None:
        """Wrap `data` of tomllib.

        path: in the file. example: a file with all keys, for messages.
        """
        self._path, self._example = path, example
        if not isinstance(data, dict):
            raise KeyFault(f"{_named(path)} is {quoted(data)}: expected a table of keys", path)
        self._data = data
        self._read: dict[str, list[Table]] = {}
        self._known: dict[str, None] = {}  # every key that was read, in that order

    def __contains__(self, key: str) -> bool:
        self._known[key] = None
        return key in self._data

    @property
    def path(self) -> KeyPath:
        """KeyPath of the table in the file."""
        return self._path

    def keys(self) -> tuple[str, ...]:
        """Return the keys in file order."""
        return tuple(self._data)

    def table(self, key: str) -> Table:
        """Return a table inside this one, the same object each time."""
        value = self.raw(key)
        if not self._read[key]:
            self._read[key] = [Table(value, (*self._path, key), self._example)]
        return self._read[key][0]

    def tables(self, key: str) -> tuple[Table, ...]:
        """Return the tables of an array, written as [[key]]; none for a missing key."""
        value = self.raw(key, ())
        if value == ():
            return ()
        if not isinstance(value, list):
            raise self.fault(
                key,
                f"is {quoted(value)}: expected tables, each beginning with [[{_named((*self._path, key))}]]",
            )
        if not self._read[key]:
            self._read[key] = [
                Table(one, (*self._path, key, number), self._example) for number, one in enumerate(value)
            ]
        return tuple(self._read[key])

    def text(self, key: str, default: Any = _NEEDED) -> str:
        """Return a non-empty text."""
        text: str = self._checked(key, default, lambda value: isinstance(value, str) and value.strip(), "a text")
        return text

    def line(self, key: str, default: Any = _NEEDED) -> str:
        """Return a one-line text without control characters."""
        text = self.text(key, default)
        self._checked(key, default, str.isprintable, "a text of one line, without control characters")
        return text

    def word(self, key: str, known: Sequence[str], default: Any = _NEEDED) -> str:
        """Return one of the allowed words."""
        word: str = self._checked(key, default, lambda value: value in known, listed(known, "or"))
        return word

    def flag(self, key: str, default: Any = _NEEDED) -> bool:
        """Return a boolean."""
        flag: bool = self._checked(key, default, lambda value: isinstance(value, bool), "true or false")
        return flag

    def number(self, key: str, default: Any = _NEEDED) -> float:
        """Return a finite number."""
        value = self._checked(key, default, _is_number, "a finite number")
        return value if value is default else float(value)

    def within(self, key: str, least: float, most: float, default: Any = _NEEDED, *, above: bool = False) -> float:
        """Return a number from least to most; above: greater than least."""
        value = self.number(key, default)
        if value is not default and not (least <= value <= most and (value > least or not above)):
            raise self.fault(key, f"is {value:g}: expected a number {_range(least, most, above)}")
        return value

    def whole(self, key: str, least: int, most: int, default: Any = _NEEDED) -> int:
        """Return a whole number from least to most."""

        def is_within(value: Any) -> bool:
            return isinstance(value, int) and not isinstance(value, bool) and least <= value <= most

        number: int = self._checked(key, default, is_within, f"a whole number {_range(least, most)}")
        return number

    def numbers(self, key: str, count: int | None = None) -> tuple[float, ...]:
        """Return finite numbers, `count` of them (None: any number)."""

        def are_right(value: Any) -> bool:
            return isinstance(value, list) and all(map(_is_number, value)) and count in (None, len(value))

        what = f"a list of {'' if count is None else f'{count} '}finite numbers"
        return tuple(map(float, self._checked(key, _NEEDED, are_right, what)))

    def texts(self, key: str, default: Any = _NEEDED) -> tuple[str, ...]:
        """Return non-empty texts."""

        def are_texts(value: Any) -> bool:
            return isinstance(value, list) and all(isinstance(entry, str) and entry.strip() for entry in value)

        return tuple(self._checked(key, default, are_texts, 'a list of texts, like ["one", "another"]'))

    def fault(self, key: str | None, says: str, *within: str | int) -> KeyFault:
        """Return an error about a key, or about this table where key is None.

        within: path inside the key's value.
        """
        path = self._path if key is None else (*self._path, key)
        return KeyFault(f"{_named(path)} {says}".lstrip(), (*path, *within))

    def refuse_unread(self) -> None:
        """Raise KeyFault for keys that were never read: a misspelt key would go unnoticed."""
        for key in self._data:
            if key not in self._read:
                known, path = [_named((*self._path, one)) for one in self._known], (*self._path, key)
                near = difflib.get_close_matches(name := _shortened(_named(path)), known, n=1, cutoff=0.5)
                hint = f"did you mean {near[0]}? " if near else ""
                raise KeyFault(f"unknown key {name}: {hint}known are {', '.join(known)}", path)
            for inner in self._read[key]:
                inner.refuse_unread()

    def _checked(self, key: str, default: Any, is_right: Callable[[Any], object], wanted: str) -> Any:
        value = self.raw(key, default)
        if value is not default and not is_right(value):
            raise self.fault(key, f"is {quoted(value)}: expected {wanted}")
        return value

    def raw(self, key: str, default: Any = _NEEDED) -> Any:
        """Return a value of any type."""
        self._read.setdefault(key, [])
        self._known[key] = None
        if key in self._data:
            return self._data[key]
        if default is not _NEEDED:
            return default
        raise self.missing(key)

    def missing(self, key: str) -> KeyFault:
        """Return the error for a missing key; it points at a similar key if there is one."""
        named = _named((*self._path, key))
        for near in difflib.get_close_matches(key, set(self._data) - set(self._known), n=1, cutoff=0.7):
            return KeyFault(f"the key {named} is missing: is {_named((near,))} meant to be {key}?", (*self._path, near))
        hint = f"; {self._example} has them all" if self._example else ""
        return KeyFault(f"the key {named} is missing{hint}", self._path)


_READ = "read"


def reads(get: Callable[..., Any], *limits: Any, at: str = "", required: bool = False, **how: Any) -> dict[str, Any]:
    """Return the metadata of an attrs field that is a key of a file, for `fields_in` to read.

    get: the getter of Table; limits, how: what that takes after the key. at: "table.key", by
    default the field's name. required: whether the file has it although the field has a default.
    """
    return {_READ: (get, limits, at, required, how)}


def read_by(get: Callable[..., Any], *limits: Any, default: Any, **how: Any) -> Any:
    """Return such a field with a default, which an optional key has too."""
    return attrs.field(default=default, metadata=reads(get, *limits, **how))


def fields_in(table: Table, kind: type[attrs.AttrsInstance]) -> dict[str, Any]:
    """Return the values of a class's fields that are keys, by name, in their order.

    Keys of a table that the file lacks have their defaults. Errors: KeyFault.
    """
    found: dict[str, Any] = {}
    for field in attrs.fields(kind):
        if _READ in field.metadata:
            get, limits, at, required, how = field.metadata[_READ]
            inside, _, name = at.rpartition(".")
            of = table if not inside else table.table(inside) if inside in table else Table({})
            default = () if required or field.default is attrs.NOTHING else (field.default,)
            found[field.name] = get(of, name or field.name, *limits, *default, **how)
    return found


def _named(path: KeyPath) -> str:
    """Join the keys, like 'part.condition.name'; the line number tells tables of one name apart."""
    return ".".join(part if re.fullmatch(r"[\w-]+", part) else repr(part) for part in path if isinstance(part, str))


def _shortened(text: str) -> str:
    return text if len(text) <= 80 else f"{text[:77]}..."


def _range(least: float, most: float, above: bool = False) -> str:
    lower = f"{'above' if above else 'of at least'} {least:g}"
    return f"{lower} and at most {most:g}" if math.isfinite(most) else lower


def _is_number(value: object) -> bool:
    if isinstance(value, int) and not isinstance(value, bool):
        return abs(value) < 2**63  # the range of TOML; a longer one would overflow as a float
    return isinstance(value, float) and math.isfinite(value)


_STRING = re.compile(
    r'"""(?:\\.|[^\\])*?"""(?:"{0,2})' r"|'''.*?'''(?:'{0,2})" r'|"(?:\\.|[^"\\])*"' r"|'[^']*'",
    re.DOTALL,
)
_KEY = re.compile(r"[A-Za-z0-9_-]+|\"(?:\\.|[^\"\\])*\"|'[^']*'")
_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_SPACE = re.compile(r"[ \t]*")
_SCALAR = re.compile(r"[^,\]}\n#]*")


class LineFinder:
    """Lines of the keys of a TOML text, which tomllib, cattrs, pydantic and msgspec do not keep."""

    def __init__(self, text: str) -> None:
        """Scan a text that tomllib parses without an error."""
        self._text, self._at = text, 0
        self._ends = [match.start() for match in re.finditer("\n", text)]
        self._lines: dict[KeyPath, int] = {}
        self._counts: dict[KeyPath, int] = {}  # tables so far in each array of tables
        self._table: KeyPath = ()
        with suppress(IndexError, RecursionError, ValueError):  # partial results are better than none
            while self._skip(_BLANK) < len(self._text):
                self._header() if self._text[self._at] == "[" else self._pair(self._table)

    def line(self, path: KeyPath) -> int:
        """Return the line of a key, from 1 on; for a missing key that of its table, or 1."""
        for length in range(len(path), 0, -1):
            found = self._lines.get(path[:length])
            if found is not None:
                return found
        return 1

    def _header(self) -> None:
        start, is_array = self._at, self._text.startswith("[[", self._at)
        self._at += 2 if is_array else 1
        keys = self._keys()
        path: KeyPath = ()
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

    def _pair(self, table: KeyPath) -> None:
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
            # Without quotes; a key with escapes, which is rare, gets the line of its table.
            keys.append(found[0][1:-1] if found[0][0] in "\"'" else found[0])
            self._at = found.end()
            self._skip(_SPACE)
            if self._text[self._at] != ".":
                return keys
            self._at += 1

    def _value(self, path: KeyPath) -> None:
        first = self._text[self._at]
        if first in "\"'":
            self._skip(_STRING)
        elif first in "[{":
            end = "]" if first == "[" else "}"
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
        else:
            self._skip(_SCALAR)

    def _skip(self, pattern: re.Pattern[str]) -> int:
        found = pattern.match(self._text, self._at)
        if found is None:
            raise ValueError
        self._at = found.end()
        return self._at

    def _note(self, path: KeyPath, at: int) -> None:
        self._lines.setdefault(path, bisect.bisect_left(self._ends, at) + 1)


T = TypeVar("T")


def text_of(path: Path, wanted: str, folder: Path | None = None) -> str:
    """Read a text file that is written by hand. wanted: for messages, such as "a .toml file".

    Errors: InputError, as `text_in`.
    """
    return text_in(path, attrs.evolve(TABLE, what=wanted), folder)


def parsed(text: str, path: Path | str, made_of: Callable[[Table], T], example: str = "") -> T:
    """Parse TOML and return the result of `made_of`; refuse keys that it did not read.

    path: for messages. Errors: InputError naming file, line and value.
    """
    try:
        table = Table(parse_toml(text), example=example)
    except DocumentError as error:
        place = path if error.line is None else f"{path}:{error.line}"
        raise InputError(f"{place}: this is no TOML: {error}{_several(str(error))}") from error
    try:
        made = made_of(table)
        table.refuse_unread()
    except KeyFault as error:
        said = " ".join(str(error).split())  # names and texts of a file may hold line ends
        raise InputError(f"{path}:{LineFinder(text).line(error.path)}: {said}") from error
    return made


def _several(says: str) -> str:
    """Suggest [[key]] for [key] written twice."""
    found = re.fullmatch(r"Cannot declare \((.*)\) twice(?: \(column \d+\))?", says)
    if found is None:
        return ""
    key = ".".join(part.strip().strip("'\"") for part in found[1].split(",") if part.strip())
    return f"; where a file may have several of them, each begins with [[{key}]]"
