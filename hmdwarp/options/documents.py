"""JSON and TOML from anywhere: one function each that bounds what a text can do to its reader."""

from __future__ import annotations

import json
import re
import tomllib
from collections import Counter
from pathlib import Path
from typing import Any

from ..errors import InputError
from .named_files import FACTS, FileKind, content_of

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
        raise DocumentError(f"the key {_shown(twice)} twice in one object: expected it once")
    return table


def _check(found: Any) -> None:
    """Refuse what is nested deeply, and long keys: level by level, without recursion."""
    level = [found]
    for _ in range(MOST_DEPTH):
        inner: list[Any] = []
        for one in level:
            if isinstance(one, dict) and (long := next((key for key in one if len(key) > MOST_KEY), None)):
                raise DocumentError(f"a key of {len(long)} characters, {_shown(long)}: expected at most {MOST_KEY}")
            values = one.values() if isinstance(one, dict) else one if isinstance(one, list) else ()
            inner += [value for value in values if isinstance(value, dict | list)]
        if not inner:
            return
        level = inner
    raise _too_deep()


def _too_deep() -> DocumentError:
    return DocumentError(f"lists or tables nested deeply: expected at most {MOST_DEPTH} in each other")


def _shown(key: str) -> str:
    return repr(key if len(key) <= 60 else f"{key[:57]}...").encode("ascii", "backslashreplace").decode()
