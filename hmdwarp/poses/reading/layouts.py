"""What the columns of a file mean: by names in its header, by its shape, or as the user says."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any

import attrs
import numpy as np

from ...errors import InputError, TraceError, are_digits
from ..assumptions import By, Defect, Layout
from ..options import COLUMNS, FRAMES, INVERSE, ROWS, VECTOR, Euler, TraceOptions, parse_euler
from ..track import PoseTrack
from . import header
from .axes import OPENXR, parse_axes
from .text_table import BILLION, DATE, UNITS_NS, Head

_ORDER_ASSUMED = Defect(
    "order-assumed",
    "nothing in the file says whether w comes first or last in its quaternions",
    "w last taken, as in TUM files; --quat-order wxyz takes it first",
)
_MIXED = 4  # rows of several devices change from one to another at least every fourth time
_CLOCKED = 0.9  # share of the steps in which a clock rises
_OFF = 0.02  # of a rotation's matrix
_SYNTAX = (
    "t=TIME,p=X+Y+Z,q=X+Y+Z+W with names or numbers from 1, such as t=1,p=2+3+4,q=5+6+7+8; or m=2-17 in place of q"
)
_COUNTS = {"t": (1,), "p": (3,), "q": (4,), "m": (9, 12, 16), "r": (3,), "e": (3,)}


def named_layout(head: Head, options: TraceOptions, **known: Any) -> Layout:
    """Return a layout from the header's names and the facts of the format. Errors: TraceError."""
    if head.names is None:
        raise TraceError(f"{head.path} has no header ({head.describe()}): its columns cannot be told apart")
    found = header.find_columns(head.names)
    clock, told = _clock(head, found)
    facts = clock | {"position": found.position, "device": _column_of_devices(head)}
    facts |= {"unit_by": By.FORMAT if "unit" in known else By.FILE, "scale": found.length_m or 1.0}
    facts["scale_by"] = By.FILE if found.length_m else By.DEFAULT
    if found.gravity and len(down := head.numbers(found.gravity, commas=False)):
        facts["gravity_down"] = tuple(sum(column) / len(down) for column in zip(*down.tolist(), strict=True))
    gaze = tuple(column for name in known.pop("gaze", ()) if (column := head.column(name)) is not None)
    turn = _turn(head, found, options, known)
    if (said := header.direction_of([head.names[c] for c in turn["orientation"]])) is not None:
        facts |= {"inverse": said == INVERSE, "direction_by": By.FILE}
    caveats = (*known.pop("caveats", ()), *turn.pop("caveats", ()), *told)
    return Layout(**(facts | turn | known), gaze=gaze if len(gaze) > 2 else (), caveats=caveats)


def _clock(head: Head, found: header.Columns) -> tuple[dict[str, Any], tuple[Defect, ...]]:
    """Return which columns are the time, as fields of Layout, and a note on other clocks."""
    names = head.names or []

    def cells(column: int) -> list[str]:
        return [row[column] for row in head.rows if len(row) > column and row[column]]

    for whole, rest, unit in sorted(found.pairs, key=lambda pair: header.owner_rank(names[pair[0]])):
        counts = [cell for cell in cells(rest) if are_digits(cell) and int(cell) < BILLION // UNITS_NS[unit]]
        if len(counts) == len(cells(rest)) and all(map(are_digits, cells(whole))):
            return {"time": whole, "unit": "s", "rest": rest, "rest_unit": unit}, ()
    if not found.clocks:
        return {"time": None}, ()
    values = {column: len(set(cells(column))) for column, _ in found.clocks}
    # Of several clocks those that take the most values over the first rows, then the pose's own.
    fine = [clock for clock in found.clocks if 10 * values[clock[0]] > 9 * max(values.values())]
    time, said = min(fine, key=lambda clock: header.owner_rank(names[clock[0]]))
    others = ", ".join(names[column] for column, _ in found.clocks if column != time)
    done = f"{names[time]} taken; --time-column takes another"
    note = Defect("clocks-several", f"its rows have other clocks as well ({others})", done)
    hours, days = cells(time), [] if found.date is None else cells(found.date)
    dated = days and all(map(DATE.match, days)) and all(re.match("[0-9]{1,2}:", hour) for hour in hours)
    dates = {"rest": found.date, "rest_unit": "date"} if dated else {}
    return {"time": time, "unit": said, **dates}, (note,) if others else ()


def _turn(head: Head, found: header.Columns, options: TraceOptions, known: dict[str, Any]) -> dict[str, Any]:
    """Return how the orientation is read: fields of Layout. Errors: TraceError."""
    euler = known.pop("euler", None) if options.euler is None else parse_euler(options.euler)
    order = options.quat_order
    if found.orientation is not None and found.numbered:
        if order is None and head.kind == "vectors":
            return {"orientation": found.orientation, "order_by": By.DEFAULT, "caveats": (_ORDER_ASSUMED,)}
        return {"orientation": ordered(head, found.orientation, order), "order_by": By.USER}
    if found.orientation is not None:
        what = f"--quat-order {order} was given, but the header names x, y, z and w"
        ignored = Defect("quat-order-named", what, "the names are followed")
        return {"orientation": found.orientation, "caveats": (ignored,) if order else ()}
    candidates = header.named_matrices(head.names or [])
    matrix = next(filter(None, (_arranged(head, cells, options.matrix) for cells in candidates)), None)
    if matrix is not None:
        return matrix | {"position": matrix["position"] or found.position}
    if found.vector and (euler is None or euler.order == VECTOR):
        by = By.USER if options.euler else By.FILE if found.vector_unit else By.DEFAULT
        stated = euler or Euler(VECTOR, found.vector_unit == "deg")
        return {"orientation": found.vector, "euler": stated, "order_by": by}
    if euler is not None and found.angles is not None:
        axes = "xyz" if euler.order == VECTOR else euler.order
        columns = tuple(found.angles["xyz".index(axis)] for axis in axes)
        return {"orientation": columns, "euler": euler, "order_by": By.USER if options.euler else By.FORMAT}
    if candidates:
        _of_matrix(head, candidates[0], options.matrix)
    if found.angles is not None:
        angles = ", ".join(map(head.name_of, found.angles))
        how = "--euler states their order (ZXY,deg is Unity's; vector,rad a rotation vector)"
        raise TraceError(f"{head.path} gives Euler angles only ({angles}), in an order that it does not state: {how}")
    raise TraceError(f"{head.path} has no head orientation among {head.describe()}; see 'hmdwarp list formats'")


def unnamed_layout(head: Head, options: TraceOptions, name: str, order: str, unit: str | None) -> Layout:
    """Return the layout of time, position and quaternion in this order, without a header.

    Named as a format, the file has w as that has it. Blank-separated it is TUM's, w last, as evo
    and others write it; otherwise the order must be stated. Errors: TraceError.
    """
    if head.width < 8:
        raise TraceError(f"{head.path}: line {head.first_line}: {head.width} columns, expected 8: a time and a pose")
    known = options.quat_order or (order if options.format == name else None)
    assumed = known is None and head.separator is None
    stated = By.FORMAT if options.format == name else By.DEFAULT
    said: dict[str, Any] = {"columns_by": stated, "order_by": By.USER if options.quat_order else stated}
    said |= {"unit": unit, "unit_by": By.FORMAT, "caveats": (_ORDER_ASSUMED,) if assumed else ()}
    return Layout(0, ordered(head, (4, 5, 6, 7), "xyzw" if assumed else known), position=(1, 2, 3), **said)


def ordered(head: Head, columns: tuple[int, ...], order: str | None) -> tuple[int, int, int, int]:
    """Return four quaternion columns in the order x y z w. Errors: TraceError if unknown."""
    if order is None:
        what = f"nothing tells whether w comes first or last in its quaternions ({head.describe()})"
        raise TraceError(f"{head.path}: {what}; say --quat-order wxyz or --quat-order xyzw")
    a, b, c, d = columns
    return (b, c, d, a) if order == "wxyz" else (a, b, c, d)


def column_of(head: Head, word: str) -> int:
    """Return the index of a column by name, or by number from 1. Errors: InputError."""
    word = word.strip()
    index = head.column(word)
    if index is None and are_digits(word) and 1 <= int(word) <= head.width:
        index = int(word) - 1
    if index is None:
        raise InputError(f"{head.path} has no column '{word}' ({head.describe()}); numbers count from 1")
    return index


def _column_of_devices(head: Head) -> int | None:
    """Return the column that names devices, by its own name or by heads or hands in its rows."""
    if (named := header.find_columns(head.names or []).device) is not None:
        return named
    for column in range(len(head.names or [])):
        fields = [row[column] for row in head.rows if column < len(row)]
        changes = sum(a != b for a, b in itertools.pairwise(fields))
        bodies = any(header.head_rank(name) != header.UNRANKED for name in set(fields) if not header.is_number(name))
        if bodies and _MIXED * changes > len(fields):
            return column
    return None


def with_clock(head: Head, layout: Layout, options: TraceOptions) -> Layout:
    """Return the layout with the clock that the options name, or their rate. Errors: TraceError."""
    if options.time_column is not None:
        layout = attrs.evolve(layout, time=column_of(head, options.time_column), unit=None, rest=None)
    frames, rate = header.find_columns(head.names or []).frames, options.rate
    if options.time_unit == FRAMES:
        if rate is None:
            raise TraceError(f"{head.path}: frame numbers are no times: give the frames per second with --trace-rate")
        if options.time_column or options.columns or frames is None:
            frames = layout.time
        if frames is None:
            raise TraceError(f"{head.path} numbers no frames ({head.describe()}): --time-column names the column")
    elif frames is not None and rate is not None:
        numbers = head.numbers((frames,))[:, 0]
        steps = np.diff(numbers)
        rises = len(steps) > 0 and bool((steps > 0).all() and (numbers % 1 == 0).all()) and float(np.median(steps)) == 1
        frames = frames if rises else None
    if frames is not None and rate is not None:
        return attrs.evolve(layout, time=frames, unit=FRAMES, rest=None)
    if layout.time is None and rate is None:
        raise TraceError(f"{head.path} has no time ({head.describe()}): --trace-rate gives the samples per second")
    return layout if rate is None else attrs.evolve(layout, time=None, clock_ignored=layout.time is not None)


def axes_stated(head: Head) -> str | None:
    """Return the axes that a comment states, such as "# axes: tum-rgbd", for `parse_axes`.

    Comments in words count where they name OpenXR.
    """
    for key, _, value in (text.partition(":") for _, text in head.comments):
        if key.strip().lower() == "axes":
            with suppress(InputError):
                said = OPENXR if OPENXR in value.lower() else value
                parse_axes(said)
                return said
    return None


def columns_read(head: Head, layout: Layout, device: str) -> str:
    """Return which columns were read as what, by name or number. device: whose rows, or ""."""
    names = head.names or []
    parts: dict[str, tuple[int | None, ...]] = {"time": (layout.time, layout.rest), "device": (layout.device,)}
    parts |= {"position": layout.position or (), "orientation": layout.orientation, "gaze": layout.gaze}
    told = []
    for part, columns in parts.items():
        words = ", ".join(names[c] if c < len(names) else str(c + 1) for c in columns if c is not None)
        words += f" = {device}" if part == "device" and device else ""
        told += [f"{part}: {words}"] if words else []
    return "; ".join(told)


def stated_layout(head: Head, options: TraceOptions) -> Layout:
    """Return the layout of --columns; w is last unless --quat-order says otherwise."""
    text = options.columns or ""
    parts = [part.partition("=") for part in text.split(",")]
    stated: dict[str, tuple[int, ...]] = {}
    for key, _, value in parts:
        words: Iterable[str] = value.split("+")
        if (span := re.fullmatch(r"\s*(\d+)\s*-\s*(\d+)\s*", value)) and head.column(value) is None:  # such as 2-17
            words = map(str, range(int(span[1]), int(span[2]) + 1))
        if value:
            stated[key.strip()] = tuple(column_of(head, word) for word in words)
    turns = [key for key in stated if key in "qmre"]
    counts = all(len(columns) in _COUNTS.get(key, ()) for key, columns in stated.items())
    if len(stated) != len(parts) or len(turns) != 1 or not counts:
        raise InputError(f"--columns '{text}': expected {_SYNTAX}")
    key, columns = turns[0], stated[turns[0]]
    facts: dict[str, Any] = {"orientation": columns, "order_by": By.USER}
    if key == "m":
        facts = _of_matrix(head, columns, options.matrix)
    elif key == "q":
        facts["orientation"] = ordered(head, columns, options.quat_order or "xyzw")
    elif key == "e" and options.euler is None:
        raise InputError("--columns e= names angles: --euler states their order and unit (ZXY,deg is Unity's)")
    elif options.euler:
        facts["euler"] = parse_euler(options.euler)
    else:
        facts |= {"euler": Euler(VECTOR, degrees=False), "order_by": By.DEFAULT}
    (time,), place = stated.get("t", (None,)), facts.get("position") or stated.get("p")
    return Layout(time=time, columns_by=By.USER, device=_column_of_devices(head), **facts | {"position": place})


def _of_matrix(head: Head, cells: header.Cells, order: str | None) -> dict[str, Any]:
    found = _arranged(head, cells, order)
    if found is None:
        last = ", nor 0,0,0,1 in the last row or column" if len(cells) == 16 else ""
        what = f"its {len(cells)} numbers of a matrix are no rotations by {order or 'rows or columns'}{last}"
        raise TraceError(f"{head.path}: {what}: were the wrong columns read? --columns m=2-17 names them")
    return found


def _arranged(head: Head, cells: header.Cells, order: str | None) -> dict[str, Any] | None:
    """Return fields of Layout for a matrix; None where the numbers are no rotation."""
    numbers, (high, wide) = head.numbers(cells), header.SHAPES[len(cells)]
    numbers = numbers[np.abs(numbers).max(axis=1, initial=0.0) > 0]  # lost tracking writes zeros
    places, fits = np.arange(len(cells)), {}
    for layout, grid in ((ROWS, places.reshape(high, wide)), (COLUMNS, places.reshape(wide, high).T)):
        if len(numbers) and order in (None, layout):
            matrices = numbers[:, grid[:3, :3]]
            off = np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
            last = np.abs(numbers[:, grid[3]] - (0, 0, 0, 1)).max(axis=1) if grid.size == 16 else np.zeros(1)
            if np.median(off) < _OFF >= np.median(last) and np.median(np.linalg.det(matrices)) > 0:
                fits[layout] = grid
    if not fits:
        return None
    # A transposed rotation is a rotation: only the place of a translation or of 0,0,0,1 decides.
    decided = len(fits) == 1 and len(cells) > 9
    way, grid = next(iter(fits.items()))
    last = ("0,0,0,1 is its last row", "3x4") if way == ROWS else ("0,0,0,1 is its last column", "4x3")
    turn, place = (tuple(cells[i] for i in part.ravel()) for part in (grid[:3, :3], grid[:3, 3:]))
    matrix, by = f"by {way}" + f" ({last[len(cells) == 12]})" * decided, By.FILE if decided else By.DEFAULT
    return {"orientation": turn, "position": place or None, "matrix": matrix, "order_by": By.USER if order else by}


# What a table of a format names where a header does not tell: its score, and how it is read.


def _sniff_ticks(head: Head) -> int:
    time = head.column("timestamp") if head.names else 0
    stamp = head.rows[0][time] if time is not None and time < head.width else ""
    named = {"timestamp", "x", "y", "z", "qx", "qy", "qz", "qw"} <= set(head.names or ())
    likely = 6 * (head.width == 8) if head.names is None else 85 * named
    return likely if len(stamp) == 18 and are_digits(stamp) else 0


def _sniff_frames(head: Head) -> int:
    """Recognise six bare columns: the second a frame number, the last four of length 1."""
    if head.names is not None or head.separator is not None or head.width != 6:
        return 0
    rows = [r for r in head.rows if len(r) == 6 and all(map(header.is_number, r))]
    counted = bool(rows) and all(are_digits(r[1]) for r in rows)
    unit = sum(abs(math.hypot(*[float(f.replace(",", ".")) for f in r[2:6]]) - 1) < 0.05 for r in rows)
    return 60 if counted and 2 * unit > len(rows) and rows == sorted(rows, key=lambda r: int(r[1])) else 0


def _bare_matrix(head: Head) -> header.Cells | None:
    """Return neighbouring columns that are a matrix with a position, 4x4 before 3x4."""
    runs = (tuple(range(a, a + n)) for n in (16, 12) for a in range(head.width - n + 1))
    return next((cells for cells in runs if _arranged(head, cells, None) is not None), None)


def _of_matrices(head: Head, options: TraceOptions, facts: dict[str, Any]) -> Layout:
    cells = _bare_matrix(head)
    if cells is None:  # the last columns, as a file of matrices alone has them
        count = 16 if head.width >= 16 else 12
        if head.width < count:
            raise TraceError(f"{head.path}: {head.width} columns, expected 12 or 16, or one more with a time first")
        cells = tuple(range(head.width - count, head.width))
    matrix = _of_matrix(head, cells, options.matrix)
    clocks = []  # columns that rise, with how likely each is the clock, and no number of the frame
    for column in set(range(head.width)) - set(cells):
        numbers = head.numbers((column,))[:, 0]
        steps = np.diff(numbers)
        if len(steps) == 0 or float((steps > 0).mean()) > _CLOCKED:
            step = float(np.median(steps)) if len(steps) else 0.0
            likely = column < cells[0], len(set(numbers.tolist())), bool((numbers % 1).any()), step
            clocks.append((likely, -column))
    time = -max(clocks)[1] if clocks else None
    return Layout(time=time, columns_by=By.DEFAULT, **matrix)


def _of_frames(head: Head, options: TraceOptions, facts: dict[str, Any]) -> Layout:
    if head.width < 6:
        raise TraceError(f"{head.path}: line {head.first_line}: {head.width} columns, expected 6: time, frame, w x y z")
    turn, by = ordered(head, (2, 3, 4, 5), options.quat_order or "wxyz"), By.USER if options.quat_order else By.FORMAT
    return Layout(time=0, orientation=turn, columns_by=By.FORMAT, order_by=by, unit_by=By.FORMAT, **facts)


def _of_multiviewpoint(head: Head, options: TraceOptions, facts: dict[str, Any]) -> Layout:
    if {"yaw", "pitch", "roll"} <= set(head.names or ()) and head.column("w") is None:
        what = "Euler angles only, mislabelled (its 'yaw' is the pitch)"
        raise TraceError(f"{head.path} gives {what}: read the twin of this file that holds quaternions")
    return named_layout(head, options, **facts)


def refuse_hanging(head: Head, track: PoseTrack) -> None:
    """Refuse frames whose head hangs upside down, and would be upright had w come last.

    The vertical part of the head's own up is 1 - 2 (x^2 + y^2) in the file's axes. Read in the
    wrong order it swings with the heading. Upside down means a tenth of the time. Errors:
    TraceError.
    """
    x, z, w = (track.orientation_xyzw[:, i] for i in (0, 2, 3))  # OpenXR's x is the file's -y, its z the file's -x
    as_read, other = 1 - 2 * (z**2 + x**2), 1 - 2 * (w**2 + z**2)
    if np.percentile(as_read, 10) < 0 and np.percentile(other, 10) > 0.5:
        what = "has the shape of 't frame w x y z', but read so the head hangs upside down"
        how = "say --quat-order xyzw if w comes last, or --quat-order wxyz if it is right as it is"
        raise TraceError(f"{head.path} {what}: {how}")


SNIFFS: dict[str, Callable[[Head], int]] = {
    "named": lambda head: 10 * (head.names is not None),
    "json": lambda head: 20 * (head.kind == "json" and head.names is not None),
    "ros2": lambda head: 50 * (
        any("header" in name.lower() for name in head.names or ())
        and any(unit == "ns" for *_, unit in header.find_columns(head.names or []).pairs)
    ),
    "matrices": lambda head: 50 * (
        head.names is None and sum(map(header.is_number, head.rows[0])) >= 12 and _bare_matrix(head) is not None
    ),
    **{"ticks": _sniff_ticks, "frames": _sniff_frames},
}  # fmt: skip
LAYOUTS: dict[str, Callable[[Head, TraceOptions, dict[str, Any]], Layout]] = {
    **{"matrices": _of_matrices, "frames": _of_frames, "multiviewpoint": _of_multiviewpoint},
    "stated": lambda head, options, _: stated_layout(head, options),
    "ticks": lambda head, options, facts: (
        named_layout(head, options, **facts) if head.names else unnamed_layout(head, options, "ticks", "xyzw", "100ns")
    ),
}  # fmt: skip
