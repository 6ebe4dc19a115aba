"""Warps by one map of the whole picture: none, a turn, a plane, a similarity, a shift."""

from __future__ import annotations

from typing import Literal

import attrs
import numpy as np

from ...geometry import Fov, Pose, View, WarpMap
from ...options import NoSettings
from ..inputs import PassInputs
from ..warp_kinds import GatherSettings, HomographyWarp, PlaneWarp
from . import warps


@warps.register
class NoWarp(HomographyWarp):
    """Show the rendered picture at its place in the field of view, as if the head had not moved.

    A guard band is cut off.
    """

    name = "none"
    needs_compute = False
    Settings = NoSettings
    summary = "the rendered picture as it is: what uncompensated latency looks like"
    exact_when = "the head is still"
    gets_wrong = "everything that moves relative to the head"
    source = "the baseline of every comparison"
    imposter = True

    def map_between(self, shown: View, rendered: View) -> WarpMap:
        return super().map_between(View(rendered.pose, shown.fov), rendered)


@attrs.frozen
class RotationSettings(GatherSettings):
    """What is shown beyond the border of the rendered picture."""

    # clamp: its outermost pixels go on, so that no border is seen. Nothing counts as a hole then.
    edge: Literal["empty", "clamp"] = "empty"


@warps.register
class Rotation(HomographyWarp):
    """Rotate the picture with the head; ignore the eye's translation (asynchronous time warp)."""

    name = "rotation"
    needs_compute = False
    summary = "turns the picture with the head, ignores how the eye moved"
    exact_when = "the eye only turns, or everything is far away"
    gets_wrong = (
        "near things under translation: they stay glued to the far background; with edge=clamp, streaks where the "
        "rendered picture ends"
    )
    source = "van Waveren 2016, The Asynchronous Time Warp for Virtual Reality on Consumer Hardware"
    Settings = RotationSettings
    baselines = {"edge=clamp": "most streamers"}

    @property
    def clamps(self) -> bool:
        return bool(self.settings.edge == "clamp")

    def map_between(self, shown: View, rendered: View) -> WarpMap:
        return super().map_between(
            View(Pose(rendered.pose.position_m, shown.pose.orientation_xyzw), shown.fov), rendered
        )


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


@warps.register
class Shift(HomographyWarp):
    """Move the picture so that the middle of the view is where the head's turn puts it."""

    name = "shift"
    needs_compute = False
    summary = "moves the picture by one offset, that of the middle of the view"
    exact_when = "the head is still"
    gets_wrong = "roll, how a turn stretches the picture towards its border, and all that rotation gets wrong"
    source = "So and Griffin 1992, Compensating Lags in Head-Coupled Displays Using Head Position Prediction and "
    source += "Image Deflection; the 2014 thesis, section 2.4"

    def map_between(self, shown: View, rendered: View) -> WarpMap:
        """Return the translation; where the middle lies behind the rendered eye, w < 0."""
        left, right, down, up = shown.fov.tangents
        middle = np.array([(left + right) / 2, (down + up) / 2, -1.0])
        to = (rendered.pose.rotation.inv() * shown.pose.rotation).apply(middle)
        offset = to[:2] / abs(to[2]) - middle[:2]
        moved = np.array([[1.0, 0, offset[0]], [0, 1, offset[1]], [0, 0, 1 if to[2] < 0 else -1]])
        into = rendered.fov.pixel_from_tangent(self.rendered_size)
        return WarpMap(into @ moved @ np.linalg.inv(shown.fov.pixel_from_tangent(self.shown_size)), np.zeros(3))
