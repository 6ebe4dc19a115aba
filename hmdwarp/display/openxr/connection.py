"""Everything that is lost with the runtime's service, from the instance to the swapchains."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack

import attrs
import xr

from ...errors import HmdwarpError, InputError, MachineError
from .. import Closed
from ..controls import Control
from .actions import Actions, open_actions
from .graphics import Graphics, check_requirements
from .runtime import DEPTH_EXTENSION, WITH_PICTURES, Calls, FrameCalls, Instance, Session, open_instance
from .swapchain import Projection, Swapchain, colour_format, depth_format
from .tracking import COUNT, HeadTracker, RuntimeEyes, Spaces

READY_S = 5.0  # for a new session to become ready; runtimes take fractions of a second
IDLE_S = 0.01  # between two polls of a session that is not running
SEEN = 4  # frames with should_render before the period counts as known (Monado reports 16 ms for up to two of them)
UNSEEN_S = 1.0  # a headset that is not worn may never request a picture
_STEREO = xr.ViewConfigurationType.PRIMARY_STEREO


@attrs.frozen(eq=False)
class Pictures:
    """The swapchains of both eyes, and the layer that submits them."""

    colours: list[Swapchain]
    depths: list[Swapchain]  # empty where the runtime accepts none
    layer: Projection


@attrs.define(eq=False)
class Connection:
    """A session with its swapchains. Safe to close in any state: errors are then ignored."""

    instance: Instance
    session: Session
    spaces: Spaces
    frames: FrameCalls
    recommended: tuple[int, int]  # (w, h) of one eye
    has_depth: bool
    _largest: tuple[int, int]
    _formats: list[int]
    _cleanup: ExitStack
    actions: Actions | None = None
    _pictures: Pictures | None = attrs.field(default=None, init=False)

    def settle(self, calls: Calls, eyes: RuntimeEyes) -> None:
        """Submit empty frames until session, period and eyes are known.

        Errors: MachineError if that takes too long.
        """
        began, seen = time.monotonic(), 0
        while seen < SEEN or not eyes.known:
            waited = time.monotonic() - began
            if eyes.known and waited > UNSEEN_S:
                return
            if waited > READY_S:
                raise MachineError(_unready(calls.name, self.session.running))
            try:
                self.session.poll()
            except Closed as closed:
                raise MachineError(f"{closed.args[0]} before it began: put the headset on") from closed
            if not self.session.running:
                time.sleep(IDLE_S)
                continue
            self.frames.begin()
            eyes.locate(calls, self.session.handle, self.spaces.head, self.frames.state.predicted_display_time)
            self.frames.end()
            seen += self.frames.state.should_render

    def make_pictures(self, calls: Calls, graphics: Graphics, size: tuple[int, int], with_depth: bool) -> None:
        """Create swapchains of that size for each eye.

        Errors: InputError for a size too large for the runtime.
        """
        if size[0] > self._largest[0] or size[1] > self._largest[1]:
            raise InputError(
                f"--size {size[0]}x{size[1]}: {calls.name} takes pictures up to {self._largest[0]}x{self._largest[1]}"
            )
        kind, deep = colour_format(self._formats), depth_format(self._formats)
        colours = [self._swapchain(calls, graphics, size, kind) for _ in range(COUNT)]
        depths = [self._swapchain(calls, graphics, size, deep) for _ in range(COUNT)] if with_depth and deep else []
        self._pictures = Pictures(colours, depths, Projection(self.spaces.world, colours, depths))

    def pictures(self) -> Pictures:
        """Return the swapchains that make_pictures() created."""
        if self._pictures is None:
            raise HmdwarpError("the session has no pictures: make_pictures() first")
        return self._pictures

    def _swapchain(self, calls: Calls, graphics: Graphics, size: tuple[int, int], kind: int) -> Swapchain:
        made = Swapchain(calls, graphics.gpu, self.session.handle, size, kind)
        self._cleanup.callback(made.destroy)
        return made

    def close(self) -> None:
        """Release all of it, in order."""
        self.frames.abandon()
        self._cleanup.close()


class Connected:
    """What has a connection while the runtime's service is there."""

    _connection: Connection | None = None

    def _disconnect(self) -> None:
        made, self._connection = self._connection, None
        if made is not None:
            made.close()


def _unready(name: str, running: bool) -> str:
    if running:
        return f"{name} does not say what the eyes see: restart it"
    return f"{name} did not begin a session within {READY_S:g} s: wake the headset, and end other programs that use it"


def connect(
    calls: Calls, graphics_for: Callable[[Instance], Graphics], tracker: HeadTracker, controls: tuple[Control, ...] = ()
) -> Connection:
    """Return a session with swapchains.

    graphics_for: returns the graphics for a runtime. controls: those with buttons are read.
    Errors: MachineError.
    """
    with ExitStack() as stack:
        instance = open_instance(calls, WITH_PICTURES)
        stack.callback(instance.destroy)
        graphics = graphics_for(instance)
        check_requirements(calls, instance, graphics.gpu)
        views = calls.call_once(xr.enumerate_view_configuration_views, instance.handle, instance.system, _STEREO)
        if len(views) != COUNT:
            raise MachineError(f"{calls.name} has {len(views)} views: expected {COUNT}")
        modes = [
            int(mode)
            for mode in calls.call_once(xr.enumerate_environment_blend_modes, instance.handle, instance.system, _STEREO)
        ]
        opaque = xr.EnvironmentBlendMode.OPAQUE.value
        session = Session(calls, instance, graphics.binding)
        stack.callback(session.destroy)
        actions = open_actions(calls, instance, session.handle, controls)
        spaces = Spaces(calls, instance, session.handle)
        tracker.attach(calls, instance, spaces)
        session.on_world_change = tracker.world_changes
        frames = FrameCalls(calls, session.handle, opaque if opaque in modes else modes[0])
        formats = [int(format_) for format_ in calls.call_once(xr.enumerate_swapchain_formats, session.handle)]
        recommended = (views[0].recommended_image_rect_width, views[0].recommended_image_rect_height)
        largest = (views[0].max_image_rect_width, views[0].max_image_rect_height)
        has_depth = DEPTH_EXTENSION in instance.extensions and depth_format(formats) is not None
        return Connection(
            instance, session, spaces, frames, recommended, has_depth, largest, formats, stack.pop_all(), actions
        )
