"""Everything that is lost with the runtime's service, from the instance to the swapchains."""

from __future__ import annotations

import ctypes
import math
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from typing import Any

import attrs
import moderngl
import xr

from ...errors import InputError, MachineError
from ...geometry import View
from ...gpu.context import Gpu
from ...gpu.egl import depth_framebuffer
from .. import Closed
from ..controls import Control
from .actions import Actions
from .graphics import Graphics, check_requirements
from .runtime import (
    DEPTH_EXTENSION,
    WITH_PICTURES,
    Calls,
    FrameCalls,
    Instance,
    Session,
    hidden_triangles,
    open_instance,
)
from .tracking import COUNT, HeadTracker, RuntimeEyes, Spaces

READY_S = 5.0  # for a new session to become ready; runtimes take fractions of a second
IDLE_S = 0.01  # between two polls of a session that is not running
SEEN = 4  # frames with should_render before the period counts as known (Monado reports 16 ms for up to two of them)
UNSEEN_S = 1.0  # a headset that is not worn may never request a picture
_STEREO = xr.ViewConfigurationType.PRIMARY_STEREO


@attrs.define(eq=False)
class Connection:
    """A session with its swapchains. Safe to close in any state: errors are then ignored."""

    instance: Instance
    session: Session
    spaces: Spaces
    frames: FrameCalls
    recommended: tuple[int, int]  # (w, h) of one eye
    has_depth: bool
    largest: tuple[int, int]
    formats: list[int]  # of images that the runtime takes
    cleanup: ExitStack  # called before the session ends
    actions: Actions | None

    def settle(self, calls: Calls, eyes: RuntimeEyes) -> None:
        """Submit empty frames until session, period and eyes are known. Errors: MachineError."""
        self.session.on_mask_change = lambda: eyes.hide(
            [hidden_triangles(calls, self.instance, self.session.handle, eye) for eye in range(COUNT)]
        )
        self.session.on_mask_change()
        began, seen = time.monotonic(), 0
        while seen < SEEN or not eyes.known:
            waited = time.monotonic() - began
            if eyes.known and waited > UNSEEN_S:
                return
            if waited > READY_S:
                raise MachineError(
                    f"{calls.name} does not say what the eyes see: restart it"
                    if self.session.running
                    else f"{calls.name} did not begin a session within {READY_S:g} s: wake the headset, and end other "
                    "programs that use it"
                )
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

    def pictures(self, calls: Calls, gpu: Gpu, size: tuple[int, int], with_depth: bool) -> Projection:
        """Create swapchains of that size for each eye. Errors: InputError for one too large."""
        if size[0] > self.largest[0] or size[1] > self.largest[1]:
            raise InputError(
                f"--size {size[0]}x{size[1]}: {calls.name} takes pictures up to {self.largest[0]}x{self.largest[1]}"
            )

        def swapchains(kind: int) -> list[Swapchain]:
            made: list[Swapchain] = []
            for _ in range(COUNT):  # each is kept as soon as it is made: the next may fail
                made.append(Swapchain(calls, gpu, self.session.handle, size, kind))
                self.cleanup.callback(made[-1].destroy)
            return made

        deep = depth_format(self.formats) if with_depth else None
        colours = swapchains(colour_format(self.formats))
        return Projection(self.spaces.world, colours, [] if deep is None else swapchains(deep))

    def close(self) -> None:
        self.frames.abandon()
        self.cleanup.close()


class Connected:
    """What has a connection while the runtime's service is there."""

    _connection: Connection | None = None

    def _disconnect(self) -> None:
        made, self._connection = self._connection, None
        if made is not None:
            made.close()


def connect(
    calls: Calls, graphics_for: Callable[[Instance], Graphics], tracker: HeadTracker, controls: tuple[Control, ...] = ()
) -> Connection:
    """Return a session. graphics_for: returns those for a runtime. Errors: MachineError."""
    with ExitStack() as stack:
        instance = open_instance(calls, WITH_PICTURES)
        stack.callback(instance.destroy)
        graphics = graphics_for(instance)
        check_requirements(calls, instance, graphics.gpu)
        views = calls.call_once(xr.enumerate_view_configuration_views, instance.handle, instance.system, _STEREO)
        if len(views) != COUNT:
            raise MachineError(f"{calls.name} has {len(views)} views: expected {COUNT}")
        modes = calls.call_once(xr.enumerate_environment_blend_modes, instance.handle, instance.system, _STEREO)
        modes, opaque = [*map(int, modes)], xr.EnvironmentBlendMode.OPAQUE.value
        session = Session(calls, instance, graphics.binding)
        stack.callback(session.destroy)
        spaces = Spaces(calls, instance, session.handle)
        has_buttons = any(one.buttons for one in controls)
        actions = Actions(calls, instance, session.handle, controls, spaces) if has_buttons else None
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


SRGB8_A8, RGBA16F, RGBA8 = 0x8C43, 0x881A, 0x8058
# The best first. The runtime reads all of them as linear light; only the first stores it encoded.
COLOURS = {SRGB8_A8: "f1", RGBA16F: "f2", RGBA8: "f1"}
DEPTH_32F, DEPTH_32F_STENCIL, DEPTH_24, DEPTH_24_STENCIL, DEPTH_16 = 0x8CAC, 0x8CAD, 0x81A6, 0x88F0, 0x81A5
DEPTHS = (DEPTH_32F, DEPTH_32F_STENCIL, DEPTH_24, DEPTH_24_STENCIL, DEPTH_16)

_DRAWN = xr.SwapchainUsageFlags.COLOR_ATTACHMENT_BIT | xr.SwapchainUsageFlags.SAMPLED_BIT
_DEPTH = xr.SwapchainUsageFlags.DEPTH_STENCIL_ATTACHMENT_BIT | xr.SwapchainUsageFlags.SAMPLED_BIT


def colour_format(offered: list[int]) -> int:
    """Return the best colour format. Errors: MachineError if none can be drawn into."""
    for colour in COLOURS:
        if colour in offered:
            return colour
    found = ", ".join(f"{format_:#x}" for format_ in offered) or "none"
    raise MachineError(
        f"the runtime's pictures have formats {found}: expected one of {', '.join(f'{each:#x}' for each in COLOURS)}; "
        "update it"
    )


def depth_format(offered: list[int]) -> int | None:
    """Return the best depth format, None if the runtime offers none."""
    return next((depth for depth in DEPTHS if depth in offered), None)


class Swapchain:
    """Images of one eye, (w, h) each, passed between runtime and client."""

    def __init__(self, calls: Calls, gpu: Gpu, session: xr.Session, size: tuple[int, int], kind: int) -> None:
        self._calls, self.size = calls, size
        self.is_depth = kind not in COLOURS  # whether they hold depth
        info = xr.SwapchainCreateInfo(
            usage_flags=_DEPTH if self.is_depth else _DRAWN, format=kind, sample_count=1,
            width=size[0], height=size[1], face_count=1, array_size=1, mip_count=1,
        )  # fmt: skip
        self.handle = calls.call_once(xr.create_swapchain, session, info)
        self._textures: list[moderngl.Texture] = []
        self._framebuffers: list[moderngl.Framebuffer] = []
        try:
            for image in calls.call_once(xr.enumerate_swapchain_images, self.handle, xr.SwapchainImageOpenGLKHR):
                if self.is_depth:
                    self._framebuffers.append(depth_framebuffer(gpu.gl, image.image, size))
                else:
                    self._textures.append(gpu.gl.external_texture(image.image, size, 4, 0, COLOURS[kind]))
                    self._framebuffers.append(gpu.gl.framebuffer([self._textures[-1]]))
        except BaseException:
            self.destroy()
            raise
        self._index = ctypes.c_uint32()
        self._index_pointer = ctypes.byref(self._index)
        self._wait = ctypes.byref(xr.SwapchainImageWaitInfo(timeout=xr.INFINITE_DURATION))

    def whole(self) -> xr.SwapchainSubImage:
        """Return the whole of an image, for a layer."""
        rectangle = xr.Rect2Di(xr.Offset2Di(0, 0), xr.Extent2Di(*self.size))
        return xr.SwapchainSubImage(self.handle, rectangle, 0)

    def acquire(self) -> moderngl.Framebuffer:
        """Return the next image to draw into, once the runtime has released it. Errors: Lost."""
        self._calls("xrAcquireSwapchainImage", self.handle, None, self._index_pointer)
        self._calls("xrWaitSwapchainImage", self.handle, self._wait)
        return self._framebuffers[self._index.value]

    def write(self, pixels: bytes) -> None:
        """Write the next image and release it. pixels: as its format has them. Errors: Lost."""
        self.acquire()
        self._textures[self._index.value].write(pixels)
        self.release()

    def release(self) -> None:
        self._calls("xrReleaseSwapchainImage", self.handle, None)

    def destroy(self) -> None:
        """Destroy our references to the images first, then the runtime's images."""
        made: list[Any] = [*self._framebuffers, *self._textures]
        for ours in made:
            ours.release()
        self._framebuffers.clear()
        self._textures.clear()
        with suppress(Exception):  # of a session that is lost
            xr.destroy_swapchain(self.handle)


NEAR_M = 0.01  # nearer than any eye can focus; costs no precision, because depth is reversed with an infinite far end


class Projection:
    """The layer of as many eyes as there are colour swapchains. depths: theirs, [] for none.

    Its depth is reversed, with the far end infinitely far: 0 lies there, 1 at NEAR_M.
    Source: OpenXR 1.1 specification, XrCompositionLayerProjection and
    XrCompositionLayerDepthInfoKHR (nearZ > farZ: reversed).
    """

    def __init__(self, space: xr.Space, colours: list[Swapchain], depths: list[Swapchain]) -> None:
        self.colours, self.depths = colours, depths
        self._views = (xr.CompositionLayerProjectionView * len(colours))()
        for view, colour in zip(self._views, colours, strict=True):
            view.type, view.sub_image = xr.StructureType.COMPOSITION_LAYER_PROJECTION_VIEW, colour.whole()
        self._depths = [
            xr.CompositionLayerDepthInfoKHR(depth.whole(), min_depth=0.0, max_depth=1.0, near_z=math.inf, far_z=NEAR_M)
            for depth in depths
        ]
        self._depth_pointers = [ctypes.cast(ctypes.pointer(info), ctypes.c_void_p) for info in self._depths]
        self.struct = xr.CompositionLayerProjection(space=space, views=self._views)

    def fill(self, eye: int, shown: View, with_depth: bool) -> None:
        """Enter the view that one eye's picture was made for; float32 from here on."""
        view, pose, fov = self._views[eye], shown.pose, shown.fov
        view.pose.position.x, view.pose.position.y, view.pose.position.z = pose.position_m.tolist()
        turned = view.pose.orientation
        turned.x, turned.y, turned.z, turned.w = pose.orientation_xyzw.tolist()
        angles = view.fov
        angles.angle_left, angles.angle_right = fov.left, fov.right
        angles.angle_down, angles.angle_up = fov.down, fov.up
        view._next = self._depth_pointers[eye] if with_depth else None
