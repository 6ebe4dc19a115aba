"""Why OpenXR does not work, and what to do; the late import of its binding."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Mapping
from pathlib import Path

from ...base import InputError, MachineError, install_line
from ...base.documents import DocumentError, parse_json
from ...base.named_files import FACTS, content_of

RUNTIME_LABEL = "the OpenXR runtime"  # named in plans as what corrects the lens and reads depth
INSTALL = "Debian, Ubuntu: sudo apt-get install"
A_BINDING = f"{INSTALL} libgl1, and {install_line('openxr')}"
_A_RUNTIME = (
    "start the runtime that came with the headset and make it the active one there, "
    "or name its .json file in XR_RUNTIME_JSON"
)
_A_HEADSET = "connect the headset, switch it on and wake it"
RESTART = "start, or restart, the runtime's service"
ANOTHER = "use a runtime that has it (Monado has)"

_GRAPHICS_EXTENSIONS = (OPENGL_EXTENSION, EGL_EXTENSION) = ("XR_KHR_opengl_enable", "XR_MNDX_egl_enable")
CLOCK_EXTENSION = (
    "XR_KHR_win32_convert_performance_counter_time" if sys.platform == "win32" else "XR_KHR_convert_timespec_time"
)

STAGES = ("binding", "runtime", "instance", "headset", "session", "running")  # on the way to a picture, in order
_STEPS = {
    "runtime": "when it was loaded",
    "instance": "when an instance was made",
    "headset": "when asked for a headset",
    "session": "when a session was made",
    "running": "in the middle of the session",
}
# In the middle of a session.
LOST = ("InstanceLostError", "SessionLostError", "SessionLossPending", "RuntimeFailureError")

_NO_RUNTIME = ("no OpenXR runtime: {active}", _A_RUNTIME)
_NO_HEADSET = ("{name} sees no headset ({error})", _A_HEADSET)
_ON_ITS_GPU = "draw on the GPU that the headset is plugged into"
_NO_GRAPHICS = ("{name} refuses this OpenGL context ({error}: {why})", _ON_ITS_GPU)
_KNOWN = {
    "RuntimeUnavailableError": _NO_RUNTIME,
    "FileAccessErrorError": _NO_RUNTIME,
    "FileContentsInvalidError": _NO_RUNTIME,
    "FormFactorUnavailableError": _NO_HEADSET,
    "FormFactorUnsupportedError": _NO_HEADSET,
    "GraphicsDeviceInvalidError": _NO_GRAPHICS,
}


def diagnose(
    stage: str, error: str, message: object = "", name: str = "the runtime", active: str = ""
) -> tuple[str, str]:
    """Return what happened and what to do about it.

    stage: one of STAGES. error: the name of pyopenxr's exception, "died" for a process that never
    returned, or of the exception raised while the binding loaded. message: the text of the error.
    name: the runtime's, where known. active: the runtime that the loader chooses (manifest_text).
    """
    words = " ".join(str(message or "").split())
    if stage == "binding" and error == "ModuleNotFoundError":
        return "pyopenxr is not installed", install_line("openxr")
    if stage == "binding":
        return f"no OpenXR loader: {error}{f': {words}' if words else ''}", A_BINDING
    if error == "died":
        return f"{name} {words} {_STEPS[stage]}", RESTART
    if error == "RuntimeFailureError" and stage == "instance":
        return f"the OpenXR runtime's service does not answer ({active})", RESTART
    if stage == "running" and error in LOST:
        return f"{name} went away ({error})", RESTART
    known, remedy = _KNOWN.get(error, ("{name} failed {step}: {error}: {why}", RESTART))
    why = words or "no reason given"
    return known.format(name=name, error=error, active=active, why=why, step=_STEPS[stage]), remedy


def missing_extensions(name: str, extensions: list[str]) -> tuple[str, str]:
    """Return what extensions the runtime lacks, and what to do."""
    missing = [] if set(_GRAPHICS_EXTENSIONS) & set(extensions) else [" or ".join(_GRAPHICS_EXTENSIONS)]
    missing += [] if CLOCK_EXTENSION in extensions else [CLOCK_EXTENSION]
    return (f"{name} lacks {' and '.join(missing)}", ANOTHER) if missing else ("", "")


def manifest(environ: Mapping[str, str]) -> Path | None:
    """Return the runtime manifest that the OpenXR loader would choose; the file may not exist.

    None where it finds none. Source: OpenXR loader design, "Runtime discovery" on Linux.
    """
    if environ.get("XR_RUNTIME_JSON"):
        return Path(environ["XR_RUNTIME_JSON"])
    home = environ.get("XDG_CONFIG_HOME") or str(Path(environ.get("HOME", "/")) / ".config")
    folders = [home, *(environ.get("XDG_CONFIG_DIRS") or "/etc/xdg").split(":"), "/etc"]
    names = (f"active_runtime.{platform.machine()}.json", "active_runtime.json")
    candidates = (Path(folder) / "openxr" / "1" / name for folder in folders for name in names)
    return next((path for path in candidates if path.is_file()), None)


def manifest_text(environ: Mapping[str, str]) -> str:
    """Return the active manifest and its fault, if any, in a few words."""
    path = manifest(environ)
    if path is None:
        return "XR_RUNTIME_JSON is not set and there is no active_runtime.json"
    source = "XR_RUNTIME_JSON names" if environ.get("XR_RUNTIME_JSON") else "active is"
    try:
        library = parse_json(content_of(path, FACTS))["runtime"]["library_path"]
    except InputError as error:
        return f"{source} {error}"
    except (DocumentError, KeyError, TypeError):
        return f"{source} {path}, which is no runtime manifest"
    return f"{source} {path}, library {library}"


def load_binding() -> None:
    """Import pyopenxr. Errors: MachineError with the reason."""
    os.environ.setdefault("XR_LOADER_DEBUG", "none")  # else the loader prints five lines on what our own error says
    try:
        import xr  # noqa: F401
    except Exception as error:  # AttributeError without libGL, OSError with a foreign loader
        words, remedy = diagnose("binding", type(error).__name__, error)
        raise MachineError(f"{words}: {remedy}") from error
