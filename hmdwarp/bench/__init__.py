"""What accuracy costs in time: every method on the same late frames, error against time."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .options import BenchOptions
    from .run import BenchResult, bench

_HOME = {"BenchOptions": "options", "BenchResult": "run", "bench": "run"}

__all__ = ["BenchOptions", "BenchResult", "bench"]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value = getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    return value
