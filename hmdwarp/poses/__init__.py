"""Head motion: poses over time, their files, prediction, and synthetic heads.

Imports are lazy: `from hmdwarp.poses import load_trace` costs what load_trace costs.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .load import LoadedTrace, load_trace
    from .options import TraceOptions
    from .sample import Origin, PoseSample
    from .source import PoseSource, RecordedSource
    from .track import PoseTrack

_HOME = {
    "LoadedTrace": "load",
    "Origin": "sample",
    "PoseSample": "sample",
    "PoseSource": "source",
    "PoseTrack": "track",
    "RecordedSource": "source",
    "TraceOptions": "options",
    "load_trace": "load",
}

__all__ = [
    "LoadedTrace",
    "Origin",
    "PoseSample",
    "PoseSource",
    "PoseTrack",
    "RecordedSource",
    "TraceOptions",
    "load_trace",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value = getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    return value
