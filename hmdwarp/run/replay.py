"""Replays a recorded head trace through the loop and measures it against a renderer without latency."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import nullcontext

import numpy as np

from ..colour import picture_from_linear
from ..errors import InputError
from ..gpu.textures import download
from ..metrics import QualityPool, aggregate, pooled, worker_count
from ..pipeline.loop import Refresh
from ..pipeline.options import AUTO, RunOptions
from ..report import OutputFolder, VideoWriter
from .guard import settled
from .log import Row, RunLog
from .measuring import AGAINST, MAIN, Probe
from .outcome import OWNED, ReplayResult, outcome_of, write_outcome
from .rig import Rig, build_rig
from .trial import ladder_for

WORST_FRAMES = 6

Progress = Callable[[int, int], None]


def replay(
    options: RunOptions, progress: Progress = lambda done, total: None, say: Callable[[str], None] = lambda text: None
) -> ReplayResult:
    """Run it and write options.out; nothing is left there if it fails or is interrupted.

    progress(done, total) is called after each refresh; say() gets a sentence before warp "auto" tries what it chooses from.
    Errors: InputError and its kin for what was asked, MachineError for what the machine lacks.
    """
    options, told = settled(options)
    ladder = ladder_for(options, say)
    with build_rig(options, levels=ladder.levels) as rig, OutputFolder(options.out, owned=OWNED) as out:
        rig.notes.extend((*told, *ladder.notes_on(rig.gpu.renderer, os.cpu_count() or 1)))
        workers = worker_count(options.workers)
        with QualityPool(
            workers, rig.pixels_per_degree, worst=WORST_FRAMES, bucket=lambda key: _contest(rig, key)
        ) as pool:
            probe = Probe(rig, pool, _keep_every(rig))
            log = _run(rig, probe, out, progress)
        log.measured(_figures(pool, MAIN))
        compared = _compared(log, probe, pool)
        more = {"filled": probe.filled_shares(), "regions": pooled(pool.regions.values())}
        result = outcome_of(rig, log, compared, more)
        write_outcome(rig, out, log, result, compared, pool)
    return result


def figures(options: RunOptions, progress: Progress = lambda done, total: None) -> dict[str, dict]:
    """What a replay measures, as metrics.summary.aggregate has it, without writing anything. Errors: as replay; InputError for warp "auto",
    which takes what the machine has time for, and for a video."""
    if options.warp == AUTO or options.video:
        raise InputError("measured without being written is a warp that is chosen, and no video")
    with build_rig(options) as rig, QualityPool(worker_count(options.workers), rig.pixels_per_degree) as pool:
        log = _run(rig, Probe(rig, pool, None), None, progress)
        pool.wait()
        log.measured(_figures(pool, MAIN))
    return aggregate(log.rows)


def _run(rig: Rig, probe: Probe, out: OutputFolder | None, progress: Progress) -> RunLog:
    log, times, number = RunLog(rig.track), rig.timetable, 0
    with _video(rig, out) as video:
        for instant_ns, shown in times.instants():
            rig.loop.draw(instant_ns)
            refresh = rig.loop.show(instant_ns) if shown else None
            if refresh is not None:
                log.add(refresh)
                if probe.wants(number):
                    probe.look(number, refresh)
                if video is not None:
                    video.add(_panels(refresh))
                number += 1
            progress(number, times.count)
    if not number:
        raise InputError(_nothing_arrived(rig))
    return log


def _nothing_arrived(rig: Rig) -> str:
    counts = ", ".join(f"{name} {count}" for name, count in rig.channel.link.tally.as_dict().items() if count)
    return f"no frame has arrived in time to be shown ({counts}): use less loss, more bandwidth, or a longer part of the trace"


def _video(rig: Rig, out: OutputFolder | None):
    if not rig.options.video or out is None:
        return nullcontext()
    wide, high = rig.size
    return VideoWriter(out.path("replay.mp4"), (2 * wide, high), rig.timetable.rate_hz)


def _panels(refresh: Refresh) -> np.ndarray:
    return np.concatenate([picture_from_linear(download(eye.panel.texture)) for eye in refresh.eyes], axis=1)


def _contest(rig: Rig, key: tuple[int, int, int]) -> int | None:
    """One worst picture for each second, of the asked-for warp alone."""
    number, _, which = key
    return int(number / rig.timetable.rate_hz) if which == MAIN else None


def _keep_every(rig: Rig) -> int | None:
    """Every how many refreshes a picture is kept for images/, so that about options.images measured ones are."""
    if not rig.options.images:
        return None
    every = rig.options.metrics_every
    measured = -(-rig.timetable.count // every)
    return every * max(1, -(-measured // rig.options.images))


def _figures(pool: QualityPool, which: int) -> dict[tuple[int, int], Row]:
    return {(number, eye): values for (number, eye, what), values in pool.results.items() if what == which}


def _compared(log: RunLog, probe: Probe, pool: QualityPool) -> list[Row] | None:
    figures = _figures(pool, AGAINST)
    return log.compared(probe.against_ms, figures) if figures else None


__all__ = ["ReplayResult", "figures", "replay"]
