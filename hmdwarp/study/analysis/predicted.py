"""What was measured while the pictures were shown, joined with the ratings they got."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any


def predicted(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any] | None:
    """None where nothing was measured."""
    return None
