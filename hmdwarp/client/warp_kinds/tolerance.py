"""When neighbouring texels, or two depths of one place, count as one surface.

They do if their inverse depths differ by at most DEPTH_TOLERANCE * (inverse depth + DEPTH_FLOOR),
and by what the code of depth may have added.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from ...frames import EyeImage

# Inverse depth is linear across a plane, so between a sampled point and a texel of its footprint it
# changes by at most one pixel's worth of slope. 3 % covers planes seen at up to 80 degrees at 10
# pixels a degree (tan 80 x 0.1 deg = 1 %, on each axis, with the rounding of the client's own
# raster on top); nearer surfaces differ by more than that from those they occlude.
DEPTH_TOLERANCE = 0.03
DEPTH_FLOOR = 0.02  # 1/m: things beyond 50 m count as equally far


class _Limits(Protocol):
    """Settings of a warp that compares depths."""

    @property
    def tolerance(self) -> float: ...

    @property
    def floor(self) -> float: ...


def depth_limits(settings: _Limits, rendered: EyeImage) -> dict[str, object]:
    """Return the uniforms of the comparison: a tolerance, and a floor under it.

    Coded depth is off by depth_error, which the floor takes in: tolerance * floor is the part that
    does not grow with inverse depth. A tolerance of 0 stays 0.
    """
    more = rendered.depth_error / settings.tolerance if settings.tolerance else 0.0
    return {"depth_tolerance": settings.tolerance, "depth_floor": settings.floor + more}
