"""Composites of several pictures, and of the layers of one."""

from __future__ import annotations

import math
from typing import Any, Literal

import attrs
import numpy as np

from ...errors import PlanError
from ...frames import Needs, Others
from ...geometry import WarpMap, view_map
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


MOST_FRAMES, MOST_VIEWS = 8, 4
_CHOSEN = "rendered.views"


@attrs.frozen
class MultiSettings:
    """The pictures to use besides the newest."""

    frames: int = 2  # Past frames of the same eye.
    spacing: float = 300.0  # Least milliseconds between two of them.
    # Whether to use the other eye's picture too, or only the eye's own.
    eye: Literal["other", "own"] = attrs.field(default="other", validator=attrs.validators.in_(("other", "own")))

    # Further pictures that the server draws for this eye, from places that it may come to.
    views: int = 0

    def __attrs_post_init__(self) -> None:
        if not 0 <= self.views <= MOST_VIEWS:
            raise ValueError(f"views is {self.views}: expected 0 to {MOST_VIEWS} further pictures")
        if not 0 <= self.frames <= MOST_FRAMES:
            raise ValueError(f"frames is {self.frames}: expected 0 to {MOST_FRAMES} past frames")
        if not (math.isfinite(self.spacing) and 0 <= self.spacing <= 60_000):
            raise ValueError(f"spacing is {self.spacing:g} ms: expected 0 to 60000")


@warps.register
class Multi(CompositeWarp):
    """Combine the newest frame, then the other eye's, then further views of it, then past ones.

    Each adds what those before it could not see.
    """

    name = "multi"
    summary = "fills what the newest frame did not see from the other eye's and from past frames"
    reads = ("rendered.colour", "rendered.inverse_depth", "rendered.others", _CHOSEN)
    exact_when = "always, up to one bilinear resample, where one of the frames saw the surface and the scene is static"
    gets_wrong = "what no frame saw; things that moved, where the newest frame cannot contradict the older ones"
    source = "Mark et al. 1997, Post-Rendering 3D Warping; Mark 1999 (thesis); Bowles et al. 2012 (the gather)"
    Settings = MultiSettings
    best = (2, "f4")

    @classmethod
    def needs(cls, settings: Any) -> Needs:
        spacing_ns = round(settings.spacing * 1e6) if settings.frames else 0
        return Needs(others=Others(settings.frames, spacing_ns, settings.eye == "other"), views=settings.views)

    @classmethod
    def reads_for(cls, settings: Any) -> tuple[str, ...]:
        return cls.reads if settings.views else tuple(name for name in cls.reads if name != _CHOSEN)

    def pictures(self, inputs: PassInputs) -> list[DepthPicture]:
        """Return the newest picture and the others.

        The newest alone for an eye that has not moved and sees no more than before.
        """
        rendered, others = inputs.rendered, inputs.others
        back = self._newest(inputs)
        if back.moves_whole_pixels():
            low = np.round(back.H[:2, 2])
            if (low >= 0).all() and (low + self.shown_size <= rendered.size).all():
                others = ()
        return [DepthPicture(image.colour, image.inverse_depth, image.view) for image in (rendered, *others)]

    def own_uniforms(self, inputs: PassInputs) -> dict[str, object]:
        inputs.rendered.inverse_depth.bind_to_image(3, read=True, write=False)
        newest = self._newest(inputs)
        return {
            "newest_inverse_depth": 3,
            "newest_size": inputs.rendered.size,
            "newest_H": newest.H,
            "newest_e": newest.e,
        }

    def _newest(self, inputs: PassInputs) -> WarpMap:
        return view_map(inputs.shown, self.shown_size, inputs.rendered.view, inputs.rendered.size)
