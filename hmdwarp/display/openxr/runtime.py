"""The runtime: calls into it, its instance, a session, and the calls of a frame."""

from __future__ import annotations

import ctypes
import os
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, suppress
from typing import Any

import attrs
import xr
from xr import raw_functions

from ...base import HmdwarpError, MachineError, __version__
from ...geometry import Polygon
from ...scenes import MOST_PANELS
from .. import Closed, Lost
from .diagnosis import (
    CLOCK_EXTENSION,
    EGL_EXTENSION,
    LOST,
    OPENGL_EXTENSION,
    diagnose,
    manifest_text,
    missing_extensions,
)

# Results that only a caller who violates the specification gets.
_WRONG = ("CallOrderInvalid", "HandleInvalid", "LayerInvalid", "PoseInvalid", "TimeInvalid", "ValidationFailure")


class Calls:
    """Calls into one runtime. stage: one of diagnosis.STAGES. name: the runtime's, for messages."""

    def __init__(self, watching: Callable[[str], AbstractContextManager[object]]) -> None:
        self._watching = watching
        self._functions: dict[str, Any] = {}
        self.begin()

    def begin(self) -> None:
        self.stage, self.name = "runtime", "the runtime"

    def call_once(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a pyopenxr function that is used once.

        Errors: MachineError; Lost during a session.
        """
        call = "xr" + function.__name__.title().replace("_", "")
        try:
            with self._watching(call):
                return function(*arguments)
        except xr.XrException as error:
            raise self._error(call, type(error).__name__, str(error)) from error

    def __call__(self, call: str, *arguments: Any) -> int:
        """Call a loader function by its C name: 2 us, not 10. Errors: as call_once."""
        if (function := self._functions.get(call)) is None:
            # Our own: that of pyopenxr wraps results in an enum, and fails on those it lacks.
            function = self._functions[call] = raw_functions.openxr_loader_library[call]
            function.restype, function.argtypes = ctypes.c_int, getattr(raw_functions, call).argtypes
        with self._watching(call):
            result: int = function(*arguments)
        if result < 0:
            raise self._error(call, _name_of(result), "")
        return result

    def _error(self, call: str, name: str, message: str) -> Exception:
        if name.removesuffix("Error") in _WRONG:
            return HmdwarpError(
                f"{call}: {name}{f' ({message})' if message else ''}, which no call of ours should get from {self.name}"
            )
        detail = f"{call}{f', {message}' if message else ''}"
        words, remedy = diagnose(self.stage, name, detail, self.name, manifest_text(os.environ))
        lost = self.stage == "running" and name in LOST
        return Lost(words) if lost else MachineError(f"{words}: {remedy}")


def _name_of(result: int) -> str:
    try:
        return type(xr.check_result(xr.Result(result))).__name__
    except ValueError:
        return f"result {result}"


DEPTH_EXTENSION = "XR_KHR_composition_layer_depth"
FLOOR_EXTENSION = "XR_EXT_local_floor"
_MASK_EXTENSION = "XR_KHR_visibility_mask"
_USED = (OPENGL_EXTENSION, EGL_EXTENSION, CLOCK_EXTENSION, DEPTH_EXTENSION, FLOOR_EXTENSION, _MASK_EXTENSION)
_NS = 1_000_000_000


@attrs.define(eq=False)
class Instance:
    handle: xr.Instance
    system: int
    extensions: frozenset[str]  # the enabled ones
    about: dict[str, str]  # runtime, runtime_version, headset
    _convert: Callable[..., int]  # from the system's clock
    _time: ctypes.c_int64 = attrs.field(factory=ctypes.c_int64)

    def offset_ns(self) -> int:
        """Return runtime clock minus time.monotonic_ns.

        Measured at every refresh: a runtime's clock may drift, and a restarted runtime may have
        another.
        """
        now_ns = time.monotonic_ns()
        if self._convert(self.handle, ctypes.byref(_stamped(now_ns)), ctypes.byref(self._time)) < 0:
            return 0
        return self._time.value - now_ns

    def destroy(self) -> None:
        with suppress(Exception):
            xr.destroy_instance(self.handle)


def open_instance(calls: Calls) -> Instance:
    """Connect to the runtime's service and find the headset.

    Errors: MachineError naming what is missing.
    """
    calls.begin()
    entries = calls.call_once(xr.enumerate_instance_extension_properties)
    offered = [_text(entry.extension_name) for entry in entries]
    words, remedy = missing_extensions(calls.name, offered)
    if words:
        raise MachineError(f"{words}: {remedy}")
    on = [name for name in _USED if name in offered]
    calls.stage = "instance"
    application = xr.ApplicationInfo(
        application_name="hmdwarp", engine_name=f"hmdwarp {__version__}", api_version=xr.Version(1, 0, 0)
    )
    handle = calls.call_once(
        xr.create_instance, xr.InstanceCreateInfo(application_info=application, enabled_extension_names=on)
    )
    try:
        properties = calls.call_once(xr.get_instance_properties, handle)
        runtime, version = _text(properties.runtime_name), str(xr.Version(properties.runtime_version))
        calls.stage = "headset"
        calls.name = runtime if version in runtime else f"{runtime} {version}"  # Monado's name includes it
        system = calls.call_once(xr.get_system, handle, xr.SystemGetInfo(xr.FormFactor.HEAD_MOUNTED_DISPLAY))
        headset = _text(calls.call_once(xr.get_system_properties, handle, system).system_name)
        name = f"xrConvert{'Win32PerformanceCounter' if sys.platform == 'win32' else 'TimespecTime'}ToTimeKHR"
        convert = ctypes.cast(calls.call_once(xr.get_instance_proc_addr, handle, name), getattr(xr, f"PFN_{name}"))
        calls.stage = "session"
        about = {"runtime": runtime, "runtime_version": version, "headset": headset}
        return Instance(handle, system, frozenset(on), about, convert)
    except BaseException:
        xr.destroy_instance(handle)
        raise


def _stamped(now_ns: int) -> ctypes.Structure | ctypes.c_int64:
    """Return an instant of time.monotonic_ns, which has just been read, as the runtime takes it."""
    if sys.platform != "win32":
        stamp: ctypes.Structure = xr.timespec(*divmod(now_ns, _NS))
        return stamp
    ticks = ctypes.c_int64()
    ctypes.CDLL("kernel32.dll").QueryPerformanceCounter(ctypes.byref(ticks))
    return ticks


def _text(value: bytes | str) -> str:
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)


State = xr.SessionState
_BUFFER = xr.StructureType.EVENT_DATA_BUFFER.value
_STATE_CHANGED = xr.StructureType.EVENT_DATA_SESSION_STATE_CHANGED.value
_WORLD_CHANGES = xr.StructureType.EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING.value
_MASK_CHANGED = xr.StructureType.EVENT_DATA_VISIBILITY_MASK_CHANGED_KHR.value
_INSTANCE_LOSS = xr.StructureType.EVENT_DATA_INSTANCE_LOSS_PENDING.value
_NO_EVENT = xr.Result.EVENT_UNAVAILABLE.value
_STEREO = xr.ViewConfigurationType.PRIMARY_STEREO


class Session:
    """An OpenXR session. binding: the graphics to draw with.

    Source: OpenXR 1.1 specification, Session Lifecycle.
    """

    def __init__(self, calls: Calls, instance: Instance, binding: ctypes.Structure) -> None:
        # The binding is kept referenced: the runtime may read it again.
        self._calls, self._instance, self._binding = calls, instance, binding
        self.state = State.UNKNOWN  # the newest one
        self.running = False  # between xrBeginSession and xrEndSession
        pointer = ctypes.cast(ctypes.pointer(binding), ctypes.c_void_p)
        info = xr.SessionCreateInfo(system_id=instance.system, next=pointer)
        self.handle = calls.call_once(xr.create_session, instance.handle, info)
        # Called with the kind of a reference space that gets another origin, and when it does.
        self.on_world_change: Callable[[int, int], None] = lambda kind, time: None
        # Called when the part of a view that the lens hides has changed.
        self.on_mask_change: Callable[[], None] = lambda: None
        self._event = xr.EventDataBuffer()
        self._changed, self._moved = (
            ctypes.cast(ctypes.pointer(self._event), ctypes.POINTER(kind)).contents
            for kind in (xr.EventDataSessionStateChanged, xr.EventDataReferenceSpaceChangePending)
        )

    def poll(self) -> None:
        """Process all events of the runtime. Errors: Closed; Lost."""
        event, pointer = self._event, ctypes.byref(self._event)
        while True:
            event._type, event._next = _BUFFER, None
            if self._calls("xrPollEvent", self._instance.handle, pointer) == _NO_EVENT:
                return
            if event._type == _STATE_CHANGED:
                self._enter(State(self._changed._state))
            elif event._type == _WORLD_CHANGES:
                self.on_world_change(self._moved._reference_space_type, self._moved.change_time)
            elif event._type == _MASK_CHANGED:
                self.on_mask_change()
            elif event._type == _INSTANCE_LOSS:
                raise Lost(f"{self._calls.name} is about to end")

    def _enter(self, state: xr.SessionState) -> None:
        self.state = state
        if state == State.READY:
            self._calls.call_once(xr.begin_session, self.handle, xr.SessionBeginInfo(_STEREO))
            self.running = True
        elif state == State.STOPPING:
            self.running = False
            self._calls.call_once(xr.end_session, self.handle)
        elif state == State.LOSS_PENDING:
            raise Lost(f"{self._calls.name} is losing the headset")
        elif state == State.EXITING:
            raise Closed(f"{self._calls.name} ended the session")

    def destroy(self) -> None:
        with suppress(Exception):  # of a lost session; destroying is allowed all the same
            xr.destroy_session(self.handle)


_LAYER = ctypes.POINTER(xr.CompositionLayerBaseHeader)
# Every runtime composes as many (XR_MIN_COMPOSITION_LAYERS_SUPPORTED): the picture, and panels.
MOST_LAYERS = 1 + MOST_PANELS


def hidden_triangles(calls: Calls, instance: Instance, session: xr.Session, eye: int) -> tuple[Polygon, ...]:
    """Return what the lens hides of an eye's view, in tangents; none where that is not known.

    Source: OpenXR 1.0, XR_KHR_visibility_mask: vertices lie on the plane z = -1.
    """
    if _MASK_EXTENSION not in instance.extensions:
        return ()
    pointer = calls.call_once(xr.get_instance_proc_addr, instance.handle, "xrGetVisibilityMaskKHR")
    ask, mask = ctypes.cast(pointer, xr.PFN_xrGetVisibilityMaskKHR), xr.VisibilityMaskKHR()
    kind = xr.VisibilityMaskTypeKHR.HIDDEN_TRIANGLE_MESH.value
    asked = (session, _STEREO.value, eye, kind, ctypes.byref(mask))
    if ask(*asked) < 0 or not mask.index_count_output:
        return ()
    vertices, indices = (xr.Vector2f * mask.vertex_count_output)(), (ctypes.c_uint32 * mask.index_count_output)()
    mask.vertex_capacity_input, mask.index_capacity_input = len(vertices), len(indices)
    mask.vertices = ctypes.cast(vertices, ctypes.POINTER(xr.Vector2f))
    mask.indices = ctypes.cast(indices, ctypes.POINTER(ctypes.c_uint32))
    if ask(*asked) < 0:
        return ()
    return triangles_of([(vertex.x, vertex.y) for vertex in vertices], list(indices[: mask.index_count_output]))


def triangles_of(vertices: Sequence[tuple[float, float]], indices: Sequence[int]) -> tuple[Polygon, ...]:
    """Return the triangles of a runtime's mesh, none for one with a wrong index."""
    if len(indices) % 3 or any(index >= len(vertices) for index in indices):
        return ()
    return tuple(tuple(vertices[index] for index in indices[first : first + 3]) for first in range(0, len(indices), 3))


class FrameCalls:
    """Frame calls of one session. state: result of the last xrWaitFrame.

    blend_mode: how the picture blends with the surroundings. A frame counts as waited for from
    before xrWaitFrame until after xrBeginFrame, and as open until after xrEndFrame, because Ctrl-C
    may come between any call and the next line. Beginning or ending a frame that is not open is
    refused and harmless.
    """

    def __init__(self, calls: Calls, session: xr.Session, blend_mode: int) -> None:
        self._calls, self._session = calls, session
        self.state = xr.FrameState()
        self._state_pointer = ctypes.byref(self.state)
        self._waited = self._open = False
        self._layers = (_LAYER * MOST_LAYERS)()
        self._end = xr.FrameEndInfo(environment_blend_mode=xr.EnvironmentBlendMode(blend_mode))
        self._end_pointer = ctypes.byref(self._end)

    def begin(self) -> None:
        self.abandon()
        self._waited = self._open = True
        self._calls("xrWaitFrame", self._session, None, self._state_pointer)
        self._calls("xrBeginFrame", self._session, None)
        self._waited = False

    def end(self, *layers: ctypes.Structure) -> None:
        """Submit the frame, with these layers, the first behind the others. Errors: Lost."""
        end = self._end
        end.display_time, end.layer_count = self.state.predicted_display_time, len(layers)
        for number, layer in enumerate(layers):
            self._layers[number] = ctypes.cast(ctypes.pointer(layer), _LAYER)
        if layers:
            end._layers = self._layers
        self._calls("xrEndFrame", self._session, self._end_pointer)
        self._open = False

    def abandon(self) -> None:
        """End an open frame, empty; never raises."""
        if self._waited:
            with suppress(Exception):
                self._calls("xrBeginFrame", self._session, None)
        if self._open:
            with suppress(Exception):
                self.end()
        self._waited = self._open = False
