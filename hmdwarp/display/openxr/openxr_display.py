"""A headset as a display.

The runtime determines refresh times and eye views, and receives the pictures. Panels may be its
own quad layers: it composes them at its newest pose.
"""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext, suppress
from typing import TYPE_CHECKING

import moderngl
import numpy as np
import xr
from numpy.typing import NDArray

from ...colour import srgb8_from_linear
from ...errors import HmdwarpError, MachineError
from ...gpu.context import Gpu
from ...poses import PoseSample
from .. import Closed, Command, DisplayOptions, Label, Status, Tick
from ..present import Presenter
from .connection import (
    IDLE_S,
    NEAR_M,
    READY_S,
    RGBA16F,
    SRGB8_A8,
    Connected,
    Connection,
    Swapchain,
    colour_format,
    connect,
)  # fmt: skip
from .diagnosis import RUNTIME_LABEL
from .graphics import Graphics, open_graphics
from .runtime import (
    HEADLESS_EXTENSION,
    RATE_EXTENSION,
    WITHOUT_PICTURES,
    Calls,
    Instance,
    Session,
    offered_extensions,
    open_instance,
)
from .tracking import HeadTracker, RuntimeEyes, Spaces, posef_of

if TYPE_CHECKING:
    from ...client.effects.text import HeldPanel
    from ...pipeline.loop import Refresh
    from .mirror_window import Mirror


class Quads:
    """The quad layers (XrCompositionLayerQuad) of one session; each picture is handed over once."""

    def __init__(self, calls: Calls, gpu: Gpu, session: xr.Session, spaces: Spaces, kind: int) -> None:
        self._calls, self._gpu, self._session, self._spaces, self._kind = calls, gpu, session, spaces, kind
        self._pictures: dict[moderngl.Texture, Swapchain] = {}

    def layers(self, panels: Sequence[HeldPanel]) -> list[ctypes.Structure]:
        """Return the layers of panels, the first behind the others. Errors: Lost."""
        shown = {each.texture for each in panels}
        for gone in self._pictures.keys() - shown:
            self._pictures.pop(gone).destroy()
        for texture in shown - self._pictures.keys():
            made = Swapchain(self._calls, self._gpu, self._session, texture.size, self._kind)
            self._pictures[texture] = made
            made.write(_stored(texture, self._kind))
        return [
            xr.CompositionLayerQuad(
                layer_flags=xr.CompositionLayerFlags.BLEND_TEXTURE_SOURCE_ALPHA_BIT,
                space=self._spaces.head if panel.head_locked else self._spaces.world,
                eye_visibility=xr.EyeVisibility.BOTH,
                sub_image=self._pictures[texture].whole(),
                pose=posef_of(panel.pose),
                size=xr.Extent2Df(*panel.size_m),
            )
            for panel, texture in ((each.panel, each.texture) for each in panels)
        ]

    def close(self) -> None:
        for picture in self._pictures.values():
            picture.destroy()
        self._pictures.clear()


def _stored(texture: moderngl.Texture, kind: int) -> bytes:
    """Return a picture as an image of that format holds it, rows as they are."""
    light: NDArray[np.float16] = np.frombuffer(texture.read(alignment=1), np.float16).reshape(*texture.size[::-1], 4)
    if kind == RGBA16F:
        return light.tobytes()
    colour, alpha = light[..., :3].astype(np.float32), light[..., 3:].astype(np.float32)
    codes = srgb8_from_linear(colour) if kind == SRGB8_A8 else np.rint(255 * np.clip(colour, 0, 1)).astype(np.uint8)
    return np.concatenate([codes, np.rint(255 * np.clip(alpha, 0, 1)).astype(np.uint8)], axis=2).tobytes()


LOST = "tracking lost"


class OpenXrDisplay(Connected):
    """display.Display for the headset of the active OpenXR runtime.

    Times are on CLOCK_MONOTONIC, which outlives the runtime's service; the runtime's own times are
    converted. With an X display it has a window that mirrors the left eye; the environment variable
    HMDWARP_OPENXR_GRAPHICS, egl or glx, forces one way to draw.
    Errors: MachineError naming which of loader, runtime, service, headset or extension is missing.
    """

    # Fifteen attributes, eight of them members of Display.
    name = "openxr"
    headset = None  # the runtime knows its lens, and corrects it
    distorts = takes_panels = RUNTIME_LABEL

    def __init__(self, options: DisplayOptions) -> None:
        self._options, self._calls = options, Calls(options.watching)
        self.eyes, self.source = RuntimeEyes(), HeadTracker()
        # Outlasts a lost runtime; None before the first connection and after close().
        self._graphics: Graphics | None = None
        try:
            self._open()
        except BaseException:
            self.close()
            raise

    def _open(self) -> None:
        self._connection = made = connect(self._calls, self._graphics_for, self.source, self._options.controls)
        graphics = self._graphics_for(made.instance)
        self.about = {**made.instance.about, "graphics": graphics.name, "space": made.spaces.name}
        self.size = self._options.size or made.recommended
        self.takes_depth = RUNTIME_LABEL if made.has_depth and self._options.depth_layer else ""
        self._calls.stage = "running"
        made.settle(self._calls, self.eyes)
        self._pictures = made.pictures(self._calls, graphics.gpu, self.size, bool(self.takes_depth))
        kind = colour_format(made.formats)
        self._quads = Quads(self._calls, graphics.gpu, made.session.handle, made.spaces, kind)
        made.cleanup.callback(self._quads.close)
        self._period_ns: int = made.frames.state.predicted_display_period
        self.rate_hz = 1e9 / self._period_ns
        self._last_shown_ns = 0

    def _graphics_for(self, instance: Instance) -> Graphics:
        if self._graphics is None:
            graphics = open_graphics(instance, self._options.controls)
            self.gpu, self._presenter = graphics.gpu, Presenter(graphics.gpu)
            self._graphics = graphics
        return self._graphics

    def _connected(self) -> Connection:
        if self._connection is None:
            raise HmdwarpError("the headset's display is not connected: reopen() first")
        return self._connection

    @property
    def _mirror(self) -> Mirror | None:
        return None if self._graphics is None else self._graphics.mirror

    def now_ns(self) -> int:
        return time.monotonic_ns()

    def wait(self) -> Tick | None:
        """Wait as Display.wait; return None after 10 ms while the runtime wants no frames."""
        made = self._connected()
        state = made.frames.state
        if self._mirror is not None:
            self._mirror.poll()
        made.session.poll()
        if not made.session.running:
            self._last_shown_ns = 0
            time.sleep(IDLE_S)
            return None
        made.frames.begin()
        if made.actions is not None:
            made.actions.sync(time.monotonic_ns(), state.predicted_display_time)
        self.source.offset_ns = made.instance.offset_ns()
        self.eyes.locate(self._calls, made.session.handle, made.spaces.head, state.predicted_display_time)
        shown_ns = state.predicted_display_time - self.source.offset_ns
        self._period_ns = state.predicted_display_period or self._period_ns
        # Of the display: a runtime may report a longer period to slow programs (Monado does).
        last, self._last_shown_ns = self._last_shown_ns, shown_ns
        missed = max(0, round((shown_ns - last) * 1e-9 * self.rate_hz) - 1) if last else 0
        return Tick(shown_ns, self._period_ns, bool(state.should_render), LOST if self.source.lost else "", missed)

    def show(self, refresh: Refresh | None, label: Label = "") -> int:
        """Submit as Display.show, by the time that xrEndFrame has returned."""
        frames, presenter = self._connected().frames, self._presenter
        if frames.state.should_render and (refresh is not None or label):
            panels = refresh.eyes[0].panels if refresh is not None else ()
            frames.end(self._draw(refresh, label), *(self._quads.layers(panels) if panels else ()))
        else:
            frames.end()
        submitted_ns = time.monotonic_ns()
        if self._mirror is not None:
            self._mirror.show(presenter, refresh.eyes[0].panel if refresh is not None else None, label)
        return submitted_ns

    def _draw(self, refresh: Refresh | None, label: Label) -> ctypes.Structure:
        """Draw both eyes; return the layer to submit."""
        pictures, presenter = self._pictures, self._presenter
        notice, black = presenter.notice(label), self.eyes.views(self.source.head_at(self._last_shown_ns).pose)
        for eye, colour in enumerate(pictures.colours):
            result = refresh.eyes[eye] if refresh is not None else None
            view, panel = (result.view, result.panel) if result is not None else (black[eye], None)
            # A float format stores linear light and ignores hardware_srgb.
            whole = (0, 0, *colour.size)
            presenter.show(panel, colour.acquire(), whole, hardware_srgb=True, notice=notice, eye=view)
            colour.release()
            inverse_depth = result.inverse_depth if result is not None and pictures.depths else None
            if inverse_depth is not None:
                depth = pictures.depths[eye]
                presenter.depth(inverse_depth, depth.acquire(), NEAR_M)
                depth.release()
            pictures.fill(eye, view, inverse_depth is not None)
        struct: ctypes.Structure = pictures.struct
        return struct

    def set_view(self, view: str) -> None:
        """Do nothing: a headset has one view."""

    def restart(self) -> None:
        """Do nothing: the head is live."""

    def commands(self) -> Sequence[Command]:
        made, mirror = self._connection, self._mirror
        by_controllers = made.actions.commands() if made is not None and made.actions is not None else ()
        return [*(mirror.commands() if mirror is not None else ()), *by_controllers]

    def show_status(self, status: Status) -> None:
        if self._mirror is not None:
            self._mirror.show_status(status)

    def reopen(self) -> bool:
        """Release the old session and connect again, as Display.reopen. Errors: Closed."""
        self._disconnect()
        if self._mirror is not None:
            self._mirror.poll()
        try:
            self._open()
        except MachineError:
            self._disconnect()
            return False
        return True

    def close(self) -> None:
        self._disconnect()
        graphics, self._graphics = self._graphics, None
        if graphics is not None:
            self._presenter.close()  # before the context it draws in
            graphics.close()


DEFAULT_HZ = 90.0  # the rate of most headsets


class OpenXrHead(Connected):
    """A PoseSource on CLOCK_MONOTONIC, for the headset of the active OpenXR runtime.

    Call poll() at least every tenth of a second. Use as a context manager, or call close(). about:
    runtime, runtime_version, headset, graphics ("none" where none was needed), space. rate_hz: of
    the display, 90 where the runtime does not report it. watching: as in DisplayOptions.
    Errors: MachineError naming which of loader, runtime, service, headset or extension is missing.
    """

    name = "openxr"

    def __init__(self, watching: Callable[[str], AbstractContextManager[object]] = nullcontext) -> None:
        self._calls, self._tracker = Calls(watching), HeadTracker()
        self._graphics: Graphics | None = None
        self._cleanup = ExitStack()
        try:
            self._open()
        except BaseException:
            self.close()
            raise

    def _open(self) -> None:
        if HEADLESS_EXTENSION in offered_extensions(self._calls):
            self._open_headless()
            return
        self._connection = made = connect(self._calls, self._graphics_for, self._tracker)
        self._instance, self._session = made.instance, made.session
        name = self._graphics.name if self._graphics is not None else "none"
        self.about = {**made.instance.about, "graphics": name, "space": made.spaces.name}
        self._calls.stage = "running"
        made.settle(self._calls, RuntimeEyes())
        self.rate_hz = 1e9 / made.frames.state.predicted_display_period

    def _open_headless(self) -> None:
        instance = open_instance(self._calls, WITHOUT_PICTURES)
        self._cleanup.callback(instance.destroy)
        self._session = Session(self._calls, instance, None)
        self._cleanup.callback(self._session.destroy)
        spaces = Spaces(self._calls, instance, self._session.handle)
        self._tracker.attach(self._calls, instance, spaces)
        self._session.on_world_change = self._tracker.world_changes
        self._instance, self.about = instance, {**instance.about, "graphics": "none", "space": spaces.name}
        self._calls.stage = "running"
        until = time.monotonic() + READY_S
        while not self.poll():
            if time.monotonic() > until:
                raise MachineError(f"{self._calls.name} did not begin a session within {READY_S:g} s: wake the headset")
            time.sleep(IDLE_S)
        self.rate_hz = DEFAULT_HZ
        if RATE_EXTENSION in self._instance.extensions:
            with suppress(xr.XrException):  # a display without any, if no pictures are submitted
                rate_hz = xr.get_display_refresh_rate_fb(self._session.handle)
                self.rate_hz = float(getattr(rate_hz, "value", rate_hz)) or DEFAULT_HZ

    def _graphics_for(self, instance: Instance) -> Graphics:
        self._graphics = self._graphics or open_graphics(instance)
        return self._graphics

    def now_ns(self) -> int:
        return time.monotonic_ns()

    def poll(self) -> bool:
        """Process events; return whether poses are available. Errors: Closed; Lost."""
        if self._graphics is not None and self._graphics.mirror is not None:
            self._graphics.mirror.poll()
        self._session.poll()
        if not self._session.running:
            return False
        self._tracker.offset_ns = self._instance.offset_ns()
        if self._connection is not None:
            self._connection.frames.begin()
            self._connection.frames.end()
        return True

    def start(self) -> None:
        """Do nothing: it is already running."""

    def head_at(self, time_ns: int) -> PoseSample:
        """Return the head pose as PoseSource.head_at: HELD while tracking is lost. Errors: Lost."""
        return self._tracker.head_at(time_ns)

    @property
    def lost(self) -> bool:
        """Whether tracking was lost at the last reading."""
        return self._tracker.lost

    def reopen(self) -> bool:
        """Reconnect after Lost; return whether the runtime is back."""
        self._disconnect()
        try:
            self._open()
        except (MachineError, Closed):
            self._disconnect()
            return False
        return True

    def _disconnect(self) -> None:
        super()._disconnect()
        self._cleanup.close()

    def close(self) -> None:
        """Release everything. Safe to call twice."""
        self._disconnect()
        graphics, self._graphics = self._graphics, None
        if graphics is not None:
            graphics.close()

    def __enter__(self) -> OpenXrHead:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
