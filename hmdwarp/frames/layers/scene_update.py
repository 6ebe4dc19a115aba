"""Parts of the scene for a client that draws it: meshes and textures, as they are needed."""

from __future__ import annotations

import attrs

from . import Delivered, layers


@attrs.frozen(order=True)
class Delivery:
    """A scene that is delivered little by little."""

    # Share of the triangles, scale of the textures, whether with light.
    share: float = 1.0
    texture: float = 1.0
    lit: bool = True
    # Bytes of each frame, at most.
    budget: int = 20_000


@layers.register
class SceneUpdate(Delivered):
    """An Update for each Delivery. The amount is the frozenset of them."""

    name = "scene_update"
    summary = "parts of the scene, packed: what the head sees or is about to see first, until all has arrived"
    drawn_by = "scene_update"
    something = frozenset({Delivery()})
