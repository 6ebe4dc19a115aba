"""Folder of a study's data, beside its file: the database, the lock and the traces."""

from __future__ import annotations

import errno
import os
from pathlib import Path

from ...errors import InputError, MachineError
from ...report import sync
from ..design import Design
from .lock import NAME as LOCK
from .records import ORIGINS, PERSON

DATABASE, TRACES = "study.sqlite3", "traces"
_OURS = {DATABASE, f"{DATABASE}-wal", f"{DATABASE}-shm", f"{DATABASE}-journal", LOCK, TRACES}
_PACKAGE = Path(__file__).resolve().parents[2]


def store_folder(design: Design, folder: Path | None, origin: str = PERSON) -> Path:
    """Return `folder`; without it `<stem>-data` beside the study's file.

    Pilots lie in `<stem>-pilot-data` and simulated participants in `<stem>-simulated-data`: no
    rehearsal stands in the way of the study. The data of a shipped study lie in the current folder.
    """
    if folder is not None:
        return Path(folder)
    file = Path(design.path or f"{design.name}.toml")
    shipped = file.resolve().is_relative_to(_PACKAGE)
    whose = "" if origin == PERSON else f"-{origin}"
    return (Path() if shipped else file.parent) / f"{file.stem}{whose}-data"


def folder_to_read(design: Design, folder: Path | None, origin: str) -> Path:
    """Return as store_folder. Errors: InputError where it holds no data, naming who has some."""
    found = store_folder(design, folder, origin)
    if (found / DATABASE).exists():
        return found
    others = {one: store_folder(design, None, one) for one in ORIGINS if folder is None and one != origin}
    there = [
        f"{at} is read {'without --' + origin if one == PERSON else 'with --' + one}"
        for one, at in others.items()
        if (at / DATABASE).exists()
    ]
    whose = "" if origin == PERSON else f", {origin},"
    hint = "".join(f"; {one}" for one in there)
    raise InputError(
        f"{found}: there are no data{whose} of '{design.name}' yet: run sessions first, or name their folder with "
        f"--store{hint}"
    )


def trace_name(sub: str, number: int, trial: int, turn: str, presentation: int) -> str:
    """Name the file of a head trace. trial: 0 for the practice. turn: as Show has it."""
    which = f"{trial}-{turn}" if turn else f"{trial}"
    return f"{sub}_ses-{number}_trial-{which}_{presentation}.csv"


def make_folders(folder: Path) -> None:
    """Create the folder and that of the traces, readable by the owner only, and sync them.

    Errors: InputError for a place that cannot be written, and for a folder of something else;
    MachineError for a full disk.
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
            f"{folder}: cannot be created ({why}): choose another folder for the study's data (--store)"
        ) from error


def check_place(folder: Path) -> None:
    """Check that make_folders can succeed, without creating anything.

    Errors: InputError, as there.
    """
    if folder.is_dir():
        _check_ours(folder)
    above = next(one for one in (folder, *folder.absolute().parents) if one.exists())
    if not above.is_dir() or not os.access(above, os.W_OK | os.X_OK):
        raise InputError(
            f"{folder}: cannot be created ({above} is not writable): choose another folder for the study's data "
            "(--store)"
        )


def _check_ours(folder: Path) -> None:
    others = sorted(one.name for one in folder.iterdir() if one.name not in _OURS)
    if others and not (folder / DATABASE).exists():
        raise InputError(
            f"{folder}: holds something else ({others[0]}): a study's data need a folder of their own (--store)"
        )


def sync_trace(path: Path) -> bool:
    """Sync a trace and its folder; False where there is no trace. Errors: MachineError."""
    try:
        sync(path)
        sync(path.parent)
    except FileNotFoundError:
        return False
    except OSError as error:
        raise MachineError(
            f"{path}: cannot be written to the disk ({error.strerror or error}): resume with a copy on another disk"
        ) from error
    return True
