"""Swapchains of the eyes' pictures, and the layer that submits them."""

from __future__ import annotations

import ctypes
import math
from contextlib import suppress

import moderngl
import xr

from ...errors import MachineError
from ...geometry import View
from ...gpu.context import Gpu
from ...gpu.egl import depth_framebuffer
from .runtime import Calls

SRGB8_A8, RGBA16F, RGBA8 = 0x8C43, 0x881A, 0x8058
# The best first. The runtime reads all of them as linear light; only the first stores it encoded.
COLOURS = {SRGB8_A8: "f1", RGBA16F: "f2", RGBA8: "f1"}
DEPTH_32F, DEPTH_32F_STENCIL, DEPTH_24, DEPTH_24_STENCIL, DEPTH_16 = 0x8CAC, 0x8CAD, 0x81A6, 0x88F0, 0x81A5
DEPTHS = (DEPTH_32F, DEPTH_32F_STENCIL, DEPTH_24, DEPTH_24_STENCIL, DEPTH_16)

_DRAWN = xr.SwapchainUsageFlags.COLOR_ATTACHMENT_BIT | xr.SwapchainUsageFlags.SAMPLED_BIT
_DEPTH = xr.SwapchainUsageFlags.DEPTH_STENCIL_ATTACHMENT_BIT | xr.SwapchainUsageFlags.SAMPLED_BIT


def colour_format(offered: list[int]) -> int:
    """Return the best colour format.

    Errors: MachineError if the runtime offers none that we can draw into.
    """
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
                self._framebuffers.append(self._framebuffer(gpu, image.image, kind))
        except BaseException:
            self.destroy()
            raise
        self._index = ctypes.c_uint32()
        self._index_pointer = ctypes.byref(self._index)
        self._wait = ctypes.byref(xr.SwapchainImageWaitInfo(timeout=xr.INFINITE_DURATION))

    def _framebuffer(self, gpu: Gpu, image: int, kind: int) -> moderngl.Framebuffer:
        if self.is_depth:
            return depth_framebuffer(gpu.gl, image, self.size)
        self._textures.append(gpu.gl.external_texture(image, self.size, 4, 0, COLOURS[kind]))
        return gpu.gl.framebuffer([self._textures[-1]])

    def whole(self) -> xr.SwapchainSubImage:
        """Return the whole of an image, for a layer."""
        rectangle = xr.Rect2Di(xr.Offset2Di(0, 0), xr.Extent2Di(*self.size))
        return xr.SwapchainSubImage(self.handle, rectangle, 0)

    def acquire(self) -> moderngl.Framebuffer:
        """Return the next image to draw into, once the runtime has released it. Errors: Lost."""
        self._calls("xrAcquireSwapchainImage", self.handle, None, self._index_pointer)
        self._calls("xrWaitSwapchainImage", self.handle, self._wait)
        return self._framebuffers[self._index.value]

    def release(self) -> None:
        """Release the image to the runtime. Errors: Lost."""
        self._calls("xrReleaseSwapchainImage", self.handle, None)

    def destroy(self) -> None:
        """Destroy our references to the images first, then the runtime's images."""
        for framebuffer in self._framebuffers:
            framebuffer.release()
        for texture in self._textures:
            texture.release()
        self._framebuffers.clear()
        self._textures.clear()
        with suppress(Exception):  # of a session that is lost
            xr.destroy_swapchain(self.handle)


NEAR_M = 0.01  # nearer than any eye can focus; costs no precision, because depth is reversed with an infinite far end


class Projection:
    """The layer of as many eyes as there are colour swapchains. depths: theirs, or none.

    Its depth is reversed, with the far end infinitely far: 0 lies there, 1 at NEAR_M.
    Source: OpenXR 1.1 specification, XrCompositionLayerProjection and
    XrCompositionLayerDepthInfoKHR (nearZ > farZ: reversed).
    """

    def __init__(self, space: xr.Space, colours: list[Swapchain], depths: list[Swapchain]) -> None:
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
        angles.angle_left, angles.angle_right, angles.angle_down, angles.angle_up = (
            fov.left,
            fov.right,
            fov.down,
            fov.up,
        )
        view._next = self._depth_pointers[eye] if with_depth else None
