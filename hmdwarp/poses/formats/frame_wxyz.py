"""360-degree video head movements: `t[s] frame w x y z`, blank-separated, no header, z up."""

from __future__ import annotations

import math

import numpy as np

from ...errors import TraceError
from ..assumptions import By, Layout
from ..options import TraceOptions
from ..reading.cleaning import LoadedTrace
from ..reading.file_head import Head, is_number
from ..track import PoseTrack
from . import TraceFormat, formats, ordered
from .multiviewpoint import AXES


@formats.register
class FrameWxyz(TraceFormat):
    """Six bare columns: the second a non-decreasing frame number, the last four of length 1.

    Only this shape identifies the format. Its order is w first by definition; a file of this shape
    whose own motion contradicts that is refused.
    Source: Corbillon et al. 2017, 360-degree video head movement dataset (MMSys).
    """

    name = "frame_wxyz"
    summary = "t[s] frame w x y z; no header, blank-separated, rotation only, z up, x forward"

    order = "quaternion wxyz"
    order_by = By.FORMAT
    facts = {"unit": "s", "axes": AXES}

    def sniff(self, head: Head, options: TraceOptions) -> int:
        if head.names is not None or head.separator is not None or head.width != 6:
            return 0
        rows = [r for r in head.rows if len(r) == 6 and all(is_number(f) for f in r)]
        if not rows or not all(r[1].encode(errors="replace").isdigit() for r in rows):
            return 0
        frames = [int(r[1]) for r in rows]
        unit = sum(abs(math.hypot(*[float(f.replace(",", ".")) for f in r[2:6]]) - 1) < 0.05 for r in rows)
        return 60 if frames == sorted(frames) and 2 * unit > len(rows) else 0

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        if head.width < 6:
            raise TraceError(
                f"{head.path}: line {head.first_line}: {head.width} columns, expected 6: time, frame and a quaternion"
            )
        return Layout(
            time=0,
            orientation=ordered(head, (2, 3, 4, 5), options.quat_order or "wxyz"),
            columns_by=By.FORMAT,
            order_by=By.USER if options.quat_order else By.FORMAT,
            unit_by=By.FORMAT,
            **self.facts,
        )

    def read(self, head: Head, options: TraceOptions) -> LoadedTrace:
        loaded = super().read(head, options)
        if options.quat_order is None and options.format != self.name and _hangs(loaded.track):
            raise TraceError(
                f"{head.path} has the shape of 't frame w x y z', but read so the head hangs upside down: "
                "say --quat-order xyzw if w comes last, or --quat-order wxyz if it is right as it is"
            )
        return loaded


def _hangs(track: PoseTrack) -> bool:
    """Return whether the head hangs upside down, but would be upright had w come last.

    Upside down means a tenth of the time. The vertical part of the head's own up is 1 - 2 (x^2 +
    y^2) in the file's axes. Read in the wrong order it swings with the heading instead, so only a
    head that has turned reveals the order.
    """
    x, z, w = (track.orientation_xyzw[:, i] for i in (0, 2, 3))  # OpenXR's x is the file's -y, its z the file's -x
    as_read, other = 1 - 2 * (z**2 + x**2), 1 - 2 * (w**2 + z**2)
    return bool(np.percentile(as_read, 10) < 0 and np.percentile(other, 10) > 0.5)
