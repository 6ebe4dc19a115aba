"""The client draws the scene under its own direct light; indirect light arrives as photons."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs

from ...frames import Needs
from ...frames.layers.photons import PhotonMap
from ...frames.photon_bundles import LEAST_BUDGET
from ..shown_picture import ShownPicture
from ..warp_kinds import ClientDrawing, Splats
from . import warps

if TYPE_CHECKING:
    import moderngl

    from ...gpu.textures import Canvas
    from ..client_geometry import ClientGeometry
    from ..inputs import PassInputs

_DEFAULT = PhotonMap()
MOST_PATHS = 1 << 16


@attrs.frozen
class PhotonsSettings:
    # Bytes of each frame, at most, before they are packed: what the link carries in a frame's time,
    # so that no bundle is late by more than one. Bundles are as large as fits, up to 6 kB.
    budget: int = attrs.field(default=_DEFAULT.budget, validator=attrs.validators.ge(LEAST_BUDGET))
    # Paths that each lamp sends; they leave about one photon each.
    paths: int = attrs.field(
        default=_DEFAULT.paths,
        validator=attrs.validators.and_(attrs.validators.ge(1), attrs.validators.le(MOST_PATHS)),
    )
    # Metres that a photon lights around it: less is sharper, and uneven where photons are few.
    radius: float = attrs.field(default=_DEFAULT.radius, validator=attrs.validators.gt(0))
    # Shown pixels of one pixel of the splatted light, on each axis.
    scale: int = attrs.field(default=4, validator=attrs.validators.ge(1))


@warps.register
class Photons(ClientDrawing):
    """Splat the photons at low resolution, and draw for the shown view and instant with that light.

    Lamps and their shadows are where they are at that instant: the client knows how they move.
    """

    name = "photons"
    summary = "the client draws the scene with direct light at the newest pose, and splats photons as indirect light"
    reads = ("client.model", "rendered.photons")
    exact_when = "never: indirect light is spread over the photons' radius; direct light is exact, and never late"
    gets_wrong = (
        "indirect light is late by the link and by the frames that its bundles take, smooth within the radius, and "
        "uneven where photons are few; takes the whole scene on the client"
    )
    source = "Crassin et al. 2013, CloudLight (photons); Jensen 1996 (photon maps)"
    Settings = PhotonsSettings
    variants = ("scale=8",)
    for_moving_light = True

    @classmethod
    def needs(cls, settings: PhotonsSettings) -> Needs:
        return Needs(photons=frozenset({_wanted(settings)}))

    def prepare_scene(self, geometry: ClientGeometry) -> None:
        chosen = self.settings
        photons = geometry.photons(_wanted(chosen))
        self._scene = photons.scene
        self._splats = Splats(self.gpu, photons, self.shown_size, chosen.scale, chosen.radius)

    def run_with_depth(self, inputs: PassInputs, into: Canvas, depth: moderngl.Texture) -> None:
        self._splats.draw(inputs.middle, inputs.shown_ns)
        self._scene.draw(inputs.middle, ShownPicture(into, depth), inputs.shown_ns, self._splats)

    def close(self) -> None:
        super().close()
        self._splats.close()


def _wanted(settings: PhotonsSettings) -> PhotonMap:
    return PhotonMap(settings.budget, settings.paths, settings.radius)
