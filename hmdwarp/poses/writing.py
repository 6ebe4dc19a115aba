"""Put a trace under its name only once it is whole."""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import IO

from ..errors import InputError, MachineError

_NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})


def write_whole(out: Path, write: Callable[[IO[str]], None], source: Path | None = None) -> None:
    """Call `write` with a text stream and move what it wrote to `out` in one step; a failure leaves nothing behind.

    source: a file that must not be overwritten. Errors: InputError naming `out` and why it cannot be written,
    MachineError for a full disk.
    """
    if out.is_dir():
        raise InputError(f"{out} is a directory: wanted the name of a file to write")
    if source is not None and out.exists() and source.exists() and out.samefile(source):
        raise InputError(f"{out} is the input itself: write to another file")
    temporary = None
    try:
        handle, temporary = tempfile.mkstemp(prefix=f".{out.name[:40]}.", dir=out.parent, text=False)
        with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as stream:
            write(stream)
        umask = os.umask(0)
        os.umask(umask)
        Path(temporary).chmod(0o666 & ~umask)  # mkstemp's 0600 is for secrets
        Path(temporary).replace(out)
        temporary = None
    except OSError as error:
        why = f"{out}: cannot be written ({error.strerror or error})"
        if error.errno in _NO_ROOM:
            raise MachineError(f"{why}: make room or choose another folder") from None
        raise InputError(f"{why}: choose a folder that you may write to") from None
    finally:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)
