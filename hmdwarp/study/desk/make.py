"""Which desk there is to be."""

from __future__ import annotations

import importlib.util
import os
import sys

from ...errors import InputError, MachineError
from ._base import Desk

KINDS = (AUTO, TERMINAL, LINES, NONE) = ("auto", "terminal", "lines", "none")


def make_desk(kind: str, title: str) -> Desk:
    """kind: one of KINDS; "auto" takes the terminal where it can, and lines where not. title: stands there before anything else does.

    Errors: InputError for another kind; MachineError where "terminal" is asked for and cannot be.
    """
    if kind not in KINDS:
        raise InputError(f"--desk {kind!r}: there are {', '.join(KINDS)}")
    why = why_no_terminal() if kind in (AUTO, TERMINAL) else ""
    if kind == TERMINAL and why:
        raise MachineError(f"--desk terminal: {why}; or use --desk lines")
    if kind == NONE:
        from .silent import NoDesk

        return NoDesk()
    if kind == LINES or why:
        from .lines import LinesDesk

        return LinesDesk(title, f"no screen for the experimenter: {why}" if why else "")
    from .terminal import TerminalDesk

    return TerminalDesk(title)


def why_no_terminal() -> str:
    """What keeps the experimenter's screen from being there, "" for nothing."""
    for name, stream in (("stdin", sys.stdin), ("stdout", sys.stdout)):
        if stream is None or stream.closed or not stream.isatty():
            return f"{name} is not a terminal"
    if os.environ.get("TERM", "dumb") in ("", "dumb"):
        return "TERM says that this terminal cannot place text (dumb, or not set)"
    if importlib.util.find_spec("prompt_toolkit") is None:
        return "prompt_toolkit is not installed: pip install 'hmdwarp[study]'"
    if sys.stdin.fileno() != 0 or sys.stdout.fileno() != 1:
        return "stdin and stdout are other files than the program was started with"
    if os.tcgetpgrp(0) != os.getpgrp():
        return "the program runs in the background"
    return ""
