"""What one sees through, warped as a surface of its own depth and laid over the shown picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs

from ...frame import Needs
from ...scenes.effects import SceneEffect
from ..carry import as_image
from ..warps._gather import GatherWarp
from ..warps._seeds import Seeds
from ..warps.iterative import IterativeSettings
from . import effects
from ._base import Effect, ShownPass

if TYPE_CHECKING:
    from ...gpu.textures import Canvas
    from ..given import Given
    from ..picture import ShownPicture

# The shown depth has been through two half floats: rounded, each is off by 2^-11 of it (truncated, both make things farther away). What
# lies on a surface must not come and go; what stands 1.5 mm behind its frame at 1.5 m is drawn over the frame for that.
NEARER = 1 + 2.0**-10


class _Veil(GatherWarp):
    """The warp `iterative` with its own settings, for the veil; what its pixels find is composited where it is found."""

    Settings = IterativeSettings
    rows = 4

    def prepare(self) -> None:
        self._program = self.gather("effects/veil.comp", PLAIN=self.settings.steps - self.settings.slanted)
        self._seeds = Seeds(self.gpu, self.late_size, self.shown_size)

    def run(self, given: Given, into: Canvas, picture: ShownPicture) -> None:
        """given.late: as the frame brought it; picture: what the veil is laid over."""
        layer, settings, (wide, high) = given.late.transparent, self.settings, self.late_size
        given = attrs.evolve(given.at_once(), late=as_image(given.late, layer.veil))
        surface: dict[str, object] = {"late_inverse_depth": 1, "last_centre": (wide - 0.5, high - 0.5)}
        surface |= {"depth_tolerance": settings.tolerance, "depth_floor": settings.floor}
        given.late.inverse_depth.bind_to_image(1, read=True, write=False)
        self._seeds.find(given, surface)
        picture.colour.texture.bind_to_image(2, read=True, write=False)
        picture.inverse_depth.bind_to_image(3, read=True, write=False)
        self.bind_colour(attrs.evolve(given, late=attrs.evolve(given.late, colour=layer.passing)), 1, self._maps(given))
        behind = {"late_passing": 1, "picture": 2, "shown_inverse_depth": 3, "nearer": NEARER}
        self.run_gather(
            self._program, given, into, most_pixels=settings.converged, cells=self._seeds.cells, **surface, **behind
        )

    def close(self) -> None:
        self._seeds.close()


class TransparencyPass(ShownPass):
    """All sheets of a late pixel are one surface at the depth of the nearest: those behind it move with it.

    What hides the veil is found in the shown view. Tested in the rendered view by the server instead, the shown depth would not be wanted
    (it takes as long as this pass), but in `greenhouse` after 400 ms FLIP is 5 % higher on look-around (0.0632 for 0.0605); on walk it is
    the same (0.0392).
    """

    name = "lay the veil over"
    order = 70
    reads = ("shown.colour", "shown.inverse_depth", "late.transparent")

    def prepare(self) -> None:
        self._veil = _Veil(self.gpu, self.late_size, self.shown_size)

    def run(self, given: Given, picture: ShownPicture, into: Canvas) -> None:
        self._veil.run(given, into, picture)

    def close(self) -> None:
        self._veil.close()

    @classmethod
    def bytes_moved(cls, late_pixels: int, shown_pixels: int) -> int:
        """The veil, what passes it and the picture in, one picture out, three depths: late, for the seeds and for the look, and shown."""
        return shown_pixels * (4 * 8 + 2 * 4) + 4 * late_pixels


effects.register(
    Effect(
        SceneEffect.TRANSPARENCY,
        "glass and what else one sees through is a layer of its own depth, laid over the warped picture",
        TransparencyPass,
        Needs(transparency=True),
        "a pane has the depth of what is seen through it, so that dirt, tint and bars on it move with the room behind",
        "Porter and Duff 1984, Compositing Digital Images; Bowles et al. 2012, Iterative Image Warping",
    )
)
