"""Fill holes from what other pictures showed there: earlier frames, or a wide one."""

from __future__ import annotations

import math
from typing import Any

import attrs

from ...errors import InputError
from ...frames import Needs
from ...geometry import View
from ...geometry.cube import COARSER
from ...gpu.textures import release_all
from ..fill_parts import (
    BYTES_PER_PIXEL,
    HoleFiller,
    Keeper,
    Keyframe,
    Slot,
    is_new,
    most_redundant,
    most_useful,
    overlapping,
    seeds_for,
)
from ..inputs import PassInputs, ShownPicture
from ..warp_kinds import DepthPicture
from . import fills
from ._base import Fill

MOST_FRAMES = 64
CELL = 2  # side, in shown pixels, of squares that share first guesses, which come from every second pixel


@attrs.frozen
class MemorySettings:
    """How many pictures are kept, and for how long."""

    frames: int = 12  # Pictures kept, of both eyes together.
    use: int = 3  # Most pictures that one fill reads.
    age: float = 60.0  # Seconds after which a picture is dropped.
    # Memory for all pictures, in 10^6 bytes; with little of it fewer are kept.
    mb: float = 1000.0

    def __attrs_post_init__(self) -> None:
        if not 1 <= self.frames <= MOST_FRAMES:
            raise ValueError(f"frames is {self.frames}: expected 1 to {MOST_FRAMES} pictures")
        if not 1 <= self.use <= MOST_FRAMES:
            raise ValueError(f"use is {self.use}: expected 1 to {MOST_FRAMES} pictures")
        if not (math.isfinite(self.age) and 0 < self.age <= 3600):
            raise ValueError(f"age is {self.age:g} s: expected above 0 and at most 3600")
        if not (math.isfinite(self.mb) and 0 < self.mb <= 1e6):
            raise ValueError(f"mb is {self.mb:g}: expected above 0 and at most 1000000")


@fills.register
class Memory(Fill):
    """Keeps rendered pictures that cover new places, and gathers from them into holes.

    Both eyes share the pictures. Each new rendered picture is compared with one of the kept ones,
    in turn (all of 12 within six refreshes of two eyes). A kept pixel is erased where the new
    picture sees clearly farther than its place, or a clearly different colour at it; not in scenes
    known to look the same at all times and from everywhere. Of 4 x 4 kept pixels one is compared,
    another one each time, and stands for all. Moving objects are never kept. The newest rendered
    picture comes first: it closes cracks, and no older one overrules it.
    """

    name = "memory"
    summary = "what was seen before behind and beside things, warped in; forgets what moved"
    reads = ("shown.colour", "rendered.colour", "rendered.inverse_depth")
    writes = ("shown.colour", "shown.inverse_depth")
    source = "this project's; keyframes as in Mark et al. 1997, Post-Rendering 3D Warping, chosen by what they cover"
    Settings = MemorySettings
    remembers = True

    def prepare(self) -> None:
        wide, high = self.rendered_size
        each = BYTES_PER_PIXEL * wide * high
        count = min(self.settings.frames, math.floor(self.settings.mb * 1e6 / each))
        if count < 1:
            wanted = f"one rendered picture of {wide}x{high} takes {each / 1e6:.0f} MB"
            raise InputError(f"fill 'memory:mb={self.settings.mb:g}': {wanted}; give it more, or use smaller pictures")
        self._holes, self._keeper = (HoleFiller(self.gpu, self.shown_size, CELL), Keeper(self.gpu, self.rendered_size))
        self._slots = [Slot.of(self.gpu, self.rendered_size) for _ in range(count)]
        self._seeds = seeds_for(self.gpu, self.rendered_size)
        self._kept: list[Keyframe] = []
        self._last: dict[int, tuple[View, int]] = {}
        self._turn = 0
        self._forgets = self.geometry is None or not self.geometry.is_still

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        rendered, shown = inputs.rendered, inputs.middle
        self.learn(inputs)
        self._keeper.seed(rendered.inverse_depth, self._seeds)
        self._holes.start(picture, into)
        self._holes.add(
            DepthPicture(rendered.colour, rendered.inverse_depth, rendered.view), shown, seeds=self._seeds, newest=True
        )
        others = [keyframe for keyframe in self._kept if keyframe.view is not rendered.view]
        for kept in most_useful(others, shown, rendered.view, self.settings.use):
            slot = self._slots[kept.slot]
            self._holes.add(DepthPicture(slot.colour, slot.inverse_depth, kept.view), shown, seeds=slot.seeds)

    def renew(self) -> None:
        self._last.clear()

    def learn(self, inputs: PassInputs) -> None:
        """Erase what a new rendered picture disproves, and keep that picture if it shows enough."""
        rendered = inputs.as_drawn  # moving things can still be distinguished in it
        before = self._last.get(inputs.eye)
        if before is not None and before[0] is rendered.view and before[1] == rendered.drawn_ns:
            return
        self._last[inputs.eye] = rendered.view, rendered.drawn_ns
        # Drop pictures that are too old, or from a later time: those belong to another run.
        limit = round(self.settings.age * 1e9)
        self._kept = [keyframe for keyframe in self._kept if 0 <= rendered.drawn_ns - keyframe.drawn_ns <= limit]
        concerned = overlapping(rendered.view, self._kept) if self._forgets else ()
        if concerned:
            self._turn += 1
            one = concerned[self._turn % len(concerned)]
            self._keeper.forget(self._slots[one.slot], one.view, rendered, self._turn // len(concerned))
        if is_new(rendered.view, self._kept):
            if len(self._kept) == len(self._slots):
                self._kept.remove(most_redundant(self._kept, rendered.view))
            used = {keyframe.slot for keyframe in self._kept}
            slot = next(slot for slot in range(len(self._slots)) if slot not in used)
            self._keeper.keep(rendered, self._slots[slot])
            self._kept.append(Keyframe(slot, rendered.view, rendered.drawn_ns))

    def close(self) -> None:
        self._holes.close()
        self._keeper.close()
        self._seeds.release()
        release_all(*self._slots)

    @classmethod
    def bytes_kept(cls, rendered_pixels: int, settings: Any) -> int:
        return min(int(settings.frames) * BYTES_PER_PIXEL * rendered_pixels, int(settings.mb * 1e6))


@fills.register
class Wide(Fill):
    """Gather from the wide view where the warp left holes.

    They lie mostly at the border, and at edges where the wide view saw more.
    """

    name = "wide"
    summary = "a second view of 150 x 140 degrees at a quarter of the resolution, drawn and sent with every frame"
    reads = ("shown.colour", "rendered.wide")
    writes = ("shown.colour", "shown.inverse_depth")
    source = "this project's; the gather of Bowles et al. 2012"

    def prepare(self) -> None:
        self._holes = HoleFiller(self.gpu, self.shown_size, COARSER)

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        wide = inputs.rendered["wide"]
        self._holes.start(picture, into)
        self._holes.add(DepthPicture(wide.colour, wide.inverse_depth, wide.view), inputs.middle)

    def close(self) -> None:
        self._holes.close()

    @classmethod
    def needs(cls, settings: Any) -> Needs:
        return Needs(wide=True)
