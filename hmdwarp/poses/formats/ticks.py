"""`timestamp x y z qx qy qz qw` with stamps of 18 digits.

Ticks of 100 ns since the year 1 (.NET) or 1601 (Windows).
"""

from __future__ import annotations

from ..assumptions import Layout
from ..options import TraceOptions
from ..reading.file_head import Head
from . import TraceFormat, formats, unnamed_layout


@formats.register
class Ticks(TraceFormat):
    """Source: System.DateTime.Ticks (ECMA-335) and FILETIME, both counts of 100 ns."""

    name = "ticks"
    summary = "timestamp x y z qx qy qz qw; 18-digit ticks of 100 ns"
    header = ("timestamp", "x", "y", "z", "qx", "qy", "qz", "qw")
    likelihood = 85
    facts = {"unit": "100ns"}

    def sniff(self, head: Head, options: TraceOptions) -> int:
        time = head.column("timestamp") if head.names else 0
        stamp = head.rows[0][time] if time is not None and time < head.width else ""
        if not (len(stamp) == 18 and stamp.encode(errors="replace").isdigit()):
            return 0
        return 6 if head.names is None and head.width == 8 else super().sniff(head, options)

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        if head.names is not None:
            return super().layout(head, options)
        return unnamed_layout(head, options, self.name, "xyzw", "100ns")
