"""The replay: a recorded head trace through the loop, measured against a zero-latency renderer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import Any

import attrs
import numpy as np

from ..base import AUTO, InputError, picture_from_linear
from ..client import Plan
from ..frames import EyeSizes
from ..geometry import Pose
from ..gpu import download
from ..link.options import ALL
from ..metrics import TRUTH_JOD, Clips, Kept, MeasuringThreads, QualityPool, pooled, worker_count
from ..pipeline import ServerFrames
from ..pipeline.options import SERVER_SCENE
from ..pipeline.sizes import refreshes_of
from ..report import OutputFolder, open_video
from ..sources.server import Server
from .measuring import MAIN, Probe, method_name
from .options import RunOptions
from .run import ReplayRun, set_up_replay
from .run_summary import OWNED, Judge, ReplayLog, ReplayResult, Row, result_of, write_results

_WORST_FRAMES = 6

Progress = Callable[[int, int], None]


def replay(
    options: RunOptions,
    progress: Progress = lambda done, total: None,
    say: Callable[[str], None] = lambda text: None,
    judge: Judge | None = None,
) -> ReplayResult:
    """Run a replay and write options.out; one that fails or is interrupted leaves nothing there.

    Parameters
    ----------
    options
        The run. `choose` first where its warp or guard is "auto".
    progress
        Called with (done, total) after each refresh.
    say
        Called with a sentence before each part that takes long and shows no progress.
    judge
        Gives the verdict, which is written with the rest.

    Returns
    -------
    ReplayResult
        The summary and the rows of frames.csv.

    Raises
    ------
    InputError
        For wrong options.
    MachineError
        For missing hardware or software.
    """
    options = RunOptions.checked(options)
    if AUTO in (options.warp, options.guard):
        raise InputError("warp or guard 'auto': choose(options).options names what it stands for in a run")
    with OutputFolder(options.out, owned=OWNED, force=options.force) as out:
        with set_up_replay(options, say=say, alone=True) as setup:

            def contest(key: tuple[int, int, int]) -> int | None:  # one of each second competes for the worst
                return int(key[0] / setup.schedule.rate_hz) if key[2] == MAIN else None

            with MeasuringThreads(worker_count(options.workers)) as threads:
                pool = QualityPool(threads, worst=_WORST_FRAMES, bucket=contest)
                probe = Probe(setup, pool)
                log = _run(setup, probe, out, progress)
            _write_delays(setup, out)
            found = [_figures(pool, which) for which in range(1, 1 + len(probe.against_ms))]
            # None where nothing was measured.
            compared = [log.compared(*pair) for pair in zip(probe.against_ms, found, strict=True)] if all(found) else []
            more: dict[str, Any] = {"filled": probe.filled_shares(), "regions": pooled(pool.regions.values())}
            more |= probe.near_gaze.entry()
            more |= _rated(setup, probe.clips, range(1, 1 + len(setup.options.compared)))
            if probe.clips is not None and "jod" in more:
                told = [f"ColorVideoVDP rates it {more['jod']['mean']:.2f} JOD, where {TRUTH_JOD:g} is like the truth"]
                others = zip(setup.options.compared, more["jod"].get("against", ()), strict=False)
                told += [f"{method_name(*pair)} {other['mean']:.2f}" for pair, other in others]
                setup.notes.append(f"{', '.join(told)}. Predicted from the pictures: no one was asked.")
            result = result_of(setup, log, compared, more, probe.without_truth)
        verdict = write_results(out, log, result, compared, pool, options.command, judge)
        return attrs.evolve(result, verdict=verdict)


def _write_delays(setup: ReplayRun, out: OutputFolder) -> None:
    """Write delays.csv: what --delay-trace takes to show the same frames at the same ages again."""
    # That replay begins to draw as long before the first shown refresh as the longest delay.
    schedule = setup.schedule
    start_s = (schedule.first_ns - setup.trace.track.start_ns) * 1e-9
    remote = setup.source.remote
    delays = [delay_ns for _, delay_ns in remote.delays_ns] if remote is not None else []
    ahead = schedule.age
    while delays and ahead > (needed := refreshes_of(max(delays) / 1e6, schedule.rate_hz)):
        delays, ahead = delays[ahead - needed :], needed
    if delays:
        longest = max(delays)
        delays[:0] = [longest] * (refreshes_of(longest / 1e6, schedule.rate_hz) - ahead)
        out.write_text("delays.csv", "".join(["delay_ms\n", *(f"{delay / 1e6!r}\n" for delay in delays)]))
    if delays and setup.source.scene.name != SERVER_SCENE:
        setup.notes.append(
            f"The same frames at the same ages, without the server: --start {start_s!r} --delay-trace delays.csv"
        )


@attrs.frozen(eq=False)
class Measured:
    """What a replay without a folder gave."""

    # As summary.json.
    summary: dict[str, Any]
    # About options.images refreshes, both eyes of each.
    kept: list[Kept]
    plan: Plan
    sizes: EyeSizes
    # As frames.csv's.
    rows: list[Row]


class NothingShown(InputError):
    """A replay over a link that let nothing through; result: with the reason as `nothing`."""

    def __init__(self, message: str, result: Measured | None = None) -> None:
        super().__init__(message)
        self.result = result


def measured(
    options: RunOptions, progress: Progress = lambda done, total: None, threads: MeasuringThreads | None = None
) -> Measured:
    """Run a replay without writing anything; threads: that stay for the next run.

    Errors: as replay; InputError for warp "auto" and for a video.
    """
    if options.warp == AUTO or options.video:
        raise InputError("figures without a folder: neither warp 'auto' nor a video is supported")
    with (
        set_up_replay(options, alone=True) as setup,
        MeasuringThreads(worker_count(options.workers)) if threads is None else nullcontext(threads) as lent,
    ):
        pool = QualityPool(lent)
        probe = Probe(setup, pool)
        log = _run(setup, probe, None, progress)
        summary = result_of(setup, log, [], _rated(setup, probe.clips), probe.without_truth).summary
        return Measured(summary, list(pool.kept), setup.plans[0], setup.sizes, log.rows)


def _run(setup: ReplayRun, probe: Probe, out: OutputFolder | None, progress: Progress) -> ReplayLog:
    log, count, options, drawn_by = ReplayLog(setup.track), 0, setup.options, setup.loop.source
    # No picture is drawn that arrives after the last refresh, in a frame that holds nothing else.
    is_plain = options.client_link.is_plain and options.network.send == ALL
    is_server = isinstance(getattr(drawn_by, "server", None), Server)
    is_plain = is_plain and is_server and options.coding.codec == "none"
    if is_plain and isinstance(drawn_by, ServerFrames) and not drawn_by.requested.needs:
        *_, (_, last_ns) = setup.schedule.numbered()
        setup.loop.source = attrs.evolve(drawn_by, unseen_from_ns=last_ns - setup.channel.latency_ns + 1)
    made: AbstractContextManager[Callable[[Any], None] | None] = nullcontext()
    (wide, high), eyes = setup.sizes.shown, len(setup.source.headset.views(Pose()))
    if options.video and out is not None:
        made = open_video(out.path("replay.mp4"), (eyes * wide, high), setup.schedule.rate_hz)
    with made as add_to_video:
        for number, instant_ns in setup.schedule.numbered():
            setup.loop.draw(instant_ns)
            refresh = setup.loop.show(instant_ns) if number >= 0 else None
            if refresh is not None:
                log.add(refresh)
                if probe.wants(count):
                    probe.read(count, refresh)
                if add_to_video is not None:
                    panels = [picture_from_linear(download(eye.panel.texture)) for eye in refresh.eyes]
                    add_to_video(np.concatenate(panels, axis=1))
                count += 1
            progress(count, setup.schedule.count)
    if not count:
        tally = setup.channel.link.tally.as_dict()
        counts = ", ".join(f"{name.replace('_', ' ')} {number}" for name, number in tally.items() if number)
        found = result_of(setup, log, [], {"nothing": f"no frame arrived in time ({counts})"})
        raise NothingShown(
            f"no frame has arrived in time to be shown ({counts}): "
            "use less loss, more bandwidth, or a longer part of the trace",
            Measured(found.summary, [], setup.plans[0], setup.sizes, []),
        )
    probe.pool.wait()
    log.measured(_figures(probe.pool, MAIN))
    return log


def _rated(setup: ReplayRun, clips: Clips | None, others: Sequence[int] = ()) -> dict[str, Any]:
    """Return the `jod` of summary.json, beside others, or `jod_failure`, which is noted."""
    if clips is None:
        return {}
    clips.finish()
    if clips.failure:
        setup.notes.append(clips.failure)
        return {"jod_failure": clips.failure}
    against = {"against": [clips.entry(other) for other in others]} if others else {}
    return {"jod": clips.entry(MAIN) | against}


def _figures(pool: QualityPool, which: int) -> dict[tuple[int, int], Row]:
    return {(number, eye): values for (number, eye, what), values in pool.results.items() if what == which}
