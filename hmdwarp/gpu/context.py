"""One OpenGL 4.3 core context with compute shaders, without a window."""

from __future__ import annotations

import ctypes
import os
import sys
import threading
from collections import deque
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from functools import cache, partial

import attrs
import moderngl

from ..base import InputError, MachineError
from . import egl
from .egl import gl_function, reset_status_of
from .shaders import ShaderLibrary
from .timers import StageTimer, is_software

WANTED = 430
HOW_TO_GET_GL = (
    "install Mesa's software OpenGL (Debian, Ubuntu: sudo apt-get install libegl1 libgl1 libgl1-mesa-dri) "
    "or a GPU driver with EGL; 'hmdwarp doctor' shows what is there"
)


def create_context(*, shared: bool = False) -> moderngl.Context:
    """Create a standalone context: through EGL without any display, else through the window system.

    shared: as of egl.EglContext. Errors: InputError for a wrong HMDWARP_EGL_DEVICE, MachineError.
    """
    ways = [] if os.name != "posix" else [("egl", partial(egl.create_context, WANTED, shared=shared))]
    if os.name != "posix" or os.environ.get("DISPLAY"):
        ways.append(("window system", partial(moderngl.create_context, standalone=True, require=WANTED)))
    failures = []
    for name, way in ways:
        try:
            context = way()
            context.gc_mode = "context_gc"
            return context
        except InputError:
            raise
        except Exception as error:  # moderngl raises bare Exception here
            failures.append(f"{name}: {error}")
    raise MachineError(f"no OpenGL {WANTED / 100:.1f} here ({'; '.join(failures)}): {HOW_TO_GET_GL}")


_thread = threading.local()  # .gpu: GL calls of this thread go to its context
_MANY = 1000  # released objects that moderngl still keeps
_process: int | None = None  # which first made a context
_idle: list[_Context] | None = None  # of closed Gpus, to be used again; None where they end


def check_not_forked() -> None:
    """Raise InputError in a process forked from one that had a context.

    There llvmpipe waits for ever for its threads, which a fork does not copy.
    """
    if _process not in (None, os.getpid()):
        raise InputError(
            "this process was forked from one that already used OpenGL, which does not survive a fork: start it with "
            "multiprocessing.get_context('spawn') or 'forkserver', or fork before the first use"
        )


@cache
def _heap_trim() -> Callable[[int], int]:
    """Return what gives free memory back to the system: a function of glibc, or of nothing."""
    return getattr(ctypes.CDLL(None), "malloc_trim", int) if sys.platform == "linux" else int


@attrs.define(eq=False)
class _Lent:
    thing: moderngl.Texture
    source: object  # It is made of this, whose id must stay its own.
    users: int = 0
    last: Gpu | None = None  # The Gpu that used it last.


@attrs.frozen(eq=False)
class _Context:
    gl: moderngl.Context
    shaders: ShaderLibrary
    lent: dict[object, _Lent] = attrs.field(factory=dict)  # For passes of one Gpu after the other.


@contextmanager
def contexts_kept() -> Iterator[None]:
    """Use contexts of closed Gpus again in this block, with compiled programs and lent textures."""
    global _idle  # noqa: PLW0603 (of the process, as its contexts)
    before, _idle = _idle, [] if _idle is None else _idle
    try:
        yield
    finally:
        left, _idle = _idle, before
        for context in left if before is None else []:
            context.gl.release()


class Gpu:
    """A context with its limits and caches; every pass gets this one object.

    Use as a context manager, or call close(). The newest Gpu of a thread is current there; close()
    makes the previous one current again. Use an older one inside `with gpu.current():`, or its GL
    calls go to another context and give black pictures. A forked process cannot use it.
    Errors: as check_not_forked and create_context.
    """

    def __init__(self, gl: moderngl.Context | None = None) -> None:
        global _process  # noqa: PLW0603 (a fork copies it)
        check_not_forked()
        self._before: Gpu | None = getattr(_thread, "gpu", None)
        self._is_own = gl is None
        if gl is None and _idle:
            self._context = _idle.pop()
            if self._before is not None:
                self._before.gl.__exit__(None, None, None)
            self._context.gl.__enter__()
        else:
            gl = gl or create_context()
            self._context = _Context(gl, ShaderLibrary(gl))
        self.gl = self._context.gl
        _process = self._process = os.getpid()
        self._closed = False
        self._dropped: deque[Callable[[], object]] = deque()
        _thread.gpu = self
        self.renderer: str = self.gl.info["GL_RENDERER"]
        self.version: str = self.gl.info["GL_VERSION"]
        self.max_texture_size: int = self.gl.info["GL_MAX_TEXTURE_SIZE"]
        self.is_software = is_software(self.gl)  # Whether the CPU renders (llvmpipe, softpipe, SwiftShader).
        self.shaders = self._context.shaders
        self.timer = StageTimer(self.gl)
        self._reset_status = reset_status_of(self.gl)
        # Makes what shaders have stored visible to everything that runs from now on.
        self.barrier = partial(self.gl.memory_barrier, moderngl.ALL_BARRIER_BITS)

    @property
    def closed(self) -> bool:
        """Whether it is closed, or of the process that this one was forked from."""
        return self._closed or self._process != os.getpid()

    def check_not_lost(self) -> None:
        """Raise MachineError if the driver has reset the GPU of this, the current context."""
        if reason := self._reset_status():
            said = f"{self.renderer} was reset, and its pictures are lost (OpenGL's reason {reason:#x}): start again"
            raise MachineError(f"{said}; if it comes back use smaller pictures, or another HMDWARP_EGL_DEVICE")

    def wait(self) -> None:
        """Wait until all is drawn, while other threads go on: moderngl's calls hold them up."""
        gl_function("glFinish", None)()

    def forget_released(self) -> None:
        """Drop what moderngl keeps of each object that was released or lost: half a kilobyte.

        Its own Context.gc() fails at the first that was released.
        """
        objects = self.gl.objects
        while objects:
            kept = objects.popleft()
            if hasattr(kept, "release"):  # not the husk of what was released by hand
                kept.release()

    def give_back_memory(self) -> None:
        """Give freed memory back to the system in a millisecond or two, where the CPU renders."""
        if self.is_software:
            self.gl.finish()  # The driver frees a texture once nothing that runs reads it.
            _heap_trim()(0)

    def free_later(self, free: Callable[[], object]) -> None:
        """Call `free` when the context is next made current; for finalizers, in any thread."""
        self._dropped.append(free)

    @contextmanager
    def current(self) -> Iterator[Gpu]:
        """Direct GL calls of this thread here in the block. Errors: InputError if closed."""
        check_not_forked()
        if self.closed:
            raise InputError("this OpenGL context is closed: make another Gpu, and what uses it")
        before = getattr(_thread, "gpu", None)
        _make_current(self)
        try:
            if self._dropped or len(self.gl.objects) >= _MANY:
                while self._dropped:
                    self._dropped.popleft()()
                self.forget_released()
                self.give_back_memory()
            yield self
        finally:
            # Not where nothing has changed: making a context current flushes it, even if it is.
            if getattr(_thread, "gpu", None) is not before:
                _make_current(before)

    def step_aside(self) -> None:
        """Make the previous Gpu current; any one thread may then use this one inside current()."""
        _make_current(self._before)

    def close(self) -> None:
        """Free all resources of the context, once; a forked process leaves them alone."""
        if self.closed:
            return
        before = getattr(_thread, "gpu", None)
        _make_current(self)
        self._release()
        if self.is_software:
            _heap_trim()(0)
        self._closed, _thread.gpu = True, None
        _make_current(self._before if before is self else before)

    def lend(self, source: object, key: Hashable, make: Callable[[], moderngl.Texture]) -> moderngl.Texture:
        """Return the texture made of a source as the key says, shared: neither may change."""
        lent = self._context.lent.get((id(source), key))
        if lent is None:
            lent = self._context.lent[id(source), key] = _Lent(make(), source)
        lent.users, lent.last = lent.users + 1, self
        return lent.thing

    def hand_back(self, thing: moderngl.Texture) -> bool:
        """Free a lent texture unless others need it; return False for one that was not lent."""
        for key, lent in self._context.lent.items():
            if lent.thing is thing:
                lent.users -= 1
                if not lent.users and _idle is None:
                    del self._context.lent[key]
                    thing.release()
                return True
        return False

    def _release(self) -> None:
        self.forget_released()
        is_kept = _idle is not None and self._is_own and not self._reset_status()
        if is_kept:
            for key, lent in list(self._context.lent.items()):
                if lent.last is not self:
                    del self._context.lent[key]
                    lent.thing.release()
                lent.last = None
            self.gl.enable_only(moderngl.NOTHING)
            self.gl.finish()
        # A context that is destroyed while current stays so in EGL, and GLX then refuses a
        # window's in the same thread (BadAccess).
        self.gl.__exit__(None, None, None)
        if is_kept and _idle is not None:
            _idle.append(self._context)
        else:
            self.gl.release()

    def __enter__(self) -> Gpu:
        return self

    def __exit__(self, *_: object) -> None:
        """Close it. Errors: MachineError if it was lost, in place of what failed by that."""
        try:
            if not self.closed:
                with self.current():
                    self.check_not_lost()
        finally:
            self.close()


def _make_current(gpu: Gpu | None) -> None:
    """Make `gpu` current; if it is closed the one before it; or none at all."""
    while gpu is not None and gpu.closed:
        gpu = gpu._before
    now = getattr(_thread, "gpu", None)
    if now is not None and now is not gpu:
        now.gl.__exit__(None, None, None)  # in EGL that leaves no context current, whatever was before
    if gpu is not None:
        gpu.gl.__enter__()
    _thread.gpu = gpu
