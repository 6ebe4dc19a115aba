"""The client draws the scene under its own direct light; indirect light arrives as an atlas."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs

from ...frames import Needs
from ..shown_picture import ShownPicture
from ..warp_kinds import ClientDrawing
from . import warps

if TYPE_CHECKING:
    import moderngl

    from ...gpu.textures import Canvas
    from ..client_geometry import ClientGeometry
    from ..inputs import PassInputs


@attrs.frozen
class IrradianceSettings:
    # Times a second that the server solves indirect light anew, at most.
    updates: float = attrs.field(default=10.0, validator=attrs.validators.gt(0))


@warps.register
class Irradiance(ClientDrawing):
    """Draw for the shown view and instant; each pixel looks its indirect light up once.

    Lamps and their shadows are where they are at that instant: the client knows how they move.
    """

    name = "irradiance"
    summary = "the client draws the scene with direct light at the newest pose, and adds indirect light that is late"
    reads = ("client.model", "rendered.irradiance")
    exact_when = "indirect light has not changed since it was solved, up to the link's code; direct light is never late"
    gets_wrong = "indirect light is late by the link and up to one update; takes the whole scene on the client"
    source = "Crassin et al. 2013, CloudLight (irradiance maps)"
    Settings = IrradianceSettings
    variants = ("updates=5.0", "updates=30.0")
    for_moving_light = True

    @classmethod
    def needs(cls, settings: IrradianceSettings) -> Needs:
        return Needs(irradiance=settings.updates)

    def prepare_scene(self, geometry: ClientGeometry) -> None:
        self._scene = geometry.under_light()

    def run_with_depth(self, inputs: PassInputs, into: Canvas, depth: moderngl.Texture) -> None:
        picture = ShownPicture(into, depth)
        self._scene.draw(inputs.middle, picture, inputs.shown_ns, inputs.rendered["irradiance"])
