"""What browsers say of their sessions: a line of JSON a second in session.jsonl, see docs/web.md.

It comes from strangers: a message is parsed once, each list in it is bounded, and so is the file.
"""

from __future__ import annotations

import json
import math
import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from .. import web  # late: the feed alone needs no aiohttp
from ..report import write_error

NAME = "session.jsonl"
MOST_BYTES, _LAST = 50_000_000, 100  # of the file, and of the line that says that it is full
FULL = f"{MOST_BYTES // 10**6} MB are written: no more is kept"
MOST_REFRESHES = 256  # of a message
DISPLAY = {"browser", "renderer", "codec", "trace", "width", "height", "rendered_width", "rendered_height"}
DISPLAY |= {"rate_hz", "latency_ms", "guard"}
_MOST, _MOST_ROWS, _MOST_LETTERS = 1e9, 16, 300
# What a value may be: a number from one to another, a word, either; or a table of such, or a list
# that is at most so long.
_NUMBER, _WORD, _FACT = (0, _MOST), "word", "fact"
_DISPLAY = dict.fromkeys(DISPLAY, _FACT)
_BENCHED = _DISPLAY | dict.fromkeys(("clock", "how", "seconds"), _FACT)
_BENCH = [dict.fromkeys(("warp", "fill", "warp_ms", "total_ms", "psnr_db"), _FACT), _MOST_ROWS]
# Of a refresh: shown_ms, age_ms, warp_ms, position in m, orientation.
_BOUNDS = (_NUMBER,) * 3 + ((-1e6, 1e6),) * 3 + ((-1, 1),) * 4
_AT_ONCE, _PER_S = 8, 2  # messages of a connection


def _checked(value: Any, shape: Any) -> Any:
    """Return a value that is as its shape says. Errors: ValueError."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    is_word = isinstance(value, str) and len(value) <= _MOST_LETTERS and value.isprintable()
    if isinstance(shape, dict) and isinstance(value, dict) and value.keys() == shape.keys():
        return {name: _checked(one, shape[name]) for name, one in value.items()}
    if isinstance(shape, list) and isinstance(value, list) and len(value) <= shape[1]:
        return [_checked(one, shape[0]) for one in value]
    if is_word and shape in (_WORD, _FACT):
        return value
    least, most = _NUMBER if shape == _FACT else shape if isinstance(shape, tuple) else (math.inf, -math.inf)
    if is_number and least <= value <= most:
        return value
    raise ValueError(f"expected {shape}")


def _refreshes(rows: Any, after_ms: float) -> list[list[float]]:
    """Return rows as _BOUNDS has them, each later than the one before. Errors: ValueError."""
    if not isinstance(rows, list) or len(rows) > MOST_REFRESHES:
        raise ValueError(f"expected a list of at most {MOST_REFRESHES}")
    for row in rows:
        if not isinstance(row, list) or len(row) != len(_BOUNDS):
            raise ValueError("expected the numbers of a refresh")
        for number, bounds in zip(row, _BOUNDS, strict=True):
            _checked(number, bounds)
        if row[0] <= after_ms or abs(math.hypot(*row[6:]) - 1) > 1e-3:
            raise ValueError("expected a later instant, and a unit quaternion")
        after_ms = row[0]
    return rows


def _mean_and_most(values: list[float]) -> list[float]:
    return [round(sum(values) / len(values), 3), max(values)]


class SessionLog:
    """The file of all pages. say: called once where no more is written. Errors: as write_error."""

    def __init__(self, folder: Path, say: Callable[[str], None]) -> None:
        self.path, self._say, self._lock = folder / NAME, say, threading.Lock()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
        except OSError as error:
            raise write_error(error, self.path) from error
        self._size, self._is_over = os.fstat(self._file).st_size, False
        self._started, self._count = f"{datetime.now(UTC):%Y%m%dT%H%M%S}", 0

    def begin(self) -> _PageLog:
        """Return what takes a connection's messages."""
        return _PageLog(self)

    def session(self) -> str:
        """Return a name that no other session has."""
        with self._lock:
            self._count += 1
            return f"{self._started}-{self._count}"

    def add(self, line: dict[str, Any]) -> None:
        """Write a line; none any more once the file is full, or the disk has refused one."""
        data = _coded(line)
        with self._lock:
            if self._is_over:
                return
            try:
                if self._size + len(data) + _LAST <= MOST_BYTES:
                    self._write(data)
                    return
                self._end(FULL)
                if self._size + _LAST <= MOST_BYTES:
                    self._write(_coded({"full": FULL}))
            except OSError as error:
                with suppress(OSError):  # whole lines alone stay
                    os.ftruncate(self._file, self._size)
                self._end(str(write_error(error, self.path)))

    def _write(self, data: bytes) -> None:
        done = 0
        while done < len(data):
            done += os.write(self._file, data[done:])
        self._size += done

    def _end(self, why: str) -> None:
        if not self._is_over:
            self._is_over = True
            self._say(f"{self.path}: {why}")

    def close(self) -> None:
        """Close the file, without one that is empty; what comes after is left out."""
        with self._lock:
            self._is_over = True
            os.close(self._file)
            if not self._size:
                self.path.unlink(missing_ok=True)


def _coded(line: dict[str, Any]) -> bytes:
    return json.dumps(line, separators=(",", ":")).encode() + b"\n"


class _PageLog:
    """What one connection says; from one thread at a time."""

    def __init__(self, log: SessionLog) -> None:
        self._log, self._begun_s = log, time.monotonic()
        self._session, self._last_ms = "", -math.inf
        self._parsed = self._errors = 0

    def take(self, text: str) -> None:
        """Take a message; what no page says is counted, and said in the next line."""
        if len(text) > web.MOST_REPORT or self._parsed >= _AT_ONCE + _PER_S * (time.monotonic() - self._begun_s):
            self._errors += 1
            return
        self._parsed += 1
        try:
            self._log.add(self._line(json.loads(text)))
        except (ValueError, RecursionError):
            self._errors += 1

    def _line(self, said: Any) -> dict[str, Any]:
        """Return what is kept of a message. Errors: ValueError for what no page says."""
        if isinstance(said, dict) and "bench" in said:
            return {"bench": _checked(said["bench"], _BENCH), "display": _checked(said.get("display"), _BENCHED)}
        if not isinstance(said, dict) or said.keys() != {"display", "warp", "missed", "delays_ms", "refreshes"}:
            raise ValueError("expected what a page says")
        begins = said["display"] is not None
        display = {"display": _checked(said["display"], _DISPLAY)} if begins else {}
        rows = _refreshes(said["refreshes"], -math.inf if begins else self._last_ms)
        if not rows or not (begins or self._session):
            raise ValueError("expected refreshes, of a display")
        found = {
            "refreshes": len(rows),
            "missed": _checked(said["missed"], _NUMBER),
            "warp": _checked(said["warp"], _WORD),
            "warp_ms": _mean_and_most([row[2] for row in rows]),
            "age_ms": _mean_and_most([row[1] for row in rows]),
            "delays_ms": _checked(said["delays_ms"], [_NUMBER, len(rows)]),
            "heads": [[row[0], *row[3:]] for row in rows],
        }
        if begins:
            self._session = self._log.session()
        line = {"session": self._session, **display, "errors": self._errors, **found}
        self._last_ms, self._errors = rows[-1][0], 0
        return line

    def close(self) -> None:
        """Say what was wrong since the last line."""
        if self._errors:
            self._log.add({"session": self._session or self._log.session(), "errors": self._errors})
            self._errors = 0
