"""Every error that this program raises on purpose, with its exit status.

A message says in one line what was found, what was expected and what to do.
"""

from __future__ import annotations

from collections.abc import Sequence


class HmdwarpError(Exception):
    """An internal error (exit status 1).

    The two classes below are errors of the input and of the machine.
    """

    exit_status = 1


class InputError(HmdwarpError):
    """The user's input cannot be used: a file, an option, a value (exit status 2)."""

    exit_status = 2


class MachineError(HmdwarpError):
    """The machine lacks something: a GL driver, an OpenXR runtime, disk space (exit status 3)."""

    exit_status = 3


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


_IRREGULAR = {"person": "people", "refresh": "refreshes"}  # plurals in messages


def counted(number: int, word: str) -> str:
    """Return "1 person" or "3 ratings"."""
    return f"{number} {word if number == 1 else _IRREGULAR.get(word, word + 's')}"


def listed(names: Sequence[str], word: str = "and") -> str:
    """Return "a, b and c"; "" for no names."""
    return f" {word} ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))
