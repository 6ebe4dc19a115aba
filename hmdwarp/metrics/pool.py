"""Measurement of pictures in other processes, and the worst of them."""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable
from concurrent.futures import ALL_COMPLETED, FIRST_COMPLETED, BrokenExecutor, Future, wait
from typing import Any

import attrs

from ..errors import HmdwarpError
from .job import QualityJob, QualityResult
from .metric import PRIMARY, measure
from .processes import MeasuringProcesses


@attrs.frozen(eq=False)
class Kept:
    """A picture to keep, with its figures."""

    key: Any  # the key it was submitted under
    job: QualityJob
    result: QualityResult

    @property
    def rank(self) -> tuple[float, Any]:
        """Sort key: larger is worse. Of two equals the one with the larger key counts as worse."""
        return self.result.values[PRIMARY] or 0.0, self.key


class WorstKeeper:
    """The `count` pictures with the largest FLIP error, at most one from each bucket.

    A bucket is a second of the trace, say.

    The order in which pictures are offered does not matter. A bucket's worst is dropped only when
    `count` other buckets are worse still, and those can only get worse. A picture whose bucket is
    None is never kept.
    """

    def __init__(self, count: int, bucket: Callable[[Any], Hashable]) -> None:
        self.count, self._bucket = count, bucket
        self._best: dict[Hashable, Kept] = {}

    def offer(self, kept: Kept) -> None:
        """Keep a picture if it is among the worst so far."""
        if self.count == 0:
            return
        bucket = self._bucket(kept.key)
        if bucket is None:
            return
        if bucket in self._best and self._best[bucket].rank >= kept.rank:
            return
        self._best[bucket] = kept
        if len(self._best) > self.count:
            del self._best[min(self._best, key=lambda b: self._best[b].rank)]

    def kept(self) -> list[Kept]:
        """Return the kept pictures, the worst first."""
        return sorted(self._best.values(), key=lambda k: k.rank, reverse=True)


MOST_WORKERS = 8  # each takes 250 MB, more for larger pictures


def worker_count(workers: int | None) -> int:
    """Return the number of measuring processes; by default one per core."""
    return min(os.cpu_count() or 1, MOST_WORKERS) if workers is None else workers


class QualityPool:
    """Measures the QualityJobs of a run, to the same bits with any number of processes.

    with MeasuringProcesses(2) as processes:
    pool = QualityPool(processes, worst=6)
    pool.submit((frame, eye), job)            # waits while all workers are behind
    pool.wait()
    pool.results[frame, eye]["flip"]              # in the order of the keys

    keep=True in submit keeps that job's pictures in `kept`. `worst` is how many of the worst
    pictures (by FLIP) are kept in `worst`, at most one from each `bucket(key)`. All others are
    dropped as soon as they are measured, so memory does not grow with the length of the run. A kept
    picture comes with its FLIP map, without previous frame, coverage and depth.

    Errors: HmdwarpError, from submit() or wait(), when measuring failed or a worker died.
    """

    def __init__(
        self, processes: MeasuringProcesses, *, worst: int = 0, bucket: Callable[[Any], Hashable] = lambda key: key
    ) -> None:
        self._processes, self._keeper = processes, WorstKeeper(worst, bucket)
        self._pending: dict[Future[QualityResult], tuple[Any, QualityJob, bool]] = {}
        self._measured: dict[Any, QualityResult] = {}
        self._kept: dict[Any, Kept] = {}

    def submit(self, key: Any, job: QualityJob, *, keep: bool = False) -> None:
        """Submit a job under a sortable key; block while each worker has a job waiting."""
        if keep or self._keeper.count:
            job = attrs.evolve(job, error_map=True)
        # One waiting job per worker keeps them busy; more would only hold pictures in memory.
        while len(self._pending) >= max(1, 2 * self._processes.count):
            self._collect(FIRST_COMPLETED)
        try:
            # What is only for reports stays here.
            measured = self._processes.submit(measure, attrs.evolve(job, rendered_picture=None, beside=()))
        except BrokenExecutor as error:
            raise self._failed(key, error) from error
        self._pending[measured] = key, job, keep
        if not self._processes.count:
            self.wait()

    def wait(self) -> None:
        """Wait until all jobs are measured, so that the next timing has the machine to itself.

        Errors: as submit.
        """
        self._collect(ALL_COMPLETED)

    @property
    def results(self) -> dict[Any, dict[str, float | None]]:
        """The figures measured so far, by metric, in the order of the keys."""
        return {key: self._measured[key].values for key in sorted(self._measured)}

    @property
    def regions(self) -> dict[Any, dict[str, dict[str, float]]]:
        """The region_sums of the measured jobs that have regions=True, in the order of the keys."""
        found = ((key, self._measured[key].regions) for key in sorted(self._measured))
        return {key: regions for key, regions in found if regions is not None}

    @property
    def kept(self) -> list[Kept]:
        """The measured jobs that were submitted with keep=True, in the order of the keys."""
        return [self._kept[key] for key in sorted(self._kept)]

    @property
    def worst(self) -> list[Kept]:
        """The worst pictures measured so far, the worst first."""
        return self._keeper.kept()

    def _collect(self, until: str) -> None:
        done = wait(self._pending, return_when=until).done
        for measured in [each for each in self._pending if each in done]:
            key, job, keep = self._pending.pop(measured)
            try:
                result = measured.result()
            except Exception as error:
                raise self._failed(key, error) from error
            self._measured[key] = attrs.evolve(result, error_map=None)
            # Keep only what reports show: a job of a 2064x2208 eye is 100 MB, its pictures are 40.
            shown = attrs.evolve(job, previous=None, covered=None, truth_inverse_depth=None, alike=None, regions=False)
            kept = Kept(key, shown, result)
            if keep:
                self._kept[key] = kept
            self._keeper.offer(kept)

    def _failed(self, key: Any, error: Exception) -> HmdwarpError:
        error = self._processes.explained(error)
        known = error if isinstance(error, HmdwarpError) else HmdwarpError(f"{type(error).__name__}: {error}")
        return type(known)(f"measuring picture {key} failed: {known}")
