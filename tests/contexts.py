"""OpenGL contexts that are used again: each new one compiles 64 ms for its first mipmaps alone.

Where one is closed its objects are freed as ever; the context and its compiled shaders wait for the
next `Gpu()` of this process, which has thousands of them in a run of all tests.
"""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import moderngl

from hmdwarp.gpu import Gpu, ShaderLibrary, context, timers
from hmdwarp.gpu.egl import VARIABLE

_create, _release, _library = context.create_context, Gpu._release, context.ShaderLibrary
_check = timers.check_clocks
MOST_BYTES = 700 << 20  # of a worker: collecting all tests takes 500 MB, and what compiled programs grow to 500
_idle: list[moderngl.Context] = []
_made: set[moderngl.Context] = set()  # standalone ones; a window's belong to it
_libraries: dict[moderngl.Context, ShaderLibrary] = {}


def install() -> None:
    """Keep contexts from now on."""
    context.create_context, Gpu._release = _take, _put_back
    context.ShaderLibrary, timers.check_clocks = _library_of, functools.cache(_check)


@contextmanager
def as_shipped() -> Iterator[None]:
    """Make and destroy contexts in this block as the program does."""
    context.create_context, Gpu._release, context.ShaderLibrary = _create, _release, _library
    timers.check_clocks = _check
    try:
        yield
    finally:
        install()


def _library_of(gl: moderngl.Context) -> ShaderLibrary:
    if gl not in _libraries:
        _libraries[gl] = _library(gl)
    return _libraries[gl]


def _take(*, shared: bool = False) -> moderngl.Context:
    if shared or os.environ.get(VARIABLE):
        return _create(shared=shared)
    if not _idle:
        _made.add(made := _create())
        return made
    before, made = getattr(context._thread, "gpu", None), _idle.pop()
    if before is not None:
        before.gl.__exit__(None, None, None)
    made.__enter__()  # a new one is current as well
    return made


def _put_back(gpu: Gpu) -> None:
    if gpu.gl not in _made or gpu._reset_status():
        return _release(gpu)
    gpu.forget_released()
    gpu.gl.enable_only(moderngl.NOTHING)
    gpu.gl.finish()
    gpu.gl.__exit__(None, None, None)
    return _idle.append(gpu.gl)


def shrink() -> None:
    """On Linux, release idle contexts and solved light once the process has grown."""
    statm = Path("/proc/self/statm")
    if statm.exists() and int(statm.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") > MOST_BYTES:
        while _idle:
            _made.discard(idle := _idle.pop())
            _libraries.pop(idle, None)
            idle.release()
        light = [vars(module) for name, module in sys.modules.items() if name.startswith("hmdwarp.cloudlight.")]
        for cached in [each for names in light for each in names.values() if hasattr(each, "cache_clear")]:
            cached.cache_clear()
        context._heap_trim()(0)
