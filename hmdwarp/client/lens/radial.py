"""A lens whose distortion is a polynomial in the squared distance from its axis, one per colour."""

from __future__ import annotations

import numpy as np

from ...errors import InputError
from ...geometry import Fov
from ...gpu.textures import Canvas
from ...headsets import MAX_COEFFICIENTS
from . import lenses
from ._base import LensPass


@lenses.register
class Radial(LensPass):
    """Looks each panel pixel up once per colour, so that the lens's colour fringes cancel."""

    name = "radial"
    summary = "radial polynomial of the headset's lens, one per colour"
    look = "lens/radial.glsl"
    source = "Brown 1966, Decentering Distortion of Lenses (the radial part); coefficients: see 'hmdwarp list headsets'"

    def prepare(self) -> None:
        if self.headset.lens is None:
            raise InputError(f"headset '{self.headset.name}' has no lens: use --lens none")
        self._program = self.gpu.shaders.compute("lens/radial.comp")

    def run(self, shown: Canvas, fov: Fov, eye: int, into: Canvas) -> None:
        shown.texture.use(0)
        into.bind_for_writing()
        self._program.uniforms.set(shown=0, panel=0, panel_size=self.panel_size, **self.look_uniforms(fov, eye))
        self._program.run(*self.panel_size)

    def look_uniforms(self, fov: Fov, eye: int) -> dict[str, object]:
        lens = self.headset.lens
        left, right, down, up = fov.tangents
        span = np.array([right - left, up - down])
        scale, offset = self.headset.lens_from_panel(eye, self.panel_size)
        return {
            "lens_from_panel": (*scale, *offset),
            "shown_from_tangent": (*(1 / span), *(-np.array([left, down]) / span)),
            "tangent_per_unit": lens.tangent_per_unit,
            **{colour: _as_matrix(lens.coefficients[colour]) for colour in ("red", "green", "blue")},
        }


def _as_matrix(coefficients: tuple[float, ...]) -> np.ndarray:
    padded = np.zeros(MAX_COEFFICIENTS)
    padded[: len(coefficients)] = coefficients
    return padded.reshape(3, 3).T  # the shader reads column after column
