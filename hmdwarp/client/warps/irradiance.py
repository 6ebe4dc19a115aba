"""The client draws the scene under its own direct light; indirect light arrives as an atlas."""

from __future__ import annotations

from typing import Any

import attrs
import moderngl

from ...frames import Needs
from ...geometry import View
from ...gpu.textures import Canvas
from ...sources.server import Indirect
from ..client_scene import ClientScene, Store
from ..drawn_scenes import Surfaces, whole_weight
from ..inputs import PassInputs, ShownPicture
from ..warp_kinds import ClientDrawing
from . import warps


@attrs.frozen
class IrradianceSettings:
    # Times a second that the server solves indirect light anew, at most.
    updates: float = attrs.field(default=10.0, validator=attrs.validators.gt(0))


class SceneUnderLight(Store):
    """The whole scene under its own lamps; its indirect light comes with each picture.

    Without lamps it is drawn by its baked light.
    """

    def __init__(self, client: ClientScene, wanted: None) -> None:
        super().__init__(client, wanted)
        self._surfaces = Surfaces(client.gpu, client.scene, Indirect.ATLAS, samples=client.server.samples)

    def draw(self, view: View, into: ShownPicture, time_ns: int, indirect: moderngl.Texture) -> None:
        """Draw the whole picture. indirect: the light atlas, rgba16f."""
        if lighting := self._surfaces.lighting(Indirect.ATLAS):
            lighting.indirect = indirect
        self._surfaces.draw(view, into, time_ns, Indirect.ATLAS)

    def weights(self) -> list[dict[str, Any]]:
        return [whole_weight(self.client.scene)]

    def close(self) -> None:
        self._surfaces.close()


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

    def prepare_scene(self, geometry: ClientScene) -> None:
        self._scene = geometry.store(SceneUnderLight)

    def run_with_depth(self, inputs: PassInputs, into: Canvas, depth: moderngl.Texture) -> None:
        picture = ShownPicture(into, depth)
        self._scene.draw(inputs.middle, picture, inputs.shown_ns, inputs.rendered["irradiance"])
