"""Motion of the Brain Imaging Data Structure: a table without header, with files that describe it.

Source: BIDS specification 1.9, "Motion".
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ....errors import TraceError
from ....options.documents import json_in
from ....options.named_files import FACTS, text_in
from ...assumptions import By
from ...options import Euler
from ..axes import parse_axes
from ..columns import head_rank
from ..made import Made, rows_text

KIND = "bids"
_ENDING = "_motion.tsv"
_BESIDE = attrs.evolve(FACTS, what="what describes a table of BIDS", error=TraceError)
_COLUMNS = ("type", "component", "tracked_point", "units", "reference_frame")
_LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
_QUATERNION = ("quat_x", "quat_y", "quat_z", "quat_w")
_TURNING = {f"ORNT.{part}" for part in ("x", "y", "z", *_QUATERNION[:3])}
# SpatialAxes: right or left, anterior or posterior, superior or inferior.
_DIRECTIONS = {
    **{"R": ("right", ""), "S": ("up", ""), "A": ("ahead", "")},
    **{"L": ("right", "-"), "I": ("up", "-"), "P": ("ahead", "-")},
}


def fits(path: Path, start: bytes) -> bool:
    """Return whether a file is such a table, by its name as the specification has it."""
    return path.name.endswith(_ENDING)


def made(path: Path, text: str) -> Made:
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
        raise TraceError(
            f"{path}: {len(lines[0])} columns, but {len(channels)} rows in its channels.tsv: they must agree"
        )
    parts = [part for part in at if part.startswith("POS")] + _turn_parts(at)
    facts = _facts(stem, channels, at)
    against = facts.pop("against", False)  # turns go against the hand of the axes
    rows = []
    for i, line in enumerate(lines):
        if len(line) != len(channels):
            rows.append(line[:1])  # too short, so that it is counted as a row without a pose
            continue
        time = [line[clock]] if clock is not None else [repr(i / rate)] if rate else []
        for name, columns in points.items():
            if set(parts) <= set(columns):
                numbers = [(part, line[columns[part]]) for part in parts]
                turned = (_negated(n) if against and part in _TURNING else n for part, n in numbers)
                rows.append([*time, name.replace(",", " "), *turned])
    names = (*(["time_s"] if clock is not None or rate else []), "device", *map(_name, parts))
    return Made(KIND, rows_text(rows), names, facts=facts)


def _name(part: str) -> str:
    return part.replace("POS.", "position.").replace("ORNT.quat_", "q").replace("ORNT.", "rotation.")


def _points(channels: list[dict[str, str]]) -> dict[str, dict[str, int]]:
    """Return the columns of each tracked point that has an orientation, by type and component."""
    points: dict[str, dict[str, int]] = {}
    for i, channel in enumerate(channels):
        kind = channel["type"].upper()
        if kind in ("POS", "ORNT"):
            points.setdefault(channel["tracked_point"], {})[f"{kind}.{channel['component']}"] = i
    return {name: at for name, at in points.items() if any(part.startswith("ORNT") for part in at)}


def _turn_parts(at: dict[str, int]) -> list[str]:
    quaternion = [f"ORNT.{part}" for part in _QUATERNION]
    return quaternion if set(quaternion) <= set(at) else [f"ORNT.{axis}" for axis in "xyz" if f"ORNT.{axis}" in at]


def _channels(path: Path, table: Path) -> list[dict[str, str]]:
    if not path.exists():
        raise TraceError(f"{table}: BIDS describes its columns in {path.name}, which is not beside it")
    rows = csv.DictReader(text_in(path, _BESIDE, path.parent).splitlines(), delimiter="\t")
    return [{key: row.get(key) or "n/a" for key in _COLUMNS} for row in rows]


def _json(path: Path) -> dict[str, Any]:
    found = json_in(path, _BESIDE, path.parent) if path.exists() else {}
    return found if isinstance(found, dict) else {}


def _facts(stem: str, channels: list[dict[str, str]], at: dict[str, int]) -> dict[str, Any]:
    facts: dict[str, Any] = {}
    place = next((channels[i] for part, i in at.items() if part.startswith("POS")), {})
    if place.get("units") in _LENGTHS:
        facts = {"scale": _LENGTHS[place["units"]], "scale_by": By.FILE}
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


def _negated(number: str) -> str:
    return number.removeprefix("-") if number.startswith("-") else f"-{number.removeprefix('+')}"


def _axes(letters: str) -> str:
    """Return axes for world and head of, for instance, "ARS" (x ahead, y right, z up)."""
    known = ((_DIRECTIONS[s], axis) for s, axis in zip(letters, "xyz", strict=False) if s in _DIRECTIONS)
    found = {way: f"{sign}{axis}" for (way, sign), axis in known}
    return ",".join(found[way] for way in ("right", "up", "ahead")) if len(found) == 3 else ""
