"""OpenGL contexts without a display: which devices EGL knows, and a context on one of them.

And the few GL calls that moderngl lacks: its own backend takes no device by name and makes
contexts that are not told of a reset.
Source: EGL 1.5; EGL_EXT_device_enumeration, EGL_EXT_platform_device.
"""

from __future__ import annotations

import ctypes
import functools
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, cast

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, MachineError

_FRAMEBUFFER, _DRAW_BINDING, _READ_BINDING = 0x8D40, 0x8CA6, 0x8CAA
_DRAW_FRAMEBUFFER, _READ_FRAMEBUFFER = 0x8CA9, 0x8CA8
_DEPTH_ATTACHMENT, _TEXTURE_2D, _COMPLETE = 0x8D00, 0x0DE1, 0x8CD5
_COPY_WRITE_BUFFER, _R32UI, _RED_INTEGER, _UNSIGNED_INT = 0x8F37, 0x8236, 0x8D94, 0x1405
_MAP_READ, _MAP_WRITE, _MAP_INVALIDATE = 1, 2, 8  # the last: all of the buffer
_LOADERS = (("libEGL.so.1", "eglGetProcAddress"), ("libGL.so.1", "glXGetProcAddress"))


@functools.cache
def _address_of() -> Callable[[bytes], int | None]:
    """Return the driver's function loader; either library knows the current context's functions."""
    for library, name in _LOADERS:
        try:
            return ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_char_p)((name, ctypes.CDLL(library)))
        except (OSError, AttributeError):
            continue
    raise MachineError(
        f"this machine has neither {' nor '.join(library for library, _ in _LOADERS)}: install libegl1 or libgl1"
    )


@functools.cache
def gl_function(name: str, result: type | None, *arguments: type) -> Callable[..., int]:
    """Return a function of the current context. Errors: MachineError if the driver lacks it."""
    address = _address_of()(name.encode())
    if not address:
        raise MachineError(f"this OpenGL driver has no {name}: update it")
    return ctypes.CFUNCTYPE(result, *arguments)(address)


def reset_status_of(gl: moderngl.Context) -> Callable[[], int]:
    """Return what asks the driver whether it has reset the GPU: 0 for no, else GL's reason."""
    for name, known in (
        ("glGetGraphicsResetStatus", gl.version_code >= 450 or "GL_KHR_robustness" in gl.extensions),
        ("glGetGraphicsResetStatusARB", "GL_ARB_robustness" in gl.extensions),
    ):
        if known:
            return gl_function(name, ctypes.c_uint32)
    return lambda: 0


def clear_buffer(buffer: moderngl.Buffer, word: int) -> None:
    """Set every 32-bit word of a buffer on the GPU, in order with what it runs.

    moderngl's own clear() maps the buffer, and waits for the GPU.
    """
    uint, address = ctypes.c_uint32, ctypes.c_void_p
    gl_function("glBindBuffer", None, uint, uint)(_COPY_WRITE_BUFFER, buffer.glo)
    clear = gl_function("glClearBufferData", None, uint, uint, uint, uint, address)
    clear(_COPY_WRITE_BUFFER, _R32UI, _RED_INTEGER, _UNSIGNED_INT, ctypes.byref(uint(word)))


def depth_framebuffer(gl: moderngl.Context, texture: int, size: tuple[int, int]) -> moderngl.Framebuffer:
    """Return a framebuffer around a foreign depth texture, by its GL name.

    The texture stays the caller's.

    moderngl accepts no foreign depth texture: the framebuffer gets one of its own, which is then
    exchanged.
    Errors: MachineError if the driver cannot draw into it.
    """
    place_holder = gl.depth_texture(size)
    made = gl.framebuffer(depth_attachment=place_holder)
    uint = ctypes.c_uint32
    bind = gl_function("glBindFramebuffer", None, uint, uint)
    attach = gl_function("glFramebufferTexture2D", None, uint, uint, uint, uint, ctypes.c_int32)
    check = gl_function("glCheckFramebufferStatus", uint, uint)
    get = gl_function("glGetIntegerv", None, uint, ctypes.POINTER(ctypes.c_int32))
    drawn, read = ctypes.c_int32(), ctypes.c_int32()
    get(_DRAW_BINDING, ctypes.byref(drawn))
    get(_READ_BINDING, ctypes.byref(read))
    bind(_FRAMEBUFFER, made.glo)
    attach(_FRAMEBUFFER, _DEPTH_ATTACHMENT, _TEXTURE_2D, texture, 0)
    status = check(_FRAMEBUFFER)
    bind(_DRAW_FRAMEBUFFER, drawn.value)
    bind(_READ_FRAMEBUFFER, read.value)
    place_holder.release()
    if status != _COMPLETE:
        made.release()
        raise MachineError(
            f"this OpenGL driver cannot draw into the runtime's depth pictures (status {status:#x}): "
            "use --no-depth-layer"
        )
    return made


@contextmanager
def mapped(buffer: moderngl.Buffer, *, write: bool = False) -> Iterator[NDArray[np.uint8]]:
    """Lend the bytes of a buffer, to read or to overwrite them all; they are gone after the block.

    Arrays of any strides and types are so copied once. Reading waits for the GPU.
    Errors: MachineError where the driver has no memory for it.
    """
    uint, size = ctypes.c_uint32, ctypes.c_ssize_t
    gl_function("glBindBuffer", None, uint, uint)(_COPY_WRITE_BUFFER, buffer.glo)
    access = _MAP_WRITE | _MAP_INVALIDATE if write else _MAP_READ
    map_range = gl_function("glMapBufferRange", ctypes.c_void_p, uint, size, size, uint)
    address = map_range(_COPY_WRITE_BUFFER, 0, buffer.size, access)
    if not address:
        raise MachineError(f"this OpenGL driver cannot map {buffer.size} bytes: use smaller pictures")
    try:
        yield np.frombuffer(memoryview((ctypes.c_uint8 * buffer.size).from_address(address)), np.uint8)
    finally:
        gl_function("glBindBuffer", None, uint, uint)(_COPY_WRITE_BUFFER, buffer.glo)
        gl_function("glUnmapBuffer", ctypes.c_uint8, uint)(_COPY_WRITE_BUFFER)


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
    file: str  # The kernel's file of a GPU, such as /dev/dri/card0; "" for a software renderer.
    handle: int = attrs.field(repr=False)  # EGL's pointer.


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
    """Return a context on the device of number HMDWARP_EGL_DEVICE, else on the first that has one.

    shared: see EglContext. Errors: InputError where there is no such device; OSError where none has
    OpenGL.
    """
    found, wanted, failures = devices(), os.environ.get(VARIABLE, "").strip(), []
    chosen = [device for device in found if not wanted or str(device.index) == wanted]
    if wanted and not chosen:
        known = "; ".join(f"{device.index}: {renderer_of(device, version)}" for device in found)
        raise InputError(
            f"{VARIABLE}={wanted} names no device here, expected one of {known or 'none'}: give its number"
        )
    for device in chosen:
        try:
            return _on(device, version, shared)
        except (OSError, ValueError) as error:
            failures.append(f"device {device.index}: {error}")
    raise OSError("; ".join(failures) or "EGL lists no device")


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
