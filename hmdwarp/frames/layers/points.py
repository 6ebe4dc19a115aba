"""Points of the scene's surfaces for a client that keeps them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import attrs

from ..point_blocks import PointUpdate
from . import EyeSizes, Layer, layers

if TYPE_CHECKING:
    import moderngl
    from numpy.typing import NDArray


@attrs.frozen(order=True)
class Cloud:
    """Points that are delivered little by little."""

    # Bytes of each frame, at most, before they are packed.
    budget: int = 60_000
    # Points that the client has room for.
    room: int = 1 << 20
    # Distance of points in pixels of the shown picture, where all have arrived.
    spacing: float = 1.0


@layers.register
class Points(Layer):
    """A PointUpdate for each Cloud. The amount is the frozenset of them."""

    name = "points"
    summary = "new points of the surfaces that the head may see, packed: what lacks most first"
    drawn_by = "points"
    per_frame = True
    nothing, something = frozenset(), frozenset({Cloud()})

    @classmethod
    def bytes(cls, amount: frozenset[Cloud], sizes: EyeSizes) -> int:
        return sum(each.budget for each in amount)

    @classmethod
    def merged(cls, amount: frozenset[Cloud], other: frozenset[Cloud]) -> frozenset[Cloud]:
        return amount | other

    @classmethod
    def serves(cls, carried: frozenset[Cloud], needed: frozenset[Cloud]) -> bool:
        """Return whether all that is needed is delivered; more does not disturb."""
        return needed <= carried

    @classmethod
    def only(cls, data: Mapping[Cloud, PointUpdate], amount: frozenset[Cloud]) -> Mapping[Cloud, PointUpdate]:
        return data if data.keys() == amount else {each: data[each] for each in sorted(amount)}

    @classmethod
    def textures(cls, data: Any) -> Iterable[moderngl.Texture]:
        return ()

    @classmethod
    def sent(cls, data: Mapping[Cloud, PointUpdate]) -> Iterable[NDArray[Any]]:
        return [update.content for update in data.values()]
