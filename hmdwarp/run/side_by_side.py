"""Combinations of warp and fill side by side: the same loop, late frames and truth for all."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from itertools import pairwise
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..client.compensator import Compensator
from ..client.inputs import PassInputs
from ..client.plan import needs_of
from ..colour import picture_from_linear
from ..frames import Needs
from ..geometry import View
from ..gpu.textures import download
from ..metrics import Clips, Compared, ShownOn
from ..pipeline.loop import Refresh
from ..sources.server.targets import TargetPool
from .combinations import Combination, OpenCvWarp, frames_used, instants_of
from .replay_setup import ReplaySetup
from .truth import WholePictures, shown_picture

# Seconds before each instant at which fills that remember are shown a refresh too. Instants are a
# few seconds apart, so these fills get to know the recording about as a replay of all of it would
# teach them.
RUN_IN_S = (4.0, 3.0, 2.0, 1.0, 0.5)


@attrs.frozen(eq=False)
class Truth:
    """What one eye should see at a refresh.

    The sRGB picture (h, w, 3) and inverse depth (h, w), top row first.
    """

    picture: NDArray[np.uint8]
    inverse_depth: NDArray[np.float32]


def refreshes(setup: ReplaySetup, needs: Needs, numbers: Collection[int]) -> Iterator[tuple[int, Refresh]]:
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


def all_frames(setup: ReplaySetup, numbers: Collection[int]) -> Iterator[tuple[int, Refresh]]:
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

    def __init__(self, setup: ReplaySetup, combinations: Sequence[Combination]) -> None:
        self._setup, self._combinations = setup, combinations
        self._needs = needs_of(combination.plan for combination in combinations)
        # In the order of the combinations.
        self.compensators = [self._compensator_of(combination) for combination in combinations]
        self._whole = WholePictures(setup.server)
        self._targets = TargetPool(setup.gpu, setup.size)
        self._target = self._targets.acquire()

    def __enter__(self) -> SideBySide:
        return self

    def __exit__(self, *error: object) -> None:
        self._whole.close()
        self._targets.close()
        for compensator in self.compensators:
            if isinstance(compensator, OpenCvWarp):
                compensator.close()

    def _compensator_of(self, combination: Combination) -> Compensator | OpenCvWarp:
        if combination.is_outside:
            return OpenCvWarp(self._setup.gpu, combination.plan, self._setup.size)
        return self._setup.compensator(combination.plan)

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
            if combination.remembers:
                for inputs in self.inputs(compensator, refresh):
                    compensator.run(inputs)
        self._setup.gpu.timer.collect()

    def inputs(self, compensator: Compensator | OpenCvWarp, refresh: Refresh) -> tuple[PassInputs, ...]:
        """Return what a compensator reads of a refresh, eye by eye."""
        return self._whole.inputs(self._setup.loop, refresh, compensator.plan)

    def truth(self, view: View, time_ns: int) -> Truth:
        """Draw what a view should show."""
        drawn = self._setup.server.draw(view, self._setup.size, self._target, time_ns)
        return Truth(picture_from_linear(download(drawn.colour)), np.maximum(download(drawn.inverse_depth), 0))

    def pictures(self, refresh: Refresh, eye: int, truth: Truth) -> list[Compared]:
        """Run all for one eye, untimed; return each picture with the truth."""
        shown = []
        for compensator in self.compensators:
            result = compensator.run(self.inputs(compensator, refresh)[eye])
            shown.append(Compared(shown_picture(result), truth.picture, result.view))
        self._setup.gpu.timer.collect()
        return shown


def clips_of(setup: ReplaySetup) -> Clips:
    """Return what rates clips of the run's length. Errors: as Clips."""
    headset = setup.headset
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
    setup: ReplaySetup, combinations: Sequence[Combination], instants: int, step: Callable[[], None]
) -> list[dict[str, Any]]:
    """Return the `jod` of each combination, from a clip that ends at each of so many instants.

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
            truth = beside.truth(refresh.inputs[eye].shown, refresh.shown_ns)
            for which, pictures in enumerate(beside.pictures(refresh, eye, truth)):
                clips.add(number, eye, which, pictures)
            if number in turns:
                clips.finish()
                step()
    return [clips.entry(which) for which in range(len(combinations))]
