"""TSV of Qualisys Track Manager with 6DOF data: key words, then columns for each body.

Source: QTM documentation, Motion data (.tsv) and 6DOF data (.tsv).
"""

from __future__ import annotations

import re
from pathlib import Path

from ....errors import TraceError
from ...assumptions import By
from ..made import Made, rows_text

KIND = "qualisys"
_EACH = 16  # columns of a body: X Y Z Roll Pitch Yaw Residual Rot[0] .. Rot[8]
_TURN = tuple(7 + 3 * column + row for row in range(3) for column in range(3))  # Rot[] goes by columns
_NAMES = ("time_s", "device", "x", "y", "z", *(f"r{row}{column}" for row in range(3) for column in range(3)))
_FACTS = {
    "scale": 0.001,
    "scale_by": By.FORMAT,
    "matrix": "by columns (Rot[0] Rot[1] Rot[2] is the first)",
    "order_by": By.FORMAT,
}


def fits(path: Path, start: bytes) -> bool:
    """Return whether a file is such an export."""
    first = start.removeprefix(b"\xef\xbb\xbf").split(b"\n", 1)[0]
    return first.startswith((b"NO_OF_FRAMES\t", b"FILE_VERSION\t")) or b"\tResidual\tRot[0]\t" in first


def made(path: Path, text: str) -> Made:
    """Return a row for each body in each frame. Errors: TraceError for other data than 6D."""
    lines = [line.rstrip("\r\n\t").split("\t") for line in text.splitlines()]
    begin = next((i for i, row in enumerate(lines) if "Rot[0]" in row), None)
    about = {row[0]: row[1:] for row in lines[:begin]}
    if begin is None:
        held = " ".join(about.get("DATA_INCLUDED", ["no"]))
        raise TraceError(f"{path}: a Qualisys export of {held} data: export the bodies as 6D, with header")
    first = lines[begin].index("Rot[0]") - 7
    bodies = about.get("BODY_NAMES") or [name.removesuffix(" X") for name in lines[begin][first::_EACH]]
    clock = lines[begin].index("Time") if "Time" in lines[begin][:first] else None
    stated = "".join(about.get("FREQUENCY", [])[:1])
    rate = float(stated) if clock is None and re.fullmatch(r"\d+(\.\d+)?", stated) else 0.0
    if clock is None and not rate:
        raise TraceError(f"{path}: a Qualisys export with neither a column Time nor a FREQUENCY: export it with them")
    rows = []
    for i, row in enumerate(lines[begin + 1 :]):
        for body, name in enumerate(bodies):
            numbers = row[first + body * _EACH :][:_EACH]
            if len(numbers) == _EACH and all(numbers):
                time = repr(i / rate) if clock is None else row[clock]
                rows.append([time, name.replace(",", " "), *numbers[:3], *(numbers[c] for c in _TURN)])
    return Made(KIND, rows_text(rows), _NAMES, facts=_FACTS)
