"""Parts of the scene for a client that draws it: meshes and textures, as they are needed."""

from __future__ import annotations

import attrs

from . import MOST_BUDGET, Delivered, between, layers


@attrs.frozen(order=True)
class Delivery:
    """A scene that is delivered little by little."""

    # Share of the triangles, scale of the textures, whether with light.
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
