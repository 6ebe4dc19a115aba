"""Load a head trace: a file in any known format, or a shipped recording by name."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from ..errors import InputError, TraceError, unknown_name
from ..resources import folder, recording_names
from .assumptions import By, Layout
from .formats import TraceFormat, column_of, column_of_devices, formats, of_matrix, ordered
from .options import AXIS_ANGLE, VECTOR, Euler, TraceOptions, parse_euler
from .reading.cleaning import LoadedTrace
from .reading.file_head import Head, read_head
from .reading.matrix_cells import read_matrix

_SYNTAX = (
    "t=TIME,p=X+Y+Z,q=X+Y+Z+W with names or numbers from 1, such as t=1,p=2+3+4,q=5+6+7+8; or m=2-17 in place of q"
)
_COUNTS = {"t": (1,), "p": (3,), "q": (4,), "m": (9, 12, 16), "r": (3,), "a": (4,), "e": (3,)}
_TURNS = ("q", "m", "r", "a", "e")


def load_trace(name_or_path: str | Path, options: TraceOptions | None = None) -> LoadedTrace:
    """Read a head trace.

    name_or_path: a file, or a bare name (no folder, no ending) of a shipped recording.
    options: overrides facts of the file, or adds missing ones.
    Errors: TraceError naming file and line; UnknownNameError with the nearest known recording or
    format.
    """
    options = TraceOptions.checked(options, optional=True)
    path = trace_path(name_or_path)
    if not path.exists() and path.stem in _recordings():
        raise TraceError(
            f"{path}: no such file; the shipped recording is called '{path.stem}', without folder and ending"
        )
    head = read_head(path)
    return find_format(head, options).read(head, options)


def trace_path(name_or_path: str | Path) -> Path:
    """Return the path of a trace; a bare name is looked up among the shipped recordings first.

    Errors: TraceError, UnknownNameError.
    """
    text = str(name_or_path)
    if not text or "\x00" in text:
        raise TraceError(f"{text!r} is no file name")
    path = Path(text)
    if isinstance(name_or_path, Path) or path.name != text or path.suffix:
        return path
    names = _recordings()
    if text in names:
        return folder("recordings") / f"{text}.csv"
    if path.exists() or not names:
        return path
    raise unknown_name("recording", text, names)


def _recordings() -> list[str]:
    try:
        return recording_names()
    except FileNotFoundError:
        return []


def find_format(head: Head, options: TraceOptions) -> TraceFormat:
    """Return the named format, or the most likely one. Errors: UnknownNameError, TraceError."""
    if options.columns is not None:
        return StatedColumns()
    if options.format is not None:
        return formats.get(options.format)
    scores = {f.name: f.sniff(head, options) for f in formats}
    best = max(scores, key=scores.__getitem__)
    if scores[best] > 0:
        return formats.get(best)
    if head.names is None and head.width >= 5:
        turn, of = ("q=5+6+7+8", "q: x y z w") if head.width > 7 else ("e=5+6+7", "e: angles, with --euler")
        raise TraceError(
            f"{head.path}: nothing in the file says what its columns are ({head.describe()}): "
            f"say --columns t=1,p=2+3+4,{turn} with their numbers ({of})"
        )
    known = ", ".join(formats.names())
    raise TraceError(
        f"{head.path} is in no known trace format ({head.describe()}): "
        f"name the columns in a header line, or say --format ({known})"
    )


class StatedColumns(TraceFormat):
    """Columns by the user's word; quaternions are x y z w unless --quat-order says otherwise."""

    name = "columns"
    summary = "columns as --columns names them"

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        text = options.columns or ""
        parts = [part.partition("=") for part in text.split(",")]
        stated = {key.strip(): _columns_of(head, value) for key, _, value in parts if value}
        turns = [key for key in stated if key in _TURNS]
        if (
            len(stated) != len(parts)
            or len(turns) != 1
            or any(len(v) not in _COUNTS.get(k, ()) for k, v in stated.items())
        ):
            raise InputError(f"--columns '{text}': expected {_SYNTAX}")
        (time,), place = stated.get("t", (None,)), stated.get("p")
        position = None if place is None else (place[0], place[1], place[2])
        return Layout(
            time=time,
            columns_by=By.USER,
            device=column_of_devices(head),
            **({"position": position} | self._turn(head, options, turns[0], stated[turns[0]], position)),
        )

    def _turn(
        self,
        head: Head,
        options: TraceOptions,
        key: str,
        columns: tuple[int, ...],
        position: tuple[int, int, int] | None,
    ) -> dict[str, Any]:
        if key == "m":
            return of_matrix(read_matrix(head, columns, options.matrix), position)
        if key == "q":
            return {"orientation": ordered(head, columns, options.quat_order or "xyzw"), "order_by": By.USER}
        if key == "e" and options.euler is None:
            raise InputError("--columns e= names angles: --euler states their order and unit (ZXY,deg is Unity's)")
        euler = (
            parse_euler(options.euler) if options.euler else Euler(VECTOR if key == "r" else AXIS_ANGLE, degrees=False)
        )
        return {"orientation": columns, "euler": euler, "order_by": By.USER if options.euler else By.NOBODY}


def _columns_of(head: Head, text: str) -> tuple[int, ...]:
    """Return columns by name or number, apart by +, or from one number to another (2-17)."""
    if (found := re.fullmatch(r"\s*([0-9]+)\s*-\s*([0-9]+)\s*", text)) and head.column(text) is None:
        return tuple(column_of(head, str(number)) for number in range(int(found[1]), int(found[2]) + 1))
    return tuple(column_of(head, word) for word in text.split("+"))
