"""What a plan needs of every frame besides colour and inverse depth."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from .layers import PIXEL_BYTES, EyeSizes, layers
from .layers.others import Others


class Needs(Mapping[str, Any]):
    """How much of each layer a plan needs, by layer name.

    An amount is True, a number, or what the layer's file says. What is not needed is not there:
    `name in needs` says whether a layer is. Immutable and hashable. `Needs(peeled=2, cube=True) |
    Needs(peeled=1)` is enough for both.
    """

    __slots__ = ("_amounts",)

    def __init__(self, **amounts: Any) -> None:
        """Errors: UnknownNameError for a name that is no layer's."""
        self._amounts = {layers.get(name).name: amounts[name] for name in sorted(amounts) if amounts[name]}

    def __getitem__(self, name: str) -> Any:
        return self._amounts[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._amounts)

    def __len__(self) -> int:
        return len(self._amounts)

    def __hash__(self) -> int:
        return hash(frozenset(self._amounts.items()))

    def __repr__(self) -> str:
        return f"Needs({', '.join(f'{name}={amount!r}' for name, amount in self.items())})"

    def __or__(self, other: Needs) -> Needs:
        both = {**self, **other}
        both |= {name: layers.get(name).merged(self[name], other[name]) for name in self if name in other}
        return Needs(**both)

    @property
    def others(self) -> Others:
        """The other eye's picture and the older frames that the client keeps."""
        others: Others = self.get("others", Others())
        return others

    def serve(self, needed: Needs) -> bool:
        """Return whether frames drawn for these needs suit a plan that needs `needed`."""
        return all(_serves(name, self, needed) for name in {*self, *needed})


def _serves(name: str, carried: Needs, needed: Needs) -> bool:
    layer = layers.get(name)
    return layer.serves(carried.get(name, layer.nothing), needed.get(name, layer.nothing))


def frame_bytes(
    needs: Needs, sizes: EyeSizes, reads: Collection[str] | None = None, *, eyes: int = 2
) -> dict[str, int]:
    """Return the bytes of each needed layer of a frame, by readable name.

    reads: readable names; colour and inverse depth count only if they are among them, None for
    both.
    """
    found = {}
    for layer in sorted(layers, key=lambda one: not one.always):
        name = layer.readable()
        amount = (reads is None or name in reads) if layer.always else needs.get(layer.name)
        if amount and (count := layer.bytes(amount, sizes)):
            found[name] = count if layer.per_frame else eyes * count
    return found


def video_pixels(weights: Mapping[str, int]) -> int:
    """Return the pixels of video that a frame takes to decode, of all eyes.

    weights: as frame_bytes returns them. Layers that are no pictures count nothing.
    """
    known = {layer.readable(): layer.formats for layer in layers if layer.formats}
    return sum(
        weight * len(known[name]) // sum(PIXEL_BYTES[kind] for kind in known[name])
        for name, weight in weights.items()
        if name in known
    )
