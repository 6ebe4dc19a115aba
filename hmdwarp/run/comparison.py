"""One case: all combinations of a batch on the same late frames, timed by turns, measured against the same truth."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from ..client.compensator import Compensator, EyeResult
from ..client.inputs import PassInputs
from ..client.plan import needs_of
from ..colour import picture_from_linear
from ..frames import Needs
from ..geometry import View
from ..gpu.textures import download
from ..metrics import Compared, Mismatch, QualityJob, QualityPool, SharedSurface
from ..pipeline.loop import Refresh
from ..server.targets import TargetPool
from .combinations import Case, Combination, frames_used, instants_of
from .read_back import coverage, shown_picture
from .replay_setup import ReplaySetup
from .rows import Row, stage_columns

Key = tuple[Case, str, str, int, int]  # (case, warp, fill, refresh, eye): what a picture is measured under
EYES = (0, 1)


@attrs.frozen(eq=False)
class Measured:
    """What was found out about one combination in one case, but for the pictures' figures, which the pool has under `keys`.

    times: one row for each timed run of one eye, keyed as frames.csv; stages: the same by the
    timer's own names.
    """

    combination: Combination
    times: list[Row] = attrs.field(factory=list)
    stages: dict[str, list[float]] = attrs.field(factory=lambda: defaultdict(list))
    keys: list[Key] = attrs.field(factory=list)
    mismatch: list[Mismatch] = attrs.field(factory=list)


@attrs.frozen(eq=False)
class Truth:
    """What one eye should see at a refresh: sRGB picture (h, w, 3) and inverse depth (h, w), top row first."""

    picture: NDArray[np.uint8]
    inverse_depth: NDArray[np.float32]


def refreshes(setup: ReplaySetup, needs: Needs, numbers: Collection[int]) -> Iterator[tuple[int, Refresh]]:
    """Those refreshes of a run, counted from 0, in the order of time; a number below 0 is passed over.

    They are what the whole run would show, but only the frames they use are drawn.
    """
    used = frames_used(setup.schedule, setup.channel.latency_ns, needs, numbers)
    for number, instant_ns in setup.schedule.numbered():
        if instant_ns in used:
            setup.loop.draw(instant_ns)
        if number in numbers and number >= 0:
            refresh = setup.loop.show(instant_ns)
            assert refresh is not None
            yield number, refresh


class Comparison:
    """The combinations of one batch beside each other in the loop of one case.

    Only the refreshes that are looked at are shown, and only the frames drawn that those use:
    measured ones, evenly spread over the recording, and the refresh before each, which flicker
    needs. Both eyes are timed; the figures of a picture are those of one eye, left and right by
    turns. Nothing is timed while pictures are measured.
    """

    def __init__(
        self, setup: ReplaySetup, case: Case, combinations: Sequence[Combination], pool: QualityPool, rounds: int
    ) -> None:
        self._setup, self._case, self._pool, self._rounds = setup, case, pool, rounds
        self.measured = [Measured(combination) for combination in combinations]
        self._needs = needs_of(combination.plan for combination in combinations)
        self._compensators = [setup.compensator(combination.plan) for combination in combinations]
        self._targets = TargetPool(setup.gpu, setup.size)
        self._target = self._targets.acquire()
        self._last: list[list[EyeResult]] = [[] for _ in combinations]
        self._turn = 0

    def run(self, instants: int, step: Callable[[], None]) -> None:
        """Look at that many refreshes; step() after each. Free what was allocated here."""
        turns = {number: turn for turn, number in enumerate(instants_of(self._setup.schedule.count, instants))}
        before: list[Compared] = []
        try:
            for number, refresh in refreshes(
                self._setup, self._needs, {number - back for number in turns for back in (0, 1)}
            ):
                if number in turns:
                    self._time(refresh)
                    self._measure(number, refresh, turns[number] % len(EYES), before)
                    step()
                before = self._neighbour(refresh, turns[number + 1] % len(EYES)) if number + 1 in turns else []
        finally:
            self._targets.close()

    def _inputs(self, compensator: Compensator, refresh: Refresh) -> tuple[PassInputs, ...]:
        return self._setup.loop.inputs(refresh, compensator.plan.needs)

    def _truth(self, view: View, time_ns: int) -> Truth:
        drawn = self._setup.server.draw(view, self._setup.size, self._target, time_ns)
        return Truth(picture_from_linear(download(drawn.colour)), download(drawn.inverse_depth))

    def _neighbour(self, refresh: Refresh, eye: int) -> list[Compared]:
        truth = self._truth(refresh.inputs[eye].shown, refresh.shown_ns)
        shown = []
        for compensator in self._compensators:
            result = compensator.run(self._inputs(compensator, refresh)[eye])
            shown.append(Compared(shown_picture(result), truth.picture, result.view))
        self._setup.gpu.timer.collect()
        return shown

    def _time(self, refresh: Refresh) -> None:
        """Every combination in each round; who comes first changes from round to round.

        Before the first of all rounds every combination runs once, to warm up; later the refresh before has done that, and the first one
        alone runs, because a processor that has slept is slow for a while.
        """
        self._pool.wait()
        count = len(self._compensators)
        for place in range(count if self._turn == 0 else 1):
            self._run((place + self._turn) % count, refresh, timed=False)
        for _ in range(self._rounds):
            for place in range(count):
                self._run((place + self._turn) % count, refresh, timed=True)
            self._turn += 1

    def _run(self, index: int, refresh: Refresh, *, timed: bool) -> None:
        compensator, measured = self._compensators[index], self.measured[index]
        self._last[index] = []
        for inputs in self._inputs(compensator, refresh):
            self._last[index].append(compensator.run(inputs))
            stages = self._setup.gpu.timer.collect()
            if timed:
                measured.times.append({"frame": refresh.shown_ns, "eye": inputs.eye, **stage_columns(stages)})
                for name in dict.fromkeys(name for name, _ in stages):
                    measured.stages[name].append(sum(milliseconds for other, milliseconds in stages if other == name))

    def _measure(self, number: int, refresh: Refresh, eye: int, before: list[Compared]) -> None:
        """Hand in the pictures, and compare the eyes' holes, which no fill changes."""
        truths = [self._truth(inputs.shown, inputs.shown_ns) for inputs in refresh.inputs]
        shared = SharedSurface(
            refresh.inputs[0].shown, refresh.inputs[1].shown, truths[0].inverse_depth, truths[1].inverse_depth
        )
        rendered, truth = refresh.frame.eyes[eye], truths[eye]
        coverages: dict[str, list[NDArray]] = {}
        handed_in: dict[str, list[tuple[Key, QualityJob]]] = {}
        for index, (results, measured) in enumerate(zip(self._last, self.measured, strict=True)):
            warp = measured.combination.warp
            if warp not in coverages:
                coverages[warp] = [coverage(result) for result in results]
            measured.mismatch.append(shared.compare(*coverages[warp]))
            job = QualityJob(
                Compared(shown_picture(results[eye]), truth.picture, results[eye].view),
                before[index] if before else None,
                coverages[warp][eye],
                truth.inverse_depth,
                rendered.view,
                rendered.size,
                regions=True,
            )
            same = next((key for key, other in handed_in.get(warp, []) if _same_pictures(job, other)), None)
            key = same or (self._case, warp, measured.combination.fill, number, eye)
            measured.keys.append(key)
            if same is None:
                handed_in.setdefault(warp, []).append((key, job))
                self._pool.submit(key, job)


def _same_pictures(one: QualityJob, other: QualityJob) -> bool:
    """Whether two fills left the same picture, as they do where there is nothing to fill: it need not be measured twice."""
    pairs = [(one.now, other.now)] + ([(one.previous, other.previous)] if one.previous and other.previous else [])
    return all(np.array_equal(a.shown, b.shown) for a, b in pairs)
