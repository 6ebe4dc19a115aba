"""One process that measures: started here, and what it says when it ends too early."""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..errors import HmdwarpError, MachineError

_BOOT = "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from hmdwarp.metrics.worker import main; main()"
_ENVIRONMENT = {
    # More than one thread in a worker's BLAS would fight the other workers for the cores.
    **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"),
    # glibc returns every freed picture to the system, which clears its pages for the next one: a
    # seventh of the time. A worker keeps the memory of its largest job instead.
    "MALLOC_MMAP_MAX_": "0",
    "MALLOC_TRIM_THRESHOLD_": str(2**62),
}


class MeasuringProcess:
    """A process that applies one function to what it is asked, and the pipes to it.

    work: a function or an object with a call, pickled to the process. remedy: what to do when the
    process ends by itself, for the message.
    """

    def __init__(self, work: Callable[[Any], Any], remedy: str) -> None:
        path = [str(Path(entry).resolve()) for entry in sys.path if isinstance(entry, str)]
        self._remedy = remedy
        self._complaints = tempfile.TemporaryFile()  # noqa: SIM115 (closed in close)
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-c", _BOOT, json.dumps(path)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._complaints,
                env={**os.environ, **_ENVIRONMENT},
                process_group=0,  # so that the terminal's Ctrl-C reaches only the loop, which then ends the workers
            )
        except OSError as error:
            self._complaints.close()
            raise MachineError(
                f"cannot start a measuring process ({error.strerror or error}): use 0 metric workers"
            ) from error
        self._first = pickle.dumps(work)

    def ask(self, what: object) -> Any:
        """Return what the function makes of it there.

        Errors: the function's own, or HmdwarpError if the process is gone.
        """
        assert self._process.stdin is not None and self._process.stdout is not None
        try:
            if self._first:
                self._process.stdin.write(self._first)
                self._first = b""
            pickle.dump(what, self._process.stdin, protocol=5)
            self._process.stdin.flush()
            answer = pickle.load(self._process.stdout)
        except (OSError, EOFError, pickle.UnpicklingError, ValueError) as error:
            raise HmdwarpError(self._obituary()) from error
        if isinstance(answer, Exception):
            raise answer
        return answer

    def kill(self) -> None:
        """End the process at once; a thread that waits for its answer gets an error."""
        self._process.kill()

    def close(self) -> None:
        """Let the process end by itself and free its pipes; safe to call again."""
        assert self._process.stdin is not None and self._process.stdout is not None
        with contextlib.suppress(OSError):  # the buffered bytes have no reader any more
            self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()
        self._complaints.close()

    def _obituary(self) -> str:
        # Its pipes were closed before it; one that only closed them would never end by itself.
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(timeout=5)
        self._process.kill()
        status = self._process.wait()
        why = f"exit status {status}" if status >= 0 else signal.strsignal(-status)
        why = "killed, perhaps for memory" if status == -9 else why
        self._complaints.seek(0)
        lines = self._complaints.read().decode(errors="replace").strip().splitlines()
        return f"a measuring process ended ({why}){': ' + lines[-1] if lines else ''}; {self._remedy}"
