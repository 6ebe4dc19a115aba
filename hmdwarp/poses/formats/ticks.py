"""`timestamp x y z qx qy qz qw` with stamps of 18 digits.

Ticks of 100 ns since the year 1 (.NET) or 1601 (Windows).
"""

from __future__ import annotations

from ..options import TraceOptions
from ..reading.file_head import Head
from ..reading.rows import Layout
from . import formats
from ._base import TraceFormat, has, named_layout, unnamed_layout, whole_number

COLUMNS = ("timestamp", "x", "y", "z", "qx", "qy", "qz", "qw")


class Ticks(TraceFormat):
    """Source: System.DateTime.Ticks (ECMA-335) and FILETIME, both counts of 100 ns."""

    name = "ticks"
    summary = "timestamp x y z qx qy qz qw; 18-digit ticks of 100 ns"

    def sniff(self, head: Head, options: TraceOptions) -> int:
        time = head.column("timestamp") if head.names else 0
        stamped = time is not None and time < head.width and whole_number(head.rows[0][time], 18)
        if has(head, *COLUMNS):
            return 85 if stamped else 0
        return 6 if head.names is None and head.width == 8 and stamped else 0

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        if head.names is not None:
            return named_layout(head, options, unit="100ns")
        return unnamed_layout(head, options, self.name, "xyzw", "100ns")


formats.register(Ticks())
