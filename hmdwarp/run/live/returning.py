"""Waiting for a runtime that went away."""

from __future__ import annotations

import time
from collections.abc import Callable

from ...display import Lost
from .ending import Ending

RETRY_S = 0.5


def come_back(
    reopen: Callable[[], bool], lost: Lost, wait_s: float, ending: Ending, say: Callable[[str], None]
) -> bool:
    """Try again and again until it is there; False if somebody asked for the end first. Errors: Lost, once it has taken too long."""
    say(f"{lost}; waiting up to {wait_s:g} s for it to come back (Ctrl-C ends)")
    until = time.monotonic() + wait_s
    while time.monotonic() < until:
        if ending.asked is not None:
            return False
        if reopen():
            say("it is back")
            return True
        time.sleep(RETRY_S)
    raise Lost(f"{lost}; it has not come back within {wait_s:g} s")
