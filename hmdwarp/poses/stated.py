"""A trace whose columns the user names: --columns t=..,p=..,q=..."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..errors import InputError
from .formats import TraceFormat, column_of, column_of_devices, ordered

if TYPE_CHECKING:
    from .options import TraceOptions
    from .reading.file_head import Head
    from .reading.rows import Layout

_SYNTAX = "t=TIME,p=X+Y+Z,q=X+Y+Z+W with names or numbers from 1, such as t=1,p=2+3+4,q=5+6+7+8"


class StatedColumns(TraceFormat):
    """Columns by the user's word; quaternions are x y z w unless --quat-order says otherwise."""

    name = "columns"
    summary = "columns as --columns names them"

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        from .reading.rows import Layout

        text = options.columns or ""
        parts = [part.partition("=") for part in text.split(",")]
        stated = {key.strip(): [column_of(head, word) for word in value.split("+")] for key, _, value in parts if value}
        counts = {"t": 1, "p": 3, "q": 4}
        if len(stated) != len(parts) or "q" not in stated or any(len(v) != counts.get(k) for k, v in stated.items()):
            raise InputError(f"--columns '{text}': expected {_SYNTAX}")
        position = stated.get("p")
        return Layout(
            time=stated["t"][0] if "t" in stated else None,
            orientation=ordered(head, tuple(stated["q"]), options.quat_order or "xyzw"),
            device=column_of_devices(head),
            position=None if position is None else (position[0], position[1], position[2]),
        )
