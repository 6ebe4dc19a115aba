"""Measurement of pictures in other processes, and the worst of them."""

from __future__ import annotations

import functools
import os
import queue
import threading
from collections.abc import Callable, Hashable
from typing import Any

import attrs

from ..errors import HmdwarpError
from .job import QualityJob, QualityResult
from .metric import PRIMARY, measure
from .process import MeasuringProcess


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


# Takes the figures of a job.
Then = Callable[[QualityResult], object]
_Waiting = tuple[Any, QualityJob, bool, Then | None]

MOST_WORKERS = 8  # each takes 250 MB, more for larger pictures


def worker_count(workers: int | None) -> int:
    """Return the number of measuring processes; by default one per core."""
    return min(os.cpu_count() or 1, MOST_WORKERS) if workers is None else workers


class QualityPool:
    """A pool of processes that measure QualityJobs; with 0 of them submit() does, to the same bits.

    with QualityPool(2, pixels_per_degree, worst=6) as pool:
    pool.submit((frame, eye), job)            # waits while all workers are behind
    pool.results[frame, eye]["flip"]              # complete, in the order of the keys

    Leaving the block normally waits for all submitted jobs. Leaving it by an exception (including
    Ctrl-C) drops the rest at once. No process outlives the block.

    keep=True in submit keeps that job's pictures in `kept`. `worst` is how many of the worst
    pictures (by FLIP) are kept in `worst`, at most one from each `bucket(key)`. All others are
    dropped as soon as they are measured, so memory does not grow with the length of the run. A kept
    picture comes with its FLIP map, without previous frame, coverage and depth.

    Errors: HmdwarpError, from submit() or from the end of the block, when measuring failed or a
    worker died.
    """

    def __init__(
        self,
        workers: int,
        pixels_per_degree: float,
        *,
        worst: int = 0,
        bucket: Callable[[Any], Hashable] = lambda key: key,
    ) -> None:
        self._pixels_per_degree = pixels_per_degree
        self._keeper = WorstKeeper(worst, bucket)
        self._results: dict[Any, dict[str, float | None]] = {}
        self._regions: dict[Any, dict[str, dict[str, float]]] = {}
        self._kept: dict[Any, Kept] = {}
        self._lock = threading.Lock()
        self._under_way = 0
        self._idle = threading.Condition(self._lock)
        self._failure: HmdwarpError | None = None
        self._stopping = threading.Event()
        # One waiting job per worker keeps them busy; more would only hold pictures in memory.
        self._queue: queue.Queue[_Waiting | None] = queue.Queue(maxsize=max(workers, 1))
        self._workers: list[MeasuringProcess] = []
        self._threads: list[threading.Thread] = []
        measured = functools.partial(measure, pixels_per_degree=pixels_per_degree)
        try:
            for _ in range(workers):
                self._workers.append(MeasuringProcess(measured, "use fewer metric workers, or 0"))
        except BaseException:
            self._stop_workers(kill=True)
            raise
        for worker in self._workers:
            thread = threading.Thread(target=self._serve, args=(worker,), name="hmdwarp-metrics", daemon=True)
            thread.start()
            self._threads.append(thread)

    def submit(self, key: Any, job: QualityJob, *, keep: bool = False, then: Then | None = None) -> None:
        """Submit a job under a sortable key; block while each worker has a job waiting.

        then: called with the figures, from any thread.
        """
        if keep or self._keeper.count:
            job = attrs.evolve(job, error_map=True)
        if not self._workers and not self._stopping.is_set():
            self._measure_here(key, job, keep, then)
            return
        with self._lock:
            self._under_way += 1
        if not self._put((key, job, keep, then)):
            self._raise_failure()
            raise HmdwarpError("this pool of measuring processes is closed: submit inside its with block")

    def take(self, key: Any, job: QualityJob, result: QualityResult, *, keep: bool = False) -> None:
        """Store figures that are known already as those of a job."""
        self._store(key, job, keep, result)

    def wait(self) -> None:
        """Wait until all jobs are measured, so that the next timing has the machine to itself.

        Errors: as submit.
        """
        with self._idle:
            while self._under_way and not self._stopping.is_set():
                self._idle.wait(timeout=0.1)
        self._raise_failure()

    def forget(self) -> None:
        """Drop the figures so far: a pool that lives long keeps those of its present pictures."""
        with self._lock:
            self._results.clear()
            self._regions.clear()
            self._kept.clear()

    def finish(self) -> dict[Any, dict[str, float | None]]:
        """Wait for all jobs, end the workers, and return all results in the order of their keys."""
        try:
            for _ in self._threads:
                self._put(None)
            for thread in self._threads:
                thread.join()
        except BaseException:
            self.abort()
            raise
        self._stopping.set()
        self._stop_workers(kill=self._failure is not None)
        self._raise_failure()
        return self.results

    def abort(self) -> None:
        """Drop the jobs not measured yet and end the workers at once."""
        self._stopping.set()
        self._stop_workers(kill=True)

    @property
    def results(self) -> dict[Any, dict[str, float | None]]:
        """The figures measured so far, by metric, in the order of the keys."""
        with self._lock:
            return {key: self._results[key] for key in sorted(self._results)}

    @property
    def regions(self) -> dict[Any, dict[str, dict[str, float]]]:
        """The region_sums of the measured jobs that have regions=True, in the order of the keys."""
        with self._lock:
            return {key: self._regions[key] for key in sorted(self._regions)}

    @property
    def kept(self) -> list[Kept]:
        """The measured jobs that were submitted with keep=True, in the order of the keys."""
        with self._lock:
            return [self._kept[key] for key in sorted(self._kept)]

    @property
    def worst(self) -> list[Kept]:
        """The worst pictures measured so far, the worst first."""
        with self._lock:
            return self._keeper.kept()

    def __enter__(self) -> QualityPool:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.finish()
        else:
            self.abort()

    def _put(self, item: _Waiting | None) -> bool:
        """Queue the item for a worker; return False if the pool stopped first."""
        while not self._stopping.is_set():
            try:
                self._queue.put(item, timeout=0.1)
                return True
            except queue.Full:
                continue
        return False

    def _measure_here(self, key: Any, job: QualityJob, keep: bool, then: Then | None) -> None:
        try:
            self._store(key, job, keep, measure(job, self._pixels_per_degree), then)
        except Exception as error:
            self._fail(key, error)
            self._raise_failure(error)

    def _serve(self, worker: MeasuringProcess) -> None:
        while not self._stopping.is_set():
            try:
                item = self._queue.get(timeout=0.1)
            except queue.Empty:
                continue
            if item is None:
                return
            key, job, keep, then = item
            try:
                # What is only for reports stays here.
                self._store(key, job, keep, worker.ask(attrs.evolve(job, rendered_picture=None, beside=())), then)
                with self._idle:
                    self._under_way -= 1
                    self._idle.notify_all()
            except Exception as error:
                self._fail(key, error)
                return

    def _store(self, key: Any, job: QualityJob, keep: bool, result: QualityResult, then: Then | None = None) -> None:
        if then is not None:
            then(result)
        with self._lock:
            self._results[key] = result.values
            if result.regions is not None:
                self._regions[key] = result.regions
            # Keep only what reports show: a job of a 2064x2208 eye is 100 MB, its pictures are 40.
            shown = attrs.evolve(job, previous=None, covered=None, truth_inverse_depth=None, alike=None, regions=False)
            kept = Kept(key, shown, result)
            if keep:
                self._kept[key] = kept
            self._keeper.offer(kept)

    def _fail(self, key: Any, error: Exception) -> None:
        with self._lock:
            if self._failure is None and not self._stopping.is_set():
                known = error if isinstance(error, HmdwarpError) else HmdwarpError(f"{type(error).__name__}: {error}")
                self._failure = type(known)(f"measuring picture {key} failed: {known}")
        self._stopping.set()

    def _raise_failure(self, cause: Exception | None = None) -> None:
        if self._failure is not None:
            raise self._failure from cause

    def _stop_workers(self, *, kill: bool) -> None:
        if kill:
            for worker in self._workers:
                worker.kill()
        for thread in self._threads:
            thread.join()
        for worker in self._workers:
            worker.close()


class SharedPool:
    """Measuring processes of runs that follow each other, for one resolution at a time."""

    def __init__(self) -> None:
        self._pool: tuple[Any, QualityPool] | None = None

    def of(self, workers: int | None, pixels_per_degree: float) -> QualityPool:
        """Return the pool, without figures; that for another resolution is ended."""
        key = workers, pixels_per_degree
        if self._pool is None or self._pool[0] != key:
            self.end()
            self._pool = key, QualityPool(worker_count(workers), pixels_per_degree)
        self._pool[1].forget()
        return self._pool[1]

    def end(self, *, at_once: bool = False) -> None:
        """End the processes; at once where measuring failed: they measure nothing more."""
        if self._pool is not None:
            (self._pool[1].abort if at_once else self._pool[1].finish)()
        self._pool = None

    def __enter__(self) -> SharedPool:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self.end(at_once=kind is not None)
