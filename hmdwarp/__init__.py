"""hmdwarp: latency compensation for head-mounted displays.

    out = hmdwarp.warp_image(colour, depth_m, rendered=View(...), shown=View(...), warp="forward", fill="interpolate")

Names are imported when they are first used, so that importing the package costs nothing.
"""

from __future__ import annotations

import importlib
from typing import Any

from .version import __version__

_HOME = {
    "DepthLayer": "geometry",
    "Fov": "geometry",
    "HmdwarpError": "errors",
    "InputError": "errors",
    "MachineError": "errors",
    "Pose": "geometry",
    "PoseTrack": "poses",
    "RunOptions": "pipeline.options",
    "View": "geometry",
    "WarpMap": "geometry",
    "WarpedImage": "image.warping",
    "inverse_depth_from_clip": "geometry",
    "load_trace": "poses",
    "replay": "run.replay",
    "warp_image": "image.warping",
}

__all__ = ["__version__", *_HOME]  # noqa: PLE0604 (the keys are strings)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'hmdwarp' has no attribute '{name}'")
    value = getattr(importlib.import_module(f"hmdwarp.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOME])
