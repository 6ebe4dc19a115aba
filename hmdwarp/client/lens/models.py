"""The lenses of headsets: none, a polynomial, a table, SteamVR's, a mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...geometry import Fov
from ...gpu.textures import Canvas, release_all
from ...headsets import COLOURS, Lens, MeshLens, RadialLens, TableLens, ViveLens
from . import LensPass, ResampledLens, lenses


@lenses.register
class NoLens(LensPass):
    """Leave the picture undistorted; the plan leaves this pass out."""

    name = "none"
    summary = "no distortion: for flat screens and for runtimes that distort by themselves"
    source = "the baseline of every lens"
    is_pass = False

    def prepare(self) -> None:
        """Do nothing."""

    def run(self, shown: Canvas, fov: Fov, eye: int, into: Canvas) -> None:
        raise AssertionError("the plan leaves this lens out")


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
        ends, step, rows = np.array([lens.distances[colour][-1] for colour in COLOURS]), 1e-4, []
        for colour, end in zip(COLOURS, ends, strict=True):
            # Straight on past the end, for the row that it lies before.
            before, last = lens.scales(colour, np.array([end - step, end]))
            past = last + (r - end) * (last - before) / step
            rows.append(np.where(r <= end, lens.scales(colour, np.minimum(r, end)), past))
        return {"lens_rows": np.stack(rows, axis=1), "lens_ends": ends, "lens_row_step": lens.reach / (ROWS - 1)}


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


_MESH = 14  # texture unit


@lenses.register
class Mesh(ResampledLens):
    """Sample once per channel where the mesh of that channel says."""

    name = "mesh"
    summary = "directions at the points of a grid over the panel, bilinear between them, one grid per colour"
    library = "lens/mesh.glsl"
    source = "OpenVR, IVRSystem::ComputeDistortion on a grid; meshes: the headset's file"

    def prepare(self) -> None:
        super().prepare()
        self._textures = []
        for lens in self.eye_lenses:
            assert isinstance(lens, MeshLens)
            grid = np.concatenate([lens.points[colour] for colour in COLOURS])
            size = grid.shape[1], grid.shape[0]
            self._textures.append(self.gpu.gl.texture(size, 2, grid.astype(np.float32).tobytes(), dtype="f4"))

    def close(self) -> None:
        release_all(*self._textures)

    def library_defines(self) -> dict[str, object]:
        return {**super().library_defines(), "LENS_TANGENTS": 1}

    def library_uniforms(self, fov: Fov, eye: int) -> dict[str, object]:
        self._textures[eye].use(_MESH)
        return super().library_uniforms(fov, eye)

    def of_lens(self, lens: Lens) -> dict[str, object]:
        assert isinstance(lens, MeshLens)
        return {"lens_panel": lens.panel_m, "lens_mesh": _MESH}
