"""A lens with polynomial distortion in the squared distance from its axis, one per channel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...headsets import COLOURS, Lens, RadialLens
from . import ResampledLens, lenses


@lenses.register
class Radial(ResampledLens):
    """Sample once per channel for each panel pixel, which cancels the lens's colour fringes."""

    name = "radial"
    summary = "radial polynomial of the headset's lens, one per colour"
    library = "lens/radial.glsl"
    source = "Brown 1966, Decentering Distortion of Lenses (the radial part); coefficients: see 'hmdwarp list headsets'"

    def library_defines(self) -> dict[str, object]:
        terms = [self._terms(lens) for lens in self.eye_lenses]
        one_colour = {"ONE_COLOUR": 1} if all((t == t[:, :1]).all() for t in terms) else {}
        return {**super().library_defines(), "LENS_TERMS": max(map(len, terms)), **one_colour}

    def of_lens(self, lens: Lens) -> dict[str, object]:
        return {"lens_terms": self._terms(lens)}

    def _terms(self, lens: Lens) -> NDArray[np.float64]:
        """Return (n, 3) coefficients of r^0, r^2, .. in the scales of red, green and blue.

        n is the length of the longest of all.
        """
        assert isinstance(lens, RadialLens)
        longest = max(
            len(terms) for one in self.eye_lenses if isinstance(one, RadialLens) for terms in one.coefficients.values()
        )
        columns = [
            np.pad(lens.coefficients[colour], (0, longest - len(lens.coefficients[colour]))) for colour in COLOURS
        ]
        return np.stack(columns, axis=1) * lens.tangent_per_unit
