"""What the columns of a file mean: by names in its header, by its shape, or as the user says.

A name is cut into words (`HeadOrientationW` -> head orientation w, `p_RS_R_x [m]` -> p rs r x m);
the last of x y z w among them is the axis, the rest identifies the position or orientation, never
the place of its column.
"""

from __future__ import annotations

import itertools
import re
import tomllib
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import InputError, TraceError, are_digits
from ..assumptions import By, Defect, Layout
from ..options import COLUMNS, FRAMES, INVERSE, ROWS, VECTOR, Euler, TraceOptions, parse_euler

COMMENT_SIGNS = ("#", "%", "//")
_NUMBER = re.compile(
    r"[-+]?([0-9]+([.,][0-9]*)?|[.,][0-9]+)([eE][-+]?[0-9]+)?$|[-+]?(nan|inf|infinity)$", re.IGNORECASE
)
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_BETWEEN = re.compile(r"[Cc]ent(?:er|re)[^A-Za-z0-9]*[Ee]ye(?![a-z])")
_GLUED = re.compile(r"^(q|quat|p|t|pos|rot|orientation|position|quaternion|rotation)([xyzw])$")
_NUMBERED = re.compile(r"(?:(.*)\.)?q_?([0-3])$", re.IGNORECASE)  # of records, after the name of their part
BILLION = 1_000_000_000
UNITS_NS = {"s": BILLION, "ms": 1_000_000, "us": 1_000, "100ns": 100, "ns": 1}

_TABLE = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
_TIME_UNITS = {word: unit for unit, text in _TABLE["units"].items() for word in text.split()}
_WORDS = {name: frozenset(text.split()) for name, text in _TABLE["words"].items()}
_ROTATION, _POSITION, _VECTOR, _ANGLE, _DEGREES, _RADIANS, _EULER, *_REST = _WORDS.values()
_ELSEWHERE, _TIMES, _FRAMES, _OWN, _ANOTHERS, _STEPS, _DEVICES = _REST
_BODY = "(?:head|hmd|headset|device|camera|cam|eye|c|body|imu)"
_WAYS = {way: form.replace("{body}", _BODY) for way, form in _TABLE["ways"].items()}
_BARE_TURNS = ("rx", "ry", "rz")
_HEAD = ("head", "hmd", "headset", "centereye", "maincam", "xrcam", "camera", "cam")  # the likeliest first
_UNRANKED = len(_HEAD)  # what `head_rank` gives for a name that tells nothing
LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2}
_ANGLES = {"pitch": "x", "yaw": "y", "roll": "z"}
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
_COUNTS = {"t": (1,), "p": (3,), "q": (4,), "m": (9, 12, 16), "e": (3,)}
Three = tuple[int, int, int]
Cells = tuple[int, ...]  # columns of 9, 12 or 16 numbers in the order of the file
_SHAPES = {16: (4, 4), 12: (3, 4), 9: (3, 3)}
_CELL = re.compile(r"(.*?)[._\[\s]*([0-4])[\]._,\s]*\[?([0-4])\]?$")
_PLACE = re.compile(r"(.*?)[._\[\s]*(\d{1,2})\]?$")


@attrs.frozen
class Made:
    """Rows that were made of what is no rows, and what the file says of them."""

    kind: str  # what `TraceFormat.kind` looks for
    rows: list[list[str]]
    names: tuple[str, ...] = ()  # of the columns, if they have any
    defects: tuple[Defect, ...] = ()  # found while the rows were made
    nested: Mapping[str, Defect] = attrs.field(factory=dict)  # those of one device's rows
    facts: Mapping[str, Any] = attrs.field(factory=dict)  # fields of Layout that the file states


@attrs.frozen
class Head:
    """The findings from the first part of a trace file."""

    path: Path
    made: Made | None
    separator: str | None  # "," ";" "\t" or None for blanks
    names: list[str]  # the header's, [] for none; a comment counts if it names as many columns as the rows have
    first_line: int  # where the rows begin
    first_byte: int  # where the rows begin
    rows: list[list[str]]  # fields of the first rows
    comments: list[tuple[int, str]]  # (line, text without the comment sign) before the rows
    decimal_comma: bool  # numbers are written 0,5
    newline: str  # "\n" or "\r"

    @property
    def kind(self) -> str:
        """Of the rows: "text", or what they were made of, such as "json"."""
        return "text" if self.made is None else self.made.kind

    @property
    def width(self) -> int:
        """Fields in the first row."""
        return len(self.rows[0])

    def cells(self, column: int) -> list[str]:
        return [row[column] for row in self.rows if len(row) > column and row[column]]

    def numbers(self, columns: tuple[int, ...]) -> NDArray[np.float64]:
        """Return (n, columns) of those of the first rows that have a number in each."""
        rows = [[row[c].replace(",", ".") for c in columns] for row in self.rows if len(row) > max(columns)]
        good = [row for row in rows if all(map(is_number, row))]
        return np.array(good, dtype=np.float64).reshape(-1, len(columns))

    def column(self, name: str) -> int | None:
        return self.names.index(name) if name in self.names else None

    def name_of(self, column: int) -> str:
        """Return its name in the header, or its number."""
        return self.names[column] if column < len(self.names) else f"column {column + 1}"

    def describe(self) -> str:
        how = {None: "blank", ",": "comma", ";": "semicolon", "\t": "tab"}[self.separator]
        named = f"the columns {', '.join(self.names)}" if self.names else "no header"
        return f"{self.width} {how}-separated columns and {named if len(named) < 160 else named[:157] + '...'}"


def is_number(field: str) -> bool:  # with decimal point or comma
    return _NUMBER.match(field) is not None


def head_rank(name: str) -> int:
    """Return how likely a device is the head, by its name: 0 most, hands and hips least."""
    found = set(words(name))
    if found & (_ELSEWHERE - {"eye"} if "camera" in found else _ELSEWHERE):  # "Camera (eye)" is SteamVR's head
        return _UNRANKED + 1
    return next((rank for rank, word in enumerate(_HEAD) if word in found), _UNRANKED)


def names_rotation(name: str) -> bool:
    return bool(set(words(name)) & _ROTATION)


def has_pose(names: list[str]) -> bool:
    found = Columns(names)
    return found.orientation is not None or bool(found.vector or named_matrices(names))


def words(name: str) -> list[str]:
    """Return the lower-case words of a column name; those of the eye between both are one word."""
    found = _WORD.findall(_BETWEEN.sub("Centereye", name))
    return " ".join(_GLUED.sub(r"\1 \2", word.lower()) for word in found).split()


class Columns:
    """Indices of the columns of one head, by their names; None where there are none."""

    def __init__(self, names: list[str]) -> None:
        split = [words(n) for n in names]
        self._find_clocks(split)
        letters = [re.sub("[^a-z]", "", n.lower()) for n in names]
        self.frames = next((i for i, name in enumerate(letters) if name in _FRAMES), None)
        self.device = next((i for i, name in enumerate(letters) if name in _DEVICES), None)
        groups: dict[tuple[str, ...], dict[str, int]] = defaultdict(dict)  # by the words beside the axis
        orders: dict[tuple[str, ...], dict[str, int]] = defaultdict(dict)
        lengths: dict[tuple[str, ...], float] = {}
        for i, found in enumerate(split):
            if found_number := _NUMBERED.match(names[i].strip()):
                orders[tuple(words(found_number[1] or ""))].setdefault("xyzw"[int(found_number[2])], i)
            unit = found[-1] if len(found) > 1 and found[-1] in LENGTHS else None
            parts = found[:-1] if unit else found
            axis = next((k for k in reversed(range(len(parts))) if parts[k] in "xyzw" and len(parts[k]) == 1), None)
            if axis is None and set(parts) & _VECTOR and parts[-1] in ("0", "1", "2"):
                axis, parts = len(parts) - 1, [*parts[:-1], "xyz"[int(parts[-1])]]
            if axis is not None:
                key = tuple(parts[:axis] + parts[axis + 1 :])
                groups[key].setdefault(parts[axis], i)
                lengths |= {key: LENGTHS[unit]} if unit else {}

        def best(keys: Iterable[tuple[str, ...]]) -> tuple[str, ...] | None:
            """Return the head's group, no hand's or gaze's: "head" first, else the plainest."""
            heads = [k for k in keys if not set(k) & _ELSEWHERE]
            return min(heads, key=lambda k: (not set(k) & set(_HEAD), len(k)), default=None)

        def xyz(key: tuple[str, ...] | None) -> Three | None:
            return None if key is None else (groups[key]["x"], groups[key]["y"], groups[key]["z"])

        turn_key = best(k for k, g in groups.items() if len(g) == 4 and (set(k) & _ROTATION or not k))
        order_key = best(key for key, order in orders.items() if len(order) == 4) if turn_key is None else None
        turn = groups[turn_key] if turn_key is not None else orders[order_key] if order_key is not None else None
        self.orientation = None if turn is None else tuple(turn[part] for part in "xyzw")  # or as numbered
        self.numbered = order_key is not None  # they are q0 .. q3, whose order the names leave open
        triples = [k for k, g in groups.items() if {"x", "y", "z"} <= set(g)]
        place_key = best(k for k in triples if k != turn_key and (set(k) & _POSITION or set(k) <= set(_HEAD)))
        self.position = xyz(place_key)
        self.length_m = None if place_key is None else lengths.get(place_key)  # metres per unit
        self.gravity = xyz(next((k for k in triples if "gravity" in k), None))  # the direction down
        pairs = (_ROTATION, {"vector", "vec"}), ({"axis"}, {"angle"})  # of words that say together what a vector is
        turning = [k for k in triples if set(k) & _VECTOR or any(set(k) & a and set(k) & b for a, b in pairs)]
        # An axis with its angle in a column of its own is no vector.
        angled = any(set(parts) & _ANGLE and not set(parts) & (_ELSEWHERE | {*"xyz"}) for parts in split)
        # A rotation vector, and "deg" or "rad" if the names say it.
        self.vector = xyz(best(k for k in turning if "w" not in groups[k] and not (angled and "axis" in k)))
        about = {word for column in self.vector or () for word in split[column]}
        self.vector_unit = "deg" if about & _DEGREES else "rad" if about & _RADIANS else ""
        named = {word: i for i, parts in enumerate(split) for word in set(parts) & set(_ANGLES)}
        axes = ((axis, named[word]) for word, axis in _ANGLES.items() if word in named)
        turns = {axis: column for axis, column in axes if not set(split[column]) & _ELSEWHERE}
        bare = {parts[0][1]: i for i, parts in enumerate(split) if parts and parts[0] in _BARE_TURNS}
        angles = next(((at["x"], at["y"], at["z"]) for at in (turns, bare) if len(at) == 3), None)
        self.angles = angles or xyz(best(k for k in triples if set(k) & (_ROTATION | _EULER)))  # about x, y and z

    def _find_clocks(self, split: list[list[str]]) -> None:
        told = [(i, parts) for i, parts in enumerate(split) if parts and not set(parts) & (_ELSEWHERE | _STEPS)]
        seconds = {tuple(parts[:-1]): i for i, parts in told if _TIME_UNITS.get(parts[-1]) == "s"}
        rests = [(seconds.get(tuple(parts[:-1])), i, _TIME_UNITS.get(parts[-1], "s")) for i, parts in told]
        # Clocks in two columns: whole seconds, the rest, its unit.
        self.pairs = [(whole, i, unit) for whole, i, unit in rests if unit != "s" and whole is not None]
        clocks: list[tuple[int, int, str | None]] = []  # rank, column, unit
        for i, parts in told:
            said = _TIME_UNITS.get(parts[-1]) if len(parts) > 1 else None
            rest = parts[:-1] if said else parts
            joined = "".join(rest)
            if joined in _TIMES:
                clocks.append((0, i, said))
            elif "date" not in parts and (set(rest) & (_TIMES - {"t"}) or re.search("timest(amp|ep)", joined)):
                clocks.append((1, i, said))
        # The likeliest first: column, and unit if the name says it.
        self.clocks = [(i, said) for _, i, said in sorted(clocks, key=lambda clock: clock[:2])]


def named_matrices(names: list[str]) -> list[Cells]:
    """Return the columns of every matrix that names number: m00 .. m33, r11 .. r33, T.0 .. T.15."""
    grids: dict[str, dict[tuple[int, int], int]] = defaultdict(dict)
    runs: dict[str, dict[int, int]] = defaultdict(dict)
    for i, name in enumerate(names):
        if found := _CELL.match(name):
            grids[found[1]].setdefault((int(found[2]), int(found[3])), i)
        if found := _PLACE.match(name):
            runs[found[1]].setdefault(int(found[2]), i)
    matrices: list[tuple[str, Cells]] = []
    shapes = [(*shape, first) for shape in _SHAPES.values() for first in (0, 1)]
    wholes = [[(first + r, first + c) for r in range(high) for c in range(wide)] for high, wide, first in shapes]
    for name, group in grids.items():
        whole = next((cells for cells in wholes if set(cells) <= set(group)), None)
        matrices += [(name, tuple(group[cell] for cell in whole))] if whole else []
    for name, run in runs.items():
        if len(run) in _SHAPES and (first := min(run)) <= 1 and set(run) == {*range(first, first + len(run))}:
            matrices.append((name, tuple(column for _, column in sorted(run.items()))))

    def rank(one: tuple[str, Cells]) -> tuple[bool, int, int]:
        other = bool(set(words(one[0])) & {"projection", "proj", "view", "inverse", "inv"})
        return other, head_rank(one[0]), -len(one[1])

    return [cells for _, cells in sorted(matrices, key=rank)]


def named_layout(head: Head, options: TraceOptions, **known: Any) -> Layout:
    """Return a layout from the header's names and the facts of the format. Errors: TraceError."""
    if not (names := head.names):
        raise TraceError(f"{head.path} has no header ({head.describe()}): its columns cannot be told apart")
    found = Columns(names)
    facts: dict[str, Any] = {"time": None, "position": found.position, "device": _column_of_devices(head)}
    facts |= {"unit_by": By.FORMAT if "unit" in known else By.FILE, "scale": found.length_m or 1.0}
    facts["scale_by"] = By.FILE if found.length_m else By.DEFAULT
    caveats = known.pop("caveats", ())

    def owner(column: int) -> int:
        """Return whose clock a column is: 0 the pose's, 1 unknown, 2 a writer's or receiver's."""
        found = set(words(names[column]))
        return 2 if found & _ANOTHERS else 0 if found & _OWN else 1

    for whole, rest, unit in sorted(found.pairs, key=lambda pair: owner(pair[0])):
        counts = [cell for cell in head.cells(rest) if are_digits(cell) and int(cell) < BILLION // UNITS_NS[unit]]
        if len(counts) == len(head.cells(rest)) and all(map(are_digits, head.cells(whole))):
            facts |= {"time": whole, "unit": "s", "rest": rest, "rest_unit": unit}
            break
    else:
        values = {column: len(set(head.cells(column))) for column, _ in found.clocks}
        # Those that take the most values over the first rows, then the pose's own.
        fine = [clock for clock in found.clocks if 10 * values[clock[0]] > 9 * max(values.values())]
        time, said = min(fine, key=lambda clock: owner(clock[0]), default=(None, None))
        facts |= {"time": time, "unit": said}
        others = ", ".join(names[column] for column, _ in found.clocks if column != time)
        if time is not None and others:
            done = f"{names[time]} taken; --time-column takes another"
            caveats += (Defect("clocks-several", f"its rows have other clocks as well ({others})", done),)
    if found.gravity and len(down := head.numbers(found.gravity)):
        facts["gravity_down"] = tuple(down.mean(axis=0).tolist())
    gaze = tuple(column for name in known.pop("gaze", ()) if (column := head.column(name)) is not None)
    turn = _turn(head, found, options, known)
    text = " ".join("_".join(words(names[column])) for column in turn["orientation"])
    way = next((way for way, form in _WAYS.items() if re.search(rf"(?:^|[ _])(?:{form})(?=[ _]|$)", text)), None)
    if way is not None:
        facts |= {"inverse": way == INVERSE, "direction_by": By.FILE}
    caveats = (*turn.pop("caveats", ()), *caveats)
    return Layout(**(facts | turn | known), gaze=gaze if len(gaze) > 2 else (), caveats=caveats)


def _turn(head: Head, found: Columns, options: TraceOptions, known: dict[str, Any]) -> dict[str, Any]:
    """Return how the orientation is read: fields of Layout. Errors: TraceError."""
    euler = known.pop("euler", None) if options.euler is None else parse_euler(options.euler)
    order, twin = options.quat_order, known.pop("angles_refused", "")
    if found.orientation is not None:
        what = f"--quat-order {order} was given, but the header names x, y, z and w"
        ignored = Defect("quat-order-named", what, "the names are followed")
        turn: dict[str, Any] = {"orientation": found.orientation, "caveats": (ignored,) if order else ()}
        if found.numbered and order is None and head.kind == "vectors":
            turn |= {"order_by": By.DEFAULT, "caveats": (_ORDER_ASSUMED,)}
        elif found.numbered:
            turn = {"orientation": ordered(head, found.orientation, order), "order_by": By.USER}
        return turn
    candidates = named_matrices(head.names)
    matrix = next(filter(None, (_arranged(head, cells, options.matrix) for cells in candidates)), None)
    if matrix is not None:
        return matrix | {"position": matrix["position"] or found.position}
    if found.vector and (euler is None or euler.order == VECTOR):
        by = By.USER if options.euler else By.FILE if found.vector_unit else By.DEFAULT
        euler = euler or Euler(VECTOR, found.vector_unit == "deg")
        return {"orientation": found.vector, "euler": euler, "order_by": by}
    if found.angles is not None and twin:
        raise TraceError(f"{head.path} {twin}")
    if euler is not None and found.angles is not None:
        axes = "xyz" if euler.order == VECTOR else euler.order
        columns = tuple(found.angles["xyz".index(axis)] for axis in axes)
        return {"orientation": columns, "euler": euler, "order_by": By.USER if options.euler else By.FORMAT}
    if candidates:
        return _of_matrix(head, candidates[0], options.matrix)  # it refuses them
    if found.angles is not None:
        angles = ", ".join(map(head.name_of, found.angles))
        how = "--euler states their order (ZXY,deg is Unity's; vector,rad a rotation vector)"
        raise TraceError(f"{head.path} gives Euler angles only ({angles}), in an order that it does not state: {how}")
    raise TraceError(f"{head.path} has no head orientation among {head.describe()}; see 'hmdwarp list formats'")


def unnamed_layout(head: Head, options: TraceOptions, order: str, unit: str) -> Layout:
    """Return the layout of time, position and quaternion in this order, without a header.

    Named as a format, the file has w and the unit as that has it. Blank-separated it is TUM's, w
    last, as evo and others write it; otherwise the order must be stated. Errors: TraceError.
    """
    if head.width < 8:
        raise TraceError(f"{head.path}: line {head.first_line}: {head.width} columns, expected 8: a time and a pose")
    is_named = options.format is not None
    known = options.quat_order or (order if is_named else None)
    assumed, stated = known is None and head.separator is None, By.FORMAT if is_named else By.DEFAULT
    return Layout(
        0, ordered(head, (4, 5, 6, 7), "xyzw" if assumed else known), position=(1, 2, 3),
        unit=unit if is_named else None, unit_by=By.FORMAT, columns_by=stated,
        order_by=By.USER if options.quat_order else stated, caveats=(_ORDER_ASSUMED,) if assumed else (),
    )  # fmt: skip


def ordered(head: Head, columns: tuple[int, ...], order: str | None) -> tuple[int, ...]:
    """Return four quaternion columns in the order x y z w. Errors: TraceError if unknown."""
    if order is None:
        what = f"nothing tells whether w comes first or last in its quaternions ({head.describe()})"
        raise TraceError(f"{head.path}: {what}; say --quat-order wxyz or --quat-order xyzw")
    return (*columns[1:], columns[0]) if order == "wxyz" else columns


def _column_of(head: Head, word: str) -> int:
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
    if (named := Columns(head.names).device) is not None:
        return named
    for column in range(len(head.names)):
        fields = [row[column] for row in head.rows if column < len(row)]
        changes = sum(a != b for a, b in itertools.pairwise(fields))
        bodies = any(head_rank(name) != _UNRANKED for name in set(fields) if not is_number(name))
        if bodies and _MIXED * changes > len(fields):
            return column
    return None


def with_clock(head: Head, layout: Layout, options: TraceOptions) -> Layout:
    """Return the layout with the clock that the options name, or their rate. Errors: TraceError."""
    frames, rate = Columns(head.names).frames, options.rate
    if options.time_column is not None:
        frames = _column_of(head, options.time_column)
        layout = attrs.evolve(layout, time=frames, unit=None, rest=None)
    if rate is None:
        if layout.time is None:
            what = f"{head.path} has no time ({head.describe()})"
            raise TraceError(f"{what}: --time-column names it, or --trace-rate gives samples or frames per second")
        if options.time_unit == FRAMES:
            raise TraceError(f"{head.path}: frame numbers are no times: --trace-rate gives the frames per second")
        return layout
    is_counted = options.time_unit == FRAMES
    if is_counted:
        frames = layout.time if frames is None or options.columns else frames
        if frames is None:
            raise TraceError(f"{head.path} numbers no frames ({head.describe()}): --time-column names the column")
    elif frames is not None:
        numbers = head.numbers((frames,))[:, 0]
        steps = np.diff(numbers)
        whole = len(steps) > 0 and bool((steps > 0).all() and (numbers % 1 == 0).all())
        is_counted = whole and (options.time_column is not None or float(np.median(steps)) == 1)
        if options.time_column and not whole:
            what = f"{head.name_of(frames)} numbers no frames, which --trace-rate would count"
            raise TraceError(f"{head.path}: {what}: leave one of --time-column and --trace-rate out")
    if is_counted:
        return attrs.evolve(layout, time=frames, unit=FRAMES, rest=None)
    return attrs.evolve(layout, time=None, clock_ignored=layout.time is not None)


def columns_read(head: Head, layout: Layout, device: str) -> str:
    """Return which columns were read as what, by name or number. device: whose rows, or ""."""
    parts: dict[str, tuple[int | None, ...]] = {"time": (layout.time, layout.rest), "device": (layout.device,)}
    parts |= {"position": layout.position or (), "orientation": layout.orientation, "gaze": layout.gaze}
    told = []
    for part, columns in parts.items():
        text = ", ".join(head.name_of(c).removeprefix("column ") for c in columns if c is not None)
        text += f" = {device}" if part == "device" and device else ""
        told += [f"{part}: {text}"] if text else []
    return "; ".join(told)


def stated_layout(head: Head, options: TraceOptions, _facts: Mapping[str, Any]) -> Layout:
    """Return the layout of --columns; w is last unless --quat-order says otherwise."""
    text = options.columns or ""
    parts = [part.partition("=") for part in text.split(",")]
    stated: dict[str, tuple[int, ...]] = {}
    for key, _, value in parts:
        each: Iterable[str] = value.split("+")
        if (span := re.fullmatch(r"\s*(\d+)\s*-\s*(\d+)\s*", value)) and head.column(value) is None:  # such as 2-17
            each = map(str, range(int(span[1]), int(span[2]) + 1))
        if value:
            stated[key.strip()] = tuple(_column_of(head, word) for word in each)
    turns = [key for key in stated if key in "qme"]
    counts = all(len(columns) in _COUNTS.get(key, ()) for key, columns in stated.items())
    if len(stated) != len(parts) or len(turns) != 1 or not counts:
        raise InputError(f"--columns '{text}': expected {_SYNTAX}")
    key, columns = turns[0], stated[turns[0]]
    facts: dict[str, Any] = {"orientation": columns, "order_by": By.USER}
    if key == "m":
        facts = _of_matrix(head, columns, options.matrix)
    elif key == "q":
        facts["orientation"] = ordered(head, columns, options.quat_order or "xyzw")
    elif options.euler is None:
        raise InputError("--columns e= names angles: --euler states their order and unit (ZXY,deg is Unity's)")
    else:
        facts["euler"] = parse_euler(options.euler)
    (time,), place = stated.get("t", (None,)), facts.get("position") or stated.get("p")
    return Layout(time=time, columns_by=By.USER, device=_column_of_devices(head), **facts | {"position": place})


def _of_matrix(head: Head, cells: Cells, order: str | None) -> dict[str, Any]:
    found = _arranged(head, cells, order)
    if found is None:
        last = ", nor 0,0,0,1 in the last row or column" if len(cells) == 16 else ""
        what = f"its {len(cells)} numbers of a matrix are no rotations by {order or 'rows or columns'}{last}"
        raise TraceError(f"{head.path}: {what}: were the wrong columns read? --columns m=2-17 names them")
    return found


def _arranged(head: Head, cells: Cells, order: str | None) -> dict[str, Any] | None:
    """Return fields of Layout for a matrix; None where the numbers are no rotation."""
    numbers, (high, wide) = head.numbers(cells), _SHAPES[len(cells)]
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


def _sniff_frames(head: Head) -> int:
    """Recognise six bare columns: the second a frame number, the last four of length 1."""
    rows = [row for row in head.rows if len(row) == 6 and all(map(is_number, row))]
    if head.names or head.separator is not None or head.width != 6 or not all(are_digits(row[1]) for row in rows):
        return 0
    numbers = head.numbers((0, 1, 2, 3, 4, 5))
    unit = np.abs(np.linalg.norm(numbers[:, 2:], axis=1) - 1) < 0.05
    return 60 if 2 * unit.sum() > len(unit) and (np.diff(numbers[:, 1]) >= 0).all() else 0


def _of_frames(head: Head, options: TraceOptions, facts: Mapping[str, Any]) -> Layout:
    if head.width < 6:
        raise TraceError(f"{head.path}: line {head.first_line}: {head.width} columns, expected 6: time, frame, w x y z")
    by = By.USER if options.quat_order else By.FORMAT if options.format else By.DEFAULT
    turn = ordered(head, (2, 3, 4, 5), options.quat_order or "wxyz")
    return Layout(time=0, orientation=turn, columns_by=By.FORMAT, order_by=by, unit_by=By.FORMAT, **facts)


def _bare_matrix(head: Head) -> Cells | None:
    """Return neighbouring columns that are a matrix with a position, 4x4 before 3x4."""
    runs = (tuple(range(a, a + n)) for n in (16, 12) for a in range(head.width - n + 1))
    return next((cells for cells in runs if _arranged(head, cells, None) is not None), None)


def _of_matrices(head: Head, options: TraceOptions, _: Mapping[str, Any]) -> Layout:
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
    return Layout(time=-max(clocks)[1] if clocks else None, columns_by=By.DEFAULT, **matrix)


# What a table of a format names where a header does not tell: its score, and how it is read.
SNIFFS: dict[str, Callable[[Head], int]] = {
    "named": lambda head: 10 * bool(head.names),
    "json": lambda head: 20 * (head.kind == "json" and bool(head.names)),
    "ros2": lambda head: 50 * (
        any("header" in name.lower() for name in head.names)
        and any(unit == "ns" for *_, unit in Columns(head.names).pairs)
    ),
    "matrices": lambda head: 50 * (
        not head.names and sum(map(is_number, head.rows[0])) >= 12 and _bare_matrix(head) is not None
    ),
    "frames": _sniff_frames,
}  # fmt: skip
LAYOUTS = {"matrices": _of_matrices, "frames": _of_frames, "stated": stated_layout}
