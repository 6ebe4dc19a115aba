"""Measurement of pictures beside the loop that makes them, and the worst of them."""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable
from concurrent.futures import ALL_COMPLETED, FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import HmdwarpError, lower_priority
from .metric import PRIMARY, QualityJob, QualityResult, measure

_NICENESS = 5  # measuring must not slow down the loop whose passes are being timed
_MOST_WORKERS = 8  # each holds what it computes of one picture


def worker_count(workers: int | None) -> int:
    """Return the number of measuring threads; by default one per core."""
    return min(os.cpu_count() or 1, _MOST_WORKERS) if workers is None else workers


class MeasuringThreads(ThreadPoolExecutor):
    """So many threads that measure, most of the time in NumPy, which lets the loop run meanwhile.

    With 0 the loop waits for each picture.
    """

    def __init__(self, count: int) -> None:
        super().__init__(max(1, count), "measuring", lower_priority, (_NICENESS,))
        self.count = count


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


def keep_worst(best: dict[Hashable, Kept], kept: Kept, bucket: Hashable, count: int) -> None:
    """Keep a picture among the `count` worst, at most one from each bucket; None is never kept.

    A bucket is a second of the trace, say. The order in which pictures come does not matter: a
    bucket's worst is dropped only when `count` others are worse still, which can only get worse.
    """
    if bucket is not None and not (bucket in best and best[bucket].rank >= kept.rank):
        best[bucket] = kept
        if len(best) > count:
            del best[min(best, key=lambda one: best[one].rank)]


class QualityPool:
    """Measures the QualityJobs of a run, to the same bits with any number of threads.

    `worst` is how many of the worst pictures (by FLIP) are kept in `worst`, at most one from each
    `bucket(key)`; submit's keep=True keeps a job's pictures in `kept`. All others are dropped as
    soon as they are measured, so memory does not grow with the length of the run. A kept picture
    comes with its FLIP map, without previous frame, coverage and depth.

    Errors: HmdwarpError, from submit() or wait(), when measuring failed.
    """

    def __init__(
        self, threads: MeasuringThreads, *, worst: int = 0, bucket: Callable[[Any], Hashable] = lambda key: key
    ) -> None:
        self._threads, self._count, self._bucket = threads, worst, bucket
        self._worst: dict[Hashable, Kept] = {}
        self._pending: dict[Future[QualityResult], tuple[Any, QualityJob, bool]] = {}
        self._measured: dict[Any, QualityResult] = {}
        self._kept: dict[Any, Kept] = {}

    def submit(self, key: Any, job: QualityJob, *, keep: bool = False) -> None:
        """Submit a job under a sortable key; block while each worker has a job waiting."""
        if keep or self._count:
            job = attrs.evolve(job, error_map=True)
        # One waiting job per worker keeps them busy; more would only hold pictures in memory.
        while len(self._pending) >= max(1, 2 * self._threads.count):
            self._collect(FIRST_COMPLETED)
        self._pending[self._threads.submit(measure, job)] = key, job, keep
        if not self._threads.count:
            self.wait()

    def wait(self) -> None:
        """Wait until all jobs are measured: the next timing has the machine to itself."""
        self._collect(ALL_COMPLETED)

    @property
    def results(self) -> dict[Any, dict[str, float | None]]:
        """The figures measured so far, by metric, in the order of the keys."""
        return {key: self._measured[key].values for key in sorted(self._measured)}

    @property
    def regions(self) -> dict[Any, NDArray[np.float64]]:
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
        return sorted(self._worst.values(), key=lambda kept: kept.rank, reverse=True)

    def _collect(self, until: str) -> None:
        done = wait(self._pending, return_when=until).done
        for measured in [each for each in self._pending if each in done]:
            key, job, keep = self._pending.pop(measured)
            try:
                result = measured.result()
            except Exception as error:
                what = f"measuring picture {key} failed"
                if isinstance(error, HmdwarpError):
                    raise type(error)(f"{what}: {error}") from error
                raise HmdwarpError(f"{what}: {type(error).__name__}: {error}") from error
            self._measured[key] = attrs.evolve(result, error_map=None)
            # Keep only what reports show: a job of a 2064x2208 eye is 100 MB, its pictures are 40.
            shown = attrs.evolve(job, previous=None, covered=None, truth_inverse_depth=None, alike=None, regions=False)
            kept = Kept(key, shown, result)
            if keep:
                self._kept[key] = kept
            keep_worst(self._worst, kept, self._bucket(key), self._count)
