"""The session's states, as the runtime reports them."""

from __future__ import annotations

import ctypes
from contextlib import suppress

import xr

from .. import Closed, Lost
from .calls import Calls
from .instance import Instance

State = xr.SessionState
_BUFFER = xr.StructureType.EVENT_DATA_BUFFER.value
_STATE_CHANGED = xr.StructureType.EVENT_DATA_SESSION_STATE_CHANGED.value
_INSTANCE_LOSS = xr.StructureType.EVENT_DATA_INSTANCE_LOSS_PENDING.value
_NO_EVENT = xr.Result.EVENT_UNAVAILABLE.value
_STEREO = xr.ViewConfigurationType.PRIMARY_STEREO


class Session:
    """An OpenXR session.

    binding: the graphics to draw with; None for a session without pictures. It is kept referenced,
    because the runtime may read it again.
    Source: OpenXR 1.1 specification, Session Lifecycle.
    """

    def __init__(self, calls: Calls, instance: Instance, binding: ctypes.Structure | None) -> None:
        self._calls, self._instance, self._binding = calls, instance, binding
        self.state = State.UNKNOWN  # the newest one
        self.running = False  # between xrBeginSession and xrEndSession
        pointer = None if binding is None else ctypes.cast(ctypes.pointer(binding), ctypes.c_void_p)
        self.handle = calls.call_once(
            xr.create_session, instance.handle, xr.SessionCreateInfo(system_id=instance.system, next=pointer)
        )
        self._event = xr.EventDataBuffer()
        self._changed = ctypes.cast(
            ctypes.pointer(self._event), ctypes.POINTER(xr.EventDataSessionStateChanged)
        ).contents

    def poll(self) -> None:
        """Process all events of the runtime. Errors: Closed; Lost."""
        event, pointer = self._event, ctypes.byref(self._event)
        while True:
            event._type, event._next = _BUFFER, None
            if self._calls("xrPollEvent", self._instance.handle, pointer) == _NO_EVENT:
                return
            if event._type == _STATE_CHANGED:
                self._enter(State(self._changed._state))
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
        """Destroy it in any state; frames must have been ended."""
        with suppress(Exception):  # of a lost session; destroying is allowed all the same
            xr.destroy_session(self.handle)
