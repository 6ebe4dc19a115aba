"""Detect the format of a file from its contents."""

from __future__ import annotations

from ..errors import TraceError
from .formats import TraceFormat, formats
from .options import TraceOptions
from .reading.file_head import Head


def find_format(head: Head, options: TraceOptions) -> TraceFormat:
    """Return the named format, or the most likely one. Errors: UnknownNameError, TraceError."""
    if options.columns is not None:
        from .stated import StatedColumns

        return StatedColumns()
    if options.format is not None:
        return formats.get(options.format)
    scores = {f.name: f.sniff(head, options) for f in formats}
    best = max(scores, key=scores.__getitem__)
    if scores[best] > 0:
        return formats.get(best)
    if head.names is None and head.width >= 5:
        raise TraceError(
            f"{head.path}: nothing in the file says what its columns are ({head.describe()}): "
            "say --columns t=1,p=2+3+4,q=5+6+7+8 with their numbers (q: x y z w)"
        )
    known = ", ".join(formats.names())
    raise TraceError(
        f"{head.path} is in no known trace format ({head.describe()}): "
        f"name the columns in a header line, or say --format ({known})"
    )
