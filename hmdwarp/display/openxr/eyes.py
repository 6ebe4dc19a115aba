"""Eye poses and fields of view, as the runtime reports them now."""

from __future__ import annotations

import ctypes

import xr

from ...errors import InputError
from ...geometry import Fov, Pose, View
from .calls import Calls

_ORIENTATION = xr.ViewStateFlags.ORIENTATION_VALID_BIT.value
COUNT = 2


class RuntimeEyes:
    """A geometry.Eyes that follows the runtime.

    A new eye distance takes effect at the next refresh.
    """

    def __init__(self) -> None:
        self._state = xr.ViewState()
        self._views = (xr.View * COUNT)(xr.View(), xr.View())
        self._count = ctypes.c_uint32()
        self._info = xr.ViewLocateInfo(xr.ViewConfigurationType.PRIMARY_STEREO)
        self._arguments = (
            ctypes.byref(self._info),
            ctypes.byref(self._state),
            COUNT,
            ctypes.byref(self._count),
            self._views,
        )
        self._known: tuple[tuple[Pose, Fov], ...] = ()
        self._bytes = b""

    @property
    def known(self) -> bool:
        """Whether the runtime has reported them yet."""
        return bool(self._known)

    def locate(self, calls: Calls, session: xr.Session, head: xr.Space, time: int) -> None:
        """Locate the eyes in head space at an instant of the runtime's clock.

        Invalid values are ignored.
        Errors: Lost.
        """
        self._info.display_time, self._info.space = time, head
        calls("xrLocateViews", session, *self._arguments)
        if not self._state._view_state_flags & _ORIENTATION:
            return
        raw = bytes(self._views)
        if raw != self._bytes:
            self._update(raw)

    def _update(self, raw: bytes) -> None:
        try:
            self._known = tuple((pose_of(view.pose), _fov_of(view.fov)) for view in self._views)
        except InputError:  # no field of view yet, or zeros from a lost service
            return
        self._bytes = raw

    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        """Return the view of each eye, as geometry.Eyes."""
        return tuple(View(world_from_head @ head_from_eye, fov, head_from_eye) for head_from_eye, fov in self._known)


def pose_of(pose: xr.Posef) -> Pose:
    """Convert the runtime's pose to ours. Errors: InputError for numbers that are no pose."""
    at, turned = pose.position, pose.orientation
    return Pose((at.x, at.y, at.z), (turned.x, turned.y, turned.z, turned.w))


def _fov_of(fov: xr.Fovf) -> Fov:
    return Fov(left=fov.angle_left, right=fov.angle_right, down=fov.angle_down, up=fov.angle_up)
