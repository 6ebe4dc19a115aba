"""Runs the cases of a bench: all rows of one case are timed together, on one machine."""

from __future__ import annotations

import functools
import itertools
import platform
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import attrs

from ...client.classes import load_client
from ...client.plan import needs_of
from ...gpu.context import Gpu
from ...gpu.timers import check_clocks
from ...metrics import MeasuringProcesses, QualityPool, clip_length, worker_count
from ...pipeline.sizes import check_held, eye_sizes
from ...platforms import memory_bytes
from ...run.combinations import GPU_BATCH_BYTES, MEMORY_PART, Combination
from ...run.replay_setup import set_up_replay
from ...run.run_summary import machine_of
from ...run.side_by_side import Comparison, rate_clips
from ..sweep import Result, SweepCase
from .bench_rows import row_of
from .cases import BenchCase, prepared

ROWS = "rows"


@attrs.frozen
class BenchWork:
    """Runs the cases of a bench."""

    # Measuring processes, as the option.
    workers: int | None

    @contextmanager
    def opened(self) -> Iterator[Callable[[SweepCase, Callable[[float], None]], Result]]:
        """Open what cases share: the measuring processes."""
        with MeasuringProcesses(worker_count(self.workers)) as processes:
            yield _Runner(processes)


@attrs.frozen(eq=False)
class _Machine:
    """What a bench says of the machine that it runs on."""

    # The keys of bench.json.
    about: dict[str, Any]
    # For the compensators of one batch.
    most_bytes: float


@functools.cache
def _examined() -> _Machine:
    """Return what this machine is, measured once in each process."""
    with Gpu() as gpu:
        clocks = check_clocks(gpu.gl, gpu.timer.clock)
        about = {
            "machine": {**machine_of(gpu), "host": platform.node()},
            "clock": clocks.clock,
            "clocks": {"wall_ms": clocks.wall_ms, "gpu_ms": clocks.gpu_ms, "note": clocks.note},
        }
        return _Machine(about, most_bytes(gpu))


def most_bytes(gpu: Gpu) -> float:
    """Return what the compensators of one batch may take."""
    return MEMORY_PART * memory_bytes() if gpu.is_software else GPU_BATCH_BYTES


def check_room(works: Sequence[BenchCase]) -> None:
    """Check that this machine can hold what each case needs. Errors: as check_held."""
    with Gpu() as gpu:
        for work in works:
            headset = work.headset
            for batch in work.batched(most_bytes(gpu)):
                run = work.run_of(batch)
                sizes = eye_sizes(run.guard_band, headset, run.size or headset.eye_size_px)
                check_held(gpu, run, needs_of(c.plan for c in batch), sizes, run.rate_hz or headset.refresh_hz)


class _Runner:
    """Runs one case after the other."""

    def __init__(self, processes: MeasuringProcesses) -> None:
        self._processes = processes

    def __call__(self, case: SweepCase, step: Callable[[float], None]) -> Result:
        try:
            rows = self.rows(prepared(case.what), step)
        except BaseException:
            self._processes.close()  # what failed is not measured any further
            raise
        return Result({**_examined().about, ROWS: rows})

    def rows(self, work: BenchCase, step: Callable[[float], None]) -> list[dict[str, Any]]:
        """Return the rows of a case."""
        machine, options, client = _examined(), work.options, load_client(work.options.client)
        pool = QualityPool(self._processes)
        seconds, rate_hz = work.options.jod_s, work.options.rate_hz or work.headset.refresh_hz
        chosen, rated = (
            work.batched(machine.most_bytes),
            (work.batched(machine.most_bytes, clip_length(seconds, rate_hz)) if seconds else []),
        )
        steps = _steps(work.instants * (len(chosen) + len(rated)), step)
        rows: list[tuple[Combination, dict[str, Any]]] = []
        for batch in chosen:
            with set_up_replay(work.run_of(batch), needs_of(c.plan for c in batch)) as setup:
                comparison = Comparison(setup, work.case, batch, pool, options.rounds)
                comparison.run(options.instants, steps)
                pool.wait()
                for each in comparison.measured:
                    row = row_of(setup, work.case, each, pool, client)
                    rows.append((each.combination, row))
        ratings: dict[tuple[str, ...], dict[str, Any]] = {}
        for batch in rated:  # after all times: no timed run has these refreshes between its own
            with set_up_replay(work.run_of(batch), needs_of(c.plan for c in batch)) as setup:
                found = rate_clips(setup, batch, options.instants, steps)
            ratings |= {_named(c): each for c, each in zip(batch, found, strict=True)}
        return [{**row, **ratings.get(_named(c), {}), "machine": machine.about["machine"]} for c, row in rows]


def _named(combination: Combination) -> tuple[str, ...]:
    return combination.strategy, combination.warp, combination.fill


def _steps(total: int, step: Callable[[float], None]) -> Callable[[], None]:
    """Return what counts the finished steps of a case."""
    shares = (done / total for done in itertools.count(1))
    return lambda: step(next(shares))
