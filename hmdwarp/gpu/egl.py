"""OpenGL contexts without a display: which devices EGL knows, and a context on one of them.

moderngl's own backend takes no device by name and makes contexts that are not told of a reset.
Source: EGL 1.5; EGL_EXT_device_enumeration, EGL_EXT_platform_device.
"""

from __future__ import annotations

import ctypes
import functools
import os
from typing import Any, cast

import attrs
import moderngl

from ..errors import InputError, are_digits

VARIABLE = "HMDWARP_EGL_DEVICE"
_DEVICE_PLATFORM, _DRM_FILE, _EXTENSIONS = 0x313F, 0x3233, 0x3055
_OPENGL_API, _NONE = 0x30A2, 0x3038
_CONFIG = (0x3033, 0x0001, 0x3040, 0x0008)  # surface type: pbuffer; renderable: OpenGL
_CORE_PROFILE = (0x30FD, 0x0001)
_LOSE_ON_RESET = (0x31BD, 0x31BF)  # reset notification strategy: the context is lost, and says so
_MOST_DEVICES = 64


@attrs.frozen
class Device:
    """One device that EGL knows."""

    index: int
    # The kernel's file of a GPU, such as /dev/dri/card0; "" for a software renderer.
    file: str
    # EGL's pointer.
    handle: int = attrs.field(repr=False)


class _Egl:
    """The library's functions, each of which raises OSError where it fails."""

    def __init__(self) -> None:
        self._library = ctypes.CDLL("libEGL.so.1")
        self.find = self._library.eglGetProcAddress
        self.find.restype, self.find.argtypes = ctypes.c_void_p, [ctypes.c_char_p]

    def current(self) -> tuple[int, int]:
        """Return this thread's display and context, 0 for none."""
        find = [self._library.eglGetCurrentDisplay, self._library.eglGetCurrentContext]
        for function in find:
            function.restype, function.argtypes = ctypes.c_void_p, []
        return find[0]() or 0, find[1]() or 0

    def call(self, name: str, result: Any, *arguments: Any) -> Any:
        """Return what a function answers; arguments are ctypes values, or integers for pointers."""
        given = [ctypes.c_void_p(argument) if isinstance(argument, int) else argument for argument in arguments]
        address = self.find(name.encode())
        if not address:
            raise OSError(f"EGL has no {name}")
        answer = ctypes.CFUNCTYPE(result)(address)(*given)
        if not answer:
            self._library.eglGetError.restype = ctypes.c_int32
            raise OSError(f"{name} failed ({self._library.eglGetError():#x})")
        return answer


@functools.cache
def _egl() -> _Egl:
    return _Egl()


def devices() -> list[Device]:
    """Return the devices in EGL's order.

    Errors: OSError, in one line, where there is no EGL, or one that cannot list devices.
    """
    egl, count = _egl(), ctypes.c_int32()
    handles = (ctypes.c_void_p * _MOST_DEVICES)()
    egl.call("eglQueryDevicesEXT", ctypes.c_int32, ctypes.c_int32(_MOST_DEVICES), handles, ctypes.byref(count))
    known = [handle or 0 for handle in handles[: count.value]]
    found = []
    for index, handle in enumerate(known):
        try:
            file = egl.call("eglQueryDeviceStringEXT", ctypes.c_char_p, handle, ctypes.c_int32(_DRM_FILE)).decode()
        except OSError:  # a software renderer has none
            file = ""
        found.append(Device(index, file, handle))
    return found


class EglContext:
    """A context of OpenGL's core profile on a device, for moderngl.create_context(context=).

    It is lost when the GPU is reset, and reports that where the driver supports it. shared: not
    so, for a context with which a runtime shares its own: EGL refuses two that differ in it.
    Errors: OSError where the device has no such OpenGL.
    """

    standalone = True

    def __init__(self, device: Device, version: int, *, shared: bool = False) -> None:
        egl = self._egl = _egl()
        platform, none = ctypes.c_uint32(_DEVICE_PLATFORM), _attributes(())
        self._display = egl.call("eglGetPlatformDisplayEXT", ctypes.c_void_p, platform, device.handle, none)
        egl.call("eglInitialize", ctypes.c_uint32, self._display, 0, 0)
        egl.call("eglBindAPI", ctypes.c_uint32, ctypes.c_uint32(_OPENGL_API))
        config, count = ctypes.c_void_p(), ctypes.c_int32()
        egl.call(
            "eglChooseConfig", ctypes.c_uint32, self._display, _attributes(_CONFIG),
            ctypes.byref(config), ctypes.c_int32(1), ctypes.byref(count),
        )  # fmt: skip
        if not count.value:
            raise OSError("it draws no OpenGL")
        wanted = (0x3098, version // 100, 0x30FB, version // 10 % 10, *_CORE_PROFILE)
        pointer = ctypes.c_void_p
        make = functools.partial(egl.call, "eglCreateContext", pointer, self._display, config, pointer(0))
        try:
            self._context = make(_attributes(wanted if shared else (*wanted, *_LOSE_ON_RESET)))
        except OSError:
            self._context = make(_attributes(wanted))
        self.__enter__()

    def load(self, name: str) -> int:
        """Return the address of a GL function, 0 where there is none."""
        return self._egl.find(name.encode()) or 0

    def __enter__(self) -> None:
        _make_current(self._display, self._context)

    def __exit__(self, *_: object) -> None:
        self._egl.call("eglMakeCurrent", ctypes.c_uint32, self._display, 0, 0, 0)

    def release(self) -> None:
        """Destroy the context. Its display stays: others on the device share it."""
        self._egl.call("eglDestroyContext", ctypes.c_uint32, self._display, self._context)


def _attributes(pairs: tuple[int, ...]) -> Any:
    return (ctypes.c_int32 * (len(pairs) + 1))(*pairs, _NONE)


def create_context(version: int, *, shared: bool = False) -> moderngl.Context:
    """Return a context on the device that HMDWARP_EGL_DEVICE names, else on the first that has one.

    shared: see EglContext.
    The variable: a number in EGL's order, or a part of the renderer's name.
    Errors: InputError where no device, or more than one, is so named; OSError where none has
    OpenGL.
    """
    found, wanted = devices(), os.environ.get(VARIABLE, "").strip()
    if not wanted:
        failures = []
        for device in found:
            try:
                return _on(device, version, shared)
            except (OSError, ValueError) as error:
                failures.append(f"device {device.index}: {error}")
        raise OSError("; ".join(failures) or "EGL lists no device")
    if are_digits(wanted):
        chosen = [device for device in found if device.index == int(wanted)]
    else:
        names = {device.index: renderer_of(device, version) for device in found}
        chosen = [device for device in found if wanted.lower() in names[device.index].lower()]
    if len(chosen) != 1:
        which = "names no device" if not chosen else f"names {len(chosen)} devices"
        known = "; ".join(f"{device.index}: {renderer_of(device, version)}" for device in found)
        raise InputError(
            f"{VARIABLE}={wanted} {which} here, expected one of {known or 'none'}: "
            "give a number or a part of one's name"
        )
    return _on(chosen[0], version, shared)


def _make_current(display: int, context: int) -> None:
    if context:
        _egl().call("eglMakeCurrent", ctypes.c_uint32, display, 0, 0, context)


def _on(device: Device, version: int, shared: bool = False) -> moderngl.Context:
    before = _egl().current()
    made = EglContext(device, version, shared=shared)
    try:
        return moderngl.create_context(standalone=True, require=version, context=cast(Any, made))
    except Exception as error:  # moderngl raises bare Exception here
        made.__exit__()
        made.release()
        _make_current(*before)
        raise OSError(str(error)) from error


def renderer_of(device: Device, version: int) -> str:
    """Return the name of what draws there, or why nothing does: a context is made for it."""
    before = _egl().current()
    try:
        gl = _on(device, version)
    except OSError as error:
        return f"no OpenGL {version / 100:.1f} ({error})"
    name = str(gl.info["GL_RENDERER"])
    gl.__exit__(None, None, None)
    gl.release()
    _make_current(*before)
    return name
