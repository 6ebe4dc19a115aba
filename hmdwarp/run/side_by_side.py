"""Combinations of warp and fill side by side: the same loop, late frames and truth for all.

And the oracle, the limit for a warp of a late picture: one that knows the depth that the eye
should see.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from itertools import pairwise
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..client.compensator import Compensator, EyeResult
from ..client.inputs import PassInputs
from ..client.plan import Plan, needs_of
from ..frames import Needs
from ..geometry import WarpMap
from ..gpu import flip_rows
from ..gpu.textures import Canvas, download, upload
from ..metrics import (
    LEAST_STEP,
    RELATIVE_STEP,
    Clips,
    Compared,
    Mismatch,
    QualityJob,
    QualityPool,
    SharedSurface,
    ShownOn,
    block_means,
    error_image,
    pixel_centres,
)
from ..pipeline.loop import Refresh
from ..sources.server import Renderer
from .combinations import ORACLE, Case, Combination, frames_used, instants_of
from .frame_rows import Row, stage_columns
from .replay_setup import ReplayRun
from .truth import Truth, WholePictures, coverage, draw_truth, shown_picture


class Oracle:
    """The truth's own depth in place of a warp's guess.

    Each pixel is taken from the place in the late frame where its true surface lay, if that frame
    saw it: coverage is 1 there. The others, which no late picture holds, are those of the truth. A
    surface that moves by itself counts as unseen where it left its place. plan: what it is compared
    beside, for what frames must carry.
    """

    def __init__(self, server: Renderer, plan: Plan, shown_size: tuple[int, int]) -> None:
        self._server, self.plan, self._size = server, plan, shown_size
        self._warped, self._shown = ([Canvas(server.gpu.gl, shown_size) for _ in range(2)] for _ in range(2))
        self._made: dict[int, tuple[PassInputs, EyeResult]] = {}

    def run(self, inputs: PassInputs) -> EyeResult:
        """Make one eye's picture, once for each refresh; it takes no time of any client."""
        before = self._made.get(inputs.eye)
        if before is not None and before[0].shown is inputs.shown and before[0].shown_ns == inputs.shown_ns:
            return before[1]
        truth = self._server.draw(inputs.shown, self._size, time_ns=inputs.shown_ns)
        try:
            picture, true_depth = download(truth.colour)[..., :3], np.maximum(download(truth.inverse_depth), 0)
        finally:
            self._server.pool(self._size).release(truth.colour)
        rendered = inputs.rendered
        late, late_depth = download(rendered.colour)[..., :3], download(rendered.inverse_depth)
        mapping = WarpMap.between(truth.view, self._size, rendered.view, rendered.size)
        colour, seen = from_late(mapping, true_depth, late, late_depth)
        self._server.gpu.timer.collect()  # of drawing the truth
        warped, shown = self._warped[inputs.eye], self._shown[inputs.eye]
        upload(warped.texture, np.dstack([colour * seen[..., None], seen]))
        upload(shown.texture, np.dstack([np.where(seen[..., None], colour, picture), np.ones(seen.shape)]))
        result = EyeResult(inputs.middle, warped, shown, shown)
        self._made[inputs.eye] = inputs, result
        return result

    def renew(self) -> None:
        """Nothing to do: it remembers nothing."""

    def close(self) -> None:
        """Free the pictures."""
        for canvas in (*self._warped, *self._shown):
            canvas.release()


def from_late(
    mapping: WarpMap, true_depth: NDArray[np.floating], late: NDArray[np.floating], late_depth: NDArray[np.floating]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return the colour (h, w, 3) of each pixel in a late picture, and where that saw its surface.

    mapping: from the shown to the late pixels. true_depth: (h, w), 1/m; late, late_depth: (H, W, 3)
    linear light and (H, W). All rows from the top. A surface was seen where the late frame has its
    inverse depth, within what is no jump of depth. Between pixels that is exact on planes.
    """
    height, width = true_depth.shape
    high, wide = late_depth.shape
    centres = pixel_centres(slice(0, height), width)
    with np.errstate(invalid="ignore"):
        place, expected, w = mapping.apply(centres, flip_rows(true_depth).astype(np.float64))
        place, expected = flip_rows(place), flip_rows(expected)
        x, y = place[..., 0] - 0.5, high - place[..., 1] - 0.5
        inside = (flip_rows(w) > 0) & (x >= 0) & (x <= wide - 1) & (y >= 0) & (y <= high - 1)
    x, y, expected = (np.where(inside, x, 0.0), np.where(inside, y, 0.0), np.where(inside, expected, 0.0))
    column, row = np.minimum(x.astype(int), wide - 2), np.minimum(y.astype(int), high - 2)
    right, below = x - column, y - row
    corners = [(row, column), (row, column + 1), (row + 1, column), (row + 1, column + 1)]
    shares = [(1 - below) * (1 - right), (1 - below) * right, below * (1 - right), below * right]
    both = np.dstack([late, late_depth]).astype(np.float64)
    found = np.sum([share[..., None] * both[corner] for share, corner in zip(shares, corners, strict=True)], axis=0)
    same = np.abs(found[..., 3] - expected) <= RELATIVE_STEP * expected + LEAST_STEP
    return found[..., :3], inside & same


# Seconds before each instant at which fills that remember are shown a refresh too. Instants are a
# few seconds apart, so these fills get to know the recording about as a replay of all of it would
# teach them.
RUN_IN_S = (4.0, 3.0, 2.0, 1.0, 0.5)


def refreshes(setup: ReplayRun, needs: Needs, numbers: Collection[int]) -> Iterator[tuple[int, Refresh]]:
    """Iterate over the chosen refreshes of a run, counted from 0, in time order.

    Negative numbers are passed over.

    The results are those of the whole run, but only the frames they use are drawn.
    """
    rate_hz = setup.options.network.server_rate_hz
    used = frames_used(setup.schedule, setup.channel.latency_ns, needs, numbers, rate_hz)
    for number, instant_ns in setup.schedule.numbered():
        for drawn_ns in used[number]:
            setup.loop.draw_at(drawn_ns)
        if number in numbers and number >= 0:
            refresh = setup.loop.show(instant_ns)
            assert refresh is not None
            yield number, refresh


def all_frames(setup: ReplayRun, numbers: Collection[int]) -> Iterator[tuple[int, Refresh]]:
    """Iterate as refreshes does, and draw every frame: for those that depend on each other."""
    last = max(numbers)
    for number, instant_ns in setup.schedule.numbered():
        if number > last:
            return
        setup.loop.draw(instant_ns)
        if number >= 0 and number in numbers:
            refresh = setup.loop.show(instant_ns)
            assert refresh is not None
            yield number, refresh
        elif number >= 0:
            setup.channel.newest(instant_ns)  # takes what has arrived, as a client that shows it


class SideBySide:
    """The compensators of some combinations in the loop of one case, and what all of them share.

    A context: leaving it frees what was allocated here.
    """

    def __init__(self, setup: ReplayRun, combinations: Sequence[Combination]) -> None:
        self._setup, self._combinations = setup, combinations
        self._needs = needs_of(combination.plan for combination in combinations)
        # In the order of the combinations.
        self.compensators: list[Compensator | Oracle] = [
            Oracle(setup.server, one.plan, setup.sizes.shown) if one.warp == ORACLE else setup.compensator(one.plan)
            for one in combinations
        ]
        self._whole = WholePictures(setup.server)

    def __enter__(self) -> SideBySide:
        return self

    def __exit__(self, *error: object) -> None:
        self._whole.close()
        for compensator in self.compensators:
            if not isinstance(compensator, Compensator):
                compensator.close()

    def refreshes(self, numbers: Collection[int]) -> Iterator[tuple[int, Refresh]]:
        """Iterate over the chosen refreshes; every frame is drawn where one of them needs that."""
        if any(combination.needs_every_frame for combination in self._combinations):
            return all_frames(self._setup, numbers)
        return refreshes(self._setup, self._needs, numbers)

    def run_in(self, numbers: Collection[int]) -> set[int]:
        """Return the refreshes to show to fills that remember before those, none without such."""
        if not any(combination.remembers for combination in self._combinations):
            return set()
        rate_hz = self._setup.schedule.rate_hz
        return {number - round(seconds * rate_hz) for number in numbers for seconds in RUN_IN_S}

    def teach(self, refresh: Refresh) -> None:
        """Show a refresh to fills that remember."""
        for compensator, combination in zip(self.compensators, self._combinations, strict=True):
            if combination.remembers and isinstance(compensator, Compensator):
                for inputs in self.inputs(compensator, refresh):
                    compensator.learn(inputs)
        self._setup.target.gpu.timer.collect()

    def inputs(self, compensator: Compensator | Oracle, refresh: Refresh) -> tuple[PassInputs, ...]:
        """Return what a compensator reads of a refresh, eye by eye."""
        return self._whole.inputs(self._setup.loop, refresh, compensator.plan)

    def truth(self, inputs: PassInputs) -> Truth:
        """Return what an eye should see in the middle of a refresh."""
        return draw_truth(self._setup.server, attrs.evolve(inputs, shown_last=None), self._setup.sizes.shown)

    def pictures(self, refresh: Refresh, eye: int, truth: Truth) -> list[Compared]:
        """Run all for one eye, untimed; return each picture with the truth."""
        shown = []
        for compensator in self.compensators:
            result = compensator.run(self.inputs(compensator, refresh)[eye])
            shown.append(Compared(shown_picture(result), truth.picture, result.view))
        self._setup.target.gpu.timer.collect()
        return shown


def clips_of(setup: ReplayRun) -> Clips:
    """Return what rates clips of the run's length. Errors: as Clips."""
    headset = setup.source.headset
    given = {"peak_cd_m2": headset.peak_cd_m2, "black_cd_m2": headset.black_cd_m2}
    known = {name: value for name, value in given.items() if value is not None}
    return Clips(setup.options.jod_s, ShownOn(setup.schedule.rate_hz, setup.pixels_per_degree, **known))


def clips_before(instants: Sequence[int], length: int) -> dict[int, int]:
    """Return the instant at which the clip of each refresh ends.

    A clip is the `length` refreshes up to its instant; fewer, where the run begins or the instant
    before lies within.
    """
    starts = [max(before + 1, instant - length + 1, 0) for before, instant in pairwise((-1, *instants))]
    return {
        number: instant for start, instant in zip(starts, instants, strict=True) for number in range(start, instant + 1)
    }


def rate_clips(
    setup: ReplayRun, combinations: Sequence[Combination], instants: int, step: Callable[[], None]
) -> list[dict[str, Any]]:
    """Return the `jod` of each combination, from a clip that ends at each of so many instants.

    Where rating failed, `jod_failure` is why instead.

    The instants and their eyes, left and right in turn, are those that a bench measures; step() is
    called after each.
    Errors: as Clips.
    """
    clips = clips_of(setup)
    turns = {number: turn for turn, number in enumerate(instants_of(setup.schedule.count, instants))}
    ends = clips_before(list(turns), clips.length)
    with SideBySide(setup, combinations) as beside:
        for number, refresh in beside.refreshes({*ends, *beside.run_in(turns)}):
            if number not in ends:
                beside.teach(refresh)
                continue
            eye = turns[ends[number]] % len(refresh.inputs)
            truth = beside.truth(refresh.inputs[eye])
            for which, pictures in enumerate(beside.pictures(refresh, eye, truth)):
                clips.add(number, eye, which, pictures)
            if number in turns:
                clips.finish()
                step()
    if clips.failure:
        return [{"jod_failure": clips.failure} for _ in combinations]
    return [{"jod": clips.entry(which)} for which in range(len(combinations))]


# (case, warp, fill, refresh, eye): identifies a picture.
Key = tuple[Case, str, str, int, int]


@attrs.frozen(eq=False)
class Measured:
    """Figures of one combination in one case; those of its pictures are still in the pool."""

    combination: Combination
    # One row for each timed run of one eye, keyed as frames.csv.
    times: list[Row] = attrs.field(factory=list)
    keys: list[Key] = attrs.field(factory=list)
    mismatch: list[Mismatch] = attrs.field(factory=list)
    # Of each measured picture, by its refresh: see metrics.block_means.
    blocks: dict[int, NDArray[np.float64]] = attrs.field(factory=dict)
    # Of each, where the late frame saw what the eye should see: pixels of the picture, those seen,
    # and the mean squared error of those, 0..1. Empty without the oracle beside it.
    where_seen: list[tuple[int, int, float]] = attrs.field(factory=list)


class Comparison:
    """Compare the combinations of one batch side by side in the loop of one case.

    Only the measured refreshes are shown, spread evenly over the recording, plus the refresh before
    each, which flicker needs; only frames that those use are drawn, and every one for a combination
    that needs it. Fills that remember see some more refreshes before each. Both eyes are timed;
    pictures are measured for the left and right eye in turn. Nothing is timed while pictures are
    measured.
    """

    def __init__(
        self, setup: ReplayRun, case: Case, combinations: Sequence[Combination], pool: QualityPool, rounds: int
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
                before = []
                if number + 1 in turns:
                    eye = turns[number + 1] % len(refresh.inputs)
                    before = beside.pictures(refresh, eye, beside.truth(refresh.inputs[eye]))

    def _time(self, refresh: Refresh) -> None:
        """Time every combination in each round, in an order that rotates from round to round."""
        self._pool.wait()
        count = len(self._beside.compensators)
        # All warm up once; later the first alone, because an idle processor is slow for a while.
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
            stages = self._setup.target.gpu.timer.collect()
            if timed:
                measured.times.append({"frame": refresh.shown_ns, "eye": inputs.eye, **stage_columns(stages)})

    def _measure(self, number: int, refresh: Refresh, eye: int, before: list[Compared]) -> None:
        """Submit the pictures, and compare the holes of both eyes, which no fill changes."""
        truths = [self._beside.truth(inputs) for inputs in refresh.inputs]
        shared = None  # with one eye nothing is seen by both
        if len(truths) == 2:
            left, right = (inputs.shown for inputs in refresh.inputs)
            near, other = (truth.inverse_depth for truth in truths)
            assert near is not None and other is not None
            shared = SharedSurface(left, right, near, other)
        rendered, truth = refresh.frame.eyes[eye], truths[eye]
        coverages: dict[str, list[NDArray[np.floating]]] = {}
        handed_in: dict[str, list[tuple[Key, QualityJob]]] = {}
        warps = [each.combination.warp for each in self.measured]
        seen = coverage(self._last[warps.index(ORACLE)][eye]) > 0 if ORACLE in warps else None
        for index, (results, measured) in enumerate(zip(self._last, self.measured, strict=True)):
            warp = measured.combination.group
            if warp not in coverages:
                coverages[warp] = [coverage(result) for result in results]
            if shared is not None:
                measured.mismatch.append(shared.compare(*coverages[warp]))
            shown = shown_picture(results[eye])
            if seen is not None:
                error = error_image(shown[seen], truth.picture[seen])
                measured.where_seen.append((seen.size, int(seen.sum()), float((error**2).sum() / 3)))
            job = QualityJob(
                Compared(shown, truth.picture, results[eye].view),
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
                self._setup.hand_in(self._pool, key, job)


def _same_pictures(one: QualityJob, other: QualityJob) -> bool:
    """Return whether two fills gave identical pictures, so that one measurement serves both."""
    pairs = [(one.now, other.now)] + ([(one.previous, other.previous)] if one.previous and other.previous else [])
    return all(np.array_equal(a.shown, b.shown) for a, b in pairs)
