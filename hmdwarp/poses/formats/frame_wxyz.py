"""360-degree video head movements: `t[s] frame w x y z`, blank-separated, no header, z up."""

from __future__ import annotations

import math

from ...errors import TraceError
from ..options import TraceOptions
from ..reading.head import Head, is_number
from ..reading.rows import Layout
from . import FORMATS
from ._base import TraceFormat, ordered
from .multiviewpoint import AXES


class FrameWxyz(TraceFormat):
    """The shape alone tells this format: six bare columns, the second a frame number that never falls, the last four of length 1.

    Its order is w first by definition; a file of this shape whose heads would then hang sideways is refused (the z axis of the
    head, on the first rows, must point up rather than down or level).
    Source: Corbillon et al. 2017, 360-degree video head movement dataset (MMSys).
    """

    name = "frame_wxyz"
    summary = "t[s] frame w x y z; no header, blank-separated, rotation only, z up, x forward"

    def sniff(self, head: Head, options: TraceOptions) -> int:
        if head.names is not None or head.separator is not None or head.width != 6:
            return 0
        rows = [r for r in head.rows if len(r) == 6 and all(is_number(f) for f in r)]
        if not rows or not all(r[1].isdigit() for r in rows):
            return 0
        frames = [int(r[1]) for r in rows]
        unit = sum(abs(math.hypot(*_quaternion(r)) - 1) < 0.05 for r in rows)
        return 60 if frames == sorted(frames) and 2 * unit > len(rows) else 0

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        if head.width < 6:
            raise TraceError(f"{head.path}: line {head.first_line}: {head.width} columns, wanted 6: time, frame and a quaternion")
        order = options.quat_order
        if order is None and options.format != self.name and not _upright(head):
            raise TraceError(
                f"{head.path} has the shape of 't frame w x y z', but read so the head hangs sideways: "
                "say --quat-order xyzw if w comes last, or --quat-order wxyz if it is right as it is"
            )
        return Layout(time=0, orientation=ordered(head, (2, 3, 4, 5), order or "wxyz"), unit="s", axes=AXES)


def _quaternion(row: list[str]) -> list[float]:
    return [float(f.replace(",", ".")) for f in row[2:6]]


def _upright(head: Head) -> bool:
    """The head's z axis has a vertical part of more than 0.3 in the mean, with w first; otherwise w last must not do better."""
    rows = [_quaternion(r) for r in head.rows if len(r) == 6 and all(is_number(f) for f in r)]
    first = sum(1 - 2 * (r[1] ** 2 + r[2] ** 2) for r in rows) / max(len(rows), 1)
    last = sum(1 - 2 * (r[0] ** 2 + r[1] ** 2) for r in rows) / max(len(rows), 1)
    return first > 0.3 or first >= last


FORMAT = FORMATS.register(FrameWxyz())
