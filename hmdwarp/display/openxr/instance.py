"""The OpenXR instance and its system, before anything is drawn."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable, Sequence
from contextlib import suppress

import attrs
import xr

from ...errors import MachineError
from ...resources import __version__
from .calls import Calls
from .diagnosis import CLOCK_EXTENSION, EGL_EXTENSION, GLX_EXTENSION, missing_extensions

DEPTH_EXTENSION = "XR_KHR_composition_layer_depth"
FLOOR_EXTENSION = "XR_EXT_local_floor"
HEADLESS_EXTENSION = "XR_MND_headless"
RATE_EXTENSION = "XR_FB_display_refresh_rate"
WITH_PICTURES = (GLX_EXTENSION, EGL_EXTENSION, CLOCK_EXTENSION, DEPTH_EXTENSION, FLOOR_EXTENSION)
WITHOUT_PICTURES = (HEADLESS_EXTENSION, CLOCK_EXTENSION, FLOOR_EXTENSION, RATE_EXTENSION)
NS = 1_000_000_000


def offered_extensions(calls: Calls) -> list[str]:
    """Return the runtime's extensions. Errors: MachineError where there is no runtime."""
    calls.begin()
    return sorted(_text(entry.extension_name) for entry in calls.call_once(xr.enumerate_instance_extension_properties))


@attrs.define(eq=False)
class Instance:
    """A connection to the runtime."""

    handle: xr.Instance
    system: int
    extensions: frozenset[str]  # the enabled ones
    about: dict[str, str]  # runtime, runtime_version, headset
    _convert: Callable[..., int]  # xrConvertTimespecTimeToTimeKHR
    _timespec: xr.timespec
    _time: ctypes.c_int64

    def offset_ns(self) -> int:
        """Return runtime clock minus CLOCK_MONOTONIC.

        Measured at every refresh: a runtime's clock may drift, and a restarted runtime may have
        another.
        """
        now_ns = time.monotonic_ns()
        self._timespec.tv_sec, self._timespec.tv_nsec = divmod(now_ns, NS)
        if self._convert(self.handle, ctypes.byref(self._timespec), ctypes.byref(self._time)) < 0:
            return 0
        return self._time.value - now_ns

    def destroy(self) -> None:
        """Destroy it in any state."""
        with suppress(Exception):
            xr.destroy_instance(self.handle)


def open_instance(calls: Calls, wanted: Sequence[str]) -> Instance:
    """Connect to the runtime's service and find the headset.

    wanted: extensions to enable if offered.
    Errors: MachineError naming what is missing.
    """
    offered = offered_extensions(calls)
    words, remedy = missing_extensions(calls.name, offered, pictures=HEADLESS_EXTENSION not in wanted)
    if words:
        raise MachineError(f"{words}: {remedy}")
    on = [name for name in wanted if name in offered]
    calls.stage = "instance"
    application = xr.ApplicationInfo(
        application_name="hmdwarp", engine_name=f"hmdwarp {__version__}", api_version=xr.Version(1, 0, 0)
    )
    handle = calls.call_once(
        xr.create_instance, xr.InstanceCreateInfo(application_info=application, enabled_extension_names=on)
    )
    try:
        return _described(calls, handle, frozenset(on))
    except BaseException:
        xr.destroy_instance(handle)
        raise


def _described(calls: Calls, handle: xr.Instance, on: frozenset[str]) -> Instance:
    properties = calls.call_once(xr.get_instance_properties, handle)
    runtime, version = _text(properties.runtime_name), str(xr.Version(properties.runtime_version))
    calls.stage, calls.name = (
        "headset",
        runtime if version in runtime else f"{runtime} {version}",
    )  # Monado's name includes it
    system = calls.call_once(xr.get_system, handle, xr.SystemGetInfo(xr.FormFactor.HEAD_MOUNTED_DISPLAY))
    headset = _text(calls.call_once(xr.get_system_properties, handle, system).system_name)
    pointer = calls.call_once(xr.get_instance_proc_addr, handle, "xrConvertTimespecTimeToTimeKHR")
    convert = ctypes.cast(pointer, xr.PFN_xrConvertTimespecTimeToTimeKHR)
    calls.stage = "session"
    about = {"runtime": runtime, "runtime_version": version, "headset": headset}
    return Instance(handle, system, on, about, convert, xr.timespec(), ctypes.c_int64())


def _text(value: bytes | str) -> str:
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)
