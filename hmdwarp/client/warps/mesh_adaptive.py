"""The rendered picture as a mesh that is coarse where inverse depth is planar."""

from __future__ import annotations

from typing import Any

import attrs

from ..warp_kinds import MeshWarp
from . import warps
from .mesh import STEEPEST_DEG

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
