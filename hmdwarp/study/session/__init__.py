"""Session: the steps of a study on the live loop, each stored before the next thing happens."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .session_options import SessionOptions
from .sickness import counting, why_sick

if TYPE_CHECKING:
    from .program import run_session

__all__ = ["SessionOptions", "counting", "run_session", "why_sick"]


def __getattr__(name: str) -> Any:
    """Load run_session late: wrong options are refused before the display's libraries load."""
    if name == "run_session":
        from .program import run_session

        return run_session
    raise AttributeError(name)
