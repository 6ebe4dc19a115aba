"""Every call into the runtime: watched, because a hung service never answers, and its result turned into an error of ours."""

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
from .trouble import LOST, manifest_in_words, trouble

# What only a caller who does not keep to the specification gets.
_WRONG = ("CallOrderInvalid", "HandleInvalid", "LayerInvalid", "PoseInvalid", "TimeInvalid", "ValidationFailure")


class Calls:
    """stage: how far one has come on the way to a picture, as trouble.STAGES has it. name: the runtime's, for the words of an error."""

    def __init__(self, watching: Callable[[str], AbstractContextManager[object]]) -> None:
        self._watching = watching
        self._functions: dict[str, Any] = {}
        self.begin()

    def begin(self) -> None:
        """From the start again."""
        self.stage, self.name = "runtime", "the runtime"

    def ask(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """A function of pyopenxr's, for what is called once. Errors: MachineError; Lost in the middle of a session."""
        call = "xr" + function.__name__.title().replace("_", "")
        try:
            with self._watching(call):
                return function(*arguments)
        except xr.XrException as error:
            raise self._error(call, type(error).__name__, str(error)) from error

    def __call__(self, call: str, *arguments: Any) -> int:
        """A function of the loader's by its name in C, for what is called at every refresh: 2 us a call instead of 10.

        Returns its result, 0 or above. Errors: as ask.
        """
        function = self._functions.get(call) or self._found(call)
        with self._watching(call):
            result = function(*arguments)
        if result < 0:
            raise self._error(call, _name_of(result), "")
        return result

    def _found(self, call: str) -> Any:
        """A pointer of our own: pyopenxr's makes an enum of every result, and trips over results it does not know."""
        function = raw_functions.openxr_loader_library[call]
        function.restype, function.argtypes = ctypes.c_int, getattr(raw_functions, call).argtypes
        self._functions[call] = function
        return function

    def _error(self, call: str, name: str, message: str) -> Exception:
        if name.removesuffix("Error") in _WRONG:
            return HmdwarpError(
                f"{call}: {name}{f' ({message})' if message else ''}, which no call of ours should get from {self.name}"
            )
        said = f"{call}{f', {message}' if message else ''}"
        words, remedy = trouble(self.stage, name, said, self.name, manifest_in_words(os.environ))
        lost = self.stage == "running" and name in LOST
        return Lost(words) if lost else MachineError(f"{words}: {remedy}")


def _name_of(result: int) -> str:
    try:
        return type(xr.check_result(xr.Result(result))).__name__
    except ValueError:
        return f"result {result}"
