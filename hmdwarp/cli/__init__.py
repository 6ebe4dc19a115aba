"""The command line: one thin file per command, each calling one function below. Heavy imports wait until a command runs."""

from __future__ import annotations

import os
import sys

INTERRUPTED = 130  # the shells' status for Ctrl-C


def main() -> None:
    """Run the command line and leave with its exit status; every error of ours is one line on stderr."""
    from ..errors import HmdwarpError
    from ._app import app

    try:
        status = app(standalone_mode=False, prog_name="hmdwarp")  # hands back the status of a typer.Exit instead of raising it
    except HmdwarpError as error:
        _leave(str(error), error.exit_status)
    except KeyboardInterrupt:
        _leave("interrupted; nothing unfinished was left behind", INTERRUPTED)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # else Python complains once more at exit
        sys.exit(0)
    except Exception as error:
        _leave_by_unforeseen(error)
    else:
        sys.exit(status if isinstance(status, int) else 0)


def _leave_by_unforeseen(error: Exception) -> None:
    import typer

    if isinstance(error, typer.Abort):
        _leave("interrupted; nothing unfinished was left behind", INTERRUPTED)
    if type(error).__name__ == "NoArgsIsHelpError":
        print(error.format_message())
        sys.exit(0)
    # Usage errors. Newer typers carry a click of their own, older ones use the real one: there is no one base class to name.
    if hasattr(error, "format_message"):
        command = getattr(getattr(error, "ctx", None), "command_path", "hmdwarp")
        _leave(f"{error.format_message()} ('{command} --help' shows what there is)", 2)
    if os.environ.get("HMDWARP_DEBUG"):
        raise error
    _leave(f"a fault of hmdwarp, please report it: {type(error).__name__}: {error} (HMDWARP_DEBUG=1 shows where)", 1)


def _leave(message: str, status: int) -> None:
    print(f"hmdwarp: {' '.join(message.split())}", file=sys.stderr)
    sys.exit(status)
