"""A lens whose angles are tabulated against the distance from its axis, for each channel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...headsets import COLOURS, Lens, TableLens
from . import ResampledLens, lenses

# Between two rows the shader interpolates linearly. Of a lens of 100 degrees that is off by 1e-5 in
# tangents, a hundredth of a pixel of 1000 per tangent.
ROWS = 129


@lenses.register
class Table(ResampledLens):
    """Sample once per channel; black beyond the last angle of the table."""

    name = "table"
    summary = "angles against distances on the panel, joined by a monotone spline, one per colour"
    library = "lens/table.glsl"
    source = "Fritsch and Butland 1984, local monotone piecewise cubic interpolants; tables: the headset's file"

    def library_defines(self) -> dict[str, object]:
        return {**super().library_defines(), "LENS_ROWS": ROWS}

    def of_lens(self, lens: Lens) -> dict[str, object]:
        assert isinstance(lens, TableLens)
        r = np.linspace(0, lens.reach, ROWS)
        rows = np.stack([_past_the_end(lens, colour, r) for colour in COLOURS], axis=1)
        ends = np.array([lens.distances[colour][-1] for colour in COLOURS])
        return {"lens_rows": rows, "lens_ends": ends, "lens_row_step": lens.reach / (ROWS - 1)}


def _past_the_end(lens: TableLens, colour: str, r: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the scales at r, straight on past the end, for the row that an end lies before."""
    end, step = lens.distances[colour][-1], 1e-4
    before, last = lens.scales(colour, np.array([end - step, end]))
    return np.where(r <= end, lens.scales(colour, np.minimum(r, end)), last + (r - end) * (last - before) / step)
