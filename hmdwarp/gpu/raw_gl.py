"""The few GL calls that moderngl lacks."""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..errors import MachineError

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
