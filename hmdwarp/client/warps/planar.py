"""Planar reprojection: everything on one plane, at the median depth of the rendered picture."""

from ..warp_kinds import PlaneWarp
from . import warps


@warps.register
class Planar(PlaneWarp):
    """A gather through the fronto-parallel plane at the median inverse depth."""

    name = "planar"
    summary = "turns and shifts the picture as one plane at its median depth"
    exact_when = "the eye only turns, or everything lies on one plane facing the eye"
    gets_wrong = "parallax: nearer things move too little, farther ones too much"
    source = (
        "XR_MSFT_composition_layer_reprojection, planar from depth; McMillan and Bishop 1995 for the plane's homography"
    )
    shader = "warps/planar.comp"
