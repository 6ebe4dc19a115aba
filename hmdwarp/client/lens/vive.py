"""The lens that SteamVR keeps of a Vive, Vive Pro or Index: a centre for each colour."""

from __future__ import annotations

import numpy as np

from ...headsets import COLOURS, Lens, ViveLens
from . import ResampledLens, lenses


@lenses.register
class Vive(ResampledLens):
    """Sample once per channel, each around its own centre; black beyond the cutoff."""

    name = "vive"
    summary = "rational polynomial around a centre for each colour, from the JSON that SteamVR keeps"
    library = "lens/vive.glsl"
    source = "Valve, HMD JSON file, tracking_to_eye_transform (DISTORT_DPOLY3)"

    def library_defines(self) -> dict[str, object]:
        return {**super().library_defines(), "LENS_TANGENTS": 1}

    def of_lens(self, lens: Lens) -> dict[str, object]:
        assert isinstance(lens, ViveLens)
        return {
            "lens_terms": np.array([lens.coefficients[colour] for colour in COLOURS]),
            "lens_centres": np.array([lens.centres[colour] for colour in COLOURS]),
            "lens_focal": lens.focal,
            "lens_cutoff": lens.cutoff_r2,
        }
