"""The three calls of a frame, kept in order.

A frame left open makes the next xrWaitFrame block forever.
"""

from __future__ import annotations

import ctypes
from contextlib import suppress

import xr

from .calls import Calls

_LAYER = ctypes.POINTER(xr.CompositionLayerBaseHeader)


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
        self._layers = (_LAYER * 1)()
        self._end = xr.FrameEndInfo(environment_blend_mode=xr.EnvironmentBlendMode(blend_mode))
        self._end_pointer = ctypes.byref(self._end)

    def begin(self) -> None:
        """Wait until it is time for the next frame, and begin it. Errors: Lost."""
        self.abandon()
        self._waited = self._open = True
        self._calls("xrWaitFrame", self._session, None, self._state_pointer)
        self._calls("xrBeginFrame", self._session, None)
        self._waited = False

    def end(self, layer: ctypes.Structure | None = None) -> None:
        """Submit the frame, with this layer or with none. Errors: Lost."""
        end = self._end
        end.display_time, end.layer_count = self.state.predicted_display_time, 0
        if layer is not None:
            self._layers[0] = ctypes.cast(ctypes.pointer(layer), _LAYER)
            end.layer_count, end._layers = 1, self._layers
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
