"""Warps, registered by name; those of one family share a file.

Each has a shader of the same stem, or shares a sibling's where only the numbers differ.
"""

from ..settings import DescribedRegistry
from ._base import KEY_BYTES, ArrayWarp, Output, Warp, pixel_of

warps: DescribedRegistry[type[Warp]] = DescribedRegistry(
    "warp",
    __name__,
    modules={
        **dict.fromkeys(("none", "rotation", "planar", "similarity", "shift"), "gather"),
        **dict.fromkeys(("environment", "backward"), "gather"),
        **dict.fromkeys(("mesh", "mesh_adaptive"), "mesh"),
        **dict.fromkeys(("layered", "multi"), "multi"),
        **dict.fromkeys(("forward", "forward_ordered", "forward_raster", "splat"), "forward"),
        **dict.fromkeys(("model", "difference"), "model"),
    },
    columns="kind reads settings=Settings fused_with_the_lens=fuses follows_scanout=scans_out exact_when gets_wrong",
)

__all__ = ["KEY_BYTES", "ArrayWarp", "Output", "Warp", "pixel_of", "warps"]
