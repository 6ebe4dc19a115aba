"""Calls into the runtime: watched, because a hung service never answers; results become errors."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import xr
from xr import raw_functions

from ...errors import HmdwarpError, MachineError
from .. import Lost
from .diagnosis import LOST, diagnose, manifest_text

# Results that only a caller who violates the specification gets.
_WRONG = ("CallOrderInvalid", "HandleInvalid", "LayerInvalid", "PoseInvalid", "TimeInvalid", "ValidationFailure")


class Calls:
    """Calls into one runtime.

    stage: progress on the way to a picture, as in diagnosis.STAGES. name: the runtime's, for
    messages.
    """

    def __init__(self, watching: Callable[[str], AbstractContextManager[object]]) -> None:
        self._watching = watching
        self._functions: dict[str, Any] = {}
        self.begin()

    def begin(self) -> None:
        """Reset the stage."""
        self.stage, self.name = "runtime", "the runtime"

    def call_once(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a pyopenxr function that is used once.

        Errors: MachineError; Lost during a session.
        """
        call = "xr" + function.__name__.title().replace("_", "")
        try:
            with self._watching(call):
                return function(*arguments)
        except xr.XrException as error:
            raise self._error(call, type(error).__name__, str(error)) from error

    def __call__(self, call: str, *arguments: Any) -> int:
        """Call a loader function by its C name, at every refresh: 2 us instead of 10.

        Returns its result, 0 or above. Errors: as call_once.
        """
        function = self._functions.get(call) or self._load(call)
        with self._watching(call):
            result = function(*arguments)
        if result < 0:
            raise self._error(call, _name_of(result), "")
        return result

    def _load(self, call: str) -> Any:
        """Return a function pointer of our own.

        pyopenxr's wraps every result in an enum, and fails on results that it does not know.
        """
        function = raw_functions.openxr_loader_library[call]
        function.restype, function.argtypes = ctypes.c_int, getattr(raw_functions, call).argtypes
        self._functions[call] = function
        return function

    def _error(self, call: str, name: str, message: str) -> Exception:
        if name.removesuffix("Error") in _WRONG:
            return HmdwarpError(
                f"{call}: {name}{f' ({message})' if message else ''}, which no call of ours should get from {self.name}"
            )
        detail = f"{call}{f', {message}' if message else ''}"
        words, remedy = diagnose(self.stage, name, detail, self.name, manifest_text(os.environ))
        lost = self.stage == "running" and name in LOST
        return Lost(words) if lost else MachineError(f"{words}: {remedy}")


def _name_of(result: int) -> str:
    try:
        return type(xr.check_result(xr.Result(result))).__name__
    except ValueError:
        return f"result {result}"
