"""Rating of a run's pictures by ColorVideoVDP, on the headset's own display."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

from ..metrics import Clips, ShownOn
from .combinations import Combination, instants_of
from .replay_setup import ReplaySetup
from .side_by_side import SideBySide


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
