"""Facts about the machine that a session ran on, stored once for each run of the program."""

from __future__ import annotations

import os
import platform
from importlib import metadata
from pathlib import Path
from typing import Any

from ...display import Display
from ...resources import __version__
from ..design import Design

PACKAGES = ("numpy", "scipy", "moderngl", "glfw", "pyopenxr", "attrs", "textual")


def facts_of(display: Display, design: Design, trace: str) -> dict[str, Any]:
    """Return versions, machine, GPU, display and seed.

    No name of a host or a user is among them: a session's data may be passed on. Of a trace file
    the name is kept, not the folders.
    """
    gpu = display.gpu
    return {
        "hmdwarp": __version__,
        "python": platform.python_version(),
        "packages": {name: version for name in PACKAGES if (version := _version(name))},
        "machine": {
            "system": platform.system(),
            "release": platform.release(),
            "cpu": platform.machine(),
            "cpu_count": os.cpu_count() or 1,
        },
        "gpu": {"renderer": gpu.renderer, "version": gpu.version, "clock": gpu.timer.clock},
        "display": dict(display.about),
        "source": display.name,
        "headset": display.headset.name if display.headset is not None else display.about.get("headset", ""),
        "rate_hz": display.rate_hz,
        "seed": design.seed,
        "trace": Path(trace).name,
        "trace_axes": display.about.get("trace_axes", ""),
    }


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""
