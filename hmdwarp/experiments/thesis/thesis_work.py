"""Runs the cases of the thesis: one run each; those that see the same late frames share them."""

from __future__ import annotations

import functools
import platform
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import attrs

from ...gpu import Gpu
from ...pipeline.build import refreshes_of
from ...report import jpeg_bytes
from ...run.run_summary import machine_of
from ...scenes import load_scene
from ..sweep import Result, SweepCase
from .picture_runs import Looked, Thoroughness, look
from .run_kinds import RATE_HZ, FactRun, Figures, PictureRun, RatingsRun, Run, StreamRun
from .stream_runs import stream

PICTURE, TRUTH, TIMELINE = "shown.jpg", "truth.jpg", "timeline.svg"
# What the published ratings of a part and latency say: the study package's, handed in.
Ratings = Callable[[str, float], Figures]
_FACTS: Mapping[str, Callable[[], float]] = {
    "triangles": lambda: float(load_scene("room").triangle_count),
    "place_of_500_ms": lambda: float(refreshes_of(500.0, RATE_HZ)),
}
# What the figures of a kind depend on besides what draws and measures pictures; the rules that
# judge them do not count.
_ALSO: Mapping[type, tuple[str, ...]] = {
    PictureRun: ("experiments/thesis/picture_runs.py", "experiments/thesis/hole_kinds.py"),
    StreamRun: ("experiments/thesis/stream_runs.py", "experiments/thesis/picture_runs.py"),
    RatingsRun: ("study/",),
    FactRun: ("experiments/thesis/thesis_work.py",),
}


@attrs.frozen
class ThesisPart:
    """What one case runs."""

    run: Run
    how: Thoroughness
    # Whether its pictures, or the time line of its frames, are kept.
    is_pictured: bool


def cases_of(runs: Sequence[Run], pictured: set[Run], how: Thoroughness) -> list[SweepCase]:
    """Return a case for each run.

    Those that are timed are one group, as are those on the same frames. pictured: whose pictures
    are kept.
    """
    cases = [
        SweepCase.of(
            "thesis", str(run), ThesisPart(run, how, run in pictured), also=_ALSO[type(run)], group=_group(run)
        )
        for run in runs
    ]
    places: dict[Any, int] = {}
    for case in cases:
        for key in (case.group, _frames(case.what.run)):
            places.setdefault(key, len(places))
    return sorted(cases, key=lambda case: (places[case.group], places[_frames(case.what.run)]))


def _group(run: Run) -> str:
    """Return what runs on one machine: what is timed is compared with each other."""
    if not isinstance(run, PictureRun):
        return ""
    return "timed" if run.timed else repr(run.shared)


def _frames(run: Run) -> Any:
    return (run.timed, run.shared) if isinstance(run, PictureRun) else run


@attrs.frozen
class ThesisWork:
    """Runs the cases of the thesis."""

    # All that are wanted: those on the same frames are looked at together.
    runs: tuple[Run, ...]
    ratings: Ratings

    @contextmanager
    def opened(self) -> Iterator[Callable[[SweepCase, Callable[[float], None]], Result]]:
        """Open a folder for the traces of heads."""
        with tempfile.TemporaryDirectory(prefix="hmdwarp-thesis-") as name:
            yield _Runner(self.runs, self.ratings, Path(name))


@functools.cache
def _examined() -> dict[str, Any]:
    """Return what this machine is, found out once in each process."""
    with Gpu() as gpu:
        return {"machine": {**machine_of(gpu), "host": platform.node()}, "clock": gpu.timer.clock}


class _Runner:
    """Runs one case after the other; what was looked at together waits for its turn."""

    def __init__(self, runs: Sequence[Run], ratings: Ratings, folder: Path) -> None:
        self._runs, self._ratings, self._folder = runs, ratings, folder
        self._looked: dict[Run, Looked] = {}
        # Frames on which not all could be looked at: there each is looked at by itself.
        self._apart: set[Any] = set()

    def __call__(self, case: SweepCase, step: Callable[[float], None]) -> Result:
        part: ThesisPart = case.what
        machine, run, files = _examined(), part.run, {}
        if isinstance(run, PictureRun):
            looked = self._look(run, part.how)
            figures = looked.figures
            files = {PICTURE: jpeg_bytes(looked.picture), TRUTH: jpeg_bytes(looked.truth)} if part.is_pictured else {}
        elif isinstance(run, StreamRun):
            figures, drawn = stream(run, part.how.stream_scale, part.how.stream_s)
            files = {TIMELINE: drawn.encode()} if part.is_pictured else {}
        elif isinstance(run, RatingsRun):
            figures = self._ratings(run.part, run.latency_ms)
        else:
            figures = {"value": _FACTS[run.fact]()}
        return Result({**machine, "figures": figures}, files)

    def _look(self, run: PictureRun, how: Thoroughness) -> Looked:
        frames = _frames(run)
        if run not in self._looked:
            together = [one for one in self._runs if isinstance(one, PictureRun) and _frames(one) == frames]
            chosen = [run] if frames in self._apart else together
            try:
                self._looked = {looked.run: looked for looked in look(chosen, how, self._folder)}
            except Exception:
                if len(chosen) == 1:
                    raise
                self._apart.add(frames)  # one of them is at fault: the others go on
                return self._look(run, how)
        return self._looked[run]
