"""Measurement of pictures in other processes, and the worst of them."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Hashable, Iterator
from concurrent.futures import ALL_COMPLETED, FIRST_COMPLETED, BrokenExecutor, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from multiprocessing.context import SpawnContext, SpawnProcess
from types import ModuleType
from typing import IO, Any

import attrs

from ..errors import HmdwarpError, MachineError
from ..platforms import lower_priority
from .metric import PRIMARY, QualityJob, QualityResult, measure

_NICENESS = 5  # measuring must not slow down the loop whose passes are being timed
# More than one thread in a worker's BLAS would fight the other workers for the cores.
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_M_MMAP_MAX, _M_TRIM_THRESHOLD = -4, -1  # of glibc's malloc.h
_MAIN = sys.modules["__main__"]  # not as it is at a start: of two threads one would take the other's


class _Context(SpawnContext):
    """Keeps the processes that it starts: they know how they ended."""

    def __init__(self) -> None:
        super().__init__()
        self.started: list[SpawnProcess] = []

    def Process(self, *args: Any, **how: Any) -> SpawnProcess:  # type: ignore[override]  # noqa: N802
        self.started.append(SpawnProcess(*args, **how))
        return self.started[-1]


@contextmanager
def _starting() -> Iterator[None]:
    """Start processes that do not import the program again, and hear nothing that is to end it.

    Neither Ctrl-C nor a terminal that closes: what started them ends them. Until the block has
    ended, the program puts them off too: Python's own tracker of semaphores complains where it is
    ended first.
    """
    heard: list[int] = []
    handlers: dict[int, Any] = {}
    if sys.platform != "win32":
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP})
        # Another thread may get a signal for this one.
        if threading.current_thread() is threading.main_thread():
            for each in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM):
                handlers[each] = signal.signal(each, lambda which, _: heard.append(which))
    try:
        sys.modules["__main__"] = ModuleType("__main__")
        yield
    finally:
        sys.modules["__main__"] = _MAIN
        for number, handler in handlers.items():
            signal.signal(number, handler or signal.SIG_DFL)
        if sys.platform != "win32":
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if heard:
            signal.raise_signal(heard[0])


def _begin(said: int) -> None:
    """Begin a worker: what it prints, a library's words too, goes to that file of the program's."""
    with suppress(OSError), open(f"/proc/{os.getppid()}/fd/{said}", "ab") as file:  # noqa: PTH123 (no path)
        for stream in (1, 2):
            os.dup2(file.fileno(), stream)
    lower_priority(_NICENESS)
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    # glibc returns every freed picture to the system, which clears its pages for the next one: a
    # seventh of the time. A worker keeps the memory of its largest job instead.
    with suppress(AttributeError):
        allocation = ctypes.CDLL(None)
        allocation.mallopt(_M_MMAP_MAX, 0)
        allocation.mallopt(_M_TRIM_THRESHOLD, 2**31 - 1)
    program: Any = multiprocessing.parent_process()
    threading.Thread(target=lambda: os._exit(program.join() or 1), daemon=True).start()


class MeasuringProcesses:
    """So many workers that run functions, begun when there is work; with 0 submit() runs it here.

    No process outlives close(), which leaving the block calls. remedy: what to do when one ends by
    itself, for the message.
    """

    def __init__(self, count: int, remedy: str = "use fewer metric workers, or 0") -> None:
        self.count, self._remedy = count, remedy
        self._open: tuple[ProcessPoolExecutor, _Context, IO[bytes]] | None = None

    def submit(self, work: Callable[..., Any], *given: Any) -> Future[Any]:
        """Let a worker run the function. Errors: MachineError where none can be started."""
        if not self.count:
            done: Future[Any] = Future()
            try:
                done.set_result(work(*given))
            except Exception as error:
                done.set_exception(error)
            return done
        try:
            if self._open is None:
                with _starting():  # Python's tracker begins here, and unblocks Ctrl-C when it has
                    context, said = _Context(), tempfile.TemporaryFile()  # noqa: SIM115 (closed in close)
                    self._open = ProcessPoolExecutor(self.count, context, _begin, (said.fileno(),)), context, said
            with _starting():
                return self._open[0].submit(work, *given)
        except OSError as error:
            raise MachineError(
                f"cannot start a measuring process ({error.strerror or error}): use 0 metric workers"
            ) from error

    def explained(self, error: Exception) -> Exception:
        """Return the error of a future; of a worker that ended by itself, how it did."""
        if not isinstance(error, BrokenProcessPool) or self._open is None:
            return error
        executor, context, said = self._open
        executor.shutdown()  # it ends the others, by SIGTERM
        ends = [end for one in context.started if (end := one.exitcode) not in (None, 0, -signal.SIGTERM)]
        status = ends[0] if ends else -signal.SIGTERM
        why = f"exit status {status}" if status >= 0 else signal.strsignal(-status)
        why = "killed, perhaps for memory" if status == -9 else why
        said.seek(0)
        lines = said.read().decode(errors="replace").strip().splitlines()
        return HmdwarpError(f"a measuring process ended ({why}){': ' + lines[-1] if lines else ''}; {self._remedy}")

    def close(self) -> None:
        """Drop what no worker has begun, and end them; later work begins new ones."""
        if self._open is not None:
            executor, _, said = self._open
            executor.shutdown(cancel_futures=True)
            said.close()
            self._open = None

    def __enter__(self) -> MeasuringProcesses:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


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


MOST_WORKERS = 8  # each takes 250 MB, more for larger pictures


def worker_count(workers: int | None) -> int:
    """Return the number of measuring processes; by default one per core."""
    return min(os.cpu_count() or 1, MOST_WORKERS) if workers is None else workers


class QualityPool:
    """Measures the QualityJobs of a run, to the same bits with any number of processes.

    `worst` is how many of the worst pictures (by FLIP) are kept in `worst`, at most one from each
    `bucket(key)`; submit's keep=True keeps a job's pictures in `kept`. All others are dropped as
    soon as they are measured, so memory does not grow with the length of the run. A kept picture
    comes with its FLIP map, without previous frame, coverage and depth.

    Errors: HmdwarpError, from submit() or wait(), when measuring failed or a worker died.
    """

    def __init__(
        self, processes: MeasuringProcesses, *, worst: int = 0, bucket: Callable[[Any], Hashable] = lambda key: key
    ) -> None:
        self._processes, self._count, self._bucket = processes, worst, bucket
        self._worst: dict[Hashable, Kept] = {}
        self._pending: dict[Future[QualityResult], tuple[Any, QualityJob, bool]] = {}
        self._measured: dict[Any, QualityResult] = {}
        self._kept: dict[Any, Kept] = {}

    def submit(self, key: Any, job: QualityJob, *, keep: bool = False) -> None:
        """Submit a job under a sortable key; block while each worker has a job waiting."""
        if keep or self._count:
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
        """Wait until all jobs are measured: the next timing has the machine to itself."""
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
        return sorted(self._worst.values(), key=lambda kept: kept.rank, reverse=True)

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
            keep_worst(self._worst, kept, self._bucket(key), self._count)

    def _failed(self, key: Any, error: Exception) -> HmdwarpError:
        error = self._processes.explained(error)
        known = error if isinstance(error, HmdwarpError) else HmdwarpError(f"{type(error).__name__}: {error}")
        return type(known)(f"measuring picture {key} failed: {known}")
