"""Write head poses to a trace file as they arrive."""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import nullcontext, suppress
from datetime import UTC, datetime
from pathlib import Path

from ..base import HmdwarpError, MachineError, __version__
from ..poses import Origin, PoseSample
from ..poses.formats import header_text, row_text
from ..report import counted, refuse_existing, write_error
from ..scenes import INPUTS_HEADER, InputEvent, inputs_beside

EVERY_S = 0.5  # plus the disk's own time, well below the second of data that a crash may cost
MOST_WAITING = 1 << 24  # characters: twenty minutes of poses at 90 Hz
PATIENCE_S = 5.0  # how long to wait at the end for a disk that does not answer


class Lines:
    """A new file; a thread of its own writes lines to the disk every half second.

    path: must not exist yet, unless forced. synced: whether to fsync each time, against a power
    cut. The file always holds whole lines, also after the disk was full.
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
        self.error: HmdwarpError | None = None  # why nothing is written any more
        self._writing, self._ending = threading.Lock(), threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"writes {path.name}", daemon=True)
        self._thread.start()

    def add(self, text: str) -> None:
        """Add one or several lines, each with its newline, in about a microsecond.

        Errors: MachineError for a disk that is full, gone, or so slow that too much waits.
        """
        if self.error is not None:
            raise self.error
        self._waiting.append(text)
        self._added += len(text)
        if self._added - self._taken > MOST_WAITING:
            raise MachineError(
                f"{self.path}: cannot write (the disk does not answer, {MOST_WAITING >> 20} MB wait): use another one"
            )

    def flush(self, patience_s: float = PATIENCE_S) -> bool:
        """Write the waiting lines now, from any thread; return whether the disk answers in time."""
        if not self._writing.acquire(timeout=patience_s):
            return False
        try:
            self._write()
        finally:
            self._writing.release()
        return True

    def close(self) -> None:
        """Write the waiting lines, and close the file; safe to call twice. Errors: as add."""
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
        if self.error is not None:
            raise self.error

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
        if self.error is None:
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
            self.error = write_error(error, self.path)
            done = data.rfind(b"\n", 0, done) + 1
            self._cut(self._bytes + done)
        self._bytes += done
        self.written += data.count(b"\n", 0, done)

    def _cut(self, size: int) -> None:
        with suppress(OSError):  # a disk that is gone: nothing can be done
            os.ftruncate(self._file, size)


LEAST = 2  # one pose is no motion, and no trace reader accepts it


class Recorder:
    """A native trace whose poses are on the disk half a second after they arrive; a context.

    Poses held while tracking is lost are left out, which leaves a gap; so are those whose time does
    not increase. With fewer than two poses the file is removed again. say: called with a sentence
    at the end, and where a clock jumps.
    Errors: InputError for an existing file or a path that cannot be written; MachineError, from add
    and at the end, for a full disk: the lines written before stay, whole.
    """

    def __init__(
        self,
        path: Path,
        say: Callable[[str], None] = lambda text: None,
        by: str = "hmdwarp live",
        *,
        force: bool = False,
    ) -> None:
        self.path, self._say, self._by = path, say, by
        self.count = self.held = self.behind = 0
        self._first_ns = self._last_ns = 0
        self._begun = False
        self._header_lines = 0
        # Beside the trace, once there is an input.
        self.inputs_path = inputs_beside(path)
        self._inputs: Lines | None = None
        refuse_existing(self.inputs_path, force=force)
        self._lines = Lines(path, synced=True, force=force)

    def begin(self, about: Mapping[str, str], rate_hz: float) -> None:
        """Write the header. about: the recorded display, by name; rate_hz: of the poses."""
        self._begun = True
        self.inputs_path.unlink(missing_ok=True)  # of a recording that is overwritten
        started = datetime.now(UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
        notes = [
            f"recorded: {started}, hmdwarp {__version__}; time_ns is the source's own clock, poses are as they were "
            "asked for"
        ]
        header = header_text(origin_of(self._by, about), rate_hz, notes)
        self._header_lines = header.count("\n")
        self._lines.add(header)

    def add(self, head: PoseSample) -> None:
        if head.origin is Origin.HELD:
            self.held += 1
        elif self.count and head.time_ns <= self._last_ns:
            self.behind += 1
            if self.behind == 1:
                back_s = (self._last_ns - head.time_ns) * 1e-9
                why = f"the clock went back by {back_s:.3f} s" if back_s else "the same instant came twice"
                self._say(f"recording: {why}; poses are left out until time has gone on")
        else:
            self._lines.add(row_text(head.time_ns, head.pose))
            if not self.count:
                self._first_ns = head.time_ns
            self.count, self._last_ns = self.count + 1, head.time_ns

    def act(self, event: InputEvent) -> None:
        """Add what somebody did, on the clock of the poses."""
        if self._inputs is None:
            self._inputs = Lines(self.inputs_path, synced=True)
            self._inputs.add(INPUTS_HEADER)
        self._inputs.add(event.row)

    def flush(self) -> None:
        for lines in self._files:
            lines.flush()

    @property
    def _files(self) -> list[Lines]:
        return [lines for lines in (self._inputs, self._lines) if lines is not None]

    def save(self) -> str:
        """Flush, and return where the recording is, "" if there is none; from any thread."""
        answered = min([lines.flush() for lines in self._files])
        if not self._is_worth_keeping():
            return ""
        late = "" if answered else ", but for its end: the disk does not answer"
        return f"the recording until then is in {self.path}{late}"

    @property
    def kept(self) -> int:
        return max(0, self._lines.written - self._header_lines)

    def _is_worth_keeping(self) -> bool:
        """Return whether the recording can be read; remove one that cannot."""
        if self.kept >= LEAST:
            return True
        if self.count < LEAST or self._lines.error is not None:  # else a slow disk may still take them
            with suppress(OSError):
                if self._begun or not self.path.stat().st_size:  # else an old file that was to be overwritten
                    self.path.unlink()
        return False

    def describe(self) -> str:
        """Return a sentence on what was recorded and is on the disk; for the end."""
        counts = (
            (self.held, "held (tracking lost)"),
            (self.behind, "whose time did not rise"),
            (self.count - self.kept, "lost, as the disk did not take them"),
        )
        left_out = ", ".join(f"{count} {what}" for count, what in counts if count)
        beside = f"; left out: {left_out}" if left_out else ""
        if self.kept < LEAST:
            came = counted(self.count, "pose") if self.count else "no pose"
            return f"{self.path}: nothing recorded, {came} came{beside}"
        length = f", {(self._last_ns - self._first_ns) * 1e-9:.3f} s" if self.kept == self.count else ""
        acted = f"; {self.inputs_path.name}: {counted(self._inputs.written - 1, 'input')}" if self._inputs else ""
        return f"{self.path}: {counted(self.kept, 'pose')}{length}{acted}{beside}"

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        with nullcontext() if kind is None else suppress(Exception):  # the exception that ended the run matters more
            try:
                for lines in self._files:
                    lines.close()
            finally:
                self._is_worth_keeping()
                if self._begun:
                    self._say(self.describe())


def origin_of(by: str, about: Mapping[str, str]) -> str:
    """Return the origin for a trace: "hmdwarp live, Monado 25.0, headset 'Simulated'"."""
    runtime, version = about.get("runtime", ""), about.get("runtime_version", "")
    if version not in runtime:  # most runtimes have it in their names
        runtime = f"{runtime} {version}".strip()
    others = [f"{name} '{value}'" for name, value in about.items() if value and not name.startswith("runtime")]
    return ", ".join(filter(None, (by, runtime, *others)))
