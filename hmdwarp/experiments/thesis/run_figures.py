"""Measures the runs of experiments: pictures, several on the same late frames; streams; facts."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from statistics import fmean, median
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import picture_from_linear
from ...client import needs_of
from ...client.capability import lacking
from ...client.classes import load_client
from ...client.strategies import strategies
from ...geometry import View, WarpMap
from ...gpu import download, flip_rows
from ...headsets import load_headset
from ...link import SUM, Bandwidth, LinkOptions
from ...link.codec import Coding
from ...metrics import LEAST_STEP, RELATIVE_STEP, Compared, hole_share, psnr
from ...pipeline import Refresh
from ...pipeline.sizes import build_plan_for, refreshes_of
from ...poses import GLIDES, synthesise, write_synthetic
from ...run import ReplayRun, RunOptions, measured, set_up_replay
from ...run.measuring import Combination, Truth, coverage, draw_truth, refreshes, shown_picture
from ...scenes import load_scene
from .experiment import LATENCIES_MS, RATE_HZ, TRACE_S, Figures, PictureRun, StreamRun

Map = NDArray[Any]


def holes_of(
    coverage: Map, truth_inverse_depth: Map, shown: View, rendered: View, rendered_inverse_depth: Map
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which holes lie beyond the rendered field of view, and which are cracks.

    All (h, w), top row first; coverage and truth_inverse_depth of the shown view. Of cracks the
    late frame had the surface; in front of that of the other holes it had another.
    """
    hole = flip_rows(np.asarray(coverage) == 0)
    inverse = np.nan_to_num(flip_rows(np.asarray(truth_inverse_depth, dtype=np.float64))[hole], nan=0.0)
    frame = flip_rows(np.asarray(rendered_inverse_depth, dtype=np.float64))
    height, width = frame.shape
    mapping = WarpMap.between(shown, (hole.shape[1], hole.shape[0]), rendered, (width, height))
    at, expected, w = mapping.apply(np.stack(hole.nonzero()[::-1], axis=1) + 0.5, inverse)
    with np.errstate(invalid="ignore"):
        inside = (w > 0) & ((at >= 0) & (at < (width, height))).all(axis=1)
    column, row = np.where(inside[:, None], at, 0).astype(np.intp).T
    border, cracks = np.zeros((2, *hole.shape), bool)
    border[hole] = ~inside
    cracks[hole] = inside & (np.abs(frame[row, column] - expected) <= RELATIVE_STEP * expected + LEAST_STEP)
    return flip_rows(border), flip_rows(cracks)


def seam(shown: Map, truth: Map, filled: NDArray[np.bool_], warped: NDArray[np.bool_]) -> float | None:
    """Return the mean false step, 0..1, between filled pixels and the warped ones next to them.

    Of the picture less that of the truth, (h, w, 3) sRGB bytes; None without such neighbours.
    """
    error = shown.astype(np.float32) - truth.astype(np.float32)
    total, count = 0.0, 0
    for axis in (0, 1):
        steps = np.abs(np.diff(error, axis=axis)).mean(axis=2)
        first, second = ((slice(None),) * axis + (part,) for part in (slice(None, -1), slice(1, None)))
        beside = (filled[first] & warped[second]) | (warped[first] & filled[second])
        total += float(steps[beside].sum())
        count += int(beside.sum())
    return total / count / 255 if count else None


# Mean of the three bytes by which neighbours differ at an edge.
_EDGE = 24


def false_edges(shown: Map, truth: Map) -> float | None:
    """Return the part of the picture's edges that the truth has not within a pixel; None for none.

    shown, truth: (h, w, 3) sRGB bytes.
    """
    false = count = 0
    for axis in (0, 1):
        found, true = (
            np.abs(np.diff(one.astype(np.float32), axis=axis)).mean(axis=2) >= _EDGE for one in (shown, truth)
        )
        wide = np.pad(true, 1)
        (height, width), ends = true.shape, range(3)
        near = np.any([wide[y : y + height, x : x + width] for y in ends for x in ends], axis=0)
        false, count = false + int((found & ~near).sum()), count + int(found.sum())
    return false / count if count else None


HEADSET = "flat-90"
# The thesis mentions no antialiasing.
_COMMON: dict[str, Any] = {"headset": HEADSET, "rate_hz": RATE_HZ, "samples": 1}
_COMMON |= {"fill": "none", "lens": "none", "against": ""}
# By the wall clock a shorter pass is mostly the driver's overhead.
_LEAST_WALL_MS = 1.0
# Of a side of the least picture: what its passes take is the GPU's overhead.
SPECK_PX = 8
Picture = NDArray[np.uint8]


def _of_class(number: int) -> float:
    """Return the share of the strategies meant for a class that take nothing which it lacks."""
    client, headset, fits = load_client(f"class-{number}"), load_headset(HEADSET), list[bool]()
    for name in strategies.names():
        if number in strategies.get(name).classes:
            plan = build_plan_for(RunOptions.of({"strategy": name, "lens": "none"}, trace="walk"), headset, None)
            fits.append(not lacking(plan, client))
    return fmean(fits)


FACTS: Mapping[str, Callable[[], float]] = {
    "triangles": lambda: float(load_scene("room").triangle_count),
    "place_of_500_ms": lambda: float(refreshes_of(500.0, RATE_HZ)),
    **{f"class_{number}": functools.partial(_of_class, number) for number in (1, 2, 3)},
}


@attrs.frozen
class Thoroughness:
    """How much is measured of each run."""

    # Pixels of one eye where a run's scale is 1.
    size: tuple[int, int]
    instants: int
    # Timed runs of each pass at each instant.
    rounds: int
    # Of each side of a stream's pictures, and how long a stream lasts.
    stream_scale: float = 1.0
    stream_s: float = 1.0


@attrs.frozen(eq=False)
class Looked:
    """What a run gave."""

    run: PictureRun
    figures: Figures
    # The shown picture and the truth at the first instant: (h, w, 3) sRGB, top row first.
    picture: Picture
    truth: Picture


def beyond(figures: Figures, least: Figures) -> Figures:
    """Return figures whose times are what they take beyond those of the least picture."""
    rest = {name: value - before for name, value in figures.items() if value and (before := least.get(name))}
    return figures | {name: value if value > 0 else None for name, value in rest.items() if name.endswith("_ms")}


def look(runs: Sequence[PictureRun], how: Thoroughness, folder: Path) -> Iterator[Looked]:
    """Measure runs that share their frames. folder: for the trace of the head."""
    first = runs[0]
    assert {run.shared for run in runs} == {first.shared}
    moved = first.motion
    track = synthesise(moved.kind, seconds=TRACE_S, speed=moved.speed, amplitude=moved.amplitude)
    path = folder / f"{moved}.csv".replace(" ", "-").replace("/", "-")
    with path.open("w", encoding="utf-8") as stream:
        write_synthetic(track, stream)
    width, height = (max(8, round(side * first.scale)) for side in how.size)
    same = {name: getattr(first, name) for name in ("scene", "latency_ms", "effects", "mirrors", "guard")}
    # The loop's own warp; those of the runs see the same frames.
    options = RunOptions(**_COMMON, **same, trace=str(path), warp="none", size=(width, height))
    headset, scene = load_headset(HEADSET), load_scene(first.scene)
    combinations = [
        Combination(run.warp, run.fill, build_plan_for(options.with_pair(run.warp, run.fill), headset, scene))
        for run in runs
    ]
    needs = needs_of(combination.plan for combination in combinations)
    with set_up_replay(options, needs) as setup:
        eased_s, turn_s = GLIDES[moved.kind].with_(moved.speed, moved.amplitude).steady_s
        first_s = (setup.schedule.first_ns - setup.track.start_ns) * 1e-9
        from_s, to_s = eased_s + max(LATENCIES_MS) * 1e-3, turn_s
        times_s = [from_s + (k + 0.5) / how.instants * (to_s - from_s) for k in range(how.instants)]
        numbers = sorted({round((time_s - first_s) * RATE_HZ) for time_s in times_s})
        watchers = [_Watcher(setup, run, each, how) for run, each in zip(runs, combinations, strict=True)]
        wanted = {number - back for number in numbers for back in (0, 1)}
        for number, refresh in refreshes(setup, needs, wanted):
            turn, is_measured = numbers.index(number if number in numbers else number + 1), number in numbers
            eye = turn % 2
            truth, frame = (
                draw_truth(setup.server, refresh.inputs[eye], setup.sizes.shown, depth=is_measured),
                refresh.frame.eyes[eye],
            )
            late = picture_from_linear(download(frame.colour)), download(frame.inverse_depth)
            for watcher in watchers:
                watcher.see(refresh, eye, truth, late)
        yield from (watcher.result() for watcher in watchers)


class _Watcher:
    """One warp and fill: its compensator, and the figures of its pictures."""

    def __init__(self, setup: ReplayRun, run: PictureRun, combination: Combination, how: Thoroughness) -> None:
        self._setup, self._run, self._plan = setup, run, combination.plan
        self._rounds = how.rounds if run.timed else 0
        self._compensator = setup.compensator(combination.plan)
        self._figures: list[Figures] = []
        self._times: list[dict[str, float]] = []
        self._before: Compared | None = None
        self._first: tuple[Picture, Picture] | None = None

    def see(self, refresh: Refresh, eye: int, truth: Truth, late: tuple[Picture, Map]) -> None:
        """Run the passes for the eye; measure the picture, or keep it to compare with the next.

        truth: without depth for a predecessor. late: the late frame's picture and inverse depth.
        """
        inputs = self._setup.loop.inputs(refresh, self._plan.needs)[eye]
        if truth.inverse_depth is None and not self._run.flickers:
            return
        result = self._compensator.run(inputs)
        self._setup.target.gpu.timer.collect()
        now = Compared(shown_picture(result), truth.picture, result.view)
        if truth.inverse_depth is None:
            self._before = now
            return
        covered = coverage(result)
        empty = (download(result.filled[-1][1].texture)[..., 3] if result.filled else covered) == 0
        border, cracks = holes_of(covered, truth.inverse_depth, result.view, refresh.frame.eyes[eye].view, late[1])
        there = covered != 0
        found: Figures = {
            "psnr_db": psnr(now.shown, now.truth),
            "hole_share": hole_share(covered),
            "border_share": float(border.mean()),
            "inner_share": float((~there & ~border).mean()),
            "crack_share": float(cracks.mean()),
            "empty_share": float(empty.mean()),
            "cracks_left_share": float((cracks & empty).mean()),
            "inner_left_share": float((~border & empty).mean()),
            "false_edges": false_edges(now.shown, now.truth),
            "seam": seam(now.shown, now.truth, ~there & ~empty, there),
            "flicker": None,
        }
        if self._before is not None:
            found["flicker"] = self._setup.pairs.flicker(now, self._before)
        if late[0].shape == now.shown.shape and there.any():
            true = now.truth[there][None]
            found["gain_db"] = psnr(now.shown[there][None], true) - psnr(late[0][there][None], true)
        self._figures.append(found)
        self._before = None
        self._first = self._first or (now.shown, now.truth)
        for _ in range(self._rounds):
            self._compensator.run(inputs)
            stages = self._setup.target.gpu.timer.collect()
            names = dict.fromkeys(name for name, _ in stages)
            self._times.append({name: sum(ms for other, ms in stages if other == name) for name in names})

    def result(self) -> Looked:
        """Return means over the instants, and medians of the times for one eye."""
        names = dict.fromkeys(itertools.chain.from_iterable(self._figures))
        figures: Figures = {}
        for name in names:
            known = [value for each in self._figures if (value := each.get(name)) is not None]
            figures[name] = fmean(known) if known else None
        for stage in dict.fromkeys(itertools.chain.from_iterable(self._times)):
            found = median(times.get(stage, 0.0) for times in self._times)
            can_tell = self._setup.target.gpu.timer.clock == "gpu" or found >= _LEAST_WALL_MS
            figures[f"{stage}_ms"] = found if can_tell else None
        width, height = self._setup.sizes.shown
        figures["pixels"] = float(width * height)
        figures["instants"] = float(len(self._figures))
        assert self._first is not None
        return Looked(self._run, figures, *self._first)


def stream(run: StreamRun, scale: float, seconds: float) -> tuple[Figures, Sequence[Mapping[str, Any]]]:
    """Return what the frames of one eye weigh and how late they are, and their time line."""
    width, height = (max(16, round(side * scale)) for side in run.size)
    network = LinkOptions(server_rate_hz=run.server_hz)
    if run.bandwidth_mbit is not None:  # all that a frame goes through delays it
        network = attrs.evolve(network, bandwidth=Bandwidth(run.bandwidth_mbit), response=SUM)
    same = {name: getattr(run, name) for name in ("trace", "scene", "latency_ms", "warp")}
    few: dict[str, Any] = {"start_s": 2.0, "seconds": seconds, "metrics_every": 10**6, "workers": 0}
    coding, size = Coding(run.codec, depth=run.depth), (width, height)
    streamed: dict[str, Any] = {"guard": 1.0, "predict": "none", "size": size, "coding": coding, "network": network}
    summary = measured(RunOptions(**_COMMON, **same, **streamed, **few)).summary
    link = summary["link"]
    per_eye, frames = link["mbit_s"] / 2, link["frames"]
    settled = frames["never_shown"] + frames["shown"]  # the rest is still under way
    found: Figures = {
        "mbit_s": per_eye,
        "never_shown_share": frames["never_shown"] / settled if settled else None,
        **{f"{name}_mbit_s": value / 2 for name, value in link["layers_mbit_s"].items()},
    }
    if scale == 1:  # smaller pictures tell nothing of these
        found["full_size_mbit_s"] = per_eye
        # A CPU that renders says nothing of a machine with a GPU.
        found["response_ms"] = (link["response_ms"] or {}).get("median_ms") if summary["clock"] == "gpu" else None
    return found, link.get("timeline") or ()
