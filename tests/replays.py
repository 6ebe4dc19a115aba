"""Small replays for tests.

One call, sensible small defaults, and the pixels of a run's pictures where figures are not enough.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray

from hmdwarp.gpu.textures import download
from hmdwarp.pipeline.loop import Refresh
from hmdwarp.pipeline.options import RunOptions
from hmdwarp.run.replay import ReplayResult, replay
from hmdwarp.run.rig import Rig, build_rig

SMALL = {
    "trace": "look-around",
    "scene": "planes",
    "fill": "none",
    "lens": "none",
    "headset": "flat-90",
    "size": (96, 80),
    "rate_hz": 60.0,
    "seconds": 0.5,
    "against": "",
    "metrics_every": 5,
    "workers": 0,
    "images": 0,
}


def small(out: Path | str = "nowhere", **options: object) -> RunOptions:
    """Options of a run that takes well under a second."""
    return RunOptions(**{**SMALL, "out": Path(out), **options})  # type: ignore[arg-type]


def run(out: Path, **options: object) -> ReplayResult:
    """A small replay into `out`."""
    return replay(small(out, **options))


def rows_of(folder: Path) -> list[dict[str, str]]:
    """frames.csv as it was written."""
    with (folder / "frames.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def contents(folder: Path) -> dict[str, bytes]:
    """Every file below a folder, hidden ones too."""
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def each_refresh(options: RunOptions, look: Callable[[Rig, int, Refresh], None]) -> None:
    """The loop alone, without measuring and files.

    look(rig, number, refresh) at every shown refresh.
    """
    with build_rig(options) as rig:
        number = 0
        for instant_ns, shown in rig.timetable.instants():
            rig.loop.draw(instant_ns)
            if shown:
                refresh = rig.loop.show(instant_ns)
                assert refresh is not None
                look(rig, number, refresh)
                number += 1


@attrs.frozen(eq=False)
class Seen:
    """One eye at one refresh, top row first.

    What was shown (h, w, 4), what should have been, coverage before the fill.
    """

    shown: NDArray[np.float32]
    truth: NDArray[np.float32]
    coverage: NDArray[np.float32]


def seen(options: RunOptions, every: int = 1) -> list[Seen]:
    """Both eyes of every n-th refresh in linear light."""
    found: list[Seen] = []

    def look(rig: Rig, number: int, refresh: Refresh) -> None:
        if number % every:
            return
        for result in refresh.eyes:
            truth = rig.server.draw(result.view, rig.size)
            textures = (result.shown.texture, truth.colour, result.warped.texture)
            shown, right, warped = (download(texture).astype(np.float32) for texture in textures)
            rig.server.pool(rig.size).release(truth.colour)
            found.append(Seen(shown, right, warped[..., 3]))

    each_refresh(options, look)
    return found
