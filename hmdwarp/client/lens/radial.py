"""A lens with polynomial distortion in the squared distance from its axis, one per channel."""

from __future__ import annotations

import numpy as np

from ...errors import InputError
from ...geometry import Fov
from ...gpu.textures import Canvas
from ...headsets import COLOURS, RadialLens
from . import LensPass, bind_texels, lenses


@lenses.register
class Radial(LensPass):
    """Sample once per channel for each panel pixel, which cancels the lens's colour fringes."""

    name = "radial"
    summary = "radial polynomial of the headset's lens, one per colour"
    library = "lens/radial.glsl"
    source = "Brown 1966, Decentering Distortion of Lenses (the radial part); coefficients: see 'hmdwarp list headsets'"

    def prepare(self) -> None:
        if self.headset.lens is None:
            raise InputError(f"headset '{self.headset.name}' has no lens: use --lens none")
        self._terms = [_terms(eye.lens) for eye in self.headset.eyes if eye.lens is not None]
        self._uniforms_by_eye: dict[int, tuple[Fov, dict[str, object]]] = {}
        self._program = self.gpu.shaders.compute("lens/radial.comp", **self.library_defines())

    def run(self, shown: Canvas, fov: Fov, eye: int, into: Canvas) -> None:
        shown.texture.use(0)
        bind_texels(self._program, shown.texture)
        into.bind_for_writing()
        size = shown.size
        sizes = {"rendered_size": size, "rendered_pixel": (1 / size[0], 1 / size[1]), "shown_size": size}
        self._program.uniforms.set(
            rendered_colour=0, written=0, panel_size=self.panel_size, **sizes, **self.library_uniforms(fov, eye)
        )
        self._program.run(*self.panel_size)

    def library_defines(self) -> dict[str, object]:
        one_colour = {"ONE_COLOUR": 1} if all((terms == terms[:, :1]).all() for terms in self._terms) else {}
        return {**super().library_defines(), "LENS_TERMS": len(self._terms[0]), **one_colour}

    def library_uniforms(self, fov: Fov, eye: int) -> dict[str, object]:
        known, uniforms = self._uniforms_by_eye.get(eye, (None, {}))
        if known != fov:
            uniforms = self._library_uniforms(fov, eye)
            self._uniforms_by_eye[eye] = fov, uniforms
        return uniforms

    def _library_uniforms(self, fov: Fov, eye: int) -> dict[str, object]:
        left, right, down, up = fov.tangents
        span = np.array([right - left, up - down])
        scale, offset = self.headset.lens_from_panel(eye, self.panel_size)
        return {
            "lens_from_panel": (*scale, *offset),
            "shown_from_tangent": (*(1 / span), *(-np.array([left, down]) / span)),
            "lens_terms": self._terms[eye],
        }


def _terms(lens: RadialLens) -> np.ndarray:
    """Return (n, 3) coefficients of r^0, r^2, .. in the scales of red, green and blue.

    n is the length of the longest of the three.
    """
    longest = max(map(len, lens.coefficients.values()))
    columns = [np.pad(lens.coefficients[colour], (0, longest - len(lens.coefficients[colour]))) for colour in COLOURS]
    terms = np.stack(columns, axis=1) * lens.tangent_per_unit
    terms.flags.writeable = False
    return terms
