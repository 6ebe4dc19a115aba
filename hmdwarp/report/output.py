"""What a command writes: files that are new, and folders of results that are whole or not there.

One rule holds for every command: what is there is not overwritten, but for a folder of results by
the command that made it; `force` (`--force`) overrides it.
"""

from __future__ import annotations

import os
import shutil
import uuid
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from ..errors import InputError, MachineError
from ..options.documents import json_in
from ..options.named_files import RESULTS
from ..resources import __version__
from .files import keep_private, lock, write_bytes, write_csv, write_error, write_json, write_png, write_text

STAGING = ".partial-"
MARK = "hmdwarp"  # key of the version in the last file of a folder, by which it is known as ours


def refuse_existing(path: str | os.PathLike[str], *, force: bool = False) -> None:
    """Refuse to overwrite a file. Errors: InputError for one that exists, unless forced."""
    if not force and os.path.lexists(path) and not Path(path).is_dir():
        raise InputError(f"{path} exists already: choose another name, or overwrite it with --force")


class OutputFolder:
    """A folder of results that appears whole or not at all.

        with OutputFolder(path, owned=("images/*-left.png", "images/*-right.png")) as out:
            out.write_json("summary.json", summary)
            video = VideoWriter(out.path("replay.mp4"), ...)

    Making one checks at once, before a long run, that the folder can be made and written. Files go
    to a hidden folder inside it and get their names when the block ends without an error; otherwise
    they are deleted, and so is the folder if this made it. What a killed run left of that kind is
    deleted first. `last` (summary.json) is removed first and put there last, so that where it is,
    everything beside it is of one run. Files of an earlier run that match an `owned` pattern and
    were not written again are removed; no other file is.

    A `private` one and its files are for their owner only.

    Files in the way are overwritten only next to a `last` that hmdwarp wrote, or by force.

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
        self._staging = self.folder / f"{STAGING}{uuid.uuid4().hex[:8]}"
        self._lock = -1
        try:
            self._made = _first_missing(self.folder)
            self.folder.mkdir(parents=True, exist_ok=True)
            with _locked(self.folder):  # else another run takes a folder just made for one left behind
                # One that was killed while it gave the names has no `last` next to them.
                self._may_replace |= self._clean_up()
                self._refuse_others(path for pattern in (*self._owned, last) for path in self.folder.glob(pattern))
                self._staging.mkdir(mode=0o700 if private else 0o777)
                self._lock = _lock(self._staging)
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
        """Return the path to write the file `name` to; its subfolders are made.

        Errors: ValueError for a name outside the folder.
        """
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
        self._remove_staging()

    def _clean_up(self) -> bool:
        """Delete what killed runs left; return whether one of them was giving the names."""
        interrupted = False
        for left in self.folder.glob(f"{STAGING}*"):
            if (lock := _lock(left)) < 0:
                continue  # of a run that still lives
            interrupted |= (left / self._last).exists()
            shutil.rmtree(left, ignore_errors=True)
            os.close(lock)
        return interrupted

    def _refuse_others(self, paths: Iterable[Path]) -> None:
        """Refuse to overwrite what another program wrote. Errors: InputError naming the first."""
        if self._may_replace or self._is_ours():
            return
        for path in paths:
            if os.path.lexists(path) and not path.is_dir():
                raise InputError(
                    f"{path} exists, in a folder without results of this command: choose another folder, or overwrite "
                    "it with --force"
                )

    def _is_ours(self) -> bool:
        with suppress(InputError):
            data = json_in(self.folder / self._last, RESULTS)
            return isinstance(data, dict) and MARK in data
        return False

    def _remove_staging(self) -> None:
        shutil.rmtree(self._staging, ignore_errors=True)
        if self._lock >= 0:
            os.close(self._lock)
            self._lock = -1

    def discard(self) -> None:
        """Delete the files written so far, and the folder if this made it and it is empty."""
        self._remove_staging()
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


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Keep other runs from looking for staging folders while the block lasts."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        lock(handle, wait=True)
        yield
    finally:
        os.close(handle)


def _lock(folder: Path) -> int:
    """Return a handle that locks the folder until it is closed; -1 where it cannot be locked."""
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:
        return -1
    if lock(handle):
        return handle
    os.close(handle)
    return -1


def _first_missing(path: Path) -> Path | None:
    """Return the outermost folder of `path` that does not exist yet, None if all do."""
    missing = [p for p in (path, *path.parents) if not p.exists()]
    return missing[-1] if missing else None
