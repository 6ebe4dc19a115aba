"""What belongs to an event, a session, a showing, as one text in a row."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def to_json(data: Mapping[str, Any]) -> str:
    """Numbers that are none (NaN, infinite) become null: JSON has no word for them. NumPy's numbers and arrays become plain ones.

    Errors: TypeError for what is no data.
    """
    return json.dumps(_plain(data), ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def from_json(text: str) -> Any:
    """What to_json wrote."""
    return json.loads(text)


def clean(text: str) -> str:
    """What a terminal's broken bytes became (lone surrogates) is "?": no database takes them, and a remark must not end a session."""
    return text.encode(errors="replace").decode()


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):  # NumPy's
        value = value.tolist()
    if isinstance(value, Mapping):
        return {clean(str(key)): _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [_plain(one) for one in value]
    if isinstance(value, str | Path):
        return clean(str(value))
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, bool | int):
        return value
    raise TypeError(f"{type(value).__name__} cannot be stored: {value!r}")
