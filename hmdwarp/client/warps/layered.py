"""Layered depth: the server also sends the surfaces that edges uncover."""

from __future__ import annotations

from typing import Any

import attrs

from ...errors import PlanError
from ...frames import Needs
from ..inputs import PassInputs
from ..warp_kinds import CompositeWarp, DepthPicture
from . import warps

MOST_LAYERS = 4


@attrs.frozen
class LayeredSettings:
    layers: int = 3  # Depth layers, the visible one included, 2 to 4.

    def __attrs_post_init__(self) -> None:
        if not 2 <= self.layers <= MOST_LAYERS:
            raise ValueError(f"layers is {self.layers}: expected 2 to {MOST_LAYERS}, the visible one included")


@warps.register
class Layered(CompositeWarp):
    """Warp all layers together, the nearest surface wins: real content behind edges."""

    name = "layered"
    summary = "warps two to four depth layers of the server together: real content behind edges"
    reads = ("rendered.colour", "rendered.inverse_depth", "rendered.peeled")
    exact_when = "always, up to one bilinear resample, where a layer holds the surface"
    gets_wrong = (
        "what no layer holds or the rendered field of view did not; the server draws the scene once more per layer"
    )
    source = "Shade et al. 1998, Layered Depth Images; Everitt 2001 (peeling); Bowles et al. 2012 (the gather)"
    Settings = LayeredSettings

    @classmethod
    def needs(cls, settings: Any) -> Needs:
        return Needs(peeled=settings.layers - 1)

    def own_uniforms(self, inputs: PassInputs) -> dict[str, object]:
        inputs.rendered.inverse_depth.bind_to_image(3, read=True, write=False)
        return {"front_inverse_depth": 3}

    def pictures(self, inputs: PassInputs) -> list[DepthPicture]:
        rendered, behind = inputs.rendered, self.settings.layers - 1
        peeled = rendered.get("peeled", ())
        if len(peeled) < behind:
            raise PlanError(
                f"warp 'layered' needs {behind} layers behind the visible one, this frame has {len(peeled)}"
            )
        return [DepthPicture(each.colour, each.inverse_depth, rendered.view) for each in (rendered, *peeled[:behind])]
