"""Parts that several fills share: light by blocks, pieces with holes, kept pictures."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..frames import EyeImage
from ..geometry import View, view_map
from ..geometry.view import tangents_of_pixels
from ..gpu.context import Gpu
from ..gpu.shaders import Compute
from ..gpu.textures import COLOUR, NUMBER, SCALAR, allocate, release_all, tiles
from .inputs import ShownPicture
from .warp_kinds import DEPTH_FLOOR, DEPTH_TOLERANCE, DepthGuesses, DepthPicture, no_pieces, piece_list

BLOCK = 8  # pixels, as in shaders/lib/relight.glsl
LIGHT = (4, "f4")  # rgba32f, PARTS texels a block
PARTS = 3
SEED = 0.5
SAME_DEPTH = SAME_SURFACE = (
    0.05  # the model's surfaces are off by a few hundredths; a smaller tolerance leaves curved objects unlit
)
NEAR, OFF_PLANE = 0.05, 0.06
_LIGHTS, _SAMPLES = 5, 1  # image unit, storage binding


def sample_offsets(count: int, reach_pixels: float) -> NDArray[np.int32]:
    """Return (count, 2) pixel offsets in a disc of that radius, denser towards the middle.

    They are the same for every pixel and picture. A separate pattern for every pixel would be grain
    that crawls when the head moves; with a common one, light changes only as its samples do.
    Source: Roberts 2018, The Unreasonable Effectiveness of Quasirandom Sequences (R2).
    """
    plastic = 1.32471795724474602596
    k = np.arange(1, count + 1)
    ring, turn = (SEED + k / plastic) % 1, 2 * np.pi * ((SEED + k / plastic**2) % 1)
    places = reach_pixels * ring[:, None] ** 2 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    offsets: NDArray[np.int32] = np.rint(places).astype(np.int32)
    return offsets


class BlockLights:
    """Finds light on blocks of a picture, and holds where a pixel looks for it.

    size: (w, h) of the picture. samples: places from which a pixel takes light; reach: the farthest
    of them, in picture widths.
    """

    def __init__(self, gpu: Gpu, size: tuple[int, int], samples: int, reach: float) -> None:
        self._size, self._blocks = size, tiles(size, BLOCK)
        self._find = gpu.shaders.compute("fills/relight_blocks.comp")
        # What find() writes; read by shaders with lib/relight.glsl.
        self.texture = allocate(gpu.gl, (PARTS * self._blocks[0], self._blocks[1]), LIGHT)
        offsets = sample_offsets(samples, reach * size[0])
        self._samples = gpu.gl.buffer(np.pad(offsets, ((0, 0), (0, 2))).tobytes())

    def find(self, view: View, textures: Sequence[moderngl.Texture]) -> None:
        """Divide the albedo out of a picture where it shows the same surface.

        textures: colour and inverse depth of the picture, then albedo and inverse depth of what the
        client draws; they stay bound to image units 0 to 3, the light to 5.
        """
        for unit, texture in enumerate(textures):
            texture.bind_to_image(unit, read=True, write=False)
        self.texture.bind_to_image(_LIGHTS, read=True, write=True)
        self._find.uniforms.set(
            warped=0, warped_inverse_depth=1, albedo=2, model_inverse_depth=3, lights=_LIGHTS, shown_size=self._size,
            block_count=self._blocks, same_depth=SAME_DEPTH, same_surface=SAME_SURFACE,
            **tangents_of_pixels(view, self._size),
        )  # fmt: skip
        self._find.run(*self._blocks)

    def bind_samples(self) -> None:
        """Bind the places for the shader that reads them."""
        self._samples.bind_to_storage_buffer(_SAMPLES)

    def close(self) -> None:
        """Free the texture and the buffer."""
        release_all(self.texture, self._samples)


PIECE = (8, 4)  # pixels, as in shaders/lib/holes.glsl
_HEADER = np.array([0, 1, 1, 0], np.uint32).tobytes()  # three work-group counts, one count of pieces
_WARPED, _FILLED, _WARPED_DEPTH, _FILLED_DEPTH = range(4)  # image units


class HolePieces:
    """The list of pieces with holes of the newest picture; owns its buffers.

    with_depth: copies the inverse depth too. coarse: also lists the pieces of the picture at half
    the resolution that see a hole.
    """

    def __init__(
        self, gpu: Gpu, name: str, size: tuple[int, int], *, with_depth: bool = False, coarse: bool = False
    ) -> None:
        self._gpu, self._size, self._stamp, self._with_depth = gpu, size, 0, with_depth
        self._program = gpu.shaders.compute(
            "fills/holes.comp", grid="shown", WITH_DEPTH=int(with_depth), COARSE=int(coarse)
        )
        self.count = _pieces_in(size)
        most = gpu.gl.info["GL_MAX_COMPUTE_WORK_GROUP_COUNT"][0]
        if self.count * PIECE[0] > 64 * most:
            raise InputError(
                f"a shown picture of {size[0]}x{size[1]} is beyond what fill '{name}' can do on this GPU: use a "
                "smaller one"
            )
        self.list = gpu.gl.buffer(reserve=len(_HEADER) + 4 * self.count)
        self._stamps = gpu.gl.buffer(bytes(8 * self.count))
        at_half = _pieces_in(tiles(size, 2))
        self._coarse = gpu.gl.buffer(reserve=len(_HEADER) + 4 * at_half) if coarse else None
        self._coarse_stamps = gpu.gl.buffer(bytes(4 * at_half)) if coarse else None
        self._run_find = self._program.over(*size)

    def find(self, picture: ShownPicture, into: ShownPicture) -> int:
        """Copy the picture, and list its pieces with holes.

        Return the stamp that marks its pieces with covered pixels.
        """
        self._stamp = self._stamp % (2**32 - 1) + 1
        self.list.write(_HEADER)
        uniforms = {"warped": _WARPED, "filled": _FILLED, "shown_size": self._size, "stamp": self._stamp}
        picture.colour.texture.bind_to_image(_WARPED, read=True, write=False)
        into.colour.texture.bind_to_image(_FILLED, read=False, write=True)
        if self._with_depth and picture.inverse_depth is not None:
            picture.inverse_depth.bind_to_image(_WARPED_DEPTH, read=True, write=False)
            into.depth.bind_to_image(_FILLED_DEPTH, read=False, write=True)
            uniforms |= {"warped_depth": _WARPED_DEPTH, "filled_depth": _FILLED_DEPTH}
        self.list.bind_to_storage_buffer(0)
        self._stamps.bind_to_storage_buffer(1)
        if self._coarse is not None and self._coarse_stamps is not None:
            self._coarse.write(_HEADER)
            self._coarse.bind_to_storage_buffer(2)
            self._coarse_stamps.bind_to_storage_buffer(3)
        self._program.uniforms.set(**uniforms)
        self._run_find()
        self._gpu.barrier()
        return self._stamp

    def run(self, program: Compute) -> None:
        """Run a program that includes lib/hole_columns.glsl over the listed pieces."""
        self.list.bind_to_storage_buffer(0)
        self._stamps.bind_to_storage_buffer(1)
        program.program.run_indirect(self.list)
        self._gpu.barrier()

    def run_coarse(self, program: Compute) -> None:
        """Run it over the pieces at half the resolution; its shown_size is that resolution."""
        assert self._coarse is not None
        self._coarse.bind_to_storage_buffer(0)
        program.program.run_indirect(self._coarse)
        self._gpu.barrier()

    def close(self) -> None:
        """Free the buffers."""
        for buffer in (self.list, self._stamps, self._coarse, self._coarse_stamps):
            if buffer is not None:
                buffer.release()


def _pieces_in(size: tuple[int, int]) -> int:
    return -(-size[0] // PIECE[0]) * -(-size[1] // PIECE[1])


_RENDERED = 1  # texture unit
_SHOWN, _BEST_FILLED, _SHOWN_DEPTH, _BEST_FILLED_DEPTH, _BEST, _DEPTH = range(6)  # image units
_GUESSES = 3


class HoleFiller:
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
        self._guesses = DepthGuesses(gpu, self._cells)
        self._pieces, self._no_pieces = piece_list(gpu, "the fill", shown_size), no_pieces(gpu)
        self._best = allocate(gl, shown_size, (2, "f4"))
        # Bound where no pass reads depth: stores outside their one pixel are discarded.
        self._no_depth = [allocate(gl, (1, 1), SCALAR) for _ in range(2)]
        self._stamp = 0
        # Uniforms of every gather, but for what depends on the picture.
        self._fixed: dict[str, object] = {
            "shown_colour": _SHOWN,
            "filled_colour": _BEST_FILLED,
            "filled_depth": _BEST_FILLED_DEPTH,
            "best": _BEST,
            "rendered_colour": _RENDERED,
            "rendered_depth": _DEPTH,
            "shown_size": shown_size,
            "cells": self._cells,
            "cells_per_pixel": (self._cells[0] / shown_size[0], self._cells[1] / shown_size[1]),
            "depth_tolerance": DEPTH_TOLERANCE,
            "depth_floor": DEPTH_FLOOR,
            "guesses": _GUESSES,
        }

    def start(self, picture: ShownPicture, into: ShownPicture) -> None:
        """Copy a picture; pictures added from now on go into its holes."""
        self._stamp = self._stamp % 0xFFFFFFFF + 1
        self._first = True
        self._guesses.empty(self._pieces)
        before, after = self._no_depth
        if picture.inverse_depth is not None and into.inverse_depth is not None:
            before, after = picture.inverse_depth, into.inverse_depth
        self._bind = (
            partial(picture.colour.texture.bind_to_image, _SHOWN, read=True, write=False),
            partial(before.bind_to_image, _SHOWN_DEPTH, read=True, write=False),
            partial(into.colour.bind_for_writing, _BEST_FILLED),
            partial(after.bind_to_image, _BEST_FILLED_DEPTH, read=False, write=True),
        )
        for bind in self._bind:
            bind()
        units = {"shown_colour": _SHOWN, "filled_colour": _BEST_FILLED, "filled_depth": _BEST_FILLED_DEPTH}
        self._start.uniforms.set(stamp=self._stamp, shown_depth=_SHOWN_DEPTH, shown_size=self._size, **units)
        self._gpu.barrier()
        self._run_start()

    def add(
        self, found: DepthPicture, shown: View, *, seeds: moderngl.Texture | None = None, newest: bool = False
    ) -> None:
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
        found.inverse_depth.bind_to_image(_DEPTH, read=True, write=False)
        found.colour.filter = (moderngl.LINEAR, moderngl.LINEAR)
        found.colour.use(_RENDERED)
        for bind in self._bind:
            bind()
        self._best.bind_to_image(_BEST, read=True, write=True)
        self._pieces.bind_to_storage_buffer(1)
        self._gather.uniforms.set(
            H=back.H,
            e=back.e,
            is_first=self._first,
            is_newest=newest,
            rendered_size=size,
            rendered_pixel=(1 / size[0], 1 / size[1]),
            **self._fixed,
        )
        self._gpu.barrier()
        self._gather.program.run_indirect(self._pieces)
        self._first = False

    def close(self) -> None:
        """Free the textures and buffers."""
        self._guesses.close()
        release_all(self._pieces, self._no_pieces, self._best, *self._no_depth)


Mask = NDArray[np.bool_]
SAMPLES = 12  # directions on each axis of a view
REACH_M = 0.3  # an eye farther away may have seen other sides of things
NOVELTY = 0.12  # least share of a view, covered by no kept picture, for it to be kept
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


def overlapping(view: View, kept: Sequence[Keyframe]) -> list[Keyframe]:
    """Return the keyframes that overlap the view's directions."""
    towards = directions(view)
    return [keyframe for keyframe in kept if sees(keyframe.view, towards).any()]


def is_new(view: View, kept: Sequence[Keyframe]) -> bool:
    """Return whether the view shows enough that no kept picture shows."""
    return float(1 - covered(view, kept).mean()) >= NOVELTY


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


BYTES_PER_PIXEL = 13  # of a kept picture

# Threshold of a clear difference. By how much nearer, relative to the depth, a place must be than
# everything that the newest picture shows in 4 x 4 pixels around it; and by how much darker or
# brighter than all of them, absolute in linear light and as a share of the brightest. Textures seen
# from another place differ by less, because their detail is filtered by distance.
TOLERANCE = 0.05
COLOUR_MARGIN = (0.08, 0.25)
_IDS = 1  # texture unit
_NEW_COLOUR, _NEW_DEPTH, _KEPT_COLOUR, _KEPT_DEPTH, _FIRST, _SECOND = range(6)  # image units


# Side of the squares of kept pixels of which a comparison looks at one: with 1 it takes 3.4 times
# as long, and pictures of six heads and scenes differ by at most 0.02 dB.
BLOCK_SIDE = 4


def place_in_block(turn: int) -> tuple[int, int]:
    """Return the pixel (x, y) of each block that a comparison looks at; in 16 turns it is each."""
    y, x = divmod(turn % BLOCK_SIDE**2, BLOCK_SIDE)
    return (x + 2 * y) % BLOCK_SIDE, (y + 2 * x) % BLOCK_SIDE


@attrs.frozen(eq=False)
class Slot:
    """Storage for one picture."""

    colour: moderngl.Texture  # rgba16f
    inverse_depth: moderngl.Texture  # r32f
    seeds: moderngl.Texture  # r32f: the nearest of each 2 x 2 pixels

    @classmethod
    def of(cls, gpu: Gpu, size: tuple[int, int]) -> Slot:
        """Return an empty slot for pictures of that size."""
        return cls(allocate(gpu.gl, size, COLOUR, linear=True), allocate(gpu.gl, size, SCALAR), seeds_for(gpu, size))

    def release(self) -> None:
        """Free the textures."""
        release_all(self.colour, self.inverse_depth, self.seeds)


def seeds_for(gpu: Gpu, size: tuple[int, int]) -> moderngl.Texture:
    """Return a texture for the seeds of a picture of that size."""
    return allocate(gpu.gl, tiles(size, 2), SCALAR)


class Keeper:
    """Programs and buffers to keep rendered pictures of one size."""

    def __init__(self, gpu: Gpu, size: tuple[int, int]) -> None:
        self._gpu, self._size = gpu, size
        self._keep, self._seed, self._forget = (
            gpu.shaders.compute(f"fills/memory_{name}.comp") for name in ("keep", "seeds", "forget")
        )
        self._no_ids, self._no_velocity = allocate(gpu.gl, (1, 1), NUMBER), allocate(gpu.gl, (1, 1), COLOUR)
        self._run_seed = self._seed.over(*tiles(size, 2))
        self._no_ids.write(bytes(2), alignment=1)
        self._no_velocity.write(bytes(8))

    def keep(self, rendered: EyeImage, slot: Slot) -> None:
        """Copy the static pixels."""
        self._bind_rendered(rendered)
        self._bind_slot(slot, read=False)
        ids = rendered["ids"].numbers if "ids" in rendered else self._no_ids
        velocity = rendered.get("velocity", self._no_velocity)
        ids.use(_IDS)
        velocity.bind_to_image(_SECOND, read=True, write=False)
        units = {
            "rendered_colour": _NEW_COLOUR,
            "rendered_depth": _NEW_DEPTH,
            "kept_colour": _KEPT_COLOUR,
            "kept_depth": _KEPT_DEPTH,
        }
        self._run(self._keep, self._size, ids=_IDS, velocity=_SECOND, rendered_size=self._size, **units)
        self.seed(slot.inverse_depth, slot.seeds)

    def seed(self, inverse_depth: moderngl.Texture, seeds: moderngl.Texture) -> None:
        """Write the nearest of each 2 x 2 pixels."""
        inverse_depth.bind_to_image(_NEW_DEPTH, read=True, write=False)
        seeds.bind_to_image(_FIRST, read=False, write=True)
        self._gpu.barrier()
        self._seed.uniforms.set(depth=_NEW_DEPTH, nearest=_FIRST, depth_size=self._size)
        self._run_seed()

    def forget(self, slot: Slot, kept: View, rendered: EyeImage, turn: int) -> None:
        """Erase what `rendered` disproves of a picture in the slot, whose view is `kept`.

        turn: counts the comparisons of a picture; each looks at another pixel of every block.
        """
        there = view_map(kept, self._size, rendered.view, self._size)
        self._bind_rendered(rendered)
        self._bind_slot(slot, read=True)
        slot.seeds.bind_to_image(_FIRST, read=False, write=True)
        units = {
            **{"rendered_colour": _NEW_COLOUR, "rendered_depth": _NEW_DEPTH},
            **{"kept_colour": _KEPT_COLOUR, "kept_depth": _KEPT_DEPTH, "seeds": _FIRST},
        }
        limits = {"depth_tolerance": TOLERANCE, "depth_floor": DEPTH_FLOOR, "colour_margin": COLOUR_MARGIN}
        which = {"block": BLOCK_SIDE, "place": place_in_block(turn), "once": 1, "rendered_size": self._size}
        self._run(self._forget, tiles(self._size, BLOCK_SIDE), H=there.H, e=there.e, **which, **units, **limits)

    def _bind_rendered(self, rendered: EyeImage) -> None:
        rendered.colour.bind_to_image(_NEW_COLOUR, read=True, write=False)
        rendered.inverse_depth.bind_to_image(_NEW_DEPTH, read=True, write=False)

    def _bind_slot(self, slot: Slot, *, read: bool) -> None:
        slot.colour.bind_to_image(_KEPT_COLOUR, read=read, write=True)
        slot.inverse_depth.bind_to_image(_KEPT_DEPTH, read=read, write=True)

    def _run(self, program: Compute, size: tuple[int, int], **uniforms: object) -> None:
        self._gpu.barrier()
        program.uniforms.set(**uniforms)
        program.run(*size)

    def close(self) -> None:
        """Free the textures."""
        release_all(self._no_ids, self._no_velocity)
