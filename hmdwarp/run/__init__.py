"""Runs around the loop: replay, live and record, with their logs, summaries and measurements."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .bench_levels import LevelSet, levels_from_file
    from .driver import Driver, FrameHandler
    from .ending import Ending
    from .host import PipelineHost, checked_scene, refuse_one_eye
    from .live_log import LiveLog, LiveResult
    from .live_run import live, open_display
    from .options import LiveOptions, RecordOptions, RunOptions
    from .record_run import record
    from .recorder import Recorder
    from .replay_run import ReplayResult, figures, replay
    from .replay_setup import ReplaySetup, set_up_replay
    from .watchdog import Watchdog

_HOME = {
    "Driver": "driver",
    "Ending": "ending",
    "FrameHandler": "driver",
    "LevelSet": "bench_levels",
    "LiveLog": "live_log",
    "LiveOptions": "options",
    "LiveResult": "live_log",
    "PipelineHost": "host",
    "RecordOptions": "options",
    "Recorder": "recorder",
    "ReplayResult": "replay_run",
    "ReplaySetup": "replay_setup",
    "RunOptions": "options",
    "Watchdog": "watchdog",
    "checked_scene": "host",
    "figures": "replay_run",
    "levels_from_file": "bench_levels",
    "live": "live_run",
    "open_display": "live_run",
    "record": "record_run",
    "refuse_one_eye": "host",
    "replay": "replay_run",
    "set_up_replay": "replay_setup",
}

__all__ = [
    "Driver",
    "Ending",
    "FrameHandler",
    "LevelSet",
    "LiveLog",
    "LiveOptions",
    "LiveResult",
    "PipelineHost",
    "RecordOptions",
    "Recorder",
    "ReplayResult",
    "ReplaySetup",
    "RunOptions",
    "Watchdog",
    "checked_scene",
    "figures",
    "levels_from_file",
    "live",
    "open_display",
    "record",
    "refuse_one_eye",
    "replay",
    "set_up_replay",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value = getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    return value
