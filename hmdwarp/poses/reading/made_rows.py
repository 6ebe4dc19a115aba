"""What is no rows as rows: JSON, cells of several numbers, exports of motion capture.

Sources: QTM documentation, Motion data (.tsv) and 6DOF data (.tsv), of Qualisys Track Manager;
OptiTrack documentation, Data Export: CSV, of Motive; BIDS specification 1.9, "Motion".
"""

from __future__ import annotations

import csv
import io
import itertools
import re
import struct
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator
from operator import itemgetter
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import TraceError, counted
from ...base.documents import DocumentError, json_in, parse_json
from ...base.named_files import FACTS, LIST, content_of, text_in
from ..assumptions import By, Defect
from ..options import Euler
from .columns import COMMENT_SIGNS, LENGTHS, Made, has_pose, head_rank, names_rotation

_LEAST_RECORDS = 2
_NAMES = ("schema", "columns", "header", "headers", "fields", "names", "keys")
# IWER's frames hold time, position, quaternion, then a list for each input.
_IWER = ("time_ms", "x", "y", "z", "qx", "qy", "qz", "qw")


def table_of_json(path: Path, raw: bytes) -> Made | None:
    """Return rows for JSON lines, or for a document with a list of records.

    Names of nested objects are joined by a dot; three numbers in a list become x, y and z, four of
    a rotation q0 to q3, a list of lists the cells of a matrix. Records of another kind than the
    poses are left out; values of an object may be poses, by their keys. None where the bytes are no
    JSON. Errors: DocumentError, as parse_json; TraceError for JSON without records.
    """
    try:
        text = raw.decode("utf-8-sig")
        document = parse_json(text)
    except UnicodeDecodeError:
        return None
    except DocumentError as error:
        if error.line is None:  # it is JSON, of a kind that is refused
            raise
        try:
            document = [parse_json(line) for line in text.splitlines() if line.strip()]
        except DocumentError:
            return None
    if rows := _iwer_rows(document):
        return Made("iwer", rows, _IWER)
    if rows := _browser_rows(document):
        return Made("browser", rows, ("device", *_IWER))
    flat = ((records, _flat(records[-1])) for records in _lists(document))  # the first may be a header
    ranked = [((has_pose(list(last)), len(records), len(last)), records) for records, last in flat]
    records = max(ranked, key=itemgetter(0), default=((), []))[1]
    if records and isinstance(records[0], list) and _are_names(records[0]):
        records = [dict(zip(records[0], record, strict=False)) for record in records[1:] if isinstance(record, list)]
    if len(records) < _LEAST_RECORDS:
        keys = ", ".join(list(_flat(document))[:8])
        raise TraceError(f"{path} is JSON without a list or an object of poses: its keys are {keys[:300] or 'none'}")
    found = [_flat(record) for record in records]
    kinds = Counter(tuple(row) for row in found)
    likely: tuple[str, ...] = max(kinds, key=lambda k: (kinds[k] >= _LEAST_RECORDS and has_pose(list(k)), kinds[k]))
    wanted = set(likely)
    likely_rows = [row for row in found if 2 * len(wanted & set(row)) >= len(wanted)]
    others = len(found) - len(likely_rows)
    what = f"{counted(others, 'record')} of another kind than the poses"
    defects = [Defect("record-of-another-kind", what, "left out", others)] if others else []
    names = tuple(dict.fromkeys(name for row in likely_rows[:100] for name in row))
    named = any(name.strip(".0123456789") for name in names)  # not by places in a list alone
    rows = [[row.get(name, "") for name in names] for row in likely_rows]
    return Made("json", rows, names if named else (), tuple(defects))


def _iwer_rows(document: Any) -> list[list[str]]:
    """Return the frames of a recording of IWER anywhere in a document, [] for any other."""
    if not isinstance(document, dict):
        return []
    schema, frames = document.get("schema"), document.get("frames")
    if not (isinstance(schema, list) and isinstance(frames, list)):
        return next(filter(None, map(_iwer_rows, document.values())), [])
    inputs = all(isinstance(entry, list) and len(entry) == 2 and isinstance(entry[1], dict) for entry in schema)
    poses = [frame[: len(_IWER)] for frame in frames if isinstance(frame, list) and len(frame) >= len(_IWER)]
    numbers = len(poses) >= _LEAST_RECORDS and all(isinstance(value, int | float) for value in poses[0])
    return [[*map(str, pose)] for pose in poses] if inputs and numbers else []


def _browser_rows(document: Any) -> list[list[str]]:
    """Return the heads of a session.jsonl of `hmdwarp serve --web`, [] of any other document."""
    lines = [line for line in (document if isinstance(document, list) else [document]) if isinstance(line, dict)]
    lines = [line for line in lines if {"session", "delays_ms"} <= set(line) and isinstance(line.get("heads"), list)]
    heads = [(line["session"], head) for line in lines for head in line["heads"] if isinstance(head, list)]
    return [[*map(str, (session, *head))] for session, head in heads if len(head) == len(_IWER)]


def _lists(document: Any) -> Iterator[list[Any]]:
    if isinstance(document, list):
        if len(document) == 1:
            yield from _lists(document[0])
        kinds = [isinstance(item, dict | list) for item in document]
        if kinds and sum(kinds) >= _LEAST_RECORDS and sum(kinds) >= len(kinds) - 1:
            yield [item for item, kind in zip(document, kinds, strict=True) if kind]
    elif isinstance(document, dict):
        names = next((document[key] for key in _NAMES if _are_names(document.get(key))), None)
        for value in document.values():
            rows = value if isinstance(value, list) else []
            if names is not None and rows and all(isinstance(r, list) and len(r) == len(names) for r in rows):
                yield [names, *rows]
            else:
                yield from _lists(value)
        # Its values may be poses, each with its key, a time or a number; or a column each.
        values = [value if isinstance(value, dict) else {"pose": value} for value in document.values()]
        if len(values) >= _LEAST_RECORDS and all(has_pose(list(_flat(value))) for value in (values[0], values[-1])):
            numbers = [(re.findall(r"\d+(?:\.\d+)?", key) or [str(i)])[-1] for i, key in enumerate(document)]
            name = "time" if any("." in number for number in numbers) else "frame"
            yield [{name: number, **value} for number, value in zip(numbers, values, strict=True)]
        lengths = Counter(len(value) for value in document.values() if isinstance(value, list))
        count = max(lengths, key=lambda n: (lengths[n], n), default=0)
        columns = {key: value for key, value in document.items() if isinstance(value, list) and len(value) == count}
        rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
        if len(rows) >= _LEAST_RECORDS and has_pose(list(_flat(rows[0]))):
            yield rows


def _are_names(value: Any) -> bool:
    return isinstance(value, list) and len(value) > 4 and all(isinstance(name, str) for name in value)


def _flat(value: Any, name: str = "") -> dict[str, str]:
    if isinstance(value, dict):
        parts = [(f"{name}.{key}" if name else str(key), part) for key, part in value.items()]
    elif isinstance(value, list):
        cells = [cell for row in value if isinstance(row, list) for cell in row]
        rows = len(value) in (3, 4) and all(isinstance(row, list) and len(row) in (3, 4) for row in value)
        if rows and not any(isinstance(cell, dict | list) for cell in cells):  # a matrix
            return {f"{name}.{r}.{c}": str(cell) for r, row in enumerate(value) for c, cell in enumerate(row)}
        places: list[Any] = list(range(len(value)))
        if len(value) == 3 and not any(isinstance(part, list) for part in value):
            places = list("xyz")
        elif len(value) == 4 and names_rotation(name):
            places = [f"q{i}" for i in range(4)]
        parts = [(f"{name}.{place}", part) for place, part in zip(places, value, strict=True)]
    else:
        return {name: "" if value is None else str(value)}
    return {key: number for one, part in parts for key, number in _flat(part, one).items()}


_CELL_NUMBER = r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
_PLAIN = re.compile(rf"(?:{_CELL_NUMBER}|[-+]?(?:nan|inf))$", re.IGNORECASE)
_LABELLED = re.compile(rf"([A-Za-z]+)[\"']*\s*[=:]\s*({_CELL_NUMBER})")
_UNREAL = re.compile(rf"(?:X|P|Pitch)={_CELL_NUMBER},?\s*(?:Y|Yaw)={_CELL_NUMBER},?\s*(?:Z|R|Roll)={_CELL_NUMBER}")
# Brackets, quotes or labels about numbers, or numbers apart by another sign than the cells are.
_SUSPECT = re.compile(
    rf"[(\[{{]\s*{_CELL_NUMBER}[\s,;]|[A-Za-z]\s*=\s*[-+.0-9]|[({{][\"'\s]*[A-Za-z]+[\"']*\s*:|\"\s*{_CELL_NUMBER}[\s,;]+{_CELL_NUMBER}[^\"]*\"|[;\t][^;\t,]*[0-9],[^;\t,]+,[^;\t]*[0-9]"
    rf"|,\s*{_CELL_NUMBER}\s+{_CELL_NUMBER}\s+{_CELL_NUMBER}"
)
_SAMPLE, _PREAMBLE, _LONGEST = 5, 200, 500  # rows, lines, characters that are looked at
_LABELS = {3: "xyz", 7: ("x", "y", "z", "q0", "q1", "q2", "q3")}
# FRotator::Quaternion of Unreal turns about x (roll) and y (pitch) against its axes.
_ROTATOR = {"r": "x", "p": "y", "y": "z", "roll": "x", "pitch": "y", "yaw": "z"}
_ROTATORS = {"p", "y", "r"}, {"pitch", "yaw", "roll"}


def _cells_made(path: Path, raw: bytes) -> Made | None:
    """Return one column for each number of the cells; None where cells cannot be separated."""
    lines = [line.strip() for line in _text(raw).splitlines() if line.strip()]
    begin = next((i for i, line in enumerate(lines) if _is_row(line)), None)
    if begin is None:
        return None
    outside = re.sub(r"\[[^\[\]]*\]", "", lines[begin])
    outside = re.sub(r'"[^"]*"|\([^()]*\)|\[[^\[\]]*\]|\{[^{}]*\}', "", outside)
    separator = next((mark for mark in ";\t," if mark in outside), None)
    first = [_parts(cell) for cell in _cells(lines[begin], separator)]
    bare = [cell.strip().strip('"').strip("# ") for cell in _cells(lines[begin - 1], separator)] if begin else []
    if max(map(len, first)) < 2:
        return None
    if len(bare) != len(first):
        what = f"its rows hold {len(first)} cells, some of several numbers, and no line above names them"
        raise TraceError(f"{path}: {what}: write one, such as time,position,rotation")
    names: list[str] = []
    for name, parts in zip(bare, first, strict=True):
        lettered = re.search(r"[(\[{]((?:\s*[A-Za-z]\s*[,;\s])+\s*[A-Za-z])\s*[)\]}]$", name)
        about = name[: lettered.start()].strip() if lettered else name
        letters = re.findall("[a-z]", lettered[1].lower()) if lettered else []
        labels, is_turn = [label for label, _ in parts], names_rotation(about)
        if set(labels) in _ROTATORS:
            about, labels = about if is_turn else f"{about}.rotation", [_ROTATOR[label] for label in labels]
        elif not all(labels):
            numbered = [f"q{i}" for i in range(4)] if len(parts) == 4 and is_turn else map(str, range(len(parts)))
            labels = letters if len(letters) == len(parts) else [*_LABELS.get(len(parts), numbered)]
        names += [about] if len(parts) == 1 else [f"{about}.{label}" for label in labels]
    if len(set(names)) < len(names):
        return None
    lines = [line for line in lines[begin:] if not line.startswith(COMMENT_SIGNS)]
    rows = [[text for cell in _cells(line, separator) for _, text in _parts(cell)] for line in lines]
    unreal, facts = _UNREAL.search(lines[0]) is not None, dict[str, Any]()
    if unreal and any({label for label, _ in parts} in _ROTATORS for parts in first):
        facts = {"euler": Euler("xyz", True, (-1, -1, 1)), "order_by": By.FORMAT}
    return Made("unreal" if unreal else "vectors", rows, tuple(names), facts=facts)


def _text(raw: bytes) -> str:
    return raw.decode("utf-8-sig", "replace")


def _is_row(line: str) -> bool:
    """Return whether a line holds numbers, and no names or a remark."""
    bare = line[:_LONGEST].strip()
    if not bare or bare.startswith(COMMENT_SIGNS):
        return False
    words = re.findall(r"[A-Za-z_]\w*", bare)
    return len(_LABELLED.findall(bare)) > 1 or len(re.findall(rf"(?<![\w.]){_CELL_NUMBER}(?![\w.])", bare)) > len(words)


def _cells(line: str, separator: str | None) -> Iterator[str]:
    depth, quoted, begin = 0, False, 0
    for i, sign in enumerate(line):
        quoted ^= sign == '"'
        depth += (sign in "([{") - (sign in ")]}")
        if depth <= 0 and not quoted and (sign == separator or (separator is None and sign.isspace())):
            if separator is not None or line[begin:i].strip():
                yield line[begin:i]
            begin = i + 1
    if line[begin:].strip():
        yield line[begin:]


def _parts(cell: str) -> list[tuple[str, str]]:
    bare = cell.strip().strip('"').strip()
    if re.fullmatch(r"[-+]?[0-9]*,[0-9]+", bare):
        return [("", bare.replace(",", "."))]
    labelled = _LABELLED.findall(bare)
    if len(labelled) > 1:
        return [(label.lower(), number) for label, number in labelled]
    inner = re.sub(r"^[A-Za-z_][\w.]*\s*(?=[(\[{])|[()\[\]{}<>]", " ", bare).strip()
    found = [part for part in re.split(r"[;,\s]+", inner) if part]
    if len(found) > 1 and all(_PLAIN.match(part) for part in found):
        return [("", part) for part in found]
    return [("", bare)]


def _of_bodies(
    kind: str, lines: Iterable[tuple[str, list[str]]], bodies: dict[str, list[int]], names: Iterable[str],
    facts: dict[str, Any],
) -> Made:  # fmt: skip
    """Return a row for each body of each line, a time and cells, where it has all numbers."""
    rows = [
        [time, name, *(line[c] for c in columns)]
        for time, line in lines
        for name, columns in bodies.items()
        if len(line) > max(columns) and all(line[c] for c in columns)
    ]
    return Made(kind, rows, ("time_s", "device", *names), facts=facts)


_QUALISYS_EACH = 16  # columns of a body: X Y Z Roll Pitch Yaw Residual Rot[0] .. Rot[8]
# X Y Z, and Rot[] by rows, which goes by columns.
_QUALISYS_READ = (0, 1, 2, *(7 + 3 * column + row for row in range(3) for column in range(3)))
_QUALISYS_NAMES = ("x", "y", "z", *(f"r{row}{column}" for row in range(3) for column in range(3)))
_QUALISYS_FACTS = {"matrix": "by columns (Rot[0] Rot[1] Rot[2] is the first)", "scale": 0.001}
_QUALISYS_FACTS |= dict.fromkeys(("order_by", "scale_by"), By.FORMAT)


def _qualisys_made(path: Path, raw: bytes) -> Made:
    lines = [line.rstrip("\r\n\t").split("\t") for line in _text(raw).splitlines()]
    begin = next((i for i, row in enumerate(lines) if "Rot[0]" in row), None)
    about = {row[0]: row[1:] for row in lines[:begin]}
    if begin is None:
        held = " ".join(about.get("DATA_INCLUDED", ["no"]))
        raise TraceError(f"{path}: a Qualisys export of {held} data: export the bodies as 6D, with header")
    names, lines = lines[begin], lines[begin + 1 :]
    first = names.index("Rot[0]") - 7
    bodies = about.get("BODY_NAMES") or [name.removesuffix(" X") for name in names[first::_QUALISYS_EACH]]
    if "Time" in names[:first]:
        clock = names.index("Time")
        times = [row[clock] if len(row) > clock else "" for row in lines]
    else:
        stated = "".join(about.get("FREQUENCY", [])[:1])
        rate = float(stated) if re.fullmatch(r"[0-9]+(\.[0-9]+)?", stated) else 0.0
        if not rate:
            raise TraceError(f"{path}: a Qualisys export with no column Time and no FREQUENCY: export it with one")
        times = [repr(i / rate) for i in range(len(lines))]
    begins = zip(bodies, itertools.count(first, _QUALISYS_EACH), strict=False)
    columns = {name: [begin + part for part in _QUALISYS_READ] for name, begin in begins}
    return _of_bodies("qualisys", zip(times, lines, strict=True), columns, _QUALISYS_NAMES, _QUALISYS_FACTS)


_MOTIVE_LENGTHS = {"meters": 1.0, "centimeters": 0.01, "millimeters": 0.001, "inches": 0.0254, "feet": 0.3048}
_BODIES = ("rigidbody", "bone", "skeletonbone")


def _motive_made(path: Path, raw: bytes) -> Made:
    lines = list(csv.reader(_text(raw).splitlines()))
    begin = next((i for i, row in enumerate(lines) if row[:1] == ["Frame"]), None)
    if begin is None or begin < 4:
        raise TraceError(f"{path}: a Motive export without its lines of names above 'Frame': export it with header")
    about = dict(zip(lines[0][::2], lines[0][1::2], strict=False))
    above = {row[1]: row for row in lines[1:begin] if len(row) > 2 and row[1]}
    types, names = above.get("Type", lines[begin - 4]), above.get("Name", lines[begin - 3])
    parts, axes = lines[begin - 1], lines[begin]
    bodies: dict[str, dict[str, int]] = {}
    for c in range(2, min(map(len, (types, names, parts, axes)), default=0)):
        if types[c].replace(" ", "").lower() in _BODIES and parts[c] in ("Rotation", "Position"):
            bodies.setdefault(names[c], {}).setdefault(f"{parts[c]}.{axes[c].lower()}", c)
    if not bodies:
        raise TraceError(f"{path}: a Motive export without rigid bodies: tick 'Rigid Bodies' where it is exported")
    wanted = next(iter(bodies.values()))
    for name in (name for name, at in bodies.items() if at.keys() != wanted.keys()):
        raise TraceError(f"{path}: {name} has other columns than {next(iter(bodies))}: export it again")
    columns = {name: [at[part] for part in wanted] for name, at in bodies.items()}
    unit = about.get("Length Units", "").lower()
    facts = {"scale": _MOTIVE_LENGTHS[unit], "scale_by": By.FILE} if unit in _MOTIVE_LENGTHS else {}
    timed = ((row[1], row) for row in lines[begin + 1 :] if len(row) > 1)
    return _of_bodies("motive", timed, columns, wanted, facts)


_ENDING = "_motion.tsv"
_BESIDE = attrs.evolve(FACTS, what="what describes a table of BIDS", error=TraceError)
_COLUMNS = ("type", "component", "tracked_point", "units", "reference_frame")
_QUATERNION = ("quat_x", "quat_y", "quat_z", "quat_w")
_TURNING = {f"ORNT.{part}" for part in ("x", "y", "z", *_QUATERNION[:3])}
# SpatialAxes: right or left, anterior or posterior, superior or inferior.
_DIRECTIONS = {
    key: (way, "-" * (key in "LIP")) for way, keys in (("right", "RL"), ("up", "SI"), ("ahead", "AP")) for key in keys
}


def _bids_made(path: Path, raw: bytes) -> Made:
    stem = str(path).removesuffix(_ENDING)
    beside, points = Path(f"{stem}_channels.tsv"), defaultdict[str, dict[str, int]](dict)
    if not beside.exists():
        raise TraceError(f"{path}: BIDS describes its columns in {beside.name}, which is not beside it")
    said = csv.DictReader(text_in(beside, _BESIDE, beside.parent).splitlines(), delimiter="\t")
    channels = [{key: row.get(key) or "n/a" for key in _COLUMNS} for row in said]
    kinds = [channel["type"].upper() for channel in channels]
    for i, (kind, channel) in enumerate(zip(kinds, channels, strict=True)):
        if kind in ("POS", "ORNT"):
            points[channel["tracked_point"]][f"{kind}.{channel['component']}"] = i
    turned = [name for name, at in points.items() if any(part.startswith("ORNT") for part in at)]
    if not turned:
        raise TraceError(f"{path}: its channels hold no orientation (type ORNT): expected quat_x .. quat_w or angles")
    at = points[min(turned, key=head_rank)]
    turn = [f"ORNT.{part}" for part in _QUATERNION]
    turn = turn if set(turn) <= set(at) else [f"ORNT.{axis}" for axis in "xyz" if f"ORNT.{axis}" in at]
    parts = [part for part in at if part.startswith("POS")] + turn
    bodies = {name: [found[part] for part in parts] for name, found in points.items() if set(parts) <= set(found)}
    facts = _bids_facts(stem, channels, at)
    against = facts.pop("against", False)  # turns go against the hand of the axes
    signed = [found[part] for found in points.values() for part in _TURNING & found.keys() if against]
    clock = kinds.index("LATENCY") if "LATENCY" in kinds else None
    rate = _json(Path(f"{stem}_motion.json")).get("SamplingFrequency") if clock is None else None
    rate = rate if isinstance(rate, int | float) and rate > 0 else None
    lines = [line.split("\t") for line in _text(raw).splitlines() if line.strip()]
    if lines and len(lines[0]) != len(channels):
        raise TraceError(f"{path}: {len(lines[0])} columns, {len(channels)} rows in its channels.tsv: they must agree")
    rows = []
    for i, line in enumerate(lines):
        if len(line) != len(channels):
            rows.append(line[:1])  # too short, so that it is counted as a row without a pose
            continue
        for c in signed:
            line[c] = f"-{line[c]}".removeprefix("--").replace("-+", "-")
        time = [line[clock]] if clock is not None else [repr(i / rate)] if rate else []
        rows += [[*time, name, *(line[c] for c in columns)] for name, columns in bodies.items()]
    named = [part.replace("POS.", "position.").replace("ORNT.quat_", "q") for part in parts]
    named = [part.replace("ORNT.", "rotation.") for part in named]
    names = (*(["time_s"] if clock is not None or rate else []), "device", *named)
    return Made("bids", rows, names, facts=facts)


def _json(path: Path) -> dict[str, Any]:
    found = json_in(path, _BESIDE, path.parent) if path.exists() else {}
    return found if isinstance(found, dict) else {}


def _bids_facts(stem: str, channels: list[dict[str, str]], at: dict[str, int]) -> dict[str, Any]:
    facts: dict[str, Any] = {}
    place = next((channels[i] for part, i in at.items() if part.startswith("POS")), {})
    if place.get("units") in LENGTHS:
        facts = {"scale": LENGTHS[place["units"]], "scale_by": By.FILE}
    turn = next(channels[i] for part, i in at.items() if part.startswith("ORNT"))
    frame: Any = _json(Path(f"{stem}_channels.json"))
    for key in ("reference_frame", "Levels", turn["reference_frame"]):
        frame = frame.get(key) if isinstance(frame, dict) else None
    frame = frame if isinstance(frame, dict) else {}
    letters = zip(str(frame.get("SpatialAxes", "")), "xyz", strict=False)  # "ARS": x ahead, y right, z up
    ways = {_DIRECTIONS[s][0]: f"{_DIRECTIONS[s][1]}{axis}" for s, axis in letters if s in _DIRECTIONS}
    if len(ways) == 3:
        three = [ways[way] for way in ("right", "up", "ahead")]
        rows = [np.eye(3)["xyz".index(axis[-1])] * (-1 if axis[0] == "-" else 1) for axis in three]
        hand = "left-hand" if np.linalg.det(rows) > 0 else "right-hand"
        against = str(frame.get("RotationRule", hand)) != hand
        facts |= {"axes": ",".join(three), "axes_by": By.FILE, "against": against}
    order = str(frame.get("RotationOrder", "")).lower()
    if sorted(order) == ["x", "y", "z"] and turn.get("units") in ("deg", "rad"):
        facts |= {"euler": Euler(order, turn["units"] == "deg"), "order_by": By.FILE}
    return facts


def maker_of(path: Path, start: bytes) -> Callable[[Path, bytes], Made | None] | None:
    """Return what makes rows of a file, None where it has rows. start: its first bytes."""
    bare = start.removeprefix(b"\xef\xbb\xbf")
    first = bare.split(b"\n", 1)[0]
    if bare.lstrip()[:1] in (b"{", b"["):
        return table_of_json
    if MARK in start[:200]:
        return table_of_colmap
    if first.startswith(b"Format Version,"):
        return _motive_made
    if first.startswith((b"NO_OF_FRAMES\t", b"FILE_VERSION\t")) or b"\tResidual\tRot[0]\t" in first:
        return _qualisys_made
    if path.name.endswith(_ENDING):  # as the specification has it
        return _bids_made
    lines = start.decode("utf-8", "replace").splitlines()[:_PREAMBLE]
    rows = list(itertools.islice((line[:_LONGEST] for line in lines if _is_row(line)), _SAMPLE))
    return _cells_made if sum(_SUSPECT.search(row) is not None for row in rows) * 2 > len(rows) else None


MARK = b"Image list with two lines of data per image"  # in the comment above the images
COLUMNS = ("qw", "qx", "qy", "qz", "tx", "ty", "tz")
# Name and number of parameters of each camera model, by its number in binary files.
_MODELS = [("SIMPLE_PINHOLE", 3), ("PINHOLE", 4), ("SIMPLE_RADIAL", 4), ("RADIAL", 5), ("OPENCV", 8)]
_MODELS += [("OPENCV_FISHEYE", 8), ("FULL_OPENCV", 12), ("FOV", 5), ("SIMPLE_RADIAL_FISHEYE", 4)]
_MODELS += [("RADIAL_FISHEYE", 5), ("THIN_PRISM_FISHEYE", 12)]
_POSE, _CAMERA, _COUNT, _POINT_BYTES = "<i7di", "<iiQQ", "<Q", 24
_MODEL = attrs.evolve(LIST, error=TraceError)


@attrs.frozen(eq=False)
class _ColmapImage:
    where: str
    name: str
    camera_id: int
    pose: tuple[float, ...]  # as the file has it, camera from world: qw qx qy qz tx ty tz
    rotation: NDArray[np.float64]  # (3, 3) world from camera
    position: NDArray[np.float64]  # of the camera in the world


@attrs.frozen
class ColmapCamera:
    where: str
    model: str
    size: tuple[int, int]  # (w, h)
    parameters: tuple[float, ...]


def table_of_colmap(path: Path, raw: bytes) -> Made:
    """Return the poses of images.txt in the order of the names. Errors: TraceError."""
    return Made("colmap", [[*map(repr, image.pose)] for image in read_images(path, raw)], COLUMNS)


def read_images(path: Path, raw: bytes | None = None) -> list[_ColmapImage]:
    """Return the images of images.txt or images.bin, by name. Errors: TraceError."""
    from scipy.spatial.transform import Rotation

    raw, images = content_of(path, _MODEL) if raw is None else raw, []
    for where, name, camera_id, pose in (_in_binary if path.suffix == ".bin" else _in_text)(path, raw):
        w, x, y, z, *moved = pose
        length = float(np.linalg.norm((w, x, y, z)))
        if not abs(length - 1) <= 1e-2 or not np.isfinite(moved).all():
            raise TraceError(f"{where}: a quaternion of length {length:.4g}; expected 1 within 0.01, w x y z")
        turned = Rotation.from_quat((x, y, z, w)).as_matrix().T
        images.append(_ColmapImage(where, name, camera_id, tuple(pose), turned, -turned @ np.array(moved)))
    return sorted(images, key=lambda image: image.name)


def _in_text(path: Path, raw: bytes) -> Iterator[tuple[str, str, int, list[float]]]:
    """Yield the images of the text form: a line of its pose, and one of points, perhaps empty."""
    lines = _lines(path, raw)
    for where, line in lines:
        if not line.strip() or line.startswith("#"):
            continue
        words = line.split(maxsplit=9)
        try:
            numbers = [float(word) for word in words[:9]]
            name, camera_id = words[9].strip(), int(numbers[8])
        except (ValueError, IndexError, OverflowError):
            wanted = "IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of points"
            raise TraceError(f"{where}: '{line.strip()[:60]}'; expected {wanted}") from None
        yield where, name, camera_id, numbers[1:8]
        next(lines, None)


def _in_binary(path: Path, raw: bytes) -> Iterator[tuple[str, str, int, list[float]]]:
    stream = io.BytesIO(raw)
    for number in range(*_unpacked(path, stream, _COUNT)):
        _, *pose, camera_id = _unpacked(path, stream, _POSE)
        name = stream.read(max(0, raw.find(b"\0", stream.tell()) - stream.tell()))
        stream.read(1)
        yield f"{path}, image {number}", name.decode("utf-8", "replace"), camera_id, pose
        points = _POINT_BYTES * _unpacked(path, stream, _COUNT)[0]
        _unpacked(path, stream, f"{min(points, len(raw))}x")  # of 2^64 no file has the bytes


def read_cameras(path: Path) -> dict[int, ColmapCamera]:
    """Return the cameras of cameras.txt or cameras.bin by their numbers. Errors: TraceError."""
    found, raw = {}, content_of(path, _MODEL)
    if path.suffix == ".bin":
        stream = io.BytesIO(raw)
        for number in range(*_unpacked(path, stream, _COUNT)):
            key, model, wide, high = _unpacked(path, stream, _CAMERA)
            where = f"{path}, camera {number}"
            if not 0 <= model < len(_MODELS):
                raise TraceError(f"{where}: model {model}; expected 0 to {len(_MODELS) - 1}")
            name, count = _MODELS[model]
            found[key] = ColmapCamera(where, name, (wide, high), _unpacked(path, stream, f"<{count}d"))
        return found
    for where, line in _lines(path, raw):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        try:
            size, parameters = (int(words[2]), int(words[3])), tuple(float(word) for word in words[4:])
            found[int(words[0])] = ColmapCamera(where, words[1], size, parameters)
        except (ValueError, IndexError):
            raise TraceError(f"{where}: '{line.strip()[:60]}'; expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS") from None
    return found


def _unpacked(path: Path, stream: io.BytesIO, form: str) -> tuple[Any, ...]:
    data = stream.read(struct.calcsize(form))
    if len(data) < struct.calcsize(form):
        raise TraceError(f"{path}: it ends in the middle; expected a whole binary model of COLMAP")
    return struct.unpack(form, data)


def _lines(path: Path, raw: bytes) -> Iterator[tuple[str, str]]:
    """Return each line behind the words that say where it is."""
    try:
        lines = raw.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise TraceError(f"{path}: not a text file ({error})") from None
    return ((f"{path}, line {number}", line) for number, line in enumerate(lines, 1))
