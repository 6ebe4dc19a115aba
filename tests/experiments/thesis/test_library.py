"""Every figure, time and claim of the thesis has an experiment, and every experiment can be run."""

from __future__ import annotations

import re

import pytest

from hmdwarp.base import UnknownNameError
from hmdwarp.client import parse_fills, parse_warp
from hmdwarp.experiments.thesis.experiment import (
    SPEEDS_DEG_S,
    SPEEDS_M_S,
    PictureRun,
    experiments,
    experiments_named,
    is_quick,
)
from hmdwarp.poses import GLIDES
from hmdwarp.scenes import scenes

EXPERIMENTS = experiments()
# Figures of its experiments; those not listed are drawings.
FIGURES = {10, 27, *range(28, 34), *range(35, 46), *range(47, 51), *range(52, 56)}
PASSES = ["copy", "client depth", "interpolation", "composite", "reflections"]  # each beside the warp
CLAIMS = (
    """
cracks are one pixel wide; holes grow with the latency; larger kernel; leaves no cracks; 1.41 times
the pixels (1600x900) suffices at 200 ms; 2.03 times the pixels (1920x1080) suffices at 400 ms;
fills every hole; reduces the discontinuities; flickers; stay black; reflections cost less than a
warp; linear in the pixels; depth adds little to the bandwidth; environment map costs several times;
14 Mbit/s; all methods fall with latency; a larger picture costs bandwidth; a larger picture costs
latency; silhouettes of a reduced model are coarse; copies texture into the holes, in streaks; costs
more where there are more holes; in screen space miss; edges of the warped picture are doubled;
draws more often than the client shows; k pictures with depth cost k times; loads the network as a
video stream; a third of the work of a photon mapper; clients of a class can run; a mesh over the
late picture has no cracks; 50 to 150 ms late are good enough
""".replace("\n", " ")
    .strip()
    .split("; ")
)
PICTURE_RUNS = sorted({run for each in EXPERIMENTS for run in each.runs() if isinstance(run, PictureRun)}, key=repr)


def figures_in(source: str) -> set[int]:
    """The numbers in "Figures 50 and 52 to 54"."""
    if not source.startswith("Figure"):
        return set()
    text = re.sub(r"(\d+) to (\d+)", lambda m: " ".join(map(str, range(int(m[1]), int(m[2]) + 1))), source)
    return {int(number) for number in re.findall(r"\b\d+\b", text.split(",")[0])}


def test_every_figure_claim_time_and_rating_has_an_experiment_and_every_figure_our_pictures():
    for found in (EXPERIMENTS, [each for each in EXPERIMENTS if each.pictures]):
        assert set().union(*(figures_in(each.source) for each in found)) == FIGURES
    texts = [f"{each.claim} {each.thesis}".lower() for each in EXPERIMENTS]
    assert [claim for claim in CLAIMS if not any(claim.lower() in text for text in texts)] == []
    (times,) = experiments_named(["times"])
    assert [cell.row for cell in times.cells] == PASSES
    rated = [cell.column for each in experiments_named(["ratings-run1", "ratings-run2"]) for cell in each.cells]
    assert rated == ["200 ms", "400 ms", "800 ms"] * 2


def test_what_shows_no_effect_at_all_holds_no_claim_of_one():
    """A share or a mean that stays, a gain of nothing; what may lose a little says so below 0."""
    for each in EXPERIMENTS:
        numbers = {cell.computed.split()[0] for cell in each.cells}
        if each.rule.low >= 0:
            assert not each.rule.holds(
                1 if numbers & {"ratio", "least_growth"} and "from" not in each.rule.words("", 1) else 0
            )


def test_names_are_unique_and_in_the_order_of_the_page_and_a_beginning_stands_for_all():
    names = [each.name for each in EXPERIMENTS]
    assert len(set(names)) == len(names)
    assert [each.name for each in experiments_named(names[::-1])] == names
    assert experiments_named([]) == EXPERIMENTS
    begun = [each.name for each in experiments_named(("ratings", "fig28"))]
    assert begun == [name for name in names if name.startswith(("ratings", "fig28"))] and "fig28-30" in begun
    with pytest.raises(UnknownNameError, match="unknown experiment of the thesis 'figg27': did you mean 'fig27'"):
        experiments_named(["figg27"])
    for each in EXPERIMENTS:
        places = [(cell.row, cell.column) for cell in each.cells]
        assert places and len(set(places)) == len(places), f"{each.name}: a setting stands twice in its table"


def test_a_motion_is_swept_over_all_speeds():
    """The thesis gives none. Timed runs and streams have no use for it."""
    for each in EXPERIMENTS:
        runs = [run for cell in each.cells for run in cell.runs if isinstance(run, PictureRun) and not run.timed]
        for kind in {run.motion.kind for run in runs}:
            expected = SPEEDS_DEG_S if kind == "rotate" else SPEEDS_M_S
            assert {run.motion.speed for run in runs if run.motion.kind == kind} == set(expected), each.name


def test_quick_keeps_the_middle_speed():
    speeds = {run.motion.speed for run in PICTURE_RUNS if is_quick(run)}
    assert speeds == {SPEEDS_M_S[1], SPEEDS_DEG_S[1]}
    assert all(is_quick(run) for each in EXPERIMENTS for run in each.runs() if not isinstance(run, PictureRun))


def test_runs_name_what_there_is():
    for run in PICTURE_RUNS:
        parse_warp(run.warp)
        parse_fills(run.fill)
        assert run.scene in scenes.names()
        GLIDES[run.motion.kind].with_(run.motion.speed, run.motion.amplitude)
