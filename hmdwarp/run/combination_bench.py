"""One case of a benchmark: a batch of combinations on the same late frames.

They are timed in turns and measured against the same truth.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from ..client.compensator import EyeResult
from ..metrics import Compared, Mismatch, QualityJob, QualityPool, SharedSurface, block_means
from ..pipeline.loop import Refresh
from .combinations import Case, Combination, instants_of
from .frame_rows import Row, stage_columns
from .replay_setup import ReplaySetup
from .side_by_side import SideBySide
from .truth import coverage, shown_picture

# (case, warp, fill, refresh, eye): identifies a picture.
Key = tuple[Case, str, str, int, int]


@attrs.frozen(eq=False)
class Measured:
    """Figures of one combination in one case; those of its pictures are still in the pool."""

    combination: Combination
    # One row for each timed run of one eye, keyed as frames.csv.
    times: list[Row] = attrs.field(factory=list)
    # The same, by the timer's own stage names.
    stages: dict[str, list[float]] = attrs.field(factory=lambda: defaultdict(list))
    keys: list[Key] = attrs.field(factory=list)
    mismatch: list[Mismatch] = attrs.field(factory=list)
    # Of each measured picture, by its refresh: see metrics.block_means.
    blocks: dict[int, NDArray[np.float64]] = attrs.field(factory=dict)


class Comparison:
    """Compare the combinations of one batch side by side in the loop of one case.

    Only the measured refreshes are shown, spread evenly over the recording, plus the refresh before
    each, which flicker needs; only frames that those use are drawn, and every one for a combination
    that needs it. Fills that remember see some more refreshes before each. Both eyes are timed;
    pictures are measured for the left and right eye in turn. Nothing is timed while pictures are
    measured.
    """

    def __init__(
        self, setup: ReplaySetup, case: Case, combinations: Sequence[Combination], pool: QualityPool, rounds: int
    ) -> None:
        self._setup, self._case, self._pool, self._rounds = setup, case, pool, rounds
        self.measured = [Measured(combination) for combination in combinations]
        self._beside = SideBySide(setup, combinations)
        self._last: list[list[EyeResult]] = [[] for _ in combinations]
        self._turn = 0

    def run(self, instants: int, step: Callable[[], None]) -> None:
        """Visit that many refreshes, calling step() after each. Free what was allocated here."""
        turns = {number: turn for turn, number in enumerate(instants_of(self._setup.schedule.count, instants))}
        before: list[Compared] = []
        neighbours = {number - 1 for number in turns}
        with self._beside as beside:
            for number, refresh in beside.refreshes({*turns, *neighbours, *beside.run_in(turns)}):
                if number not in turns and number not in neighbours:
                    beside.teach(refresh)
                if number in turns:
                    self._time(refresh)
                    self._measure(number, refresh, turns[number] % len(refresh.inputs), before)
                    step()
                before = (
                    self._neighbour(refresh, turns[number + 1] % len(refresh.inputs)) if number + 1 in turns else []
                )

    def _neighbour(self, refresh: Refresh, eye: int) -> list[Compared]:
        truth = self._beside.truth(refresh.inputs[eye].shown, refresh.shown_ns)
        return self._beside.pictures(refresh, eye, truth)

    def _time(self, refresh: Refresh) -> None:
        """Time every combination in each round, in an order that rotates from round to round.

        Before the very first round, every combination runs once to warm up. In later rounds the
        refresh before has done that, and only the first combination is run again, because an idle
        processor is slow for a while.
        """
        self._pool.wait()
        count = len(self._beside.compensators)
        for place in range(count if self._turn == 0 else 1):
            self._run((place + self._turn) % count, refresh, timed=False)
        for _ in range(self._rounds):
            for place in range(count):
                self._run((place + self._turn) % count, refresh, timed=True)
            self._turn += 1

    def _run(self, index: int, refresh: Refresh, *, timed: bool) -> None:
        compensator, measured = self._beside.compensators[index], self.measured[index]
        self._last[index] = []
        compensator.renew()
        for inputs in self._beside.inputs(compensator, refresh):
            self._last[index].append(compensator.run(inputs))
            stages = self._setup.gpu.timer.collect()
            if timed:
                measured.times.append({"frame": refresh.shown_ns, "eye": inputs.eye, **stage_columns(stages)})
                for name in dict.fromkeys(name for name, _ in stages):
                    measured.stages[name].append(sum(milliseconds for other, milliseconds in stages if other == name))

    def _measure(self, number: int, refresh: Refresh, eye: int, before: list[Compared]) -> None:
        """Submit the pictures, and compare the holes of both eyes, which no fill changes."""
        truths = [self._beside.truth(inputs.shown, inputs.shown_ns) for inputs in refresh.inputs]
        shared = None  # with one eye nothing is seen by both
        if len(truths) == 2:
            left, right = (inputs.shown for inputs in refresh.inputs)
            shared = SharedSurface(left, right, truths[0].inverse_depth, truths[1].inverse_depth)
        rendered, truth = refresh.frame.eyes[eye], truths[eye]
        coverages: dict[str, list[NDArray[np.floating]]] = {}
        handed_in: dict[str, list[tuple[Key, QualityJob]]] = {}
        for index, (results, measured) in enumerate(zip(self._last, self.measured, strict=True)):
            warp = measured.combination.group
            if warp not in coverages:
                coverages[warp] = [coverage(result) for result in results]
            if shared is not None:
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
            measured.blocks[number] = block_means(job.now.shown)
            same = next((key for key, other in handed_in.get(warp, []) if _same_pictures(job, other)), None)
            key = same or (self._case, warp, measured.combination.fill, number, eye)
            measured.keys.append(key)
            if same is None:
                handed_in.setdefault(warp, []).append((key, job))
                self._pool.submit(key, job)


def _same_pictures(one: QualityJob, other: QualityJob) -> bool:
    """Return whether two fills gave identical pictures, as they do where there are no holes.

    Then one measurement serves both.
    """
    pairs = [(one.now, other.now)] + ([(one.previous, other.previous)] if one.previous and other.previous else [])
    return all(np.array_equal(a.shown, b.shown) for a, b in pairs)
