"""The scene for a client that draws it: its parts as they are needed, or what the picture adds."""

from __future__ import annotations

import attrs

from . import MOST_BUDGET, Delivered, Layer, between, layers


@attrs.frozen(order=True)
class Simplified:
    """A simplified scene, as client and server draw it."""

    # Share of the triangles, scale of the textures, whether with light.
    share: float = attrs.field(default=0.2, validator=between(1e-6, 1))
    texture: float = attrs.field(default=1.0, validator=between(1e-6, 1))
    lit: bool = True


@attrs.frozen(order=True)
class Delivery:
    """A scene that is delivered little by little; the first three as of Simplified."""

    share: float = attrs.field(default=1.0, validator=between(1e-6, 1))
    texture: float = attrs.field(default=1.0, validator=between(1e-6, 1))
    lit: bool = True
    # Bytes of each frame, at most.
    budget: int = attrs.field(default=20_000, validator=between(1, MOST_BUDGET))


@layers.register
class SceneUpdate(Delivered):
    """An Update for each Delivery. The amount is the frozenset of them."""

    name = "scene_update"
    summary = "parts of the scene, packed: what the head sees or is about to see first, until all has arrived"
    drawn_by = "scene_update"
    something = frozenset({Delivery()})


@layers.register
class Difference(Layer):
    """A texture for each Simplified. The amount is the frozenset of them.

    A pixel is (d + 1) / 2 in display space (sRGB), where d is the picture's byte less the
    simplified scene's, over 255. It is kept as the light of that value, so that a codec codes it as
    it codes colour: 511 levels, which a half tells apart; 8 bits of a codec lose the last of 9.
    """

    name = "difference"
    summary = "the picture less that of a simplified scene, for a client that draws that one itself"
    formats = ("rgba16f",)
    drawn_by = "difference"
    made_from_picture = True
    nothing, something = frozenset(), frozenset({Simplified()})
