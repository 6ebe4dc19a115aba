"""Irradiance map: indirect light of the whole scene in one atlas, added by clients that draw it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ..client import ClientScene, PassInputs, ShownPicture, Store, Surfaces, whole_weight
from ..client.strategies import Strategy, strategies
from ..client.warp_kinds import ClientDrawing
from ..client.warps import warps
from ..frames import EyeImage, Needs
from ..frames.layers import BRIGHT_VIDEO, OWN, EyeSizes, Layer, layers
from ..geometry import View
from ..gpu import Canvas, Uniforms
from ..scenes import ATLAS, indirect_atlas
from ..sources.server import Lighting
from ..sources.server.parts import DrawContext, Drawing, Part, parts
from ..sources.server.passes import Viewport


@layers.register
class IrradianceLayer(Layer):
    """The light atlas of the surfaces: what each gets from the others and the sky.

    The amount is how many times a second it changes at most; every frame has the newest whole.
    """

    name = "irradiance"
    summary = "indirect light of all surfaces in one light atlas, whatever the eye sees"
    formats = ("rgba16f",)
    codings = (BRIGHT_VIDEO,)
    size_class = OWN
    drawn_by = "irradiance"
    per_frame = True
    # It is lit for the first frame of each update.
    builds_on_frames = True
    something = 10.0

    @classmethod
    def size(cls, sizes: EyeSizes) -> tuple[int, int]:
        return ATLAS

    @classmethod
    def pictures(cls, amount: Any) -> tuple[str, ...]:
        return cls.formats


@parts.register
class IrradiancePart(Part):
    """Solved anew for the first frame of each update; the frames until the next carry it too.

    Without lamps it is black: all light is baked.
    """

    name = "irradiance"
    order = 130
    of_client = True

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._update: int | None = None
        self._atlas: NDArray[np.float16] = np.zeros((*ATLAS[::-1], 4), np.float16)

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        return eye

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        scene = self.context.scene
        # The thousandth keeps frames that are drawn at the very rate of the updates apart.
        update = int(drawing.time_ns * drawing.needs["irradiance"] * 1e-9 + 1e-3)
        if scene.lamps and update != self._update:
            self._atlas, self._update = indirect_atlas(scene, drawing.time_ns), update
        into = self.context.acquire(ATLAS, depth=False).colour
        into.write(self._atlas.tobytes())
        return {"irradiance": into}


class _AtlasLight(Lighting):
    """Its indirect light is the atlas that its owner sets."""

    indirect: moderngl.Texture

    def use(self, uniforms: Uniforms, view: View, viewport: Viewport, time_ns: int) -> None:
        self.use_lamps(uniforms, time_ns)
        self.use_atlas(uniforms, self.indirect)


@attrs.frozen
class _IrradianceSettings:
    # Times a second that the server solves indirect light anew, at most.
    updates: float = attrs.field(default=10.0, validator=attrs.validators.gt(0))


class _SceneUnderLight(Store):
    """The whole scene under its own lamps; its indirect light comes with each picture.

    Without lamps it is drawn by its baked light.
    """

    def __init__(self, client: ClientScene, wanted: None) -> None:
        super().__init__(client, wanted)
        self._surfaces = Surfaces(client.gpu, client.scene, _AtlasLight, samples=client.server.samples)

    def draw(self, view: View, into: ShownPicture, time_ns: int, indirect: moderngl.Texture) -> None:
        """Draw the whole picture. indirect: the light atlas, rgba16f."""
        if lighting := self._surfaces.lighting(_AtlasLight):
            lighting.indirect = indirect
        self._surfaces.draw(view, into, time_ns, _AtlasLight)

    def weights(self) -> list[dict[str, Any]]:
        return [whole_weight(self.client.scene)]

    def close(self) -> None:
        self._surfaces.close()


@warps.register
class IrradianceWarp(ClientDrawing):
    """Draw for the shown view and instant; each pixel looks its indirect light up once.

    Lamps and their shadows are where they are at that instant: the client knows how they move.
    """

    name = "irradiance"
    summary = "the client draws the scene with direct light at the newest pose, and adds indirect light that is late"
    reads = ("client.model", "rendered.irradiance")
    exact_when = "indirect light has not changed since it was solved, up to the link's code; direct light is never late"
    gets_wrong = "indirect light is late by the link and up to one update; takes the whole scene on the client"
    source = "Crassin et al. 2013, CloudLight (irradiance maps)"
    Settings = _IrradianceSettings
    variants = ("updates=5.0", "updates=30.0")
    for_moving_light = True

    @classmethod
    def needs(cls, settings: _IrradianceSettings) -> Needs:
        return Needs(irradiance=settings.updates)

    def prepare_scene(self, geometry: ClientScene) -> None:
        self._scene = geometry.store(_SceneUnderLight)

    def run_with_depth(self, inputs: PassInputs, into: Canvas, depth: moderngl.Texture) -> None:
        picture = ShownPicture(into, depth)
        self._scene.draw(inputs.middle, picture, inputs.shown_ns, inputs.rendered["irradiance"])


@strategies.register
class IrradianceStrategy(Strategy):
    """For scenes whose light moves; one map serves any number of clients."""

    name = "irradiance"
    summary = "the server sends indirect light as an atlas; the client draws the scene with direct light and adds it"
    crosses = "the scene once; an atlas of indirect light"
    client = "draws the scene with direct light at the newest pose, adds indirect light"
    late = "indirect light"
    classes = (3,)
    source = "Crassin et al. 2013, CloudLight"
    warp, fill = "irradiance", "none"
