"""Combinations of warp and fill side by side: the same loop, late frames and truth for all."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

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
from ..metrics import Compared
from ..pipeline.loop import Refresh
from ..sources.server.targets import TargetPool
from .combinations import Combination, frames_used
from .outside import OpenCvWarp
from .read_back import shown_picture
from .replay_setup import ReplaySetup
from .whole_pictures import WholePictures

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
