"""What a command writes: files that are new, and folders of results that are whole or not there.

One rule holds for every command: what is there is not overwritten, but for a folder of results by
the command that made it; `force` (`--force`) overrides it.
"""

from __future__ import annotations

import itertools
import os
import re
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from ..base import InputError, MachineError, __version__
from ..base.documents import json_in
from ..base.named_files import RESULTS
from ..metrics import QUALITY, STAGES
from .files import Partial, keep_private, write_bytes, write_csv, write_error, write_json, write_png, write_text

_STAGING = ".partial-"
MARK = "hmdwarp"  # key of the version in the last file of a folder, by which it is known as ours


def refuse_existing(path: str | os.PathLike[str], *, force: bool = False) -> None:
    """Refuse to overwrite a file. Errors: InputError for one that exists, unless forced."""
    if not force and os.path.lexists(path) and not Path(path).is_dir():
        raise InputError(f"{path} exists already: choose another name, or overwrite it with --force")


class OutputFolder:
    """A folder of results that appears whole or not at all.

        with OutputFolder(path, owned=("images/*-left.png", "images/*-right.png")) as out:
            out.write_json("summary.json", summary)

    Making one checks at once, before a long run, that the folder can be made and written. Files go
    to a hidden folder inside it and get their names when the block ends without an error; otherwise
    they are deleted, and so is the folder if this made it. What a killed run left is deleted first.
    `last` is removed first and put there last: where it is, everything beside it is of one run.
    Files of an earlier run that match an `owned` pattern are removed; no other file is. Files in
    the way are overwritten only next to a `last` that hmdwarp wrote, or by force. A `private` one
    and its files are for their owner only.

    Errors: InputError if the folder cannot be written or holds such files of others, MachineError
    if the disk is full.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        owned: Sequence[str] = (),
        last: str = "summary.json",
        force: bool = False,
        private: bool = False,
    ) -> None:
        self.folder, self._private = Path(path), private
        self._owned, self._last = tuple(owned), last
        self._may_replace = force
        self._made: Path | None = None
        self._close: Callable[[], None] = lambda: None  # deletes the hidden folder
        try:
            missing = [p for p in (self.folder, *self.folder.parents) if not p.exists()]
            self._made = missing[-1] if missing else None
            self.folder.mkdir(parents=True, exist_ok=True)
            mode = 0o700 if private else 0o777
            staged = Partial.make(self.folder, _STAGING, mode=mode, is_folder=True, last=last)
            self._staging, self._close = staged.path, staged.close
            # A run that was killed while it gave the names has no `last` next to them.
            self._may_replace |= bool(staged.ended)
            self._refuse_others(path for pattern in (*self._owned, last) for path in self.folder.glob(pattern))
            probe = self._staging / "probe"
            with probe.open("wb") as file:
                file.write(bytes(4096))  # a file of 0 bytes fits on a full disk
                file.flush()
                os.fsync(file.fileno())
            probe.unlink()
        except BaseException as error:
            self.discard()
            if isinstance(error, OSError):
                raise write_error(error, self.folder) from error
            raise

    def path(self, name: str) -> Path:
        """Return the path to write a file to, in its subfolder. Errors: ValueError."""
        staged = self._staging / name
        if Path(name).is_absolute() or ".." in Path(name).parts:
            raise ValueError(f"'{name}' leads out of the output folder")
        try:
            staged.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise write_error(error, self.folder / name) from error
        return staged

    def write_bytes(self, name: str, content: bytes) -> None:
        self._write(name, write_bytes, content)

    def write_text(self, name: str, content: str) -> None:
        self._write(name, write_text, content)

    def write_json(self, name: str, value: Any) -> None:
        if name == self._last and MARK not in value:
            value = {MARK: __version__, **value}
        self._write(name, write_json, value)

    def write_csv(self, name: str, rows: Iterable[Mapping[str, Any]], columns: Sequence[str]) -> None:
        self._write(name, write_csv, rows, columns)

    def write_png(self, name: str, picture: NDArray[Any]) -> None:
        self._write(name, write_png, picture)

    def _write(self, name: str, writer: Any, *content: Any) -> None:
        staged = self.path(name)
        try:
            writer(staged, *content)
        except (InputError, MachineError) as error:
            # The message names the file the user will look for, not where it waits.
            raise type(error)(str(error).replace(str(staged), str(self.folder / name))) from error

    def commit(self) -> None:
        """Give every file its final name. Errors: InputError or MachineError, without `last`."""
        staged = sorted(p.relative_to(self._staging) for p in self._staging.rglob("*") if p.is_file())
        final = [p for p in staged if p != Path(self._last)] + [p for p in staged if p == Path(self._last)]
        self._refuse_others(self.folder / name for name in final)
        current = self.folder / self._last
        try:
            if self._private:
                keep_private(self.folder, *(self._staging / name for name in staged))
            current.unlink(missing_ok=True)
            for pattern in self._owned:
                for old in self.folder.glob(pattern):
                    if old.is_file() and old.relative_to(self.folder) not in staged:
                        old.unlink()
            for name in final:
                current = self.folder / name
                current.parent.mkdir(parents=True, exist_ok=True)
                if self._private:
                    keep_private(*(self.folder / parent for parent in name.parents))
                (self._staging / name).replace(current)
        except OSError as error:
            raise write_error(error, current) from error
        self._close()

    def _refuse_others(self, paths: Iterable[Path]) -> None:
        """Refuse to overwrite what another program wrote. Errors: InputError naming the first."""
        if self._may_replace:
            return
        with suppress(InputError):
            data = json_in(self.folder / self._last, RESULTS)
            if isinstance(data, dict) and MARK in data:
                return
        for path in paths:
            if os.path.lexists(path) and not path.is_dir():
                raise InputError(
                    f"{path} exists, in a folder without results of this command: choose another folder, or overwrite "
                    "it with --force"
                )

    def discard(self) -> None:
        """Delete the files written so far, and the folder if this made it and it is empty."""
        self._close()
        folder = self.folder
        while self._made is not None and folder.is_relative_to(self._made):
            try:
                folder.rmdir()
            except FileNotFoundError:
                pass  # making it failed
            except OSError:
                return  # someone else's file is in it by now
            folder = folder.parent

    def __enter__(self) -> OutputFolder:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is not None:
            self.discard()
            return
        try:
            self.commit()
        except BaseException:
            self.discard()
            raise


SCHEMA = 1

POSE_PARTS = ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")

# One row per frame and eye, of a replay and of a live run. Metrics are empty where a frame was not
# measured; a live run has those that need no truth.
FRAME_COLUMNS = (
    "frame",  # counts the shown frames from 0
    "eye",  # 0 left, 1 right
    "time_s",  # shown_ns since the start of the trace, in seconds; live: since the first picture
    "shown_ns",  # when the picture is seen
    "drawn_ns",  # when the late frame it was made from was drawn
    "age_ms",  # shown_ns - drawn_ns
    "pose_age_ms",  # from reading the head to handing the picture over; empty in a replay
    "pose_origin",  # how the shown pose was obtained: measured, interpolated, predicted, held
    "angular_speed_deg_s",
    "linear_speed_m_s",
    *(f"{stage}_ms" for stage in STAGES),
    *QUALITY,
    *(f"shown_{part}" for part in POSE_PARTS),  # world_from_head the picture was warped to
    "drawn_origin",  # how the pose the frame was drawn for was obtained
    *(f"drawn_{part}" for part in POSE_PARTS),  # world_from_head the frame was drawn for
    "warp",  # of this picture; the same in all rows unless warp "auto" or the user of a live run changed it
    "fill",
)

# What differs from run to run, and between machines: equal runs are equal in all else.
TIMED_COLUMNS = ("pose_age_ms", *(f"{stage}_ms" for stage in STAGES))
TIMED_KEYS = ("time_ms", "response_ms", "machine", "made_with", "hmdwarp", "notes", "digests")

SUMMARY_KEYS = (
    *("schema", "hmdwarp", "trace", "scene", "effects", "latency_ms", "warp", "fill", "lens", "headset", "size"),
    *("frames", "machine", "clock", "time_ms", "quality"),
)
MACHINE_KEYS = ("gl_renderer", "gl_version", "cpu_count")
CLOCKS = ("gpu", "wall")
_LARGEST = sys.float_info.max  # JSON may hold whole numbers beyond it
_MOST_PIXELS = 1 << 20  # on a side

_TEXTS = ("hmdwarp", "trace", "scene", "warp", "fill", "lens", "headset")


def validate_summary(summary: Mapping[str, Any]) -> None:
    """Check that this is a summary of this schema; unknown keys are fine.

    Numbers are finite; a figure may be None where nothing was measured.
    Errors: InputError that names every fault at once.
    """
    faults = summary_faults(summary)
    if faults:
        raise InputError(f"no summary of schema {SCHEMA}: {'; '.join(faults)}")


def summary_faults(summary: Any) -> list[str]:
    """Return the faults of a summary, one phrase each."""
    if not isinstance(summary, Mapping):
        return [f"it is a {type(summary).__name__}, expected an object"]
    faults = [f"'{key}' is missing" for key in SUMMARY_KEYS if key not in summary]
    for key, expected, fits in _CHECKS:
        if key in summary and not fits(summary[key]):
            faults.append(f"'{key}' is {summary[key]!r}, expected {expected}")
    for table, names, middle in (("time_ms", STAGES, "median"), ("quality", QUALITY, "mean")):
        for name, figure in itertools.product(names if table in summary else (), (middle, "p95")):
            try:
                value = summary[table][name][figure]
            except (LookupError, TypeError):
                faults.append(f"'{table}.{name}.{figure}' is missing")
            else:
                if value is not None and not _is_number(value):
                    faults.append(f"'{table}.{name}.{figure}' is {value!r}, expected a finite number or null")
    return faults


def _is_count(value: Any, least: int = 0) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= least


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and -_LARGEST <= value <= _LARGEST


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and value != ""


def _is_size(value: Any) -> bool:
    sides = value if isinstance(value, list | tuple) else ()
    return len(sides) == 2 and all(_is_count(side, 1) and side <= _MOST_PIXELS for side in sides)


_FACTOR = r"[1-9][0-9]*(\.[0-9]+)?"
_CHECKS: tuple[tuple[str, str, Callable[[Any], bool]], ...] = (
    ("schema", str(SCHEMA), lambda v: _is_count(v) and v == SCHEMA),
    *((key, "a text", _is_text) for key in _TEXTS),
    ("effects", "a list of names", lambda v: isinstance(v, list) and all(_is_text(name) for name in v)),
    ("latency_ms", "a number from 0", lambda v: _is_number(v) and v >= 0),
    ("size", "[w, h] in pixels", _is_size),
    ("frames", "a count", _is_count),
    (
        "machine",
        f"an object with {', '.join(MACHINE_KEYS)}",
        lambda v: isinstance(v, Mapping) and {*MACHINE_KEYS} <= {*v} and _is_count(v["cpu_count"], 1),
    ),
    ("clock", " or ".join(CLOCKS), lambda v: v in CLOCKS),
    # Optional, but read where they are.
    ("rate_hz", "a number above 0", lambda v: _is_number(v) and v > 0),
    ("server_rate_hz", "a number above 0, or null", lambda v: v is None or (_is_number(v) and v > 0)),
    (
        "guard",
        "a number from 1, or a text like 1.25x1.125",
        lambda v: (_is_number(v) and v >= 1) or bool(isinstance(v, str) and re.fullmatch(f"{_FACTOR}x{_FACTOR}", v)),
    ),
    ("predict", "a text", _is_text),
    ("strategy", "a text", _is_text),
)
