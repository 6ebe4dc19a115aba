"""Stretch the background into the hole from the side on which it was occluded."""

from __future__ import annotations

import attrs

from ...geometry import view_map
from ...gpu.textures import COLOUR, allocate
from ..fill_parts import HolePieces
from ..inputs import PassInputs, ShownPicture
from . import fills
from ._base import Fill

LEAST_PARALLAX = 0.25  # pixels at 1 m; below this no hole is a pixel wide unless an object is nearer than 25 cm
_FILLED, _WARPED, _WARPED_DEPTH, _FILLED_DEPTH, _STREAKS = range(5)  # image units


@attrs.frozen
class StretchSettings:
    """How streaks are smoothed, and which depths are one surface.

    Inverse depths are of one surface if they differ by at most tolerance * (the smaller one +
    floor).
    """

    # Pixels of smoothing per pixel of distance from the start of the streak, if that is at least
    # one pixel; 0: none.
    spread: float = 0.1
    tolerance: float = 0.1
    floor: float = 0.02  # 1/m

    def __attrs_post_init__(self) -> None:
        if not all(0 <= value < float("inf") for value in (self.spread, self.tolerance, self.floor)):
            raise ValueError("spread, tolerance and floor must be 0 or more")


@fills.register
class Stretch(Fill):
    """Follow the epipolar line of an empty pixel to both edges of the hole.

    It takes the farther one's colour, smoothed inside the hole alone. Pixels outside the rendered
    picture stay empty: they were not occluded, and their line leads nowhere. `stretch+pyramid`
    fills them too.
    """

    name = "stretch"
    summary = "draws the background into the hole along the line on which things moved, then smooths it"
    reads = ("shown.colour", "shown.inverse_depth")
    writes = ("shown.colour", "shown.inverse_depth")
    source = "Mark 1999, Post-Rendering 3D Image Warping (UNC TR99-022); decaying weights as in YORO"
    Settings = StretchSettings

    def prepare(self) -> None:
        self._draw, self._smooth = (self.gpu.shaders.compute("fills/stretch.comp", PASS=k) for k in range(2))
        self._pieces = HolePieces(self.gpu, self.name, self.shown_size, with_depth=True)
        self._streaks = allocate(self.gpu.gl, self.shown_size, COLOUR)

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        stamp = self._pieces.find(picture, into)
        forward = view_map(inputs.rendered.view, self.rendered_size, inputs.middle, self.shown_size)
        back = view_map(inputs.middle, self.shown_size, inputs.rendered.view, self.rendered_size)
        picture.colour.texture.bind_to_image(_WARPED, read=True, write=False)
        picture.depth.bind_to_image(_WARPED_DEPTH, read=True, write=False)
        into.depth.bind_to_image(_FILLED_DEPTH, read=True, write=True)
        self._streaks.bind_to_image(_STREAKS, read=True, write=True)
        into.colour.bind_for_writing(_FILLED)
        chosen = self.settings
        uniforms = {
            "warped": _WARPED,
            "filled_depth": _FILLED_DEPTH,
            "streaks": _STREAKS,
            "shown_size": self.shown_size,
            "e": forward.e,
        }
        uniforms |= {"depth_tolerance": chosen.tolerance, "depth_floor": chosen.floor, "least_parallax": LEAST_PARALLAX}
        views = {"back_H": back.H, "back_e": back.e, "rendered_size": self.rendered_size}
        self._draw.uniforms.set(warped_depth=_WARPED_DEPTH, stamp=stamp, **views, **uniforms)
        self._smooth.uniforms.set(filled=_FILLED, spread=chosen.spread, **uniforms)
        self._pieces.run(self._draw)
        self._pieces.run(self._smooth)

    def close(self) -> None:
        self._pieces.close()
        self._streaks.release()
