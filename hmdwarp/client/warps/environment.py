"""Environment map: the server sends everything around the eye, so the head turns freely."""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np

from ...errors import PlanError
from ...frames import Needs
from ...geometry import Pose, View, WarpMap, view_map
from ...geometry.cube import face_views
from ...gpu.textures import Canvas
from ...options import NoSettings
from ..inputs import PassInputs
from ..warp_kinds import GatherWarp
from . import warps

_EYE_FROM_HOMOGENEOUS = np.diag([1.0, 1.0, -1.0])  # the tangent point (x, y, 1) lies at (x, y, -1)


@warps.register
class Environment(GatherWarp):
    """A gather from a cube map around the rendered eye: one bilinear sample per pixel, no depth."""

    name = "environment"
    needs_compute = False
    Settings = NoSettings
    summary = "turns freely within a cube map drawn around the eye, ignores how the eye moved"
    reads = ("rendered.cube",)
    exact_when = "the eye only turns, by any angle, up to one bilinear resample"
    gets_wrong = "near things under translation, as rotation; six faces are drawn and sent instead of one picture"
    source = "Chen 1995, QuickTime VR; Greene 1986, Environment Mapping (the cube)"
    resamples = True
    carries = False
    depth_reads = None

    def prepare(self) -> None:
        self._program = self.gather("warps/environment.comp")

    @classmethod
    def needs(cls, settings: Any) -> Needs:
        return Needs(cube=True)

    def map_between(self, shown: View, rendered: View) -> WarpMap:
        """Return the map from shown pixels to directions in the axes of the rendered eye."""
        turn = rendered.pose.rotation.inv() * shown.pose.rotation
        tangent_from_pixel = np.linalg.inv(shown.fov.pixel_from_tangent(self.shown_size))
        return WarpMap(turn.as_matrix() @ _EYE_FROM_HOMOGENEOUS @ tangent_from_pixel, np.zeros(3))

    def picture(self, inputs: PassInputs) -> moderngl.Texture:
        cube: moderngl.Texture = inputs.rendered["cube"]
        return cube

    def bind_colour(self, inputs: PassInputs, unit: int, maps: list[WarpMap]) -> None:
        cube, shown, chosen = inputs.rendered["cube"], inputs.shown, moderngl.LINEAR
        if self.output.lens is None and not self.output.scanout and np.abs(shown.fov.tangents).max() <= 1 + 1e-9:
            here = View(Pose(shown.pose.position_m, inputs.rendered.view.pose.orientation_xyzw), shown.fov)
            side = cube.size[0] // 3
            of_faces = (view_map(shown, self.shown_size, face, (side, side)) for face in face_views(here, side))
            if any(each.moves_whole_pixels() for each in of_faces):  # each pixel is one of one face
                chosen = moderngl.NEAREST
        cube.filter = (chosen, chosen)
        cube.use(unit)

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        cube = inputs.rendered.get("cube")
        if cube is None:
            raise PlanError(
                "warp 'environment' needs a cube map around the eye, which this frame lacks; frames from a scene "
                "have it"
            )
        side = cube.size[0] // 3
        pixel = (1 / cube.size[0], 1 / cube.size[1])
        self.run_gather(self._program, inputs, into, face_size=float(side), rendered_pixel=pixel)
