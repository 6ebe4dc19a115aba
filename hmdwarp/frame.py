"""What was drawn, and the exact views it was drawn for: they travel together, always."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs

from .geometry import View
from .scenes.effects import SceneEffect

if TYPE_CHECKING:
    import moderngl

    from .poses import PoseSample


@attrs.frozen(eq=False)
class EyeImage:
    """One eye's picture: `colour` rgba16f linear with coverage in alpha, `inverse_depth` r32f in 1/m, and its view.

    Rows run bottom to top, as GL has them. Where nothing was drawn colour is (0, 0, 0, 0) and inverse_depth is
    -1 (no depth), so that a hole is neither averaged into its neighbours nor scattered.
    """

    view: View
    colour: moderngl.Texture
    inverse_depth: moderngl.Texture

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
