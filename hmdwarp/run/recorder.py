"""Write head poses to a trace file as they arrive."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path

from ..poses import Origin, PoseSample
from ..poses.formats.native import header_text, row_text
from ..report import counted
from ..resources import __version__
from .lines import Lines

LEAST = 2  # one pose is no motion, and no trace reader accepts it
_TAIL = 4096  # bytes: longer than any row


class Recorder:
    """A native trace whose poses are on the disk half a second after they arrive.

    Use as a context manager.

    The file is created at once, so that a path that cannot be written fails at the start. Poses
    held while tracking is lost are left out, which leaves a gap; so are those whose time does not
    increase. With fewer than two poses the file is removed again.
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
        """Create the file.

        path: a new file, unless forced. say: called with a sentence at the end, and where a clock
        jumps.
        """
        self.path, self._say, self._by = path, say, by
        self.count = self.held = self.behind = 0
        self._first_ns = self._last_ns = 0
        self._begun = False
        self._header_lines = 0
        self._lines = Lines(path, synced=True, force=force)

    @property
    def seconds(self) -> float:
        """Time from the first pose to the last."""
        return (self._last_ns - self._first_ns) * 1e-9

    def begin(self, about: Mapping[str, str], rate_hz: float) -> None:
        """Write the header.

        about: the recorded display, by name; rate_hz: of the poses.
        """
        self._begun = True
        started = datetime.now(UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
        notes = [
            f"recorded: {started}, hmdwarp {__version__}; time_ns is the source's own clock, poses are as they were "
            "asked for"
        ]
        header = header_text(origin_of(self._by, about), rate_hz, notes)
        self._header_lines = header.count("\n")
        self._lines.add(header)

    def add(self, head: PoseSample) -> None:
        """Add a pose."""
        if head.origin is Origin.HELD:
            self.held += 1
        elif self.count and head.time_ns <= self._last_ns:
            self._fell_behind(head.time_ns)
        else:
            self._lines.add(row_text(head.time_ns, head.pose))
            if not self.count:
                self._first_ns = head.time_ns
            self.count, self._last_ns = self.count + 1, head.time_ns

    def _fell_behind(self, time_ns: int) -> None:
        self.behind += 1
        if self.behind == 1:
            back_s = (self._last_ns - time_ns) * 1e-9
            why = f"the clock went back by {back_s:.3f} s" if back_s else "the same instant came twice"
            self._say(f"recording: {why}; poses are left out until time has gone on")

    def flush(self) -> None:
        """Put the poses so far on the disk; from any thread."""
        self._lines.flush()

    def save(self) -> str:
        """Flush, and return where the recording is, "" if there is none; from any thread.

        For a program that cannot close its files any more.
        """
        answered = self._lines.flush()
        if not self._is_worth_keeping():
            return ""
        return f"the recording until then is in {self.path}" + (
            "" if answered else ", but for its end: the disk does not answer"
        )

    def _end(self) -> None:
        try:
            self._lines.close()
        finally:
            self._is_worth_keeping()
            if self._begun:
                self._say(self.describe())

    @property
    def kept(self) -> int:
        """Number of poses that the disk has taken."""
        return max(0, self._lines.written - self._header_lines)

    def _is_worth_keeping(self) -> bool:
        """Return whether the recording can be read; remove one that cannot."""
        if self.kept >= LEAST:
            return True
        if self.count < LEAST or self._lines.failed:  # else a slow disk may still take them
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
        return f"{self.path}: {counted(self.kept, 'pose')}, {self._kept_s():.3f} s{beside}"

    def _kept_s(self) -> float:
        """Return the seconds from the first pose to the last on the disk."""
        if self.kept == self.count:
            return self.seconds
        with self.path.open("rb") as file:
            file.seek(-min(_TAIL, file.seek(0, os.SEEK_END)), os.SEEK_END)
            last = file.read().splitlines()[-1]
        return (int(last.split(b",")[0]) - self._first_ns) * 1e-9

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self._end()
            return
        with suppress(Exception):  # the exception that ended the run matters more
            self._end()


def origin_of(by: str, about: Mapping[str, str]) -> str:
    """Return the origin for a trace: "hmdwarp live, Monado 25.0, headset 'Simulated'"."""
    runtime, version = about.get("runtime", ""), about.get("runtime_version", "")
    if version not in runtime:  # most runtimes have it in their names
        runtime = f"{runtime} {version}".strip()
    others = [f"{name} '{value}'" for name, value in about.items() if value and not name.startswith("runtime")]
    return ", ".join(filter(None, (by, runtime, *others)))
