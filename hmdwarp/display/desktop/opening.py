"""Start glfw; an error says why there is no window."""

from __future__ import annotations

import contextlib
import ctypes
import importlib.util
import os
import platform
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType

from ...errors import MachineError

REMEDY = (
    "run in a desktop session, or under a virtual screen (Debian, Ubuntu: sudo apt-get install xvfb, then put "
    "'xvfb-run -a' before the "
    "command); 'hmdwarp doctor' shows what is there"
)


def variant(environ: Mapping[str, str]) -> str:
    """Return which of glfw's two libraries fits, "x11" or "wayland".

    "" leaves it to glfw, which goes by XDG_SESSION_TYPE alone. A session of one kind may offer only
    the other kind of display, as under ssh -X, Xvfb and in containers.
    """
    wayland, x11 = environ.get("WAYLAND_DISPLAY"), environ.get("DISPLAY")
    if "PYGLFW_LIBRARY_VARIANT" in environ or bool(wayland) == bool(x11):
        return ""
    return "wayland" if wayland else "x11"


def choose_library() -> None:
    """Choose the library that fits, before glfw is imported."""
    fitting = variant(os.environ)
    if fitting:
        os.environ["PYGLFW_LIBRARY_VARIANT"] = fitting
    if (fitting or os.environ.get("PYGLFW_LIBRARY_VARIANT") or os.environ.get("XDG_SESSION_TYPE")) == "wayland":
        _load_the_glfw_of_imgui()


def _load_the_glfw_of_imgui() -> None:
    """Load the glfw library of Dear ImGui's package, which has the same name and needs X11.

    Under Wayland that package would find the library of the glfw package, which lacks X11, and fail
    to load. It finds its own if that was loaded first.
    """
    spec = importlib.util.find_spec("imgui_bundle")
    if spec is not None and spec.origin is not None:
        with contextlib.suppress(OSError):
            ctypes.CDLL(str(Path(spec.origin).with_name("libglfw.so.3")))


def start() -> ModuleType:
    """Return the running glfw. Errors: MachineError with the reason."""
    if platform.system() == "Linux":
        if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            raise MachineError(f"no window: neither DISPLAY nor WAYLAND_DISPLAY is set; {REMEDY}")
        choose_library()
    try:
        import glfw
    except Exception as error:  # its loader may raise anything where a library is missing
        raise MachineError(f"no window: glfw cannot be loaded ({error}); pip install glfw") from error
    glfw.ERROR_REPORTING = "log"  # else every refusal (a window position under Wayland) is a warning on stderr
    if not glfw.init():
        raise MachineError(f"no window: {last_error(glfw)}; {REMEDY}")
    return glfw


def last_error(glfw: ModuleType) -> str:
    """Return glfw's reason for refusing the last call."""
    code, message = glfw.get_error()
    words = message.decode(errors="replace") if isinstance(message, bytes) else str(message or "no reason given")
    return f"{' '.join(words.split())}" if code else "no reason given"
