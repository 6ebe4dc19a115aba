"""Keep rendered pictures, and erase the pixels that newer ones disprove."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ...frames import EyeImage
from ...geometry import View, view_map
from ...gpu.context import Gpu
from ...gpu.shaders import Compute
from ...gpu.textures import COLOUR, NUMBER, SCALAR, allocate, release_all, tiles
from ..warp_kinds import DEPTH_FLOOR

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
_COLOUR, _DEPTH, _KEPT_COLOUR, _KEPT_DEPTH, _FIRST, _SECOND = range(6)  # image units


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
            "rendered_colour": _COLOUR,
            "rendered_depth": _DEPTH,
            "kept_colour": _KEPT_COLOUR,
            "kept_depth": _KEPT_DEPTH,
        }
        self._run(self._keep, self._size, ids=_IDS, velocity=_SECOND, rendered_size=self._size, **units)
        self.seed(slot.inverse_depth, slot.seeds)

    def seed(self, inverse_depth: moderngl.Texture, seeds: moderngl.Texture) -> None:
        """Write the nearest of each 2 x 2 pixels."""
        inverse_depth.bind_to_image(_DEPTH, read=True, write=False)
        seeds.bind_to_image(_FIRST, read=False, write=True)
        self._gpu.barrier()
        self._seed.uniforms.set(depth=_DEPTH, nearest=_FIRST, depth_size=self._size)
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
            **{"rendered_colour": _COLOUR, "rendered_depth": _DEPTH},
            **{"kept_colour": _KEPT_COLOUR, "kept_depth": _KEPT_DEPTH, "seeds": _FIRST},
        }
        limits = {"depth_tolerance": TOLERANCE, "depth_floor": DEPTH_FLOOR, "colour_margin": COLOUR_MARGIN}
        which = {"block": BLOCK_SIDE, "place": place_in_block(turn), "once": 1, "rendered_size": self._size}
        self._run(self._forget, tiles(self._size, BLOCK_SIDE), H=there.H, e=there.e, **which, **units, **limits)

    def _bind_rendered(self, rendered: EyeImage) -> None:
        rendered.colour.bind_to_image(_COLOUR, read=True, write=False)
        rendered.inverse_depth.bind_to_image(_DEPTH, read=True, write=False)

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
