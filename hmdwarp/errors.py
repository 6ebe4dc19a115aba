"""Every error this program raises on purpose, and the exit status each one ends the command line with.

A message says what was found, what was wanted and what to do, in one line.
"""


class HmdwarpError(Exception):
    """A fault of ours (exit status 1); the two classes below are faults of the input and of the machine."""

    exit_status = 1


class InputError(HmdwarpError):
    """What the user gave cannot be used: a file, an option, a value (exit status 2)."""

    exit_status = 2


class MachineError(HmdwarpError):
    """The machine lacks something: a GL driver, an OpenXR runtime, disk space (exit status 3)."""

    exit_status = 3


class UnknownNameError(InputError):
    """A name that is in no registry; the message offers the nearest known one."""


class TraceError(InputError):
    """A head-motion file that cannot be read, or cannot be trusted."""


class SceneError(InputError):
    """A scene file that is corrupt, empty, or holds no triangles."""


class PlanError(InputError):
    """A combination of passes that cannot run, because one reads what none before it writes."""


class ShaderError(HmdwarpError):
    """A shader that does not compile or link, or a uniform set by a name it does not have."""
