"""The client draws the scene under its own direct light; indirect light arrives as an atlas."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs

from ...errors import PlanError
from ...frames import Needs
from ...gpu.textures import SCALAR, allocate
from ..shown_picture import ShownPicture
from . import warps
from ._base import Warp

if TYPE_CHECKING:
    import moderngl

    from ...gpu.textures import Canvas
    from ...scenes import Scene
    from ..inputs import PassInputs


@attrs.frozen
class IrradianceSettings:
    # Times a second that the server solves indirect light anew, at most.
    updates: float = attrs.field(default=10.0, validator=attrs.validators.gt(0))


@warps.register
class Irradiance(Warp):
    """Draw for the shown view and instant; each pixel looks its indirect light up once.

    Lamps and their shadows are where they are at that instant: the client knows how they move.
    """

    name = "irradiance"
    summary = "the client draws the scene with direct light at the newest pose, and adds indirect light that is late"
    kind = "draw"
    needs_compute = False
    reads = ("client.model", "rendered.irradiance")
    exact_when = "indirect light has not changed since it was solved, up to the link's code; direct light is never late"
    gets_wrong = "indirect light is late by the link and up to one update; takes the whole scene on the client"
    source = "Crassin et al. 2013, CloudLight (irradiance maps)"
    Settings = IrradianceSettings
    variants = ("updates=5.0", "updates=30.0")
    depth_reads = ()
    carries = False

    @classmethod
    def needs(cls, settings: IrradianceSettings) -> Needs:
        return Needs(irradiance=settings.updates)

    @classmethod
    def unsuited(cls, scene: Scene) -> str:
        return "" if scene.lamps else "its light stands still, so that 'model' with baked light is exact"

    def prepare(self) -> None:
        if self.geometry is None:
            raise PlanError("warp 'irradiance' needs the scene on the client; for frames without one use 'iterative'")
        self._scene = self.geometry.under_light()
        # Where the depth goes that nobody reads; it keeps near surfaces before far ones.
        self._own_depth = allocate(self.gpu.gl, self.shown_size, SCALAR)

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        self.run_with_depth(inputs, into, self._own_depth)

    def run_with_depth(self, inputs: PassInputs, into: Canvas, depth: moderngl.Texture) -> None:
        picture = ShownPicture(into, depth)
        self._scene.draw(inputs.middle, picture, inputs.shown_ns, inputs.rendered["irradiance"])

    def close(self) -> None:
        super().close()
        self._own_depth.release()
