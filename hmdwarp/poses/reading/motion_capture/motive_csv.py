"""CSV of OptiTrack's Motive: seven lines of header, columns for each rigid body.

Source: OptiTrack documentation, Data Export: CSV.
"""

from __future__ import annotations

import csv
from pathlib import Path

from ....errors import TraceError
from ...assumptions import By
from ..made import Made, rows_text

KIND = "motive"
_LENGTHS = {"meters": 1.0, "centimeters": 0.01, "millimeters": 0.001, "inches": 0.0254, "feet": 0.3048}
_BODIES = ("rigidbody", "bone", "skeletonbone")


def fits(path: Path, start: bytes) -> bool:
    """Return whether a file is such an export."""
    return start.removeprefix(b"\xef\xbb\xbf").startswith(b"Format Version,")


def made(path: Path, text: str) -> Made:
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
    facts = {"scale": _LENGTHS[unit], "scale_by": By.FILE} if unit in _LENGTHS else {}
    return Made(KIND, rows_text(rows), ("Time (s)", "device", *columns), facts=facts)
