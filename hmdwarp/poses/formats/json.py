"""JSON: an object a line, or a document with a list of poses."""

from __future__ import annotations

from ..options import TraceOptions
from ..reading.file_head import Head
from . import TraceFormat, formats


@formats.register
class Json(TraceFormat):
    """Records with named parts; names are those that column headers have."""

    name = "json"
    summary = "JSON lines, or a document with a list of poses; names as in headers, matrices as lists of lists"

    def sniff(self, head: Head, options: TraceOptions) -> int:
        return 20 if head.source.kind == self.name and head.names is not None else 0
