"""Everything that is lost with the runtime's service, from the instance to the swapchains."""

from __future__ import annotations

import ctypes
import math
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING, Any

import moderngl
import numpy as np
import xr
from numpy.typing import NDArray

from ...base import InputError, MachineError, srgb8_from_linear
from ...geometry import View
from ...gpu import Gpu, depth_framebuffer
from .. import Closed, DisplayOptions
from .actions import Actions
from .graphics import Graphics, check_requirements
from .runtime import DEPTH_EXTENSION, Calls, FrameCalls, Instance, Session, hidden_triangles, open_instance
from .tracking import COUNT, HeadTracker, RuntimeEyes, Spaces, posef_of

if TYPE_CHECKING:
    from ...client.effects.text import HeldPanel

READY_S = 5.0  # for a new session to become ready; runtimes take fractions of a second
IDLE_S = 0.01  # between two polls of a session that is not running
SEEN = 4  # frames with should_render before the period counts as known (Monado reports 16 ms for up to two of them)
_UNSEEN_S = 1.0  # a headset that is not worn may never request a picture
_STEREO = xr.ViewConfigurationType.PRIMARY_STEREO


class Connection:
    """A session with its swapchains. graphics_for: returns those for a runtime.

    Errors: MachineError; InputError for pictures larger than the runtime takes.
    """

    def __init__(
        self, calls: Calls, graphics_for: Callable[[Instance], Graphics], tracker: HeadTracker, eyes: RuntimeEyes,
        options: DisplayOptions,
    ) -> None:  # fmt: skip
        with ExitStack() as stack:
            self._calls, self.instance = calls, open_instance(calls)
            stack.callback(self.instance.destroy)
            self.graphics = graphics_for(self.instance)
            gpu, instance, system = self.graphics.gpu, self.instance.handle, self.instance.system
            check_requirements(calls, self.instance, gpu)
            views = calls.call_once(xr.enumerate_view_configuration_views, instance, system, _STEREO)
            if len(views) != COUNT:
                raise MachineError(f"{calls.name} has {len(views)} views: expected {COUNT}")
            modes = [*map(int, calls.call_once(xr.enumerate_environment_blend_modes, instance, system, _STEREO))]
            opaque = xr.EnvironmentBlendMode.OPAQUE.value
            self.session = Session(calls, self.instance, self.graphics.binding)
            session = self.session.handle
            stack.callback(self.session.destroy)
            self.spaces = Spaces(calls, self.instance, session)
            self.actions: Actions | None = None
            if any(one.buttons for one in options.controls):
                self.actions = Actions(calls, self.instance, session, options.controls, self.spaces)
            tracker.attach(calls, self.instance, self.spaces)
            self.session.on_world_change = tracker.world_changes
            self.frames = FrameCalls(calls, session, opaque if opaque in modes else modes[0])
            stack.callback(self.frames.abandon)
            calls.stage = "running"
            self._settle(eyes)
            self.size = options.size or (views[0].recommended_image_rect_width, views[0].recommended_image_rect_height)
            largest = (views[0].max_image_rect_width, views[0].max_image_rect_height)
            if self.size[0] > largest[0] or self.size[1] > largest[1]:
                raise InputError(
                    f"--size {self.size[0]}x{self.size[1]}: {calls.name} takes pictures up to {largest[0]}x{largest[1]}"
                )
            formats = [int(format_) for format_ in calls.call_once(xr.enumerate_swapchain_formats, session)]
            wants_depth = options.depth_layer and DEPTH_EXTENSION in self.instance.extensions
            deep = depth_format(formats) if wants_depth else None

            def swapchain(kind: int) -> Swapchain:
                made = Swapchain(calls, gpu, session, self.size, kind)
                stack.callback(made.destroy)
                return made

            colours = [swapchain(colour_format(formats)) for _ in range(COUNT)]
            depths = [] if deep is None else [swapchain(deep) for _ in range(COUNT)]
            self.pictures = Projection(self.spaces.world, colours, depths)
            self.quads = Quads(calls, gpu, session, self.spaces, colour_format(formats))
            stack.callback(self.quads.close)
            self._made = stack.pop_all()

    def _settle(self, eyes: RuntimeEyes) -> None:
        """Submit empty frames until session, period and eyes are known. Errors: MachineError."""
        calls, session = self._calls, self.session
        session.on_mask_change = lambda: eyes.hide(
            [hidden_triangles(calls, self.instance, session.handle, eye) for eye in range(COUNT)]
        )
        session.on_mask_change()
        began, seen = time.monotonic(), 0
        while seen < SEEN or not eyes.known:
            waited = time.monotonic() - began
            if eyes.known and waited > _UNSEEN_S:
                return
            if waited > READY_S:
                raise MachineError(
                    f"{calls.name} does not say what the eyes see: restart it"
                    if session.running
                    else f"{calls.name} did not begin a session within {READY_S:g} s: wake the headset, and end other "
                    "programs that use it"
                )
            try:
                session.poll()
            except Closed as closed:
                raise MachineError(f"{closed.args[0]} before it began: put the headset on") from closed
            if not session.running:
                time.sleep(IDLE_S)
                continue
            self.frames.begin()
            eyes.locate(calls, session.handle, self.spaces.head, self.frames.state.predicted_display_time)
            self.frames.end()
            seen += self.frames.state.should_render

    def close(self) -> None:
        """Release everything, in any state: errors are ignored."""
        self.frames.abandon()
        self._made.close()


SRGB8_A8, RGBA16F, RGBA8 = 0x8C43, 0x881A, 0x8058
# The best first. The runtime reads all of them as linear light; only the first stores it encoded.
COLOURS = {SRGB8_A8: "f1", RGBA16F: "f2", RGBA8: "f1"}
_DEPTH_32F, _DEPTH_32F_STENCIL, _DEPTH_24, _DEPTH_24_STENCIL, DEPTH_16 = 0x8CAC, 0x8CAD, 0x81A6, 0x88F0, 0x81A5
DEPTHS = (_DEPTH_32F, _DEPTH_32F_STENCIL, _DEPTH_24, _DEPTH_24_STENCIL, DEPTH_16)

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
