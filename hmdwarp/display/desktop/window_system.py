"""The window system through glfw: its start, its screens, and a connection that may break."""

from __future__ import annotations

import math
import os
import platform
from types import ModuleType
from typing import TYPE_CHECKING

import attrs

from ...base import InputError, MachineError
from ...geometry import Eyes, Fov, Pose, View
from ...headsets import Headset

if TYPE_CHECKING:
    import ctypes

    import glfw

    WindowHandle = ctypes._Pointer[glfw._GLFWwindow]
    ScreenHandle = ctypes._Pointer[glfw._GLFWmonitor]
    VideoMode = glfw._GLFWvidmode.GLFWvidmode
else:  # glfw loads in start()
    WindowHandle = ScreenHandle = VideoMode = object


REMEDY = (
    "run in a desktop session, or under a virtual screen (Debian, Ubuntu: sudo apt-get install xvfb, then put "
    "'xvfb-run -a' before the "
    "command); 'hmdwarp doctor' shows what is there"
)


def choose_library() -> None:
    """Choose the library of X11 or Wayland before glfw is imported, which goes by the session.

    X11 wherever it is there, in XWayland too: the packages of control panel and OpenXR need it.
    """
    is_wayland = os.environ.get("WAYLAND_DISPLAY") and not os.environ.get("DISPLAY")
    os.environ.setdefault("PYGLFW_LIBRARY_VARIANT", "wayland" if is_wayland else "x11")


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


Size = tuple[int, int]
Rectangle = tuple[int, int, int, int]

_FLAT_AREA_PX = 800 * 600
_LEAST_HEIGHT, _SHARE = 480, 0.9  # of a new window: readable pixels, and its share of the free area
WHOLE = 8  # pictures of whole work groups, which also suit video encoders


def viewports(framebuffer: Size, count: int, aspect: float) -> tuple[Rectangle, ...]:
    """Return (x, y, w, h) of `count` equal pictures side by side, as large as fits, centred.

    The left eye comes first.
    framebuffer: (w, h) in pixels, not in the window's units. aspect: width over height of one
    picture; kept within a pixel.
    """
    width, height = framebuffer
    each = max(1, min(width // count, round(height * aspect)))
    tall = max(1, min(height, round(each / aspect)))
    left, low = (width - count * each) // 2, (height - tall) // 2
    return tuple((left + k * each, low, each, tall) for k in range(count))


def flat_size(aspect: float) -> Size:
    """Return a size of that aspect with as many pixels as 800x600, in multiples of eight."""
    width = math.sqrt(_FLAT_AREA_PX * aspect)
    return max(WHOLE, round(width / WHOLE) * WHOLE), max(WHOLE, round(width / aspect / WHOLE) * WHOLE)


def window_size(wanted: Size, room: Size, column: int = 0) -> Size:
    """Return the size of a new window for pictures of `wanted` pixels and a panel next to them.

    It is large enough to read, and within most of the free area of the screen; the pictures'
    aspect is kept.
    """
    width, height = wanted
    most = _SHARE * room[0], _SHARE * room[1]
    column = column if 2 * column <= most[0] else 0
    scale = max(1.0, _LEAST_HEIGHT / height)
    scale = min(scale, (most[0] - column) / width, most[1] / height)
    return max(1, round(width * scale)) + column, max(1, round(height * scale))


BOTH, FLAT = "both", "flat"


@attrs.frozen(eq=False)
class _OneEye:
    name: str  # the headset whose field of view it has
    fov: Fov

    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        return (View(world_from_head, self.fov),)


class WindowView:
    """What of a Display follows from its view. size: of one eye; None for the view's own.

    The flat view has the shape of both eyes side by side, and so fills the same window.
    """

    distorts = takes_depth = takes_panels = ""

    def __init__(self, view: str, headset: Headset, size: Size | None) -> None:
        self._emulated, self._wanted_size = headset, size
        self.set_view(view)

    def set_view(self, view: str) -> None:
        """Switch to "both" or "flat". Errors: InputError for another name."""
        if view not in (BOTH, FLAT):
            raise InputError(f"--view '{view}': expected {BOTH} or {FLAT}")
        seen, (fov, flat_aspect) = self._emulated, self._emulated.flat_view
        is_flat = view == FLAT
        self.eyes: Eyes = _OneEye(seen.name, fov) if is_flat else seen
        self.headset = None if is_flat else seen  # whose lens is in front of it, None for a picture viewed without one
        self.count = 1 if is_flat else len(seen.eyes)  # how many eyes
        self.aspect = flat_aspect if is_flat else seen.aspect  # width over height of one picture as displayed
        self.size = self._wanted_size or (flat_size(flat_aspect) if is_flat else seen.eye_size_px)

    @property
    def total_size(self) -> Size:
        """(w, h) of all eyes side by side, in square pixels."""
        return max(1, round(self.count * self.size[1] * self.aspect)), self.size[1]
