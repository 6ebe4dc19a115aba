"""Drives Monado's 'remote' device exactly.

The head's poses, fields of view and where the eyes sit, controllers' buttons, over TCP 4242.
Source: Monado 25.0, src/xrt/drivers/remote/r_interface.h, struct r_remote_data, which is sent as it
lies in memory.
"""

from __future__ import annotations

import ctypes
import socket
from collections.abc import Sequence

from hmdwarp.geometry import Fov, Pose

PORT = 4242


def _floats(*names: str) -> type[ctypes.Structure]:
    return type("Floats", (ctypes.Structure,), {"_fields_": [(name, ctypes.c_float) for name in names]})


_Vector, _Quaternion = _floats("x", "y", "z"), _floats("x", "y", "z", "w")
_Fov = _floats("left", "right", "up", "down")


class _Pose(ctypes.Structure):
    _fields_ = [("orientation", _Quaternion), ("position", _Vector)]

    def put(self, pose: Pose) -> None:
        self.orientation = _Quaternion(*pose.orientation_xyzw)
        self.position = _Vector(*pose.position_m)


class _View(ctypes.Structure):
    _fields_ = [("fov", _Fov), ("head_from_eye", _Pose), ("pad", ctypes.c_uint32)]


class _Head(ctypes.Structure):
    _fields_ = [("views", _View * 2), ("pose", _Pose), ("views_valid", ctypes.c_uint8), ("pad", ctypes.c_uint8 * 3)]


AXES = (
    "trigger_value", "squeeze_value", "squeeze_force", "thumbstick_x", "thumbstick_y", "trackpad_force", "trackpad_x",
    "trackpad_y",
)  # fmt: skip
BUTTONS = (
    "hand_tracking_active", "active", "system_click", "system_touch", "a_click", "a_touch", "b_click", "b_touch",
    "trigger_click", "trigger_touch", "thumbstick_click", "thumbstick_touch", "trackpad_touch",
    "pad_0", "pad_1", "pad_2",
)  # fmt: skip


class _Controller(ctypes.Structure):
    """Monado shows it as a controller of the Valve Index."""

    _fields_ = [
        ("pose", _Pose), ("linear_velocity", _Vector), ("angular_velocity", _Vector), ("hand_curl", ctypes.c_float * 5),
        *((name, ctypes.c_float) for name in AXES), *((name, ctypes.c_uint8) for name in BUTTONS),
    ]  # fmt: skip


class _Data(ctypes.Structure):
    _fields_ = [("header", ctypes.c_uint64), ("head", _Head), ("left", _Controller), ("right", _Controller)]


class RemoteHead:
    """A connection to the service, which must run with monado.REMOTE. Use as a context manager."""

    def __init__(self, host: str = "127.0.0.1", port: int = PORT) -> None:
        self._socket = socket.create_connection((host, port), timeout=20)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._read()  # first comes what a reset would be
        self._data = self._read()

    def put(self, pose: Pose) -> None:
        """world_from_head from now on."""
        self._data.head.pose.put(pose)
        self._socket.sendall(bytes(self._data))

    def put_eyes(self, eyes: Sequence[tuple[Pose, Fov]]) -> None:
        """head_from_eye and field of view of the left and the right eye from now on."""
        self._data.head.views_valid = 1
        for view, (head_from_eye, fov) in zip(self._data.head.views, eyes, strict=True):
            view.fov = _Fov(fov.left, fov.right, fov.up, fov.down)
            view.head_from_eye.put(head_from_eye)
        self._socket.sendall(bytes(self._data))

    def aim(self, hand: str, pose: Pose) -> None:
        """world_from_hand of "left" or "right" from now on."""
        getattr(self._data, hand).pose.put(pose)
        self.hold(hand)

    def hold(self, hand: str, **states: float) -> None:
        """From now on "left" or "right" has these, by their names in AXES (-1..1) and BUTTONS (0 or
        1); what is not named stays.
        """
        controller = getattr(self._data, hand)
        controller.active = 1
        for name, state in states.items():
            assert name in (*AXES, *BUTTONS), name
            setattr(controller, name, type(getattr(controller, name))(state))
        self._socket.sendall(bytes(self._data))

    def _read(self) -> _Data:
        data = b""
        while len(data) < ctypes.sizeof(_Data):
            more = self._socket.recv(ctypes.sizeof(_Data) - len(data))
            if not more:
                raise ConnectionError("Monado's remote device closed the connection")
            data += more
        return _Data.from_buffer_copy(data)

    def __enter__(self) -> RemoteHead:
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()  # the head stays where it is
