"""Shift, rotation and scale of the picture, as `planar` has them in the middle of the view."""

from __future__ import annotations

from ...geometry import Fov
from ..inputs import PassInputs
from ..warp_kinds import PlaneWarp
from . import warps


@warps.register
class Similarity(PlaneWarp):
    """A gather through the similarity nearest to the planar map around the middle of the view.

    It has the planar map's value there, and of all rotations with scale the one whose derivative is
    nearest to the planar map's in the sense of least squares over all directions.
    """

    name = "similarity"
    summary = "shifts, rolls and scales the picture as the plane at its median depth does in the middle of the view"
    exact_when = "the eye only rolls; or it moves straight, without a turn, before a plane that faces it"
    gets_wrong = "how a turn stretches the picture towards its border, and all that planar gets wrong"
    source = "the 2014 thesis, section 2.4; the nearest similarity is the conformal part of the map's Jacobian"
    shader = "warps/similarity.comp"
    scans_out = False  # one similarity for the whole picture

    def own_uniforms(self, inputs: PassInputs) -> dict[str, object]:
        wide, high = self.shown_size
        return {
            "middle": (wide / 2, high / 2),
            "shown_per_tangent": _pixels_per_tangent(inputs.shown.fov, self.shown_size),
            "rendered_per_tangent": _pixels_per_tangent(inputs.rendered.view.fov, self.rendered_size),
        }


def _pixels_per_tangent(fov: Fov, size: tuple[int, int]) -> tuple[float, float]:
    (x, _, _), (_, y, _), _ = fov.pixel_from_tangent(size).tolist()
    return x, y
