"""The OpenGL context that a runtime takes pictures from, and its description for the runtime."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING

import attrs
import xr

from ...base import InputError, MachineError
from ...gpu.context import WANTED, Gpu, create_context
from ..controls import CONTROLS, Control
from .diagnosis import EGL_EXTENSION, OPENGL_EXTENSION
from .runtime import Calls, Instance

if TYPE_CHECKING:
    from .mirror_window import Mirror

VARIABLE = "HMDWARP_OPENXR_GRAPHICS"
GLX, EGL, WGL = "glx", "egl", "wgl"
_CONFIG_ID, _FBCONFIG_ID, _VISUAL_ID, _NONE, _NONE_EGL = 0x3028, 0x8013, 0x800B, 0, 0x3038


@attrs.define(eq=False)
class Graphics:
    """An OpenGL context for a runtime."""

    gpu: Gpu  # with its context current
    name: str  # "GLX", "EGL" or "WGL"
    binding: ctypes.Structure  # that context as a runtime expects it
    mirror: Mirror | None = None  # the window, if any

    def close(self) -> None:
        """Close the window after the context in it."""
        self.gpu.close()
        if self.mirror is not None:
            self.mirror.close()


def kinds(extensions: frozenset[str], environ: Mapping[str, str], system: str = sys.platform) -> list[str]:
    """Return the ways to draw for that runtime here, the best first.

    GLX: a window's context, which mirrors the left eye on the desktop. EGL: one without a window.
    WGL: as GLX, on Windows. The environment variable HMDWARP_OPENXR_GRAPHICS forces one.
    Errors: InputError for one that is not possible; MachineError if none is.
    """
    possible = []
    if OPENGL_EXTENSION in extensions and (system == "win32" or environ.get("DISPLAY")):
        possible.append(WGL if system == "win32" else GLX)
    if EGL_EXTENSION in extensions and system != "win32":
        possible.append(EGL)
    requested = environ.get(VARIABLE, "").lower()
    if requested and requested not in possible:
        raise InputError(f"{VARIABLE} is '{requested}': expected {' or '.join(possible) or 'none'} for this runtime")
    if not possible:
        raise MachineError(
            f"the runtime takes pictures from a window only (no {EGL_EXTENSION}), and DISPLAY is not set: start an X "
            "server"
        )
    return [requested] if requested else possible


def open_graphics(instance: Instance, controls: tuple[Control, ...] = CONTROLS) -> Graphics:
    """Open the first of `kinds` that works.

    controls: of the window, if there is one. Errors: MachineError with the reasons why none works.
    """
    failures = []
    for kind in kinds(instance.extensions, os.environ):
        mirror: Mirror | None = None
        gpu: Gpu | None = None
        try:
            if kind != EGL:
                from .mirror_window import Mirror as Window

                mirror = Window(controls)
            gpu = Gpu(create_context(shared=True) if mirror is None else mirror.gl)
            binding = {EGL: _egl_binding, GLX: _glx_binding, WGL: _wgl_binding}[kind]
            return Graphics(gpu, kind.upper(), binding(), mirror)
        except BaseException as error:
            if (opened := mirror or gpu) is not None:
                opened.close()
            if not isinstance(error, MachineError):
                raise
            failures.append(str(error))
    raise MachineError("; ".join(failures))


def check_requirements(calls: Calls, instance: Instance, gpu: Gpu) -> None:
    """Query which OpenGL the runtime needs, as required before every session.

    Errors: MachineError if it needs a newer one.
    """
    if OPENGL_EXTENSION not in instance.extensions:
        return
    needs = calls.call_once(xr.get_opengl_graphics_requirements_khr, instance.handle, instance.system)
    least = xr.Version(needs.min_api_version_supported)
    found = gpu.gl.version_code
    if least.major * 100 + least.minor * 10 > max(found, WANTED):
        raise MachineError(
            f"{calls.name} wants OpenGL {least.major}.{least.minor}, found {found / 100:.1f}: update the GPU's driver"
        )


def _library(name: str, *functions: str) -> ctypes.CDLL:
    """Load a library whose functions return pointers."""
    try:
        library = ctypes.CDLL(name)
    except OSError as error:
        raise MachineError(f"{name} cannot be loaded ({error})") from error
    for function in functions:
        getattr(library, function).restype = ctypes.c_void_p
    return library


def _glx_binding() -> ctypes.Structure:
    glx = _library(
        "libGL.so.1", "glXGetCurrentDisplay", "glXGetCurrentContext", "glXGetCurrentDrawable", "glXChooseFBConfig"
    )
    display, context = glx.glXGetCurrentDisplay(), glx.glXGetCurrentContext()
    if not (display and context):
        raise MachineError("the window's context is not GLX's")
    number, count = ctypes.c_int(), ctypes.c_int()
    shown, drawn = ctypes.c_void_p(display), ctypes.c_void_p(context)
    glx.glXQueryContext(shown, drawn, _FBCONFIG_ID, ctypes.byref(number))
    request = (ctypes.c_int * 3)(_FBCONFIG_ID, number.value, _NONE)
    screen = ctypes.CDLL("libX11.so.6").XDefaultScreen(shown)
    chosen = ctypes.cast(
        glx.glXChooseFBConfig(shown, screen, request, ctypes.byref(count)), ctypes.POINTER(ctypes.c_void_p)
    )
    config, visual = chosen[0] if count.value else None, ctypes.c_int()
    if config:
        glx.glXGetFBConfigAttrib(shown, ctypes.c_void_p(config), _VISUAL_ID, ctypes.byref(visual))
    binding: ctypes.Structure = xr.GraphicsBindingOpenGLXlibKHR()
    _put(binding, x_display=display, visualid=visual.value, glx_fbconfig=config, glx_context=context)
    binding.glx_drawable = glx.glXGetCurrentDrawable()
    return binding


def _wgl_binding() -> ctypes.Structure:
    wgl = _library("opengl32.dll", "wglGetCurrentDC", "wglGetCurrentContext")
    binding: ctypes.Structure = xr.GraphicsBindingOpenGLWin32KHR()
    _put(binding, h_dc=wgl.wglGetCurrentDC(), h_glrc=wgl.wglGetCurrentContext())
    if not binding.h_glrc:
        raise MachineError("the window's context is not WGL's")
    return binding


def _egl_binding() -> ctypes.Structure:
    egl = _library("libEGL.so.1", "eglGetCurrentDisplay", "eglGetCurrentContext", "eglGetProcAddress")
    display, context = egl.eglGetCurrentDisplay(), egl.eglGetCurrentContext()
    if not (display and context):
        raise MachineError("the context is not EGL's")
    number, config, count = ctypes.c_int(), ctypes.c_void_p(), ctypes.c_int()
    shown = ctypes.c_void_p(display)
    egl.eglQueryContext(shown, ctypes.c_void_p(context), _CONFIG_ID, ctypes.byref(number))
    request = (ctypes.c_int * 3)(_CONFIG_ID, number.value, _NONE_EGL)
    egl.eglChooseConfig(shown, request, ctypes.byref(config), 1, ctypes.byref(count))
    binding: ctypes.Structure = xr.GraphicsBindingEGLMNDX()
    _put(binding, get_proc_address=ctypes.cast(egl.eglGetProcAddress, ctypes.c_void_p).value)
    _put(binding, display=display, config=config.value, context=context)
    return binding


def _put(binding: ctypes.Structure, **pointers: int | None) -> None:
    """Write addresses into fields, whose types differ: pyopenxr's, PyOpenGL's or plain."""
    for name, value in pointers.items():
        field = getattr(type(binding), name)
        size = ctypes.sizeof(ctypes.c_uint32) if name == "visualid" else ctypes.sizeof(ctypes.c_void_p)
        ctypes.memmove(ctypes.addressof(binding) + field.offset, (value or 0).to_bytes(size, "little"), size)
