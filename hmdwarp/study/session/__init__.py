"""Session: the steps of a study on the live loop, each stored before the next thing happens.

Imports are lazy: wrong options are refused before the display's libraries load.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .program import run_session
    from .session_context import head_angles_deg
    from .session_facts import facts_of
    from .session_options import SessionOptions
    from .sickness import counting, why_sick
    from .trial_runner import first_picture_wait_s

_HOME = {
    "SessionOptions": "session_options",
    "counting": "sickness",
    "facts_of": "session_facts",
    "run_session": "program",
    "head_angles_deg": "session_context",
    "first_picture_wait_s": "trial_runner",
    "why_sick": "sickness",
}

__all__ = [
    "SessionOptions",
    "counting",
    "facts_of",
    "first_picture_wait_s",
    "head_angles_deg",
    "run_session",
    "why_sick",
]


def __getattr__(name: str) -> Any:
    """Import the module of a public name when it is first used."""
    if name not in _HOME:
        raise AttributeError(name)
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
