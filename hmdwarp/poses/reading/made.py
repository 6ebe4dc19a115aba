"""A table that was made of a file whose rows are no plain rows of numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import attrs

from ..stated import Defect


@attrs.frozen
class Made:
    """Comma-separated rows, and what the file says of them."""

    kind: str  # what `TraceFormat.kind` looks for
    text: bytes
    names: tuple[str, ...] = ()  # of the columns; (): they are in the text, or there are none
    defects: tuple[Defect, ...] = ()  # found while the rows were made
    nested: Mapping[str, Defect] = attrs.field(factory=dict)  # those of one device's rows
    facts: Mapping[str, Any] = attrs.field(factory=dict)  # fields of Layout that the file states


def rows_text(rows: Iterable[Iterable[str]]) -> bytes:
    """Return the text of rows of fields without commas."""
    return "".join(f"{','.join(row)}\n" for row in rows).encode()
