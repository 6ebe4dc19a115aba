"""What was drawn, and the exact views it was drawn for: they travel together, always."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs

from .geometry import View
from .scenes.effects import SceneEffect

if TYPE_CHECKING:
    import moderngl

    from .poses import PoseSample


@attrs.frozen
class Needs:
    """What a plan wants of every frame besides colour and inverse depth, and of the frames before it.

    layers: surfaces behind the visible one, by peeling. cube: whether the surroundings of each eye are drawn too. past: how many
    older frames the client keeps, at least past_spacing_ns apart. other_eye: whether the other eye's picture is used as well.
    """

    layers: int = 0
    cube: bool = False
    past: int = 0
    past_spacing_ns: int = 0
    other_eye: bool = False

    def __or__(self, other: Needs) -> Needs:
        """Enough for both."""
        spacings = [needs.past_spacing_ns for needs in (self, other) if needs.past]
        return Needs(
            max(self.layers, other.layers),
            self.cube or other.cube,
            max(self.past, other.past),
            min(spacings, default=0),
            self.other_eye or other.other_eye,
        )


@attrs.frozen(eq=False)
class Layer:
    """A surface behind the visible one, of the same view and size: `colour` rgba16f and `inverse_depth` r32f; holes as in EyeImage."""

    colour: moderngl.Texture
    inverse_depth: moderngl.Texture


@attrs.frozen(eq=False)
class EyeImage:
    """One eye's picture: `colour` rgba16f linear with coverage in alpha, `inverse_depth` r32f in 1/m, and its view.

    Rows run bottom to top, as GL has them. Where nothing was drawn colour is (0, 0, 0, 0) and inverse_depth is
    -1 (no depth), so that a hole is neither averaged into its neighbours nor scattered. layers: what lies behind, nearest first,
    where it was asked for. cube: colour of everything around the eye, rgba16f, the six faces of geometry.cube in one texture.
    """

    view: View
    colour: moderngl.Texture
    inverse_depth: moderngl.Texture
    layers: tuple[Layer, ...] = ()
    cube: moderngl.Texture | None = None

    @property
    def size(self) -> tuple[int, int]:
        """(w, h) in pixels."""
        return self.colour.size


@attrs.frozen(eq=False)
class Frame:
    """Both eyes as the server drew them at `drawn_ns`; `effects` is what the scene called for.

    head: world_from_head the frame was asked for, and how that was obtained; None where only the views are known.
    """

    eyes: tuple[EyeImage, ...]
    drawn_ns: int
    effects: SceneEffect = SceneEffect.NONE
    head: PoseSample | None = None
