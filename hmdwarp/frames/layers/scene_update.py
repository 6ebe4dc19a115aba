"""Parts of the scene for a client that draws it: meshes and textures, as they are needed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import attrs

from ..deliveries import Update
from . import EyeSizes, Layer, layers

if TYPE_CHECKING:
    import moderngl
    from numpy.typing import NDArray


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
class SceneUpdate(Layer):
    """An Update for each Delivery. The amount is the frozenset of them."""

    name = "scene_update"
    summary = "parts of the scene, packed: what the head sees or is about to see first, until all has arrived"
    drawn_by = "scene_update"
    per_frame = True
    nothing, something = frozenset(), frozenset({Delivery()})

    @classmethod
    def bytes(cls, amount: frozenset[Delivery], sizes: EyeSizes) -> int:
        return sum(each.budget for each in amount)

    @classmethod
    def merged(cls, amount: frozenset[Delivery], other: frozenset[Delivery]) -> frozenset[Delivery]:
        return amount | other

    @classmethod
    def serves(cls, carried: frozenset[Delivery], needed: frozenset[Delivery]) -> bool:
        """Return whether all that is needed is delivered; more does not disturb."""
        return needed <= carried

    @classmethod
    def only(cls, data: Mapping[Delivery, Update], amount: frozenset[Delivery]) -> Mapping[Delivery, Update]:
        return data if data.keys() == amount else {each: data[each] for each in sorted(amount)}

    @classmethod
    def textures(cls, data: Any) -> Iterable[moderngl.Texture]:
        return ()

    @classmethod
    def sent(cls, data: Mapping[Delivery, Update]) -> Iterable[NDArray[Any]]:
        return [update.content for update in data.values()]
