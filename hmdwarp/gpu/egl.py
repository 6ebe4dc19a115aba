"""OpenGL contexts on EGL's devices, without a display, and the few GL calls that moderngl lacks.

Its own backend makes contexts that do not report a reset of the GPU.
Source: EGL 1.5; EGL_EXT_device_enumeration, EGL_EXT_platform_device.
"""

from __future__ import annotations

import ctypes
import functools
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, cast

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..base import InputError, MachineError
from .textures import drawing_into

_FRAMEBUFFER, _DEPTH_ATTACHMENT, _TEXTURE_2D, _COMPLETE = 0x8D40, 0x8D00, 0x0DE1, 0x8CD5
_COPY_WRITE_BUFFER, _R32UI, _RED_INTEGER, _UNSIGNED_INT = 0x8F37, 0x8236, 0x8D94, 0x1405
_MAP_READ, _MAP_WRITE, _MAP_INVALIDATE = 1, 2, 8  # the last: all of the buffer


@functools.cache
def _address_of() -> Callable[[bytes], int | None]:
    """Return the driver's function loader; either library knows the current context's functions."""
    for library, name in (("libEGL.so.1", "eglGetProcAddress"), ("libGL.so.1", "glXGetProcAddress")):
        try:
            return ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_char_p)((name, ctypes.CDLL(library)))
        except (OSError, AttributeError):
            continue
    raise MachineError("this machine has neither libEGL.so.1 nor libGL.so.1: install libegl1 or libgl1")


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
    """Return a framebuffer around a foreign depth texture, by its GL name; it stays the caller's.

    moderngl accepts none: the framebuffer gets one of its own, which is then exchanged.
    Errors: MachineError if the driver cannot draw into it.
    """
    made = gl.framebuffer(depth_attachment=(place_holder := gl.depth_texture(size)))
    uint = ctypes.c_uint32
    attach = gl_function("glFramebufferTexture2D", None, uint, uint, uint, uint, ctypes.c_int32)
    with drawing_into(made):
        attach(_FRAMEBUFFER, _DEPTH_ATTACHMENT, _TEXTURE_2D, texture, 0)
        status = gl_function("glCheckFramebufferStatus", uint, uint)(_FRAMEBUFFER)
    place_holder.release()
    if status != _COMPLETE:
        made.release()
        said = f"this OpenGL driver cannot draw into the runtime's depth pictures (status {status:#x})"
        raise MachineError(f"{said}: use --no-depth-layer")
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
_DEVICE_PLATFORM, _OPENGL_API, _NONE = 0x313F, 0x30A2, 0x3038
_CONFIG = (0x3033, 0x0001, 0x3040, 0x0008)  # surface type: pbuffer; renderable: OpenGL
_LOSE_ON_RESET = (0x31BD, 0x31BF)  # reset notification strategy: the context is lost, and says so
_MOST_DEVICES = 64
_POINTER, _WORD = ctypes.c_void_p, ctypes.c_uint32


def _egl(name: str, result: Any, *arguments: Any) -> Any:
    """Return what a function of EGL answers. Errors: OSError where it fails."""
    answer = gl_function(name, result, *[_POINTER] * len(arguments))(*arguments)  # a register each
    if not answer:
        raise OSError(f"{name} failed ({gl_function('eglGetError', ctypes.c_int32)():#x})")
    return answer


def _attributes(*pairs: int) -> Any:
    return (ctypes.c_int32 * (len(pairs) + 1))(*pairs, _NONE)


def devices() -> list[int]:
    """Return EGL's handles of the devices, in its order. Errors: OSError, MachineError."""
    handles, count = (_POINTER * _MOST_DEVICES)(), ctypes.c_int32()
    _egl("eglQueryDevicesEXT", _WORD, _MOST_DEVICES, handles, ctypes.byref(count))
    return [handle or 0 for handle in handles[: count.value]]


class EglContext:
    """A context of OpenGL's core profile on a device, for moderngl.create_context(context=).

    It is lost when the GPU is reset, and reports that where the driver supports it. shared: not
    so, for a context with which a runtime shares its own: EGL refuses two that differ in it.
    Errors: OSError where the device has no such OpenGL.
    """

    standalone = True

    def __init__(self, device: int, version: int, *, shared: bool = False) -> None:
        self._display = _egl("eglGetPlatformDisplayEXT", _POINTER, _DEVICE_PLATFORM, device, _attributes())
        _egl("eglInitialize", _WORD, self._display, None, None)
        _egl("eglBindAPI", _WORD, _OPENGL_API)
        config, count = _POINTER(), ctypes.c_int32()
        chosen = ctypes.byref(config), 1, ctypes.byref(count)
        _egl("eglChooseConfig", _WORD, self._display, _attributes(*_CONFIG), *chosen)
        if not count.value:
            raise OSError("it draws no OpenGL")
        wanted = (0x3098, version // 100, 0x30FB, version // 10 % 10, 0x30FD, 1)  # major, minor; core profile
        make = functools.partial(_egl, "eglCreateContext", _POINTER, self._display, config, None)
        try:
            self._context = make(_attributes(*wanted, *(() if shared else _LOSE_ON_RESET)))
        except OSError:
            self._context = make(_attributes(*wanted))
        self.__enter__()

    def load(self, name: str) -> int:
        """Return the address of a GL function, 0 where there is none."""
        return _address_of()(name.encode()) or 0

    def __enter__(self) -> None:
        _egl("eglMakeCurrent", _WORD, self._display, None, None, self._context)

    def __exit__(self, *_: object) -> None:
        _egl("eglMakeCurrent", _WORD, self._display, None, None, None)

    def release(self) -> None:
        """Destroy the context. Its display stays: others on the device share it."""
        _egl("eglDestroyContext", _WORD, self._display, self._context)


def _on(device: int, version: int, shared: bool = False) -> moderngl.Context:
    made = EglContext(device, version, shared=shared)
    try:
        return moderngl.create_context(standalone=True, require=version, context=cast(Any, made))
    except Exception as error:  # moderngl raises bare Exception here
        made.__exit__()
        made.release()
        raise OSError(str(error)) from error


def create_context(version: int, *, shared: bool = False) -> moderngl.Context:
    """Return a context on the device of number HMDWARP_EGL_DEVICE, else on the first that has one.

    shared, and errors: as of EglContext; InputError where there is no such device.
    """
    found, wanted, failures = dict(enumerate(devices())), os.environ.get(VARIABLE, "").strip(), []
    chosen = {index: device for index, device in found.items() if wanted in ("", str(index))}
    if wanted and not chosen:
        known = ", ".join(map(str, found)) or "none"
        raise InputError(f"{VARIABLE}={wanted} names no device here, expected one of {known}: 'hmdwarp doctor'")
    for index, device in chosen.items():
        try:
            return _on(device, version, shared)
        except (OSError, ValueError) as error:
            failures.append(f"device {index}: {error}")
    raise OSError("; ".join(failures) or "EGL lists no device")


def renderer_of(device: int, version: int) -> str:
    """Return the name of what draws there, or why nothing does; then no context is current."""
    try:
        gl = _on(device, version)
    except OSError as error:
        return f"no OpenGL {version / 100:.1f} ({error})"
    name = str(gl.info["GL_RENDERER"])
    gl.__exit__(None, None, None)
    gl.release()
    return name
