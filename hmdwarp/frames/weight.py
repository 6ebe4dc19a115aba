"""What a frame weighs uncompressed: for the plan, the memory check and a link without a codec."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from .layers import PIXEL_BYTES, EyeSizes, layers
from .needs import Needs


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
        weight * len(known[name]) // sum(PIXEL_BYTES[one] for one in known[name])
        for name, weight in weights.items()
        if name in known
    )
