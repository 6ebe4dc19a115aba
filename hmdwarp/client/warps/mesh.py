"""The rendered picture as a mesh of triangles: of a grid, or of cells where it is flat."""

from __future__ import annotations

from typing import Any, Literal

import attrs

from ...gpu.textures import Canvas
from ..inputs import PassInputs
from ..warp_kinds import GridMesh, MeshWarp
from . import warps

STEEPEST_DEG = 85.0
MOST_VERTICES = 1024  # a side: a vertex's index times the picture's side stays below 2^24
RING = 0.005  # of the picture; openwarp's program sets one cell of its grid


@attrs.frozen
class MeshSettings:
    """Where the mesh is cut; or, with a grid, how it is stretched."""

    # How sheets between two surfaces are found.
    cut: Literal["slope", "vertex", "both"] = attrs.field(
        default="slope", validator=attrs.validators.in_(("slope", "vertex", "both"))
    )
    # Planes seen at up to this angle from facing stay whole.
    steepest_deg: float = attrs.field(default=STEEPEST_DEG, validator=[attrs.validators.gt(0), attrs.validators.lt(90)])
    # Vertices on each axis of a mesh that is stretched across edges; 0 for one at each pixel, cut.
    grid: int = 0
    # Share of the picture at which a grid's vertex looks around itself for a nearer surface to lie
    # on; 0 for its own depth.
    ring: float = attrs.field(default=RING, validator=[attrs.validators.ge(0), attrs.validators.le(0.5)])

    def __attrs_post_init__(self) -> None:
        if self.grid != 0 and not 2 <= self.grid <= MOST_VERTICES:
            raise ValueError(f"grid is {self.grid}: expected 2 to {MOST_VERTICES} vertices a side, or 0 for none")
        if self.grid and (self.cut, self.steepest_deg) != ("slope", STEEPEST_DEG):
            raise ValueError(f"grid={self.grid} is stretched across edges: leave out cut and steepest_deg, or the grid")
        if not self.grid and self.ring != RING:
            raise ValueError(f"ring is {self.ring:g}, but only a grid has one: give grid too, or leave it out")


@warps.register
class Mesh(MeshWarp):
    """A mesh with one vertex a pixel, or with a grid of fewer.

    Sheets between surfaces are cut by slope before they are drawn, by vertex identity after, or by
    either; those of a grid are not cut.
    """

    name = "mesh"
    summary = "draws the rendered picture as triangles between its pixels, cut where surfaces part"
    exact_when = (
        "surfaces are seen in the rendered picture and are smooth from one pixel to the next, up to one bilinear "
        "resample"
    )
    gets_wrong = (
        "what was hidden is a hole; every edge is half a pixel wide of the truth; slow where triangles are; with a "
        "grid, edges are off by up to a cell, and what was hidden shows colours stretched from beside it"
    )
    source = (
        "Mark, McMillan and Bishop 1997, Post-Rendering 3D Warping; Mark 1999 (thesis), 3.3; the grid: openwarp in "
        "Huzaifa et al. 2021, ILLIXR"
    )
    Settings = MeshSettings
    baselines = {"grid=64": "CloudXR.js", "grid=512,ring=0.002": "ILLIXR openwarp"}
    adaptive = False

    @property
    def cuts(self) -> tuple[bool, bool]:
        return self.settings.cut != "vertex", self.settings.cut != "slope"

    def prepare(self) -> None:
        chosen = self.settings
        if chosen.grid:
            self._grid = GridMesh(self.gpu, self.rendered_size, self.shown_size, chosen.grid, chosen.ring)
        else:
            super().prepare()

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        if self.settings.grid:
            self._grid.run(inputs, into)
        else:
            super().run(inputs, into)

    def close(self) -> None:
        if self.settings.grid:
            self._grid.close()
        else:
            super().close()


BLOCKS = (1, 2, 4, 8, 16)


@attrs.frozen
class MeshAdaptiveSettings:
    """How far cells are merged."""

    # Shown pixels by which merging may displace a point.
    tolerance: float = attrs.field(default=0.05, validator=attrs.validators.ge(0))
    # Pixels on a side of the largest cell: 1, 2, 4, 8 or 16.
    block: int = attrs.field(default=16, validator=attrs.validators.in_(BLOCKS))
    # Planes seen at up to this angle from facing stay whole.
    steepest_deg: float = attrs.field(default=STEEPEST_DEG, validator=[attrs.validators.gt(0), attrs.validators.lt(90)])


@warps.register
class MeshAdaptive(MeshWarp):
    """`mesh` with cells of up to 16x16 pixels where this motion stays within the tolerance."""

    name = "mesh_adaptive"
    summary = (
        "as mesh, with few large triangles where the surface is flat: the same picture within a twentieth of a pixel"
    )
    exact_when = "as mesh, up to the tolerance (in shown pixels)"
    gets_wrong = "as mesh; detail in depth below the tolerance is flattened"
    source = (
        "Schollmeyer et al. 2017, Efficient Hybrid Image Warping; "
        "Reinert et al. 2016, Proxy-guided Image-based Rendering"
    )
    Settings = MeshAdaptiveSettings
    adaptive = True

    @property
    def merging(self) -> dict[str, Any]:
        return {"tolerance": self.settings.tolerance, "coarsest": self.settings.block}
