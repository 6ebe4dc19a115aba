"""Folders of results: whole or not there."""

from __future__ import annotations

import os
import shutil
import uuid
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from ..errors import InputError, MachineError
from .files import write_bytes, write_csv, write_error, write_json, write_png, write_text


class OutputFolder:
    """A folder of results that appears whole or not at all.

        with OutputFolder(path, owned=("images/*-left.png", "images/*-right.png")) as out:
            out.write_json("summary.json", summary)
            video = VideoWriter(out.path("replay.mp4"), ...)

    Making one checks at once, before a long run, that the folder can be made and written. Files go
    to a hidden folder inside it and get their names when the block ends without an error; otherwise
    they are deleted, and so is the folder if this made it. `last` (summary.json) is removed first
    and put there last, so that where it is, everything beside it is of one run. Files of an earlier
    run that match an `owned` pattern and were not written again are removed; no other file is.

    Errors: InputError if the folder cannot be written, MachineError if the disk is full.
    """

    def __init__(self, path: str | os.PathLike, *, owned: Sequence[str] = (), last: str = "summary.json") -> None:
        self.folder = Path(path)
        self._owned, self._last = tuple(owned), last
        self._made: Path | None = None
        self._staging = self.folder / f".partial-{uuid.uuid4().hex[:8]}"
        try:
            self._made = _first_missing(self.folder)
            self._staging.mkdir(parents=True)
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
        self._write(name, write_json, value)

    def write_csv(self, name: str, rows: Iterable[Mapping[str, Any]], columns: Sequence[str]) -> None:
        self._write(name, write_csv, rows, columns)

    def write_png(self, name: str, picture: NDArray) -> None:
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
        current = self.folder / self._last
        try:
            current.unlink(missing_ok=True)
            for pattern in self._owned:
                for old in self.folder.glob(pattern):
                    if old.is_file() and old.relative_to(self.folder) not in staged:
                        old.unlink()
            for name in final:
                current = self.folder / name
                current.parent.mkdir(parents=True, exist_ok=True)
                (self._staging / name).replace(current)
        except OSError as error:
            raise write_error(error, current) from error
        shutil.rmtree(self._staging)

    def discard(self) -> None:
        """Delete the files written so far, and the folder if this made it and it is empty."""
        shutil.rmtree(self._staging, ignore_errors=True)
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


def _first_missing(path: Path) -> Path | None:
    """Return the outermost folder of `path` that does not exist yet, None if all do."""
    missing = [p for p in (path, *path.parents) if not p.exists()]
    return missing[-1] if missing else None
