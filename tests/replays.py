"""Small replays for tests: one call, small defaults, and pixels where figures are not enough."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path
from unittest.mock import patch

import attrs
import numpy as np
from numpy.typing import NDArray

from hmdwarp.client import parse_indirect, parse_warp
from hmdwarp.client.effects import effects
from hmdwarp.client.strategies import options_of_strategy
from hmdwarp.client.warps import warps
from hmdwarp.gpu import Gpu, download
from hmdwarp.pipeline import Refresh
from hmdwarp.pipeline.options import DEFAULT_WARP
from hmdwarp.run import ReplayResult, ReplayRun, RunOptions, replay, set_up_replay
from hmdwarp.scenes import load_scene

SMALL = {
    "trace": "look-around", "scene": "planes", "warp": "forward", "fill": "none", "guard": 1.0, "predict": "none",
    "lens": "none", "headset": "flat-90", "size": (96, 80), "rate_hz": 60.0, "samples": 1, "seconds": 0.5,
    "against": "", "metrics_every": 5, "workers": 0, "images": 0,
}  # fmt: skip
# Light of fewer paths or cells, solved at every fifth refresh, and fewer layers are kept in the
# same places.
CHEAPER = {
    "photons": "photons:paths=256",
    "irradiance": "irradiance:updates=0.05",
    "layered": "layered:layers=2",
    "voxels": "voxels:size=8,cones=4",
}


def suited(scene: str = "planes") -> list[str]:
    """Return the names of the warps that are for the scene."""
    return [warp.name for warp in warps if not warp.unsuited(load_scene(scene))]


def scene_for(strategy: str) -> str:
    """Return a small scene that the strategy's warp, light and effects are for."""
    sets, planes = options_of_strategy(strategy), load_scene("planes")
    light = parse_indirect(sets.get("indirect", "converged"))
    warp, told = parse_warp(sets.get("warp", DEFAULT_WARP)).entry, sets.get("effects", "auto")
    if effects.forced(told) - {*effects.selected(told, (), planes)}:
        return "parade"
    return "lantern" if warp.unsuited(planes) or (light is not None and light.entry.unsuited(planes)) else "planes"


def small(out: Path | str = "nowhere", **options: object) -> RunOptions:
    """Options of a run that takes well under a second."""
    return RunOptions(**{**SMALL, "out": Path(out), **options})  # type: ignore[arg-type]


def run(out: Path, page: bool = False, gpu: Gpu | None = None, **options: object) -> ReplayResult:
    """Run a small replay into `out`; page, gpu: as replayed."""
    return replayed(small(out, **options), page, gpu)


def replayed(options: RunOptions, page: bool = False, gpu: Gpu | None = None) -> ReplayResult:
    """Run a replay.

    page: whether report.html is drawn; its plots take longer than such a replay, and without them
    it says nothing. gpu: a context that many runs share, instead of one of its own.
    """
    with ExitStack() as stack:
        if not page:
            stack.enter_context(patch("hmdwarp.run.run_summary.render_report", lambda *_, **__: "no page"))
        if gpu is not None:
            stack.enter_context(patch("hmdwarp.run.run.Gpu", lambda: nullcontext(gpu)))
        return replay(options)


def rows_of(folder: Path) -> list[dict[str, str]]:
    """frames.csv as it was written."""
    with (folder / "frames.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def contents(folder: Path) -> dict[str, bytes]:
    """Every file below a folder, hidden ones too."""
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def each_refresh(options: RunOptions, look: Callable[[ReplayRun, int, Refresh], None]) -> None:
    """The loop alone, without measuring and files.

    look(setup, number, refresh) at every shown refresh.
    """
    with set_up_replay(options) as setup:
        for number, instant_ns in setup.schedule.numbered():
            setup.loop.draw(instant_ns)
            if number >= 0:
                refresh = setup.loop.show(instant_ns)
                assert refresh is not None, "refresh is not None"  # test_proxy reads it
                look(setup, number, refresh)


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

    def look(setup: ReplayRun, number: int, refresh: Refresh) -> None:
        if number % every:
            return
        for result in refresh.eyes:
            truth = setup.server.draw(result.view, setup.sizes.shown)
            textures = (result.shown.texture, truth.colour, result.warped.texture)
            shown, right, warped = (download(texture).astype(np.float32) for texture in textures)
            setup.server.pool(setup.sizes.shown).release(truth.colour)
            found.append(Seen(shown, right, warped[..., 3]))

    each_refresh(options, look)
    return found


@contextmanager
def set_up(gpu: Gpu, options: RunOptions, **more: object) -> Iterator[ReplayRun]:
    """A replay that compares with nothing, in a context that others share."""
    with patch("hmdwarp.run.run.Gpu", lambda: nullcontext(gpu)), set_up_replay(options, alone=True, **more) as setup:
        yield setup


def of_strategy(strategy: str, network: dict[str, object], **more: object) -> RunOptions:
    """Half a second of a strategy, with nothing but what it sets: no codec, no prediction."""
    usual = {key: value for key, value in SMALL.items() if key not in ("warp", "fill", "guard")}
    usual |= {"size": (48, 41), "start_s": 1.0, "out": Path("nowhere")}
    return RunOptions.of({"strategy": strategy, **network}, **usual | more)


def refreshed(setup):
    """The third refresh that a set-up replay shows."""
    shown = 0
    for _, instant_ns in setup.schedule.numbered():
        setup.loop.draw(instant_ns)
        refresh = setup.loop.show(instant_ns)
        shown += refresh is not None
        if shown == 3:
            return refresh
    raise AssertionError("the recording is too short")
