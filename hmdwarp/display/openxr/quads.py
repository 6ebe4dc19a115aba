"""Panels as the runtime's own quad layers: it composes them at its newest pose."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import moderngl
import numpy as np
import xr
from numpy.typing import NDArray

from ...colour import srgb8_from_linear
from ...gpu.context import Gpu
from ...scenes import Panel
from .._base import ShownPanel
from .connection import RGBA16F, SRGB8_A8, Swapchain
from .runtime import Calls
from .tracking import Spaces


class Quads:
    """The quad layers of one session; each picture is handed over once.

    Source: OpenXR 1.0, XrCompositionLayerQuad.
    """

    def __init__(self, calls: Calls, gpu: Gpu, session: xr.Session, spaces: Spaces, kind: int) -> None:
        self._calls, self._gpu, self._session, self._spaces, self._kind = calls, gpu, session, spaces, kind
        self._pictures: dict[moderngl.Texture, Swapchain] = {}

    def layers(self, panels: Sequence[ShownPanel]) -> list[ctypes.Structure]:
        """Return the layers of panels, the first behind the others. Errors: Lost."""
        shown = {each.texture for each in panels}
        for gone in self._pictures.keys() - shown:
            self._pictures.pop(gone).destroy()
        return [self._layer(each.panel, self._picture(each.texture)) for each in panels]

    def _picture(self, texture: moderngl.Texture) -> Swapchain:
        if texture not in self._pictures:
            made = Swapchain(self._calls, self._gpu, self._session, texture.size, self._kind)
            self._pictures[texture] = made
            made.write(_stored(texture, self._kind))
        return self._pictures[texture]

    def _layer(self, panel: Panel, picture: Swapchain) -> ctypes.Structure:
        x, y, z = panel.pose.position_m.tolist()
        layer: ctypes.Structure = xr.CompositionLayerQuad(
            layer_flags=xr.CompositionLayerFlags.BLEND_TEXTURE_SOURCE_ALPHA_BIT,
            space=self._spaces.head if panel.head_locked else self._spaces.world,
            eye_visibility=xr.EyeVisibility.BOTH,
            sub_image=picture.whole(),
            pose=xr.Posef(xr.Quaternionf(*panel.pose.orientation_xyzw.tolist()), xr.Vector3f(x, y, z)),
            size=xr.Extent2Df(*panel.size_m),
        )
        return layer

    def close(self) -> None:
        """Destroy the pictures."""
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
