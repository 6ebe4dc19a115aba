"""Trace formats: one file each, recognised by what a file holds."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from typing import IO, Any

import attrs
import numpy as np

from ...errors import InputError, TraceError
from ...registry import Registry
from ..assumptions import Assumption, By, Defect, Layout
from ..options import AXIS_ANGLE, INVERSE, VECTOR, Euler, TraceOptions, parse_euler
from ..reading.axes import AXES, CLOCK, COLUMNS, DIRECTION, LENGTH, OPENXR, ORIENTATION, POSE, parse_axes
from ..reading.cleaning import Cleaner, LoadedTrace
from ..reading.columns import UNRANKED, Columns, direction_of, find_columns, head_rank, named_matrices
from ..reading.file_head import Head, is_number
from ..reading.matrix_cells import Matrix, matrix_in, read_matrix
from ..reading.rows import RowReader
from ..reading.times import UNIT_NAMES
from ..track import PoseTrack

_ORDER_ASSUMED = Defect(
    "order-assumed",
    "nothing in the file says whether w comes first or last in its quaternions",
    "w last taken, as in TUM files; --quat-order wxyz takes it first",
)
_MIXED = 4  # rows of several devices change from one to another at least every fourth time
_BLOCK = 65536  # rows written at a time
_LARGEST_NS = 2**62  # what the readers accept


class TraceFormat:
    """One layout of head-motion files. A new one is one file in this package.

    Most need nothing but `header` and `facts`, and are tables of these fields.
    """

    name = ""  # the name of the format
    summary = ""  # one line for people
    kind: str = ""  # of the table that such files are made into, see `reading.columns.Made`
    file: str = ""  # what such a file is called, for errors
    header: tuple[str, ...] = ()  # names of columns that every such file has
    likelihood = 90  # of a file with that header, see `sniff`
    facts: Mapping[str, Any] = {}  # what the format states: fields of Layout
    order = ""  # of an orientation's numbers, in words; "": as the names of its columns say
    order_by = By.FILE
    bare_order = ""  # of quaternions in files without a header: xyzw or wxyz; "" where there are none
    writes = False  # whether `write` works
    binary = False  # whether `write` takes a stream of bytes
    axes_written = OPENXR  # of the files that `write` makes

    def sniff(self, head: Head, options: TraceOptions) -> int:
        """Return how likely the file is of this format, 0 to 100 (certainly); the highest wins."""
        if self.kind:
            return 100 if head.source.kind == self.kind else 0
        return self.likelihood if self.header and has(head, *self.header) else 0

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        """Return the meaning of the columns. Errors: TraceError when a required one is missing."""
        if head.names is None and self.bare_order:
            unit = self.facts.get("unit") if options.format else None
            return unnamed_layout(head, options, self.name, self.bare_order, unit)
        return named_layout(head, options, **{**self.facts, **head.source.made.facts})

    def assumes(self) -> tuple[Assumption, ...]:
        """Return what is taken where neither a file nor the user says it, and who says so."""
        facts, axes = self.facts, parse_axes(self.facts.get("axes", OPENXR))
        axes_by = facts.get("axes_by", By.NOBODY)
        unit, scale = facts.get("unit"), facts.get("scale", axes.metres_per_unit or 1.0)
        scale_by = facts.get("scale_by", axes_by if axes.metres_per_unit else By.NOBODY)
        bare = f", {self.bare_order} without a header" if self.bare_order else ""
        order = self.order or f"as the names say{bare}"
        return (
            Assumption(
                CLOCK, UNIT_NAMES[unit] if unit else "what makes a tracker's rate", By.FORMAT if unit else By.NOBODY
            ),
            Assumption(LENGTH, f"{scale:g} m per unit", scale_by, "--scale"),
            Assumption(AXES, axes.label(), axes_by, "--axes"),
            Assumption(ORIENTATION, order, facts.get("order_by", self.order_by), "--quat-order"),
            Assumption(POSE, DIRECTION[bool(facts.get("inverse"))], facts.get("direction_by", By.NOBODY), "--pose"),
        )

    def read(self, head: Head, options: TraceOptions) -> LoadedTrace:
        """Return the clean track of a file. Errors: TraceError, InputError."""
        if self.kind and head.source.kind != self.kind:
            what = self.file or f"file of format {self.name}"
            raise TraceError(f"{head.path} is no {what} ({head.describe()}): leave --format out, or name its own")
        layout = self.layout(head, options)
        if options.time_column is not None:
            layout = attrs.evolve(layout, time=column_of(head, options.time_column), unit=None, nanoseconds=None)
        if (axes := axes_stated(head)) is not None:
            layout = attrs.evolve(layout, axes=axes, axes_by=By.FILE)
        if layout.time is None and options.rate is None:
            raise TraceError(
                f"{head.path} has no time ({head.describe()}): give the samples per second with --trace-rate"
            )
        if options.rate is not None:
            layout = attrs.evolve(layout, time=None, clock_ignored=layout.time is not None)
        reader = RowReader(head, layout, options.lost_rows)
        rows = reader.read()
        layout = attrs.evolve(layout, caveats=(*head.source.made.defects, *layout.caveats, *reader.defects))
        cleaner = Cleaner(head, rows, layout, options, reader.ends_with_newline)
        loaded = cleaner.clean(self.origin(head))
        columns = _columns_read(head, layout, loaded.device)
        read = Assumption(COLUMNS, columns, layout.columns_by, "--columns")
        return attrs.evolve(loaded, format=self.name, columns=columns, assumptions=(read, *loaded.assumptions))

    def origin(self, head: Head) -> str:
        """Return the origin of the motion, if the file states it."""
        return next(
            (text.removeprefix("origin:").strip() for _, text in head.comments if text.startswith("origin:")), ""
        )

    def write(self, track: PoseTrack, stream: IO[Any]) -> None:
        """Write a track so that reading it gives the same poses bit for bit."""
        raise TraceError(f"format {self.name} is read, not written")


def _of_table(name: str, table: dict[str, Any]) -> TraceFormat:
    said = table.pop("facts", {}).items()
    facts: dict[str, Any] = {key: By(value) if key.endswith("_by") else value for key, value in said}
    if caveats := facts.get("caveats"):
        facts["caveats"] = tuple(Defect(**caveat) for caveat in caveats)
    made = TraceFormat()
    made.name, made.facts, made.header = name, facts, tuple(table.pop("header", ()))
    made.order_by = By(table.pop("order_by", made.order_by))
    for field, value in table.items():
        setattr(made, field, value)
    return made


formats: Registry[TraceFormat] = Registry(
    "trace format", __package__, of_table=_of_table, holds_objects=True, columns="can_write=writes"
)


def axes_stated(head: Head) -> str | None:
    """Return the axes that a comment of the file states, as `parse_axes` takes them.

    For instance "# axes: tum-rgbd". Comments in words count where they name OpenXR.
    """
    for _, text in head.comments:
        key, _, value = text.partition(":")
        if key.strip().lower() != "axes":
            continue
        if OPENXR in value.lower():
            return OPENXR
        try:
            parse_axes(value)
        except InputError:
            continue
        return value
    return None


def column_of(head: Head, word: str) -> int:
    """Return the index of a column by name, or by number from 1. Errors: InputError."""
    word = word.strip()
    index = head.column(word)
    if index is None and word.encode(errors="replace").isdigit() and 1 <= int(word) <= head.width:
        index = int(word) - 1
    if index is None:
        raise InputError(f"{head.path} has no column '{word}' ({head.describe()}); numbers count from 1")
    return index


def named_layout(head: Head, options: TraceOptions, **known: Any) -> Layout:
    """Return a layout from the header's names.

    known: facts of the format: unit, axes, device, scale, caveats.
    Errors: TraceError for Euler angles only, and for a quaternion that is missing or of unknown
    order.
    """
    if head.names is None:
        raise TraceError(f"{head.path} has no header ({head.describe()}): its columns cannot be told apart")
    found = find_columns(head.names)
    time, unit = _finest(head, found.clocks)
    facts = {
        "time": time,
        "unit": unit,
        "unit_by": By.FORMAT if "unit" in known else By.FILE,
        "nanoseconds": found.nanoseconds,
        "position": found.position,
        "device": column_of_devices(head),
        "scale": found.length_m or 1.0,
        "scale_by": By.FILE if found.length_m else By.NOBODY,
        "gravity_down": _mean_of(head, found.gravity),
    }
    gaze = tuple(column for name in known.pop("gaze", ()) if (column := head.column(name)) is not None)
    turn = _turn(head, found, options, known)
    facts |= _direction([head.names[c] for c in turn["orientation"]])
    caveats = (*known.pop("caveats", ()), *turn.pop("caveats", ()))
    return Layout(**(facts | turn | known), gaze=gaze if len(gaze) > 2 else (), caveats=caveats)


def _turn(head: Head, found: Columns, options: TraceOptions, known: dict[str, Any]) -> dict[str, Any]:
    """Return how the orientation is read: fields of Layout. Errors: TraceError."""
    euler = known.pop("euler", None) if options.euler is None else parse_euler(options.euler)
    if found.orientation is not None:
        return _quaternion(head, found, options)
    candidates = named_matrices(head.names or [])
    if (matrix := matrix_in(head, candidates, options.matrix)) is not None:
        return of_matrix(matrix, found.position)
    if found.vector is not None and (euler is None or euler.order in (VECTOR, AXIS_ANGLE)):
        order = VECTOR if len(found.vector.columns) == 3 else AXIS_ANGLE
        by = By.USER if options.euler else By.FILE if found.vector.stated else By.NOBODY
        stated = euler or Euler(order, found.vector.degrees)
        return {"orientation": found.vector.columns, "euler": stated, "order_by": by}
    if euler is not None and found.angles is not None:
        order = "xyz" if euler.order == VECTOR else euler.order
        columns = tuple(found.angles["xyz".index(axis)] for axis in order)
        return {"orientation": columns, "euler": euler, "order_by": By.USER if options.euler else By.FORMAT}
    if candidates:
        read_matrix(head, candidates[0], options.matrix)
    raise _no_quaternion(head, found, has_order=options.euler is not None)


def _quaternion(head: Head, found: Columns, options: TraceOptions) -> dict[str, Any]:
    columns, stated = found.orientation or (), options.quat_order
    if not found.numbered:
        return {"orientation": columns, "caveats": (_order_ignored(stated),) if stated else ()}
    if stated is None and head.source.kind == "vectors":
        return {"orientation": columns, "order_by": By.NOBODY, "caveats": (_ORDER_ASSUMED,)}
    return {"orientation": ordered(head, columns, stated), "order_by": By.USER}


def of_matrix(matrix: Matrix, position: tuple[int, int, int] | None) -> dict[str, Any]:
    """Return the fields of Layout of a matrix. position: columns of one in addition."""
    place = matrix.position or position
    return {"orientation": matrix.turn, "position": place, "matrix": matrix.words, "order_by": matrix.by}


def _direction(names: list[str]) -> dict[str, Any]:
    """Return which way poses go where names say it: world_device or world_to_camera."""
    said = direction_of(names)
    return {} if said is None else {"inverse": said == INVERSE, "direction_by": By.FILE}


def unnamed_layout(head: Head, options: TraceOptions, name: str, order: str, unit: str | None) -> Layout:
    """Return the layout of time, position and quaternion in this order, without a header.

    Named as a format, the file has w in that order. Blank-separated it is TUM's, w last, as evo and
    others write and read it; otherwise the order must be stated.
    Errors: TraceError for fewer columns, or an unknown order.
    """
    if head.width < 8:
        raise TraceError(
            f"{head.path}: line {head.first_line}: {head.width} columns, expected 8: time, position and quaternion"
        )
    known = options.quat_order or (order if options.format == name else None)
    assumed = known is None and head.separator is None
    stated = By.FORMAT if options.format == name else By.NOBODY
    return Layout(
        time=0,
        position=(1, 2, 3),
        orientation=ordered(head, (4, 5, 6, 7), "xyzw" if assumed else known),
        columns_by=stated,
        order_by=By.USER if options.quat_order else stated,
        unit=unit,
        unit_by=By.FORMAT,
        caveats=(_ORDER_ASSUMED,) if assumed else (),
    )


def column_of_devices(head: Head) -> int | None:
    """Return the column that names devices, by its own name or by heads or hands in its rows."""
    names = head.names or []
    named = find_columns(names).device
    if named is not None:
        return named
    return next((c for c in range(len(names)) if _names_bodies([r[c] for r in head.rows if c < len(r)])), None)


def _names_bodies(fields: list[str]) -> bool:
    changes = sum(a != b for a, b in itertools.pairwise(fields))
    named = any(head_rank(name) != UNRANKED for name in set(fields) if not is_number(name))
    return named and _MIXED * changes > len(fields)


def _columns_read(head: Head, layout: Layout, device: str) -> str:
    """Return which columns were read as what, by name, or by number from 1.

    device: whose rows were taken; "" where the file does not say.
    """
    names = head.names or []
    parts: dict[str, tuple[int | None, ...]] = {
        "time": (layout.time, layout.nanoseconds),
        "device": (layout.device,),
        "position": layout.position or (),
        "orientation": layout.orientation,
        "gaze": layout.gaze,
    }
    words = {
        part: ", ".join(names[c] if c < len(names) else str(c + 1) for c in columns if c is not None)
        for part, columns in parts.items()
    }
    if device:
        words["device"] += f" = {device}"
    return "; ".join(f"{part}: {columns}" for part, columns in words.items() if columns)


def _finest(head: Head, clocks: tuple[tuple[int, str | None], ...]) -> tuple[int | None, str | None]:
    """Return the clock that takes the most values over the first rows, the likeliest of equals."""

    def values(clock: tuple[int, str | None]) -> int:
        return len({row[clock[0]] for row in head.rows if len(row) > clock[0] and row[clock[0]]})

    return max(clocks, key=values, default=(None, None))


def _mean_of(head: Head, columns: tuple[int, int, int] | None) -> tuple[float, ...]:
    """Return the mean of three columns over the first rows; zeros where one holds no number."""
    rows = [[row[c] for c in columns] for row in head.rows if len(row) > max(columns)] if columns else []
    numbers = [[float(f) for f in row] for row in rows if all(is_number(f) and "," not in f for f in row)]
    return tuple(sum(column) / len(numbers) for column in zip(*numbers, strict=True)) if numbers else (0.0, 0.0, 0.0)


def _order_ignored(order: str) -> Defect:
    return Defect(
        "quat-order-named",
        f"--quat-order {order} was given, but the header names x, y, z and w",
        "the names are followed",
    )


def _no_quaternion(head: Head, found: Columns, *, has_order: bool) -> TraceError:
    if found.euler:
        names = ", ".join(found.euler[:4])
        if has_order:
            return TraceError(f"{head.path}: --euler takes three angles, called pitch, yaw and roll; found {names}")
        return TraceError(
            f"{head.path} gives Euler angles only ({names}): their order and signs differ "
            "from device to device, and the file does not state them; --euler does (ZXY,deg is Unity's; vector,rad a "
            "rotation vector)"
        )
    return TraceError(
        f"{head.path} has no head orientation as a quaternion among {head.describe()}; see 'hmdwarp list formats'"
    )


def ordered(head: Head, columns: tuple[int, ...], order: str | None) -> tuple[int, int, int, int]:
    """Return four quaternion columns in the order x y z w. Errors: TraceError if unknown."""
    if order is None:
        raise TraceError(
            f"{head.path}: nothing in the file tells whether w comes first or last in its quaternions "
            f"({head.describe()}); say --quat-order wxyz or --quat-order xyzw"
        )
    a, b, c, d = columns
    return (b, c, d, a) if order == "wxyz" else (a, b, c, d)


def has(head: Head, *names: str) -> bool:
    """Return whether the header has all these names."""
    return head.names is not None and set(names) <= set(head.names)


def numbers_alone(head: Head, separator: str | None, *widths: int) -> bool:
    """Return whether the file has no header, one of these widths, and numbers in its first row."""
    same = head.names is None and head.separator == separator and head.width in widths
    return same and all(is_number(f) for f in head.rows[0])


def clock_offset_ns(track: PoseTrack) -> int:
    """Return what restores the recording's own clock; 0 where that is beyond 2^62 ns."""
    fits = abs(track.epoch_ns + track.start_ns) < _LARGEST_NS and abs(track.epoch_ns + track.end_ns) < _LARGEST_NS
    return track.epoch_ns if fits else 0


def write_rows(
    track: PoseTrack,
    stream: IO[str],
    separator: str,
    *,
    stamp: Callable[[int], str],
    order: str,
    decimals: tuple[int, int] | None = None,
    gaze: bool = False,
) -> None:
    """Write time, position and quaternion of every sample.

    stamp: nanoseconds to text.
    order: xyzw or wxyz.
    decimals: of positions and quaternions; None writes the shortest text that reads back as the
    same number.
    gaze: where the eyes look, too, if the track has it; 0 0 0 where it is not known.
    """
    offset = clock_offset_ns(track)
    columns = ["xyzw".index(c) for c in order]

    def form(numbers: list[float]) -> str:
        if decimals is None:
            return separator.join(map(repr, numbers))
        return row % tuple(numbers)

    more = 0 if track.gaze is None or not gaze else 3
    row = separator.join([f"%.{decimals[0]}f"] * 3 + [f"%.{decimals[1]}f"] * (4 + more)) if decimals is not None else ""
    for a in range(0, len(track), _BLOCK):
        part = slice(a, a + _BLOCK)
        position, orientation = track.position_m[part], track.orientation_xyzw[part][:, columns]
        if track.gaze is not None and gaze:
            orientation = np.hstack([orientation, np.nan_to_num(track.gaze[part])])
        if decimals is not None:  # + 0.0 turns a rounded -0.0 into 0.0
            position, orientation = np.round(position, decimals[0]) + 0.0, np.round(orientation, decimals[1]) + 0.0
        texts = [form(p + q) for p, q in zip(position.tolist(), orientation.tolist(), strict=True)]
        times = track.time_ns[part].tolist()
        stream.writelines(f"{stamp(t + offset)}{separator}{text}\n" for t, text in zip(times, texts, strict=True))
