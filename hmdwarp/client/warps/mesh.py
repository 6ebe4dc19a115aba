"""The rendered picture as a mesh with a vertex at every pixel."""

from __future__ import annotations

from typing import Literal

import attrs

from ..warp_kinds import MeshWarp
from . import warps

STEEPEST_DEG = 85.0


@attrs.frozen
class MeshSettings:
    """Where the mesh is cut."""

    # How sheets between two surfaces are found.
    cut: Literal["slope", "vertex", "both"] = attrs.field(
        default="slope", validator=attrs.validators.in_(("slope", "vertex", "both"))
    )
    # Planes seen at up to this angle from facing stay whole.
    steepest_deg: float = attrs.field(default=STEEPEST_DEG, validator=[attrs.validators.gt(0), attrs.validators.lt(90)])


@warps.register
class Mesh(MeshWarp):
    """A mesh with one vertex a pixel.

    Sheets between surfaces are cut by slope before they are drawn, by vertex identity after, or by
    either.
    """

    name = "mesh"
    summary = "draws the rendered picture as triangles between its pixels, cut where surfaces part"
    exact_when = (
        "surfaces are seen in the rendered picture and are smooth from one pixel to the next, up to one bilinear "
        "resample"
    )
    gets_wrong = "what was hidden is a hole; every edge is half a pixel wide of the truth; slow where triangles are"
    source = "Mark, McMillan and Bishop 1997, Post-Rendering 3D Warping; Mark 1999 (thesis), 3.3"
    Settings = MeshSettings
    adaptive = False

    @property
    def cuts(self) -> tuple[bool, bool]:
        return self.settings.cut != "vertex", self.settings.cut != "slope"
