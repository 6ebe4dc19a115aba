"""The command line.

One thin file per command, each calling one function below. Heavy imports wait until a command runs.
"""

from __future__ import annotations

import errno
import os
import signal
import sys
from contextlib import suppress
from typing import NoReturn

from ._app import instead_of
from ._signals import INTERRUPTED, Ended, end_cleanly

# What the system says of names that users typed: too long, in a folder not to be read, in a circle.
_NAMES = (errno.ENAMETOOLONG, errno.EACCES, errno.EPERM, errno.ELOOP)
NOTHING_LEFT = "nothing unfinished was left behind"


def main() -> None:
    """Run the command line and leave with its exit status; an error of ours is a line on stderr."""
    from ..base import HmdwarpError, RequirementError

    end_cleanly()
    with suppress(AttributeError):  # closed (None), or a caller's own stream
        # '?' for a dash that the locale lacks, or a file name that is no text: no reason to end a
        # run that is done.
        sys.stdout.reconfigure(errors="replace")  # type: ignore[union-attr]
    try:
        from ._app import app

        status = app(
            standalone_mode=False, prog_name="hmdwarp"
        )  # hands back the status of a typer.Exit instead of raising it
        if sys.stdout is not None:
            sys.stdout.flush()  # here, where a full disk still gets its line
    except RequirementError as error:  # lines and tables
        print(f"hmdwarp: {error}", file=sys.stderr, flush=True)
        sys.exit(error.exit_status)
    except HmdwarpError as error:
        _leave((error.exit_status == 2 and instead_of(sys.argv[1:])) or str(error), error.exit_status)
    except KeyboardInterrupt:
        _leave(f"interrupted; {NOTHING_LEFT}", INTERRUPTED)
    except Ended as error:
        number = error.args[0]
        _leave(f"ended by {signal.Signals(number).name}; {NOTHING_LEFT}", 128 + number)
    except BrokenPipeError:
        _nobody_reads()
    except SystemExit as error:
        # Rich and newer typers make an exit of status 1 of it.
        if isinstance(error.__context__, BrokenPipeError):
            _nobody_reads()
        raise
    except Exception as error:
        _leave_by_unforeseen(error)
    else:
        if status == INTERRUPTED:  # how newer typers hand on Ctrl-C
            _leave(f"interrupted; {NOTHING_LEFT}", INTERRUPTED)
        sys.exit(status if isinstance(status, int) else 0)


def _nobody_reads() -> NoReturn:
    """Leave quietly: the reader of standard output has gone, as `head` does."""
    _forget_stdout()
    sys.exit(0)


def _forget_stdout() -> None:
    """Let what is still buffered go nowhere, else Python complains at exit."""
    with suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _leave_by_unforeseen(error: Exception) -> NoReturn:
    import typer

    if isinstance(error, typer.Abort):
        _leave(f"interrupted; {NOTHING_LEFT}", INTERRUPTED)
    if type(error).__name__ == "NoArgsIsHelpError":
        print(error.format_message())  # type: ignore[attr-defined]
        sys.exit(0)
    # Usage errors. Newer typers carry a click of their own, older ones use the real one: there is
    # no one base class to name.
    if hasattr(error, "format_message"):
        command = getattr(getattr(error, "ctx", None), "command_path", "hmdwarp")
        what = f"{error.format_message()} ('{command} --help' shows what there is)"
        _leave(instead_of(sys.argv[1:]) or what, 2)
    if os.environ.get("HMDWARP_DEBUG"):
        raise error
    if isinstance(error, OSError) and error.filename is None and error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
        _forget_stdout()
        _leave(f"cannot print the results ({error.strerror or error}): make room where standard output goes", 3)
    if isinstance(error, OSError) and error.filename is not None and error.errno in _NAMES:
        _leave(f"{error.filename}: {error.strerror}: expected a file or folder that this user can reach", 2)
    if isinstance(error, MemoryError):
        _leave("out of memory: use a smaller --size, a shorter --latency or fewer --images", 3)
    _leave(f"a fault of hmdwarp, please report it: {type(error).__name__}: {error} (HMDWARP_DEBUG=1 shows where)", 1)


def _leave(message: str, status: int) -> NoReturn:
    if sys.stderr is not None:
        with suppress(OSError):
            print(f"hmdwarp: {' '.join(message.split())}", file=sys.stderr, flush=True)
    sys.exit(status)
