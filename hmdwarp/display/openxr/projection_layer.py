"""The projection layer: both eyes' pictures with poses, fields of view and, if accepted, depths."""

from __future__ import annotations

import ctypes
import math

import xr

from ...geometry import View
from .swapchain import Swapchain

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
