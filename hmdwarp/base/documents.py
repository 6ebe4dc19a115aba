"""JSON and TOML from anywhere, within bounds; TOML of people by a getter per type."""

from __future__ import annotations

import bisect
import difflib
import functools
import json
import math
import re
import tomllib
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

import attrs

from .declared import Number
from .errors import InputError, listed
from .named_files import FACTS, TABLE, FileKind, content_of, text_in

MOST_DEPTH = 100  # of lists and tables in each other; what is read by recursion stays far from Python's 1000
MOST_KEY = 1000  # characters
MOST_VALUES = 30_000_000  # of JSON: 2 GB, if they are lists of nothing
_MOST_PARTS = 32  # of a dotted key: tomllib takes the square of their number
_MOST_WHOLE = 1 << 63
_PART = r"(?:(?<![\w-])[\w-]++|\"[^\"\n]*+\"|'[^'\n]*+')"
_SURROGATE = re.compile(r"\\u[dD][89a-fA-F]")
_DOTTED = re.compile(rf"(?:{_PART}[ \t]*+\.[ \t]*+){{{_MOST_PARTS}}}")


class DocumentError(ValueError):
    """What is wrong with a text, without the file's name; line: from 1 on, None where unknown."""

    def __init__(self, what: str, line: int | None = None) -> None:
        super().__init__(what)
        self.line = line


def json_in(path: Path, kind: FileKind = FACTS, folder: Path | None = None) -> Any:
    """Return what a JSON file holds. Errors: as opened, json_of."""
    return json_of(content_of(path, kind, folder), path, kind.error)


def json_of(data: bytes | str, where: object, error: type[InputError] = InputError) -> Any:
    """Return what a JSON text holds. where: for messages. Errors: of the kind `error`, one line."""
    try:
        return parse_json(data)
    except DocumentError as fault:
        place = f"{where}" if fault.line is None else f"{where}, line {fault.line}"
        raise error(f"{place}: not JSON that can be read ({fault}): expected JSON") from fault


def parse_json(data: bytes | str) -> Any:
    """Return what a JSON text holds, with or without a byte order mark. Errors: DocumentError."""
    try:
        text = data if isinstance(data, str) else data.decode("utf-8-sig")
        if sum(map(text.count, ",[{")) > MOST_VALUES:
            raise DocumentError(f"more than {MOST_VALUES:,} values: expected fewer")
        found = json.loads(text, parse_int=_whole, object_pairs_hook=_table)
    except UnicodeDecodeError as error:
        raise DocumentError(f"not UTF-8 text: byte {error.start} is {error.object[error.start]:#x}") from error
    except json.JSONDecodeError as error:
        raise DocumentError(f"{error.msg} (column {error.colno})", error.lineno) from error
    except RecursionError as error:
        raise _too_deep() from error
    _check(found)
    if _SURROGATE.search(text):  # half a character, as an escape can write it: no file and no page can hold it
        try:
            json.dumps(found, ensure_ascii=False).encode()
        except UnicodeEncodeError as error:
            raise DocumentError("a text with half a character (\\ud800 to \\udfff alone): expected UTF-8") from error
    return found


def parse_toml(text: str) -> dict[str, Any]:
    """Return what a TOML text holds. Errors: DocumentError."""
    if found := _DOTTED.search(text):
        raise DocumentError(
            f"a key of more than {_MOST_PARTS} parts: expected fewer", text.count("\n", 0, found.start()) + 1
        )
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        says = " ".join(str(error).split())
        if (found := re.fullmatch(r"(.*) \(at line (\d+), column (\d+)\)", says)) is None:
            raise DocumentError(says) from error
        raise DocumentError(f"{found[1]} (column {found[3]})", int(found[2])) from error
    except RecursionError as error:
        raise _too_deep() from error
    except ValueError as error:  # whole numbers of thousands of digits
        raise DocumentError(" ".join(str(error).split())) from error
    _check(data)
    return data


def _whole(digits: str) -> int | float:
    number = int(digits) if len(digits) <= 20 else _MOST_WHOLE
    return number if -_MOST_WHOLE <= number < _MOST_WHOLE else float(digits)  # which NumPy and float() take


def _table(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        twice = next(key for key, count in Counter(key for key, _ in pairs).items() if count > 1)
        raise DocumentError(f"the key {_shortened(ascii(twice))} twice in one object: expected it once")
    return table


def _check(found: Any) -> None:
    """Refuse what is nested deeply, and long keys: level by level, without recursion."""
    level = [found]
    for _ in range(MOST_DEPTH):
        inner: list[Any] = []
        for one in level:
            if isinstance(one, dict) and (long := next((key for key in one if len(key) > MOST_KEY), None)):
                raise DocumentError(
                    f"a key of {len(long)} characters, {_shortened(ascii(long))}: expected at most {MOST_KEY}"
                )
            values = one.values() if isinstance(one, dict) else one if isinstance(one, list) else ()
            inner += [value for value in values if isinstance(value, dict | list)]
        if not inner:
            return
        level = inner
    raise _too_deep()


def _too_deep() -> DocumentError:
    return DocumentError(f"lists or tables nested deeply: expected at most {MOST_DEPTH} in each other")


_KeyPath = tuple[str | int, ...]
_NEEDED = object()  # no default: the key is required
T = TypeVar("T")


def quoted(value: object) -> str:
    """Format a value of a file for messages: one line of limited length."""
    try:
        return _shortened(repr(value))
    except ValueError:  # Python does not print integers of more than 4300 digits
        return "a number beyond all bounds"


class KeyFault(InputError):
    """A wrong key in a file; path: from the top, keys, and indices from 0 within arrays."""

    def __init__(self, text: str, path: _KeyPath) -> None:
        super().__init__(text)
        self.path = path


class Table:
    """A table of a TOML file: `data` of tomllib, at `path` in the file.

    Getters take a default for an optional key. example: a file with all keys, for messages. Errors:
    KeyFault naming the key.
    """

    def __init__(self, data: object, path: _KeyPath = (), example: str = "") -> None:
        self.path, self._example = path, example
        if not isinstance(data, dict):
            raise KeyFault(f"{_named(path)} is {quoted(data)}: expected a table of keys", path)
        self._data = data
        self._read: dict[str, list[Table]] = {}
        self._known: dict[str, None] = {}  # every key that was read, in that order

    def __contains__(self, key: str) -> bool:
        self._known[key] = None
        return key in self._data

    def keys(self) -> tuple[str, ...]:
        """Return the keys in file order."""
        return tuple(self._data)

    def table(self, key: str) -> Table:
        """Return a table inside this one, the same object each time."""
        value = self.raw(key)
        if not self._read[key]:
            self._read[key] = [Table(value, (*self.path, key), self._example)]
        return self._read[key][0]

    def tables(self, key: str) -> tuple[Table, ...]:
        """Return the tables of an array, written as [[key]]; none for a missing key."""
        value, path = self.raw(key, ()), (*self.path, key)
        if not isinstance(value, list | tuple):
            raise self.fault(key, f"is {quoted(value)}: expected tables, each beginning with [[{_named(path)}]]")
        if not self._read[key]:
            self._read[key] = [Table(one, (*path, number), self._example) for number, one in enumerate(value)]
        return tuple(self._read[key])

    def text(self, key: str, default: Any = _NEEDED) -> str:
        """Return a non-empty text."""
        return self._checked(str, key, default, str.strip, "a text")

    def line(self, key: str, default: Any = _NEEDED) -> str:
        """Return a one-line text without control characters."""
        self.text(key, default)
        return self._checked(str, key, default, str.isprintable, "a text of one line, without control characters")

    def word(self, key: str, known: Sequence[str], default: Any = _NEEDED) -> str:
        """Return one of the allowed words."""
        return self._checked(str, key, default, known.__contains__, listed(known, "or"))

    def flag(self, key: str, default: Any = _NEEDED) -> bool:
        """Return a boolean."""
        return self._checked(bool, key, default, lambda _: True, "true or false")

    def number(self, key: str, default: Any = _NEEDED) -> float:
        """Return a finite number."""
        value = self._checked(object, key, default, _is_number, "a finite number")
        return value if value is default else float(value)  # type: ignore[arg-type]

    def within(self, key: str, least: float, most: float, default: Any = _NEEDED, *, above: bool = False) -> float:
        """Return a number from least to most; above: greater than least."""
        value = self.number(key, default)
        if value is not default and not (least <= value <= most and (value > least or not above)):
            raise self.fault(key, f"is {value:g}: expected a number {Number(least, most, above).words()}")
        return value

    def whole(self, key: str, least: int, most: int, default: Any = _NEEDED) -> int:
        """Return a whole number from least to most."""
        wanted = f"a whole number {Number(least, most).words()}"
        return self._checked(int, key, default, lambda value: least <= value <= most, wanted)

    def numbers(self, key: str, count: int | None = None) -> tuple[float, ...]:
        """Return finite numbers, `count` of them (None: any number)."""
        what = f"a list of {'' if count is None else f'{count} '}finite numbers"
        found = self._checked(
            list, key, _NEEDED, lambda value: all(map(_is_number, value)) and count in (None, len(value)), what
        )
        return tuple(map(float, found))

    def texts(self, key: str, default: Any = _NEEDED) -> tuple[str, ...]:
        """Return non-empty texts."""
        found = self._checked(
            list, key, default, lambda value: all(isinstance(one, str) and one.strip() for one in value),
            'a list of texts, like ["one", "another"]',
        )  # fmt: skip
        return tuple(found)

    def _checked(self, kind: type[T], key: str, default: Any, is_right: Callable[[Any], object], wanted: str) -> T:
        value: Any = self.raw(key, default)
        is_kind = isinstance(value, kind) and not (kind is int and isinstance(value, bool))
        if value is not default and not (is_kind and is_right(value)):
            raise self.fault(key, f"is {quoted(value)}: expected {wanted}")
        return value  # type: ignore[no-any-return]

    def raw(self, key: str, default: Any = _NEEDED) -> Any:
        """Return a value of any type."""
        self._read.setdefault(key, [])
        self._known[key] = None
        if key not in self._data and default is _NEEDED:
            raise self.missing(key)
        return self._data.get(key, default)

    def fault(self, key: str | None, says: str, *within: str | int) -> KeyFault:
        """Return an error about a key, or this table for None; within: path in the key's value."""
        path = self.path if key is None else (*self.path, key)
        return KeyFault(f"{_named(path)} {says}".lstrip(), (*path, *within))

    def missing(self, key: str) -> KeyFault:
        """Return the error for a missing key; it points at a similar key if there is one."""
        named = _named((*self.path, key))
        for near in difflib.get_close_matches(key, set(self._data) - set(self._known), n=1, cutoff=0.7):
            return KeyFault(f"the key {named} is missing: is {_named((near,))} meant to be {key}?", (*self.path, near))
        hint = f"; {self._example} has them all" if self._example else ""
        return KeyFault(f"the key {named} is missing{hint}", self.path)

    def refuse_unread(self) -> None:
        """Raise KeyFault for keys that were never read: a misspelt key would go unnoticed."""
        for key in self._data:
            if key not in self._read:
                known, path = [_named((*self.path, one)) for one in self._known], (*self.path, key)
                near = difflib.get_close_matches(name := _shortened(_named(path)), known, n=1, cutoff=0.5)
                hint = f"did you mean {near[0]}? " if near else ""
                raise KeyFault(f"unknown key {name}: {hint}known are {', '.join(known)}", path)
            for inner in self._read[key]:
                inner.refuse_unread()


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


def _named(path: _KeyPath) -> str:
    """Join the keys, like 'part.condition.name'; the line number tells tables of one name apart."""
    return ".".join(part if re.fullmatch(r"[\w-]+", part) else repr(part) for part in path if isinstance(part, str))


def _shortened(text: str) -> str:
    return text if len(text) <= 80 else f"{text[:77]}..."


def _is_number(value: object) -> bool:
    if isinstance(value, int) and not isinstance(value, bool):
        return abs(value) < 2**63  # the range of TOML; a longer one would overflow as a float
    return isinstance(value, float) and math.isfinite(value)


# What may close the lists and texts that the beginning of a file leaves open.
_ENDS = ["\n" + text + end for text in ("", '"""', "'''") for end in ("", "\n]", "\n]]", "\n]]]", "\n]}", "\n]}]")]
_MOST_OPEN, _MOST_READ = 30, 5_000_000  # lines of a value that no end closes; characters in all, for seconds


def line_of(text: str, path: _KeyPath) -> int:
    """Return the line of a key in TOML, from 1 on; for a missing key that of its table; 0: unknown.

    No parser keeps them: it is that after the longest beginning of the text that lacks the key.
    """
    lines, left = text.split("\n"), _MOST_READ

    @functools.cache
    def begun(count: int) -> tuple[int, Any]:
        """Return how many of so many lines can be read, and what they hold."""
        nonlocal left
        for length in range(count, max(count - _MOST_OPEN, 0), -1):
            begin = "\n".join(lines[:length])
            for end in _ENDS if left > 0 else ():
                left -= len(begin)
                with suppress(ValueError, RecursionError):
                    return length, tomllib.loads(begin + end)
        return max(count - _MOST_OPEN, 0), {}

    def has(count: int) -> bool:
        found = begun(count)[1]
        with suppress(KeyError, IndexError, TypeError):
            for key in path:
                found = found[key]
            return True
        return False

    while path and not has(len(lines)):
        path = path[:-1]
    found = begun(bisect.bisect_left(range(len(lines)), True, key=has) - 1)[0] + 1 if path else 1
    return found if left > 0 else 0


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
        twice, hint = re.fullmatch(r"Cannot declare \((.*)\) twice(?: \(column \d+\))?", str(error)), ""
        if twice:
            key = ".".join(part.strip().strip("'\"") for part in twice[1].split(",") if part.strip())
            hint = f"; where a file may have several of them, each begins with [[{key}]]"
        raise InputError(f"{place}: this is no TOML: {error}{hint}") from error
    try:
        made = made_of(table)
        table.refuse_unread()
    except KeyFault as error:
        said = " ".join(str(error).split())  # names and texts of a file may hold line ends
        line = line_of(text, error.path)
        raise InputError(f"{path}:{line}: {said}" if line else f"{path}: {said}") from error
    return made
