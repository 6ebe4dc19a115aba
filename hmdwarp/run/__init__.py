"""Runs around the loop: replay, live and record, with their logs, summaries and measurements."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .options import LiveOptions, RecordOptions, RunOptions

_HOME = {"LiveOptions": "options", "RecordOptions": "options", "RunOptions": "options"}

__all__ = ["LiveOptions", "RecordOptions", "RunOptions"]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value = getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    return value
