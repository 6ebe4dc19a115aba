"""How recorded frames are replayed if nothing is said: three frames late."""

from __future__ import annotations

from pathlib import Path

from hmdwarp.run import RunOptions

# Frames of 30 Hz.
SIZE, COUNT, LATE_MS = (60, 40), 12, 100.0


def options(folder: Path, out: Path | str = "nowhere", **said: object) -> RunOptions:
    usual = {"latency": LATE_MS, "against": "", "metrics_every": 3, "workers": 0, "images": 0}
    return RunOptions.of({**usual, "frames": folder, "out": Path(out), **said})
