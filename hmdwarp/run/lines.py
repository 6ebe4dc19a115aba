"""Lines of text written to a growing file without stalling the loop on a slow disk."""

from __future__ import annotations

import os
import threading
from collections import deque
from contextlib import suppress
from pathlib import Path

from ..errors import HmdwarpError, MachineError
from ..report import refuse_existing, write_error

EVERY_S = 0.5  # plus the disk's own time, well below the second of data that a crash may cost
MOST_WAITING = 1 << 24  # characters: twenty minutes of poses at 90 Hz
PATIENCE_S = 5.0  # how long to wait at the end for a disk that does not answer


class Lines:
    """A new file; a thread of its own writes lines to the disk every half second.

    path: must not exist yet, unless forced. synced: whether to fsync each time, so that even a
    power cut costs no more than a second. The file always holds whole lines, also after the disk
    was full.
    Errors: InputError for a path that cannot be written, and for a file that exists.
    """

    def __init__(self, path: Path, *, synced: bool = False, force: bool = False) -> None:
        self.path, self._synced = path, synced
        # Lines that the disk has taken.
        self.written = 0
        refuse_existing(path, force=force)
        try:
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | (0 if force else os.O_EXCL), 0o666)
        except OSError as error:
            raise write_error(error, path) from error
        self._waiting: deque[str] = deque()
        # Each is written by one thread alone, so that counting needs no lock.
        self._added = self._taken = 0
        self._bytes = 0
        self._error: HmdwarpError | None = None
        self._writing, self._ending = threading.Lock(), threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"writes {path.name}", daemon=True)
        self._thread.start()

    def add(self, text: str) -> None:
        """Add one or several lines, each with its newline. Takes about a microsecond.

        Errors: MachineError (or InputError) for a disk that is full, gone, or so slow that too much
        waits.
        """
        if self._error is not None:
            raise self._error
        self._waiting.append(text)
        self._added += len(text)
        if self._added - self._taken > MOST_WAITING:
            raise MachineError(
                f"{self.path}: cannot write (the disk does not answer, {MOST_WAITING >> 20} MB wait): use another one"
            )

    def flush(self, patience_s: float = PATIENCE_S) -> bool:
        """Write the waiting lines now; from any thread.

        Return False if the disk does not answer in time.
        """
        if not self._writing.acquire(timeout=patience_s):
            return False
        try:
            self._write()
        finally:
            self._writing.release()
        return True

    @property
    def failed(self) -> bool:
        """Whether the disk has refused lines; it takes none afterwards."""
        return self._error is not None

    def close(self) -> None:
        """Write the waiting lines, and close the file.

        Safe to call twice. Errors: as add, for lines that could not be written.
        """
        if self._file < 0:
            return
        self._ending.set()
        self._thread.join(PATIENCE_S)
        if self._thread.is_alive() or not self.flush():
            raise MachineError(
                f"{self.path}: cannot write (the disk does not answer): what it had taken before is there"
            )
        os.close(self._file)
        self._file = -1
        if self._error is not None:
            raise self._error

    def _run(self) -> None:
        while not self._ending.wait(EVERY_S):
            with self._writing:
                self._write()

    def _write(self) -> None:
        """Write the waiting lines. The caller holds the lock."""
        count = len(self._waiting)
        if not count or self._file < 0:
            return
        text = "".join([self._waiting.popleft() for _ in range(count)])
        if self._error is None:
            self._put(text.encode(errors="replace"))
        self._taken += len(text)

    def _put(self, data: bytes) -> None:
        done = 0
        if not self._bytes:  # only now: a run that never begins leaves the old file
            self._cut(0)
        try:
            while done < len(data):
                done += os.write(self._file, memoryview(data)[done:])
            if self._synced:
                os.fsync(self._file)
        except OSError as error:
            self._error = write_error(error, self.path)
            done = data.rfind(b"\n", 0, done) + 1
            self._cut(self._bytes + done)
        self._bytes += done
        self.written += data.count(b"\n", 0, done)

    def _cut(self, size: int) -> None:
        with suppress(OSError):  # a disk that is gone: nothing can be done
            os.ftruncate(self._file, size)
