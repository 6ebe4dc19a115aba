"""Exports of motion capture: a table of several bodies under a header of several lines.

Sources: QTM documentation, Motion data (.tsv) and 6DOF data (.tsv), of Qualisys Track Manager;
OptiTrack documentation, Data Export: CSV, of Motive; BIDS specification 1.9, "Motion".
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ...errors import TraceError
from ...options.documents import json_in
from ...options.named_files import FACTS, text_in
from ..assumptions import By
from ..options import Euler
from .axes import parse_axes
from .columns import Made, head_rank, rows_text

_QUALISYS_EACH = 16  # columns of a body: X Y Z Roll Pitch Yaw Residual Rot[0] .. Rot[8]
_QUALISYS_TURN = tuple(7 + 3 * column + row for row in range(3) for column in range(3))  # Rot[] goes by columns
_QUALISYS_NAMES = ("time_s", "device", "x", "y", "z", *(f"r{row}{column}" for row in range(3) for column in range(3)))
_QUALISYS_FACTS = {
    **{"matrix": "by columns (Rot[0] Rot[1] Rot[2] is the first)", "order_by": By.FORMAT},
    **{"scale": 0.001, "scale_by": By.FORMAT},
}


def _qualisys_made(path: Path, text: str) -> Made:
    """Return a row for each body in each frame. Errors: TraceError for other data than 6D."""
    lines = [line.rstrip("\r\n\t").split("\t") for line in text.splitlines()]
    begin = next((i for i, row in enumerate(lines) if "Rot[0]" in row), None)
    about = {row[0]: row[1:] for row in lines[:begin]}
    if begin is None:
        held = " ".join(about.get("DATA_INCLUDED", ["no"]))
        raise TraceError(f"{path}: a Qualisys export of {held} data: export the bodies as 6D, with header")
    first = lines[begin].index("Rot[0]") - 7
    bodies = about.get("BODY_NAMES") or [name.removesuffix(" X") for name in lines[begin][first::_QUALISYS_EACH]]
    clock = lines[begin].index("Time") if "Time" in lines[begin][:first] else None
    stated = "".join(about.get("FREQUENCY", [])[:1])
    rate = float(stated) if clock is None and re.fullmatch(r"[0-9]+(\.[0-9]+)?", stated) else 0.0
    if clock is None and not rate:
        raise TraceError(f"{path}: a Qualisys export with neither a column Time nor a FREQUENCY: export it with them")
    rows = []
    for i, row in enumerate(lines[begin + 1 :]):
        for body, name in enumerate(bodies):
            numbers = row[first + body * _QUALISYS_EACH :][:_QUALISYS_EACH]
            if len(numbers) == _QUALISYS_EACH and all(numbers):
                time = repr(i / rate) if clock is None else row[clock]
                rows.append([time, name.replace(",", " "), *numbers[:3], *(numbers[c] for c in _QUALISYS_TURN)])
    return Made("qualisys", rows_text(rows), _QUALISYS_NAMES, facts=_QUALISYS_FACTS)


_MOTIVE_LENGTHS = {"meters": 1.0, "centimeters": 0.01, "millimeters": 0.001, "inches": 0.0254, "feet": 0.3048}
_BODIES = ("rigidbody", "bone", "skeletonbone")


def _motive_made(path: Path, text: str) -> Made:
    """Return a row for each body that is tracked in a frame. Errors: TraceError."""
    lines = list(csv.reader(text.splitlines()))
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
    columns = next(iter(bodies.values()))
    rows = [
        [row[1], name.replace(",", " "), *(row[at[part]] for part in columns)]
        for row in lines[begin + 1 :]
        for name, at in bodies.items()
        if len(row) > max(at.values()) and all(row[at[part]] for part in columns)
    ]
    unit = about.get("Length Units", "").lower()
    facts = {"scale": _MOTIVE_LENGTHS[unit], "scale_by": By.FILE} if unit in _MOTIVE_LENGTHS else {}
    return Made("motive", rows_text(rows), ("Time (s)", "device", *columns), facts=facts)


_ENDING = "_motion.tsv"
_BESIDE = attrs.evolve(FACTS, what="what describes a table of BIDS", error=TraceError)
_COLUMNS = ("type", "component", "tracked_point", "units", "reference_frame")
_BIDS_LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
_QUATERNION = ("quat_x", "quat_y", "quat_z", "quat_w")
_TURNING = {f"ORNT.{part}" for part in ("x", "y", "z", *_QUATERNION[:3])}
# SpatialAxes: right or left, anterior or posterior, superior or inferior.
_DIRECTIONS = {
    key: (way, "-" * (key in "LIP")) for way, keys in (("right", "RL"), ("up", "SI"), ("ahead", "AP")) for key in keys
}


def _bids_made(path: Path, text: str) -> Made:
    """Return a row for each tracked point in each sample. Errors: TraceError."""
    stem = str(path).removesuffix(_ENDING)
    channels = _channels(Path(f"{stem}_channels.tsv"), path)
    points = _points(channels)
    if not points:
        raise TraceError(f"{path}: its channels hold no orientation (type ORNT): expected quat_x .. quat_w or angles")
    at = points[min(points, key=head_rank)]
    clock = next((i for i, channel in enumerate(channels) if channel["type"].upper() == "LATENCY"), None)
    rate = _json(Path(f"{stem}_motion.json")).get("SamplingFrequency") if clock is None else None
    rate = rate if isinstance(rate, int | float) and rate > 0 else None
    lines = [line.split("\t") for line in text.splitlines() if line.strip()]
    if lines and len(lines[0]) != len(channels):
        raise TraceError(f"{path}: {len(lines[0])} columns, {len(channels)} rows in its channels.tsv: they must agree")
    quaternion = [f"ORNT.{part}" for part in _QUATERNION]
    turn = quaternion if set(quaternion) <= set(at) else [f"ORNT.{axis}" for axis in "xyz" if f"ORNT.{axis}" in at]
    parts = [part for part in at if part.startswith("POS")] + turn
    facts = _bids_facts(stem, channels, at)
    against = facts.pop("against", False)  # turns go against the hand of the axes
    rows = []
    for i, line in enumerate(lines):
        if len(line) != len(channels):
            rows.append(line[:1])  # too short, so that it is counted as a row without a pose
            continue
        time = [line[clock]] if clock is not None else [repr(i / rate)] if rate else []
        for name, columns in points.items():
            if set(parts) <= set(columns):
                numbers = {part: line[columns[part]] for part in parts}
                for part in _TURNING & numbers.keys() if against else ():
                    number = numbers[part]
                    numbers[part] = number[1:] if number.startswith("-") else f"-{number.removeprefix('+')}"
                rows.append([*time, name.replace(",", " "), *numbers.values()])
    named = [part.replace("POS.", "position.").replace("ORNT.quat_", "q") for part in parts]
    named = [part.replace("ORNT.", "rotation.") for part in named]
    names = (*(["time_s"] if clock is not None or rate else []), "device", *named)
    return Made("bids", rows_text(rows), names, facts=facts)


def _points(channels: list[dict[str, str]]) -> dict[str, dict[str, int]]:
    """Return the columns of each tracked point that has an orientation, by type and component."""
    points: dict[str, dict[str, int]] = {}
    for i, channel in enumerate(channels):
        kind = channel["type"].upper()
        if kind in ("POS", "ORNT"):
            points.setdefault(channel["tracked_point"], {})[f"{kind}.{channel['component']}"] = i
    return {name: at for name, at in points.items() if any(part.startswith("ORNT") for part in at)}


def _channels(path: Path, table: Path) -> list[dict[str, str]]:
    if not path.exists():
        raise TraceError(f"{table}: BIDS describes its columns in {path.name}, which is not beside it")
    rows = csv.DictReader(text_in(path, _BESIDE, path.parent).splitlines(), delimiter="\t")
    return [{key: row.get(key) or "n/a" for key in _COLUMNS} for row in rows]


def _json(path: Path) -> dict[str, Any]:
    found = json_in(path, _BESIDE, path.parent) if path.exists() else {}
    return found if isinstance(found, dict) else {}


def _bids_facts(stem: str, channels: list[dict[str, str]], at: dict[str, int]) -> dict[str, Any]:
    facts: dict[str, Any] = {}
    place = next((channels[i] for part, i in at.items() if part.startswith("POS")), {})
    if place.get("units") in _BIDS_LENGTHS:
        facts = {"scale": _BIDS_LENGTHS[place["units"]], "scale_by": By.FILE}
    turn = next(channels[i] for part, i in at.items() if part.startswith("ORNT"))
    described = _json(Path(f"{stem}_channels.json")).get("reference_frame")
    levels = described.get("Levels") if isinstance(described, dict) else None
    frame = levels.get(turn["reference_frame"]) if isinstance(levels, dict) else None
    frame = frame if isinstance(frame, dict) else {}
    if axes := _axes(str(frame.get("SpatialAxes", ""))):
        hand = "right-hand" if np.linalg.det(parse_axes(axes).world) > 0 else "left-hand"
        against = str(frame.get("RotationRule", hand)) != hand
        facts |= {"axes": axes, "axes_by": By.FILE, "against": against}
    order = str(frame.get("RotationOrder", "")).lower()
    if sorted(order) == ["x", "y", "z"] and turn.get("units") in ("deg", "rad"):
        facts |= {"euler": Euler(order, turn["units"] == "deg"), "order_by": By.FILE}
    return facts


def _axes(letters: str) -> str:
    """Return axes for world and head of, for instance, "ARS" (x ahead, y right, z up)."""
    known = ((_DIRECTIONS[s], axis) for s, axis in zip(letters, "xyz", strict=False) if s in _DIRECTIONS)
    found = {way: f"{sign}{axis}" for (way, sign), axis in known}
    return ",".join(found[way] for way in ("right", "up", "ahead")) if len(found) == 3 else ""


def export_reader(path: Path, start: bytes) -> Callable[[Path, str], Made] | None:
    """Return what reads such an export, None for any other file. start: its first bytes."""
    first = start.removeprefix(b"\xef\xbb\xbf").split(b"\n", 1)[0]
    if first.startswith(b"Format Version,"):
        return _motive_made
    if first.startswith((b"NO_OF_FRAMES\t", b"FILE_VERSION\t")) or b"\tResidual\tRot[0]\t" in first:
        return _qualisys_made
    return _bids_made if path.name.endswith(_ENDING) else None  # as the specification has it
