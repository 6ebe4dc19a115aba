"""The head and the eyes, as the runtime reports them."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Sequence
from contextlib import suppress
from operator import attrgetter

import xr

from ...base import InputError
from ...geometry import Fov, Hidden, Polygon, Pose, View
from ...poses import Origin, PoseSample
from .runtime import FLOOR_EXTENSION, Calls, Instance

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
        info, state, count = map(ctypes.byref, (self._info, self._state, self._count))
        self._arguments = (info, state, COUNT, count, self._views)
        self._known: tuple[tuple[Pose, Fov, Hidden | None], ...] = ()
        self._hidden: tuple[tuple[Polygon, ...], ...] = ((),) * COUNT
        self._bytes = b""

    @property
    def known(self) -> bool:
        return bool(self._known)

    def locate(self, calls: Calls, session: xr.Session, head: xr.Space, time: int) -> None:
        """Locate the eyes in head space at an instant; invalid values are ignored. Errors: Lost."""
        self._info.display_time, self._info.space = time, head
        calls("xrLocateViews", session, *self._arguments)
        if not self._state._view_state_flags & _ORIENTATION:
            return
        raw = bytes(self._views)
        if raw != self._bytes:
            self._update(raw)

    def hide(self, hidden: Sequence[tuple[Polygon, ...]]) -> None:
        """Take what the lens hides of each view, as polygons of tangents."""
        self._hidden, self._bytes = tuple(hidden), b""

    def _update(self, raw: bytes) -> None:
        try:
            found = [(pose_of(view.pose), Fov(*_ENDS(view.fov))) for view in self._views]
            self._known = tuple(
                (pose, fov, Hidden(hidden, fov) if hidden else None)
                for (pose, fov), hidden in zip(found, self._hidden, strict=True)
            )
        except InputError:  # no field of view yet, or zeros from a lost service
            return
        self._bytes = raw

    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        return tuple(
            View(world_from_head @ head_from_eye, fov, head_from_eye, hidden)
            for head_from_eye, fov, hidden in self._known
        )


def pose_of(pose: xr.Posef) -> Pose:
    """Convert the runtime's pose to ours. Errors: InputError for numbers that are no pose."""
    at, turned = pose.position, pose.orientation
    return Pose((at.x, at.y, at.z), (turned.x, turned.y, turned.z, turned.w))


def posef_of(pose: Pose) -> xr.Posef:
    """Convert our pose to the runtime's."""
    return xr.Posef(xr.Quaternionf(*pose.orientation_xyzw.tolist()), xr.Vector3f(*pose.position_m.tolist()))


_ENDS = attrgetter("angle_left", "angle_right", "angle_down", "angle_up")
_Flags = xr.SpaceLocationFlags
_TURN_VALID, _TURN_TRACKED = _Flags.ORIENTATION_VALID_BIT.value, _Flags.ORIENTATION_TRACKED_BIT.value
_PLACE_VALID = _Flags.POSITION_VALID_BIT.value
_Space = xr.ReferenceSpaceType
EYE_HEIGHT_M = 1.6  # of a standing person, where the runtime does not know the floor
STANDING = Pose((0.0, EYE_HEIGHT_M, 0.0))


class Spaces:
    def __init__(self, calls: Calls, instance: Instance, session: xr.Session) -> None:
        offered = {int(kind) for kind in calls.call_once(xr.enumerate_reference_spaces, session)}
        self.name, self.kind, height = _world(offered, FLOOR_EXTENSION in instance.extensions)
        self.world, self.head = (
            calls.call_once(xr.create_reference_space, session, xr.ReferenceSpaceCreateInfo(kind, posef_of(origin)))
            for kind, origin in ((self.kind, Pose((0.0, -height, 0.0))), (_Space.VIEW, Pose()))
        )


def _world(offered: set[int], floor: bool) -> tuple[str, xr.ReferenceSpaceType, float]:
    """Return its name, its kind, and how far its origin is above the floor, in metres."""
    if _Space.STAGE.value in offered:
        return "stage", _Space.STAGE, 0.0
    if floor and _Space.LOCAL_FLOOR.value in offered:
        return "local floor", _Space.LOCAL_FLOOR, 0.0
    return f"local, taken to be {EYE_HEIGHT_M:g} m above the floor", _Space.LOCAL, EYE_HEIGHT_M


class HeadTracker:
    """A PoseSource on CLOCK_MONOTONIC.

    While tracking is lost the head is HELD: at the runtime's last known pose, if it still reports
    that (valid but not tracked, as the specification has it), else at the last pose read here.
    Tracked poses of the past are MEASURED, of the future PREDICTED. Only the orientation counts: an
    invalid position, as of 3-DoF headsets, is held while the orientation is tracked.
    Source: OpenXR 1.0, XrSpaceLocationFlagBits.
    """

    def __init__(self) -> None:
        self._location = xr.SpaceLocation()
        self._pointer = ctypes.byref(self._location)
        self._time = ctypes.c_int64()
        self._last = STANDING
        self._sessions = 0  # each has a world of its own
        self._changes: list[int] = []  # of the world, on the runtime's clock
        self.lost = False  # whether the orientation was untracked at the last reading

    def attach(self, calls: Calls, instance: Instance, spaces: Spaces) -> None:
        """Read from these spaces from now on."""
        self._calls, self._spaces = calls, spaces
        self._sessions += 1
        self.offset_ns = instance.offset_ns()

    def start(self) -> None:
        """Do nothing: it is already running."""

    def world_changes(self, kind: int, time: int) -> None:
        """Take note that a reference space has another origin from an instant of the runtime on."""
        if kind == self._spaces.kind.value:
            self._changes.append(time)

    def head_at(self, time_ns: int) -> PoseSample:
        """Return the head as PoseSource.head_at; space: its world changed. Errors: Lost."""
        read_ns = time.monotonic_ns()
        self._calls("xrLocateSpace", self._spaces.head, self._spaces.world, time_ns + self.offset_ns, self._pointer)
        flags = self._location._location_flags
        pose = None
        if flags & _TURN_VALID:
            with suppress(InputError):  # NaN, or a zero quaternion: some runtimes call even that valid
                pose = pose_of(self._location.pose)
        if pose is not None and not flags & _PLACE_VALID:
            pose = Pose(self._last.position_m, pose.orientation_xyzw)
        self._last = pose or self._last
        self.lost = pose is None or not flags & _TURN_TRACKED
        origin = Origin.HELD if self.lost else Origin.MEASURED if time_ns <= read_ns else Origin.PREDICTED
        space = self._sessions + sum(time <= time_ns + self.offset_ns for time in self._changes)
        return PoseSample(time_ns, self._last, origin, read_ns, space)

    def close(self) -> None:
        """Do nothing: it owns nothing."""
