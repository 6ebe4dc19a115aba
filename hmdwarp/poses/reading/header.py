"""Meaning of columns, by name and never by position.

A name is cut into words (`HeadOrientationW` -> head orientation w, `p_RS_R_x [m]` -> p rs r x m);
the last of x y z w among them is the axis, the rest identifies the position or orientation.
"""

from __future__ import annotations

import re
import tomllib
from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import attrs

from ..assumptions import Defect

COMMENT_SIGNS = ("#", "%", "//")
_NUMBER = re.compile(
    r"[-+]?([0-9]+([.,][0-9]*)?|[.,][0-9]+)([eE][-+]?[0-9]+)?$|[-+]?(nan|inf|infinity)$", re.IGNORECASE
)
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_GLUED = re.compile(r"(q|quat|p|t|pos|rot|orientation|position|quaternion|rotation)([xyzw])$")
_NUMBERED = re.compile(r"(?:(.*)\.)?q_?([0-3])$", re.IGNORECASE)  # of records, after the name of their part


_TABLE = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
_TIME_UNITS = {word: unit for unit, text in _TABLE["units"].items() for word in text.split()}
_WORDS = {name: frozenset(text.split()) for name, text in _TABLE["words"].items()}
_ROTATION, _POSITION, _VECTOR, _ANGLE, _DEGREES, _RADIANS, _EULER, *_REST = _WORDS.values()
_ELSEWHERE, _TIMES, _DATES, _FRAMES, _OWN, _ANOTHERS, _STEPS, _DEVICES = _REST
_BODY = "(?:head|hmd|headset|device|camera|cam|eye|c|body|imu)"
_WAYS = {way: form.replace("{body}", _BODY) for way, form in _TABLE["ways"].items()}
_BARE_TURNS = ("rx", "ry", "rz")
_HEAD = ("head", "hmd", "headset", "centereye", "maincam", "xrcam", "camera", "cam")  # the likeliest first
UNRANKED = len(_HEAD)  # what `head_rank` gives for a name that tells nothing
LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2}
Groups = dict[tuple[str, ...], dict[str, int]]  # columns of each axis, by the other words of their names
_ANGLES = {"pitch": "x", "yaw": "y", "roll": "z"}


@attrs.frozen
class Columns:
    """Indices of the columns of one head."""

    # Every clock, the likeliest first: its column, and its unit, a key of `times.UNITS_NS`, if the
    # name says it.
    clocks: tuple[tuple[int, str | None], ...] = ()
    # What may be a clock in two columns: whole seconds, the rest, its unit; a date beside a time.
    pairs: tuple[tuple[int, int, str], ...] = ()
    date: int | None = None
    frames: int | None = None  # that numbers frames
    orientation: tuple[int, int, int, int] | None = None  # in the order x y z w, or as numbered
    numbered: bool = False  # the quaternion's columns are q0..q3, whose order the names leave open
    position: tuple[int, int, int] | None = None
    length_m: float | None = None  # metres per unit if the name says it
    device: int | None = None
    vector: tuple[int, int, int] | None = None  # columns of a rotation vector
    vector_unit: str = ""  # "deg" or "rad" if the names say it
    angles: tuple[int, int, int] | None = None  # columns of the angles about x, y and z
    gravity: tuple[int, int, int] | None = None  # columns of the direction down, in the file's world


def is_number(field: str) -> bool:  # with decimal point or comma
    return _NUMBER.match(field) is not None


def head_rank(name: str) -> int:
    """Return how likely a device is the head, by its name: 0 most, hands and hips least."""
    found = set(words(name))
    if found & (_ELSEWHERE - {"eye"} if "camera" in found else _ELSEWHERE):  # "Camera (eye)" is SteamVR's head
        return UNRANKED + 1
    return next((rank for rank, word in enumerate(_HEAD) if word in found), UNRANKED)


def direction_of(names: list[str]) -> str | None:
    """Return `direct` or `inverse` where names of poses say which way they go, else None."""
    text = " ".join("_".join(words(name)) for name in names)
    return next((way for way, form in _WAYS.items() if re.search(rf"(?:^|[ _])(?:{form})(?=[ _]|$)", text)), None)


def names_rotation(name: str) -> bool:
    return bool(set(words(name)) & _ROTATION)


def words(name: str) -> list[str]:
    """Return the lower-case words of a column name; those of the eye between both are one word."""
    out: list[str] = []
    for word in _WORD.findall(name):
        low = word.lower()
        glued = _GLUED.match(low)
        if out and low == "eye" and out[-1] in ("center", "centre"):
            out[-1] = "centereye"
            continue
        out += list(glued.groups()) if glued else [low]
    return out


def find_columns(names: list[str]) -> Columns:
    split = [words(n) for n in names]
    groups: dict[tuple[str, ...], dict[str, int]] = defaultdict(dict)
    lengths: dict[tuple[str, ...], float] = {}
    for i, found in enumerate(split):
        unit = found[-1] if len(found) > 1 and found[-1] in LENGTHS else None
        parts = found[:-1] if unit else found
        axis = next((k for k in reversed(range(len(parts))) if parts[k] in "xyzw" and len(parts[k]) == 1), None)
        if axis is None and set(parts) & _VECTOR and parts[-1] in ("0", "1", "2"):
            axis, parts = len(parts) - 1, [*parts[:-1], "xyz"[int(parts[-1])]]
        if axis is None:
            continue
        key = tuple(parts[:axis] + parts[axis + 1 :])
        groups[key].setdefault(parts[axis], i)
        if unit:
            lengths[key] = LENGTHS[unit]

    def xyz(key: tuple[str, ...] | None) -> tuple[int, int, int] | None:
        return None if key is None else (groups[key]["x"], groups[key]["y"], groups[key]["z"])

    orientation_key = _best([k for k, g in groups.items() if len(g) == 4 and (set(k) & _ROTATION or not k)])
    triples = [k for k, g in groups.items() if {"x", "y", "z"} <= set(g)]
    places = [k for k in triples if k != orientation_key and (set(k) & _POSITION or set(k) <= set(_HEAD))]
    position_key, down = _best(places), next((k for k in triples if "gravity" in k), None)
    turn, numbered = None if orientation_key is None else groups[orientation_key], False
    if turn is None:
        orders: dict[tuple[str, ...], dict[str, int]] = defaultdict(dict)
        for i, name in enumerate(names):
            if found_number := _NUMBERED.match(name.strip()):
                orders[tuple(words(found_number[1] or ""))].setdefault("xyzw"[int(found_number[2])], i)
        order_key = _best([key for key, order in orders.items() if len(order) == 4])
        turn, numbered = (None, False) if order_key is None else (orders[order_key], True)
    pairs = (_ROTATION, {"vector", "vec"}), ({"axis"}, {"angle"})  # of words that say together what a vector is
    turning = [k for k in triples if set(k) & _VECTOR or any(set(k) & a and set(k) & b for a, b in pairs)]
    # An axis with its angle in a column of its own is no vector.
    angled = any(set(parts) & _ANGLE and not set(parts) & (_ELSEWHERE | {*"xyz"}) for parts in split)
    vector = xyz(_best([k for k in turning if "w" not in groups[k] and not (angled and "axis" in k)]))
    about = {word for column in vector or () for word in split[column]}
    told = [(i, parts) for i, parts in enumerate(split) if parts and not set(parts) & (_ELSEWHERE | _STEPS)]
    seconds = {tuple(parts[:-1]): i for i, parts in told if _TIME_UNITS.get(parts[-1]) == "s"}
    rests = [(seconds.get(tuple(parts[:-1])), i, _TIME_UNITS.get(parts[-1], "s")) for i, parts in told]
    clocks: list[tuple[int, int, str | None]] = []  # rank, column, unit
    for i, parts in told:
        said = _TIME_UNITS.get(parts[-1]) if len(parts) > 1 else None
        rest = parts[:-1] if said else parts
        joined = "".join(rest)
        if joined in _TIMES:
            clocks.append((0, i, said))
        elif "date" not in parts and (set(rest) & (_TIMES - {"t"}) or re.search("timest(amp|ep)", joined)):
            clocks.append((1, i, said))
    named = {word: i for i, parts in enumerate(split) for word in set(parts) & set(_ANGLES)}
    turns = {axis: named[word] for word, axis in _ANGLES.items() if word in named}
    turns = {axis: column for axis, column in turns.items() if not set(split[column]) & _ELSEWHERE}
    bare = {parts[0][1]: i for i, parts in enumerate(split) if parts and parts[0] in _BARE_TURNS}
    angles = next(((at["x"], at["y"], at["z"]) for at in (turns, bare) if len(at) == 3), None)
    return Columns(
        clocks=tuple((i, said) for _, i, said in sorted(clocks, key=lambda clock: clock[:2])),
        pairs=tuple((whole, i, unit) for whole, i, unit in rests if unit != "s" and whole is not None),
        date=next((i for i, parts in told if set(parts) & _DATES), None),
        frames=next((i for i, n in enumerate(names) if "".join(re.findall("[a-z]+", n.lower())) in _FRAMES), None),
        orientation=None if turn is None else (turn["x"], turn["y"], turn["z"], turn["w"]), numbered=numbered,
        position=xyz(position_key), length_m=None if position_key is None else lengths.get(position_key),
        device=next((i for i, n in enumerate(names) if re.sub(r"[^a-z]", "", n.lower()) in _DEVICES), None),
        angles=angles or xyz(_best([k for k in triples if set(k) & (_ROTATION | _EULER)])),
        gravity=xyz(down), vector=vector,
        vector_unit="deg" if about & _DEGREES else "rad" if about & _RADIANS else "",
    )  # fmt: skip


def _best(keys: list[tuple[str, ...]]) -> tuple[str, ...] | None:
    """Return the head's group: never a hand's or a gaze's; "head" first, else the plainest."""
    heads = [k for k in keys if not set(k) & _ELSEWHERE]
    return min(heads, key=lambda k: (not set(k) & set(_HEAD), len(k)), default=None)


def owner_rank(name: str) -> int:
    """Return whose clock a column is: 0 the pose's, 1 unknown, 2 a writer's or receiver's."""
    found = set(words(name))
    return 2 if found & _ANOTHERS else 0 if found & _OWN else 1


@attrs.frozen
class Made:
    """Comma-separated rows, and what the file says of them."""

    kind: str  # what `TraceFormat.kind` looks for
    text: bytes
    names: tuple[str, ...] = ()  # of the columns; (): they are in the text, or there are none
    defects: tuple[Defect, ...] = ()  # found while the rows were made
    nested: Mapping[str, Defect] = attrs.field(factory=dict)  # those of one device's rows
    facts: Mapping[str, Any] = attrs.field(factory=dict)  # fields of Layout that the file states


def rows_text(rows: Iterable[Iterable[str]]) -> bytes:
    return "".join(f"{','.join(row)}\n" for row in rows).encode()


Cells = tuple[int, ...]  # columns of 9, 12 or 16 numbers in the order of the file
SHAPES = {16: (4, 4), 12: (3, 4), 9: (3, 3)}
_CELL = re.compile(r"(.*?)[._\[\s]*([0-4])[\]._,\s]*\[?([0-4])\]?$")
_PLACE = re.compile(r"(.*?)[._\[\s]*(\d{1,2})\]?$")


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
    for name, group in grids.items():
        shapes = ((*shape, first) for shape in SHAPES.values() for first in (0, 1))
        wholes = ([(first + r, first + c) for r in range(high) for c in range(wide)] for high, wide, first in shapes)
        whole = next((cells for cells in wholes if set(cells) <= set(group)), [])
        matrices += [(name, tuple(group[cell] for cell in whole))] if whole else []
    for name, run in runs.items():
        places, first = sorted(run), min(run)
        if len(run) in SHAPES and first <= 1 and places == [*range(first, first + len(run))]:
            matrices.append((name, tuple(run[place] for place in places)))

    def rank(one: tuple[str, Cells]) -> tuple[bool, int, int]:
        other = bool(set(words(one[0])) & {"projection", "proj", "view", "inverse", "inv"})
        return other, head_rank(one[0]), -len(one[1])

    return [cells for _, cells in sorted(matrices, key=rank)]
