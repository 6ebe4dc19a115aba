"""JSON texts of events, sessions and showings."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def to_json(data: Mapping[str, Any]) -> str:
    """Encode data; NaN and infinite numbers become null, NumPy's numbers and arrays plain ones.

    Errors: TypeError for other objects.
    """
    return json.dumps(_plain(data), ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def from_json(text: str) -> Any:
    """Decode a text that to_json wrote."""
    return json.loads(text)


def clean(text: str) -> str:
    """Replace lone surrogates, a terminal's broken bytes, by "?": the database refuses them."""
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
