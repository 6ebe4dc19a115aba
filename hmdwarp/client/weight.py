"""What a frame weighs uncompressed: for the plan, for the memory check, and for the link where nothing is encoded."""

from __future__ import annotations

from collections.abc import Iterable

import attrs

from ..frames.frame import Needs

# Bytes a pixel: rgba16f and r32f, r16ui.
COLOUR, DEPTH, IDS = 8, 4, 2
PICTURE_BYTES = {"rendered.colour": COLOUR, "rendered.inverse_depth": DEPTH}
# A pixel of the late picture, for each of these layers that Needs asks for.
_LATE_BYTES = {
    "rendered.ids": IDS,
    "rendered.velocity": COLOUR,
    "rendered.reflection": 2 * COLOUR + DEPTH,
    "rendered.transparent": 2 * COLOUR + DEPTH,
}


@attrs.frozen
class EyeSizes:
    """(w, h) in pixels of one eye's pictures: late with its guard band, shown, the cube around it, the wide view."""

    rendered: tuple[int, int]
    shown: tuple[int, int]
    cube: tuple[int, int] = (0, 0)
    wide: tuple[int, int] = (0, 0)


def eye_bytes(needs: Needs, sizes: EyeSizes, pictures: Iterable[str] = tuple(PICTURE_BYTES)) -> dict[str, int]:
    """Bytes of each layer of one eye, by the names of client/plan.py; those that are not asked for are not there.

    pictures: which of colour and inverse depth are sent at all.
    """
    rendered, shown, cube, wide = (pixels(getattr(sizes, field.name)) for field in attrs.fields(EyeSizes))
    wanted = {
        "rendered.ids": needs.ids,
        "rendered.velocity": needs.velocity,
        "rendered.reflection": needs.reflections or needs.curved_reflections,
        "rendered.transparent": needs.transparency,
    }
    found = {name: PICTURE_BYTES[name] * rendered for name in PICTURE_BYTES if name in pictures}
    found |= {"rendered.layers": needs.layers * (COLOUR + DEPTH) * rendered}
    found |= {name: _LATE_BYTES[name] * rendered for name, asked in wanted.items() if asked}
    found |= {"rendered.overlay": needs.overlay * COLOUR * shown, "rendered.cube": needs.cube * COLOUR * cube}
    found |= {"rendered.wide": needs.wide * (COLOUR + DEPTH) * wide}
    return {name: count for name, count in found.items() if count}


def pixels(size: tuple[int, int]) -> int:
    """Of a (w, h) picture."""
    return size[0] * size[1]
