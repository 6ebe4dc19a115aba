"""Processes that measure: an executor whose workers know nothing of the program that started them.

A worker neither imports the user's main script again nor hears the terminal's Ctrl-C, and ends with
the program even where that is killed. Nothing heavy is imported here.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from multiprocessing.context import SpawnContext, SpawnProcess
from types import ModuleType
from typing import IO, Any

from ..errors import HmdwarpError, MachineError
from ..platforms import lower_priority

_NICENESS = 5  # measuring must not slow down the loop whose passes are being timed
# More than one thread in a worker's BLAS would fight the other workers for the cores.
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_M_MMAP_MAX, _M_TRIM_THRESHOLD = -4, -1  # of glibc's malloc.h


class _Process(SpawnProcess):
    def start(self) -> None:
        main, sys.modules["__main__"] = sys.modules["__main__"], ModuleType("__main__")  # else imported there
        try:
            super().start()
        finally:
            sys.modules["__main__"] = main


class _Context(SpawnContext):
    """Starts such processes, and keeps them: they know how they ended."""

    def __init__(self) -> None:
        super().__init__()
        self.started: list[_Process] = []

    def Process(self, *args: Any, **how: Any) -> _Process:  # type: ignore[override]  # noqa: N802
        self.started.append(_Process(*args, **how))
        return self.started[-1]


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """Put signals that end the program off until the block has ended.

    A process that is started in it hears neither Ctrl-C nor a terminal that closes: what started it
    ends it. Python's own tracker of semaphores complains where it is ended first.
    """
    if sys.platform == "win32":
        yield
        return
    heard: list[int] = []
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP})
    # Another thread may get a signal for this one.
    is_main = threading.current_thread() is threading.main_thread()
    kept = (signal.SIGINT, signal.SIGHUP, signal.SIGTERM) if is_main else ()
    handlers = {number: signal.signal(number, lambda which, _: heard.append(which)) for number in kept}
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler or signal.SIG_DFL)
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
    threading.Thread(target=_end_with_the_program, daemon=True).start()


def _end_with_the_program() -> None:
    program = multiprocessing.parent_process()
    assert program is not None
    program.join()
    os._exit(1)


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
            return _run_here(work, *given)
        try:
            if self._open is None:
                with _without_interrupts():  # Python's tracker begins here, and unblocks Ctrl-C when it has
                    context, said = _Context(), tempfile.TemporaryFile()  # noqa: SIM115 (closed in close)
                    self._open = ProcessPoolExecutor(self.count, context, _begin, (said.fileno(),)), context, said
            with _without_interrupts():
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


def _run_here(work: Callable[..., Any], *given: Any) -> Future[Any]:
    done: Future[Any] = Future()
    try:
        done.set_result(work(*given))
    except Exception as error:
        done.set_exception(error)
    return done
