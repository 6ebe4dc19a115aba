"""Every error that this program raises on purpose, with its exit status.

A message says in one line what was found, what was expected and what to do.
"""

from __future__ import annotations

import difflib
import os
import reprlib
from collections.abc import Sequence

FILE = "FILE"  # how an entry begins that stands for a file of the user
# What converting to numbers raises for a text, a ragged list, an integer of 400 digits, a tensor.
NO_NUMBERS = (TypeError, ValueError, OverflowError, RuntimeError)
_SHOWN = 80  # characters of a value in a message
_IRREGULAR = {"person": "people", "refresh": "refreshes"}  # plurals in messages


class HmdwarpError(Exception):
    """An internal error (exit status 1); those below are of the input and of the machine."""

    exit_status = 1


class InputError(HmdwarpError):
    """The user's input cannot be used: a file, an option, a value (exit status 2)."""

    exit_status = 2


class MachineError(HmdwarpError):
    """The machine lacks something: a GL driver, an OpenXR runtime, disk space (exit status 3)."""

    exit_status = 3


class RequirementError(HmdwarpError):
    """Results that do not hold what was required of them, a line each (exit status 4)."""

    exit_status = 4


class UnknownNameError(InputError):
    """A name that no registry holds; the message offers the nearest known one."""


class TraceError(InputError):
    """A head-motion file that cannot be read, or cannot be trusted."""


class SceneError(InputError):
    """A scene file that is corrupt, empty, or holds no triangles."""


class PlanError(InputError):
    """A combination of passes that cannot run, because one reads what no earlier one writes."""


class ShaderError(HmdwarpError):
    """A shader that does not compile or link, or a uniform set by a name that it lacks."""


def counted(number: int, word: str) -> str:
    """Return "1 person" or "3 ratings"."""
    return f"{number} {word if number == 1 else _IRREGULAR.get(word, word + 's')}"


def listed(names: Sequence[str], word: str = "and") -> str:
    """Return "a, b and c"; "" for no names."""
    return f" {word} ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))


def are_digits(text: str) -> bool:
    """Return whether a text is digits 0 to 9 alone, of which int() makes a number."""
    return text.isascii() and text.isdigit()


def in_brief(value: object) -> str:
    """Return a value of a caller for a message, in one short line."""
    text = " ".join(reprlib.repr(value).split())
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}.."


def unknown_name(kind: str, name: str, known: list[str]) -> UnknownNameError:
    """Return the error for an unknown `name`: it offers the nearest, and tells a directory."""
    if any(name.startswith(FILE) for name in known) and os.path.isdir(name):  # noqa: PTH112 (Path fails for a name too long)
        return UnknownNameError(f"{kind} '{name}' is a directory: expected a file or a name: {', '.join(known)}")
    near, name = difflib.get_close_matches(name.lower(), known, n=1), name[:_SHOWN] + ".." * (len(name) > _SHOWN)
    hint = f"did you mean '{near[0]}'? " if near else ""
    return UnknownNameError(f"unknown {kind} '{name}': {hint}known are {', '.join(known)}")
