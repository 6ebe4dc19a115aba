"""Where a study's data lie: a folder beside its file, with the database, the lock and the traces."""

from __future__ import annotations

import errno
import os
from pathlib import Path

from ...errors import InputError, MachineError
from ..design import Design
from .lock import NAME as LOCK

FILE, TRACES = "study.sqlite3", "traces"
_OURS = {FILE, f"{FILE}-wal", f"{FILE}-shm", f"{FILE}-journal", LOCK, TRACES}
_PACKAGE = Path(__file__).resolve().parents[2]


def store_folder(design: Design, given: Path | None) -> Path:
    """The one asked for; else `<stem>-data` beside the study's file, for one that came with the program in the current folder."""
    if given is not None:
        return Path(given)
    file = Path(design.path or f"{design.name}.toml")
    shipped = file.resolve().is_relative_to(_PACKAGE)
    return (Path() if shipped else file.parent) / f"{file.stem}-data"


def trace_name(sub: str, number: int, trial: int, presentation: int) -> str:
    """Of a head's recording. trial: 0 for the practice."""
    return f"{sub}_ses-{number}_trial-{trial}_{presentation}.csv"


def make_folders(folder: Path) -> None:
    """The folder and the one for its traces, for its owner's eyes alone, and on the disk.

    Errors: InputError for a place that cannot be written, and for a folder that holds something else; MachineError for a full disk.
    """
    try:
        if folder.is_dir():
            _check_ours(folder)
        else:
            folder.mkdir(mode=0o700, parents=True)
            sync(folder.parent)
        (folder / TRACES).mkdir(mode=0o700, exist_ok=True)
        sync(folder)
    except OSError as error:
        why = error.strerror or str(error)
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
            raise MachineError(
                f"{folder}: cannot write ({why}): make room, or choose another folder (--store)"
            ) from error
        raise InputError(
            f"{folder}: cannot be made ({why}): choose another folder for the study's data (--store)"
        ) from error


def check_place(folder: Path) -> None:
    """Whether make_folders has a chance; nothing is made. Errors: InputError, as there."""
    if folder.is_dir():
        _check_ours(folder)
    above = next(one for one in (folder, *folder.absolute().parents) if one.exists())
    if not above.is_dir() or not os.access(above, os.W_OK | os.X_OK):
        raise InputError(
            f"{folder}: cannot be made ({above} may not be written to): choose another folder for the study's data (--store)"
        )


def _check_ours(folder: Path) -> None:
    others = sorted(one.name for one in folder.iterdir() if one.name not in _OURS)
    if others and not (folder / FILE).exists():
        raise InputError(
            f"{folder}: holds something else ({others[0]}): a study's data need a folder of their own (--store)"
        )


def sync_trace(path: Path) -> bool:
    """Put a trace on the disk, its name in the folder too; False where there is none. Errors: MachineError."""
    try:
        sync(path)
        sync(path.parent)
    except FileNotFoundError:
        return False
    except OSError as error:
        raise MachineError(
            f"{path}: the disk does not take it ({error.strerror or error}): go on with a copy on another disk"
        ) from error
    return True


def sync(path: Path) -> None:
    """Put on the disk that files came, went, or have new names; of a file, what is in it. Errors: OSError."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
