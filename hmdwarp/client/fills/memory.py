"""Fill holes from what other pictures showed there: earlier frames, or a wide one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ...base import InputError
from ...frames import EyeImage, Needs
from ...geometry import View, view_map
from ...geometry.cube import COARSER
from ...gpu import Compute, Gpu
from ...gpu.textures import COLOUR, NUMBER, SCALAR, Owner, allocate, bind_images, tiles
from ..inputs import PassInputs, ShownPicture
from ..settings import limited
from ..warps import pixel_of
from ..warps.gather import DEPTH_FLOOR, USUAL_LIMITS, bind_rendered_colour
from ..warps.multi import DepthGuesses, no_pieces, piece_list
from . import fills
from ._base import Fill

_RENDERED = 1  # texture unit
_DEPTH = 5  # image unit
_GUESSES = 3


class HoleFiller(Owner):
    """Intersect the rays of holes with one picture after the other.

    Of several hits the nearest stays; of equally near ones, the one sampled more densely. Nothing
    overrules the first picture if it is the newest.

    cell: side, in shown pixels, of the square that shares a guess: a texel of the guessing picture
    covers as much.
    """

    def __init__(self, gpu: Gpu, shown_size: tuple[int, int], cell: int = 1) -> None:
        self._gpu, self._size = gpu, shown_size
        self._cells = tiles(shown_size, cell)
        shaders, gl = gpu.shaders, gpu.gl
        self._start, self._gather = (
            shaders.compute("fills/memory_start.comp", grid="shown"),
            shaders.compute("fills/memory_gather.comp"),
        )
        self._run_start = self._start.over(*shown_size)
        self._guesses = self.own(DepthGuesses(gpu, self._cells))
        self._pieces, self._no_pieces = self.own(piece_list(gpu, "the fill", shown_size)), self.own(no_pieces(gpu))
        self._best = self.own(allocate(gl, shown_size, (2, "f4")))
        # Bound where no pass reads depth: stores outside their one pixel are discarded.
        self._no_depth = [self.own(allocate(gl, (1, 1), SCALAR)) for _ in range(2)]
        self._stamp = 0
        # Uniforms of every gather, but for what depends on the picture.
        self._fixed: dict[str, object] = {"rendered_colour": _RENDERED, "guesses": _GUESSES}
        per_pixel = self._cells[0] / shown_size[0], self._cells[1] / shown_size[1]
        self._fixed |= {"shown_size": shown_size, "cells": self._cells, "cells_per_pixel": per_pixel, **USUAL_LIMITS}

    def start(self, picture: ShownPicture, into: ShownPicture) -> None:
        """Copy a picture; pictures added from now on go into its holes."""
        self._stamp = self._stamp % 0xFFFFFFFF + 1
        self._first = True
        self._guesses.empty(self._pieces)
        before, after = self._no_depth
        if picture.inverse_depth is not None and into.inverse_depth is not None:
            before, after = picture.inverse_depth, into.inverse_depth
        self._write = {"filled_colour": into.colour.texture, "filled_depth": after}
        self._read = {"shown_colour": picture.colour.texture}
        units = bind_images({**self._read, "shown_depth": before}, self._write)
        self._start.uniforms.set(stamp=self._stamp, shown_size=self._size, **units)
        self._gpu.barrier()
        self._run_start()

    def add(self, found: EyeImage, shown: View, *, seeds: moderngl.Texture | None = None, newest: bool = False) -> None:
        """Fill the remaining holes from `found`.

        seeds: its inverse depth at a lower resolution, for the guesses. newest: whether it is the
        newest rendered picture.
        """
        if not self._first:
            self._guesses.empty(self._no_pieces)
        depth = found.inverse_depth if seeds is None else seeds
        self._guesses.scatter(depth, found.view, shown, _DEPTH)
        size = found.colour.size
        back = view_map(shown, self._size, found.view, size)
        units = bind_images({**self._read, "rendered_depth": found.inverse_depth}, self._write, {"best": self._best})
        bind_rendered_colour(found, _RENDERED, whole_pixels=False)
        self._pieces.bind_to_storage_buffer(1)
        sizes = {"rendered_size": size, "rendered_pixel": pixel_of(size), "is_first": self._first, "is_newest": newest}
        self._gather.uniforms.set(H=back.H, e=back.e, **sizes, **units, **self._fixed)
        self._gpu.barrier()
        self._gather.program.run_indirect(self._pieces)
        self._first = False


Mask = NDArray[np.bool_]
SAMPLES = 12  # directions on each axis of a view
REACH_M = 0.3  # an eye farther away may have seen other sides of things
_NOVELTY = 0.12  # least share of a view, covered by no kept picture, for it to be kept
INSIDE = 0.15  # weight of a direction inside the newest picture, which lacks only occluded places there
AGAIN = 0.3  # weight of a direction that another picture covers: the place may be occluded there


@attrs.frozen(eq=False)
class Keyframe:
    """A kept picture."""

    slot: int  # Index of the memory's slot that holds it.
    view: View
    drawn_ns: int


def directions(view: View) -> NDArray[np.float64]:
    """Return (n, 3) world directions: an even grid over the view's tangents.

    None lies on the border, where the least motion would lose a whole row.
    """
    left, right, down, up = view.fov.tangents
    share = (np.arange(SAMPLES) + 0.5) / SAMPLES
    x, y = np.meshgrid(left + share * (right - left), down + share * (up - down))
    rays = np.stack([x.ravel(), y.ravel(), -np.ones(x.size)], axis=-1)
    return rays @ view.pose.rotation_matrix.T


def sees(view: View, towards: NDArray[np.float64]) -> Mask:
    """Return (n,) which of the directions lie in the view's field of view."""
    x, y, z = (towards @ view.pose.rotation_matrix).T
    left, right, down, up = view.fov.tangents
    with np.errstate(divide="ignore", invalid="ignore"):
        across, above = -x / z, -y / z
    inside: NDArray[np.bool_] = (
        (z < 0) & (across >= left - 1e-9) & (across <= right + 1e-9) & (above >= down - 1e-9) & (above <= up + 1e-9)
    )
    return inside


def covered(view: View, by: Sequence[Keyframe]) -> Mask:
    """Return (n,) which of the view's directions a nearby keyframe covers."""
    towards = directions(view)
    found = np.zeros(len(towards), bool)
    for keyframe in by:
        if np.linalg.norm(view.pose.position_m - keyframe.view.pose.position_m) <= REACH_M:
            found |= sees(keyframe.view, towards)
    return found


def _overlapping(view: View, kept: Sequence[Keyframe]) -> list[Keyframe]:
    """Return the keyframes that overlap the view's directions."""
    towards = directions(view)
    return [keyframe for keyframe in kept if sees(keyframe.view, towards).any()]


def is_new(view: View, kept: Sequence[Keyframe]) -> bool:
    """Return whether the view shows enough that no kept picture shows."""
    return float(1 - covered(view, kept).mean()) >= _NOVELTY


def most_redundant(kept: Sequence[Keyframe], newest: View) -> Keyframe:
    """Return the keyframe whose loss costs least, the oldest of equals.

    The others and the newest picture cover most of it.
    """
    beside = Keyframe(-1, newest, 0)
    return max(
        kept, key=lambda one: (covered(one.view, [beside, *(k for k in kept if k is not one)]).mean(), -one.drawn_ns)
    )


def most_useful(kept: Sequence[Keyframe], shown: View, rendered: View, most: int) -> list[Keyframe]:
    """Return up to `most` keyframes that together see most of what `rendered` does not show.

    The newest come first. Directions inside `rendered` count a little: the place may be occluded.
    """
    towards = directions(shown)
    worth = np.where(sees(rendered, towards), INSIDE, 1.0)
    seen = {}
    for keyframe in kept:
        away_m = float(np.linalg.norm(shown.pose.position_m - keyframe.view.pose.position_m))
        if (of_it := sees(keyframe.view, towards)).any():
            seen[keyframe] = of_it * np.exp(-away_m / REACH_M / 3)
    chosen: list[tuple[int, int, Keyframe]] = []
    while len(chosen) < most and seen:
        best, most_worth = None, (0.0, 0)
        for keyframe, share in seen.items():
            its_worth = float(worth @ share), keyframe.drawn_ns
            if best is None or its_worth > most_worth:
                best, most_worth = keyframe, its_worth
        assert best is not None
        chosen.append((-best.drawn_ns, best.slot, best))
        worth = np.where(seen.pop(best) > 0, AGAIN * worth, worth)
    return [keyframe for _, _, keyframe in sorted(chosen)]


_BYTES_PER_PIXEL = 13  # of a kept picture

# Threshold of a clear difference. By how much nearer, relative to the depth, a place must be than
# everything that the newest picture shows in 4 x 4 pixels around it; and by how much darker or
# brighter than all of them, absolute in linear light and as a share of the brightest. Textures seen
# from another place differ by less, because their detail is filtered by distance.
_TOLERANCE = 0.05
_COLOUR_MARGIN = (0.08, 0.25)
_IDS = 1  # texture unit


# Side of the squares of kept pixels of which a comparison looks at one: with 1 it takes 3.4 times
# as long, and pictures of six heads and scenes differ by at most 0.02 dB.
_BLOCK_SIDE = 4


def _place_in_block(turn: int) -> tuple[int, int]:
    """Return the pixel (x, y) of each block that a comparison looks at; in 16 turns it is each."""
    y, x = divmod(turn % _BLOCK_SIDE**2, _BLOCK_SIDE)
    return (x + 2 * y) % _BLOCK_SIDE, (y + 2 * x) % _BLOCK_SIDE


class Slot(Owner):
    """Storage for one picture of that size."""

    def __init__(self, gpu: Gpu, size: tuple[int, int]) -> None:
        self.colour = self.own(allocate(gpu.gl, size, COLOUR, linear=True))
        self.inverse_depth = self.own(allocate(gpu.gl, size, SCALAR))
        self.seeds = self.own(seeds_for(gpu, size))  # the nearest of each 2 x 2 pixels


def seeds_for(gpu: Gpu, size: tuple[int, int]) -> moderngl.Texture:
    """Return a texture for the seeds of a picture of that size."""
    return allocate(gpu.gl, tiles(size, 2), SCALAR)


class Keeper(Owner):
    """Programs and buffers to keep rendered pictures of one size."""

    def __init__(self, gpu: Gpu, size: tuple[int, int]) -> None:
        self._gpu, self._size = gpu, size
        self._keep, self._seed, self._forget = (
            gpu.shaders.compute(f"fills/memory_{name}.comp") for name in ("keep", "seeds", "forget")
        )
        self._no_ids, self._no_velocity = (self.own(allocate(gpu.gl, (1, 1), kind)) for kind in (NUMBER, COLOUR))
        self._no_ids.write(bytes(2), alignment=1)
        self._no_velocity.write(bytes(8))

    def keep(self, rendered: EyeImage, slot: Slot) -> None:
        """Copy the static pixels."""
        ids = rendered["ids"].numbers if "ids" in rendered else self._no_ids
        ids.use(_IDS)
        read = {"rendered_colour": rendered.colour, "rendered_depth": rendered.inverse_depth}
        read["velocity"] = rendered.get("velocity", self._no_velocity)
        units = bind_images(read, {"kept_colour": slot.colour, "kept_depth": slot.inverse_depth})
        self._run(self._keep, self._size, ids=_IDS, rendered_size=self._size, **units)
        self.seed(slot.inverse_depth, slot.seeds)

    def seed(self, inverse_depth: moderngl.Texture, seeds: moderngl.Texture) -> None:
        """Write the nearest of each 2 x 2 pixels."""
        units = bind_images({"depth": inverse_depth}, {"nearest": seeds})
        self._run(self._seed, tiles(self._size, 2), depth_size=self._size, **units)

    def forget(self, slot: Slot, kept: View, rendered: EyeImage, turn: int) -> None:
        """Erase what `rendered` disproves of a picture in the slot, whose view is `kept`.

        turn: counts the comparisons of a picture; each looks at another pixel of every block.
        """
        there = view_map(kept, self._size, rendered.view, self._size)
        read = {"rendered_colour": rendered.colour, "rendered_depth": rendered.inverse_depth}
        change = {"kept_colour": slot.colour, "kept_depth": slot.inverse_depth}
        units = bind_images(read, {"seeds": slot.seeds}, change)
        limits = {"depth_tolerance": _TOLERANCE, "depth_floor": DEPTH_FLOOR, "colour_margin": _COLOUR_MARGIN}
        which = {"block": _BLOCK_SIDE, "place": _place_in_block(turn), "once": 1, "rendered_size": self._size}
        self._run(self._forget, tiles(self._size, _BLOCK_SIDE), H=there.H, e=there.e, **which, **units, **limits)

    def _run(self, program: Compute, size: tuple[int, int], **uniforms: object) -> None:
        self._gpu.barrier()
        program.uniforms.set(**uniforms)
        program.run(*size)


MOST_FRAMES = 64
CELL = 2  # side, in shown pixels, of squares that share first guesses, which come from every second pixel


@attrs.frozen
class _MemorySettings:
    """How many pictures are kept, and for how long."""

    frames: int = limited(12, 1, MOST_FRAMES, "pictures")  # Kept, of both eyes together.
    use: int = limited(3, 1, MOST_FRAMES, "pictures")  # Most that one fill reads.
    age: float = limited(60.0, 0, 3600, "s", above=True)  # After which a picture is dropped.
    mb: float = limited(1000.0, 0, 1e6, above=True)  # Memory for all, in 10^6 bytes; with little fewer are kept.


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
    reads = ("shown.colour", "rendered.colour", "rendered.inverse_depth")
    writes = ("shown.colour", "shown.inverse_depth")
    Settings = _MemorySettings
    remembers = True

    def prepare(self) -> None:
        wide, high = self.rendered_size
        each = _BYTES_PER_PIXEL * wide * high
        count = min(self.settings.frames, math.floor(self.settings.mb * 1e6 / each))
        if count < 1:
            wanted = f"one rendered picture of {wide}x{high} takes {each / 1e6:.0f} MB"
            raise InputError(f"fill 'memory:mb={self.settings.mb:g}': {wanted}; give it more, or use smaller pictures")
        self._holes = self.own(HoleFiller(self.gpu, self.shown_size, CELL))
        self._keeper = self.own(Keeper(self.gpu, self.rendered_size))
        self._slots = [self.own(Slot(self.gpu, self.rendered_size)) for _ in range(count)]
        self._seeds = self.own(seeds_for(self.gpu, self.rendered_size))
        self._kept: list[Keyframe] = []
        self._last: dict[int, tuple[View, int]] = {}
        self._turn = 0
        self._forgets = self.geometry is None or not self.geometry.scene.is_still

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        rendered, shown = inputs.rendered, inputs.middle
        self.learn(inputs)
        self._keeper.seed(rendered.inverse_depth, self._seeds)
        self._holes.start(picture, into)
        self._holes.add(rendered, shown, seeds=self._seeds, newest=True)
        others = [keyframe for keyframe in self._kept if keyframe.view is not rendered.view]
        for kept in most_useful(others, shown, rendered.view, self.settings.use):
            slot = self._slots[kept.slot]
            image = EyeImage(kept.view, slot.colour, slot.inverse_depth)
            self._holes.add(image, shown, seeds=slot.seeds)

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
        concerned = _overlapping(rendered.view, self._kept) if self._forgets else ()
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

    @classmethod
    def bytes_kept(cls, rendered_pixels: int, settings: Any) -> int:
        return min(int(settings.frames) * _BYTES_PER_PIXEL * rendered_pixels, int(settings.mb * 1e6))


@fills.register
class Wide(Fill):
    """Gather from the wide view where the warp left holes.

    They lie mostly at the border, and at edges where the wide view saw more.
    """

    name = "wide"
    reads = ("shown.colour", "rendered.wide")
    writes = ("shown.colour", "shown.inverse_depth")

    def prepare(self) -> None:
        self._holes = self.own(HoleFiller(self.gpu, self.shown_size, COARSER))

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        self._holes.start(picture, into)
        self._holes.add(inputs.rendered["wide"], inputs.middle)

    @classmethod
    def needs(cls, settings: Any) -> Needs:
        return Needs(wide=True)
