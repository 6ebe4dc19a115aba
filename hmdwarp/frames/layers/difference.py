"""The picture less that of a simplified scene, which the client draws itself."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import attrs

from . import PIXEL_BYTES, EyeSizes, Layer, layers

if TYPE_CHECKING:
    import moderngl


@attrs.frozen(order=True)
class Simplified:
    """A simplified scene, as client and server draw it."""

    # Share of the triangles, scale of the textures, whether with light.
    share: float = 0.2
    texture: float = 1.0
    lit: bool = True


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

    @classmethod
    def bytes(cls, amount: frozenset[Simplified], sizes: EyeSizes) -> int:
        width, height = cls.size(sizes)
        return len(amount) * PIXEL_BYTES[cls.formats[0]] * width * height

    @classmethod
    def merged(cls, amount: frozenset[Simplified], other: frozenset[Simplified]) -> frozenset[Simplified]:
        return amount | other

    @classmethod
    def serves(cls, carried: frozenset[Simplified], needed: frozenset[Simplified]) -> bool:
        """Return whether all that is needed is carried; more does not disturb."""
        return needed <= carried

    @classmethod
    def only(
        cls, data: Mapping[Simplified, moderngl.Texture], amount: frozenset[Simplified]
    ) -> Mapping[Simplified, moderngl.Texture]:
        return data if data.keys() == amount else {each: data[each] for each in sorted(amount)}

    @classmethod
    def textures(cls, data: Mapping[Simplified, moderngl.Texture]) -> Iterable[moderngl.Texture]:
        return data.values()
