"""Backward warping with the client's own geometry: it knows its depth now, and asks the late frame for the colour."""

from __future__ import annotations

import moderngl

from ...errors import PlanError
from ...frame import EyeImage
from ...geometry import View, WarpMap
from ...gpu.textures import Canvas
from . import warps
from ._base import Warp
from ._homography import bind_late_colour

# Inverse depth is linear across a plane, so between the looked-up point and a texel of its footprint it changes by at most
# one pixel's worth of slope. 3 % covers planes seen at up to 80 degrees at 10 pixels a degree (tan 80 x 0.1 deg = 1 %, on
# each axis, with the rounding of the client's own raster on top); nearer surfaces differ by more than that from what they hide.
DEPTH_TOLERANCE = 0.03
DEPTH_FLOOR = 0.02  # 1/m: things beyond 50 m count as equally far


@warps.register
class Backward(Warp):
    """A gather with the client's own depth; a depth test against the late depth keeps disoccluded pixels empty."""

    name = "backward"
    summary = "the client draws its own depth now and fetches the colour from the late picture"
    kind = "gather"
    reads = ("late.colour", "late.inverse_depth", "client.inverse_depth")
    exact_when = "always, up to one bilinear resample, where the late picture saw the surface"
    gets_wrong = "needs the scene's geometry; shading that depends on the view stays late"
    source = "McMillan and Bishop 1995 (the map); Williams 1978 (the depth test)"

    def prepare(self) -> None:
        self._program = self.gpu.shaders.compute("warps/backward.comp")

    def run(self, late: EyeImage, shown: View, into: Canvas, client_inverse_depth: moderngl.Texture | None = None) -> None:
        if client_inverse_depth is None:
            raise PlanError("warp 'backward' needs the client's own depth, so a scene; for frames without one use 'forward'")
        gather = WarpMap.between(shown, self.shown_size, late.view, self.late_size)
        bind_late_colour(late, 0, whole_pixels=gather.moves_whole_pixels())
        late.inverse_depth.bind_to_image(1, read=True, write=False)
        client_inverse_depth.bind_to_image(2, read=True, write=False)
        into.bind_for_writing()
        self.set_sizes(self._program)
        self._program.uniforms.set(H=gather.H, e=gather.e, late_colour=0, late_inverse_depth=1, client_inverse_depth=2, shown_colour=0)
        self._program.uniforms.set(depth_tolerance=DEPTH_TOLERANCE, depth_floor=DEPTH_FLOOR)
        self._program.run(*self.shown_size)
