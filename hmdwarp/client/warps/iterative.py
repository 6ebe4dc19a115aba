"""A gather that finds its depth in the rendered picture by fixed-point iteration."""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, Literal

import attrs
import moderngl
import numpy as np

from ...base import InputError
from ...frames import EyeImage, Needs, Others
from ...geometry import Fov, Hidden, WarpMap, view_map
from ...gpu import Gpu
from ...gpu.hidden import Grid
from ...gpu.textures import COLOUR, SCALAR, Canvas, Owner, allocate, bind_images, tiles
from ..inputs import PassInputs
from ..settings import chosen, limited
from . import warps
from .gather import DEPTH_FLOOR, DEPTH_TOLERANCE, GatherSettings, GatherWarp, depth_limits, last_centre

BLOCK = 4  # pixels on each axis, rendered and shown; as in shaders/lib/seeds.glsl
BLOCK_BYTES, CELL_BYTES = 16, 4
_MOST_INDEX_BITS = 27  # of a key's 32; five are the exponent of the depth


class Seeds(Owner):
    """The rendered inverse depths that the rays of each cell of 4x4 shown pixels meet first."""

    def __init__(self, gpu: Gpu, rendered_size: tuple[int, int], shown_size: tuple[int, int]) -> None:
        self._gpu, self._rendered_size, self._shown_size = gpu, rendered_size, shown_size
        bits = tuple((n - 1).bit_length() for n in rendered_size)
        self._blocks, self.cells = (tiles(size, BLOCK) for size in (rendered_size, shown_size))
        most = min(gpu.gl.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"] // BLOCK_BYTES * BLOCK**2, 2**_MOST_INDEX_BITS)
        if sum(bits) > _MOST_INDEX_BITS or BLOCK**2 * self._blocks[0] * self._blocks[1] > most:
            raise InputError(
                f"a rendered picture of {rendered_size[0]}x{rendered_size[1]}: the forward seed takes about {most} "
                "pixels at most; use seed=rotation"
            )
        compute = partial(gpu.shaders.compute, "warps/iterative_seed.comp")
        # The last one visits every cell, whose key may be of the other eye.
        programs = compute(grid="rendered", PASS=0), compute(grid="rendered", PASS=1), compute(PASS=2)
        sizes = {"blocks": self._blocks, "cells": self.cells, "index_bits": bits}
        grids = (rendered_size, self._blocks), (rendered_size, self._blocks), (shown_size, self.cells)
        self._passes = [
            (program, program.over(*size, BLOCK), {"grid": grid, **sizes})
            for program, (size, grid) in zip(programs, grids, strict=True)
        ]
        of_cells = bytes(CELL_BYTES * self.cells[0] * self.cells[1])
        nearest = gpu.gl.buffer(reserve=BLOCK_BYTES * self._blocks[0] * self._blocks[1])
        self._buffers = [self.own(each) for each in (gpu.gl.buffer(of_cells), nearest, gpu.gl.buffer(of_cells))]

    def find(self, inputs: PassInputs, surface: dict[str, object]) -> None:
        """Compute the guesses and leave them bound for the gather.

        surface: the uniforms of lib/rendered_surface.glsl; the rendered depth is bound.
        """
        shown = inputs.middle
        forward = view_map(inputs.rendered.view, self._rendered_size, shown, self._shown_size)
        back = view_map(shown, self._shown_size, inputs.rendered.view, self._rendered_size)
        for binding, buffer in enumerate(self._buffers):  # the seeds, the nearest of blocks, the keys
            buffer.bind_to_storage_buffer(binding)
        for (program, run, sizes), warp in zip(self._passes, (forward, forward, back), strict=True):
            program.uniforms.set(H=warp.H, e=warp.e, **sizes, **surface)
            run()
            self._gpu.barrier()


_MEAN_BLOCK = 8  # pixels on each side, as SIDE and ROWS in the shaders
_MOST_OLDER = 3
# Image units; one for each older frame. The texture unit of a colour is that of its image.
_SHOWN, _SHOWN_DEPTH, _SUMS, _TOLD, _DEPTHS, _COLOURS = 0, 1, 2, 3, 4, 4 + _MOST_OLDER


class _OlderFrames(Owner):
    """Passes that look each shown pixel up in older frames, where they saw the same surface.

    The place follows from the depth that the warp has found, so nothing is searched again. Noise,
    codec errors and the blur of sampling differ from frame to frame and average out. Of an older
    frame only detail counts: in blocks of 8 x 8 pixels its mean becomes the newest frame's. It
    counts less the more light has changed there, and the farther off it lies.
    """

    def __init__(
        self, gpu: Gpu, rendered_size: tuple[int, int], shown_size: tuple[int, int], most: int, *, scanout: bool
    ) -> None:
        """Compile for at most `most` older frames."""
        self._gpu = gpu
        wide, high = blocks = tiles(shown_size, _MEAN_BLOCK)
        ways = {name: 1 for name, asked in {"SCANOUT": scanout, "TEXELS": gpu.is_software}.items() if asked}
        agree = gpu.shaders.compute("warps/older_agree.comp")
        # For each number of frames the passes in order, the constants of each, and what runs it.
        self._passes = []
        for count in range(1, most + 1):
            compare, join = (
                gpu.shaders.compute(f"warps/older_{name}.comp", OLDER=count, **ways) for name in ("compare", "join")
            )
            every: dict[str, object] = {"shown_colour": _SHOWN, "shown_inverse_depth": _SHOWN_DEPTH, "sums": _SUMS}
            every |= {"told": _TOLD, "blocks": blocks, "shown_size": shown_size, "rendered_size": rendered_size}
            every["frames"] = count
            for name, first in (("older_inverse_depth", _DEPTHS), ("older_colour", _COLOURS)):
                every[name] = tuple(range(first, first + count)) if count > 1 else first
            runs = compare.over(*blocks), agree.over(wide, count * high), join.over(wide, shown_size[1])
            self._passes.append((every, tuple(zip((compare, agree, join), runs, strict=True))))
        self._told = self.own(allocate(gpu.gl, (wide, most * high), COLOUR))
        self._sums = self.own(allocate(gpu.gl, (wide, 4 * most * high), (4, "f4")))

    def add(
        self,
        older: Sequence[EyeImage],
        depths: Sequence[moderngl.Texture],
        maps: Sequence[Mapping[str, np.ndarray]],
        into: Canvas,
        inverse_depth: moderngl.Texture,
        limits: Mapping[str, object],
    ) -> None:
        """Average `into`, whose pixels lie at `inverse_depth` (r32f), with the older frames.

        depths: their inverse depths. maps: H and e to each of them, as uniforms. limits:
        depth_tolerance and depth_floor.
        """
        for k, (image, depth) in enumerate(zip(older, depths, strict=True)):
            depth.bind_to_image(_DEPTHS + k, read=True, write=False)
            image.colour.bind_to_image(_COLOURS + k, read=True, write=False)
            image.colour.use(_COLOURS + k)
        inverse_depth.bind_to_image(_SHOWN_DEPTH, read=True, write=False)
        for unit, changed in ((_SHOWN, into.texture), (_SUMS, self._sums), (_TOLD, self._told)):
            changed.bind_to_image(unit, read=True, write=True)
        places = {}
        for name in maps[0]:
            places[f"older_{name}"] = np.array([*map(operator.itemgetter(name), maps)])
        every, passes = self._passes[len(older) - 1]
        for program, run in passes:
            self._gpu.barrier()
            program.uniforms.settle(every)
            if program.uniforms.declares("older_H"):
                program.uniforms.set(**places, **limits)
            run()


MOST_STEPS = 64


@attrs.frozen
class IterativeSettings(GatherSettings):
    """How guesses start, converge and end; which neighbours are one surface: see depth_limits."""

    # Source of the first guess: a forward splat of depth at a quarter of the resolution, or the map
    # at infinity.
    seed: Literal["forward", "rotation"] = chosen("forward", "rotation")
    steps: int = 3  # Samples of the rendered depth.
    # How many of the last steps use the slope of the surface; each costs three plain ones and helps
    # most for near objects that pass by.
    slanted: int = 1
    tolerance: float = limited(DEPTH_TOLERANCE)
    floor: float = limited(DEPTH_FLOOR)  # 1/m
    converged: float = limited(0.75)  # Pixels by which the last guess may be off; beyond that the pixel is a hole.
    # Pixels by which neighbours on two surfaces may part and still be joined by a stretched sheet:
    # narrower than a pixel it looks like the mixed colours of an antialiased silhouette.
    sheet: float = limited(1.0)
    resample: Literal["bilinear", "catmull-rom"] = "catmull-rom"
    # Late frames that are averaged: the newest, and older ones where they saw the same surface.
    frames: int = limited(3, 1, _MOST_OLDER + 1)
    # Whether the pixel beside a nearer surface, whose colour antialiasing has mixed, moves with it.
    fringe: Literal["front", "own"] = chosen("front", "own")

    def __attrs_post_init__(self) -> None:
        if not 1 <= self.slanted <= self.steps <= MOST_STEPS:
            raise ValueError(
                f"steps={self.steps}, slanted={self.slanted}: expected 1 <= slanted <= steps <= {MOST_STEPS}"
            )


# As it is where it draws a part of the picture for another pass.
OF_A_PART = IterativeSettings(frames=1, resample="bilinear")


@warps.register
class Iterative(GatherWarp):
    """A gather by fixed point on the rendered depth, seeded by a low-resolution forward splat.

    Pixels that do not converge are holes.
    """

    name = "iterative"
    reads = ("rendered.colour", "rendered.inverse_depth")
    Settings = IterativeSettings
    variants = ("seed=rotation", "slanted=3", "frames=1", "frames=2")
    rows_with_depth = 3  # with more, Mesa no longer unrolls the loop: 26 ms of CPU instead of 23 on llvmpipe

    @classmethod
    def needs(cls, settings: Any) -> Needs:
        return Needs(others=Others(recent=settings.frames - 1)) if settings.frames > 1 else Needs()

    @property
    def _averages(self) -> bool:
        return self.settings.frames > 1 and self.output.lens is None

    def own_depth(self) -> moderngl.Texture | None:
        return allocate(self.gpu.gl, self.shown_size, SCALAR) if self._averages else super().own_depth()

    def prepare(self) -> None:
        chosen = self.settings
        self._older: _OlderFrames | None = None
        if self._averages:
            most, scanout = chosen.frames - 1, self.output.scanout
            self._older = self.own(_OlderFrames(self.gpu, self.rendered_size, self.shown_size, most, scanout=scanout))
        seeded = chosen.seed == "forward"
        samples = {"PLAIN": chosen.steps - chosen.slanted, "SLANTED": chosen.slanted}
        self._program = self.gather("warps/iterative.comp", **samples, **({"SEEDED": 1} if seeded else {}))
        # At first it runs over all; what lenses hide then stays, with pictures for each eye.
        grids: tuple[Grid | None, ...] = (None, "rendered") if chosen.fringe == "front" else ()
        self._fringes = [self.gpu.shaders.compute("warps/iterative_fringe.comp", grid=grid) for grid in grids]
        self._run_fringe = [program.over(*self.rendered_size) for program in self._fringes]
        counts = [chosen.frames] * 2 if self._averages else [1] * len(set(self._fringes))
        # Of each eye: pictures whose fringes were moved, and what of them the lens hides.
        self._fringed: list[dict[object, tuple[moderngl.Texture, tuple[Hidden | None, Fov] | None]]] = [
            {k: (self.own(allocate(self.gpu.gl, self.rendered_size, SCALAR)), None) for k in range(count)}
            for count in counts
        ]
        self._seeds = self.own(Seeds(self.gpu, self.rendered_size, self.shown_size)) if seeded else None

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        limits = depth_limits(self.settings, inputs.rendered)
        surface: dict[str, object] = {"rendered_inverse_depth": 1, **limits}
        inputs.rendered.inverse_depth.bind_to_image(1, read=True, write=False)
        if self._fringes:  # the gather reads the rendered depth with its fringes moved
            self._moved(inputs.rendered, inputs).bind_to_image(1, read=True, write=False)
        surface |= last_centre(self.rendered_size)
        if self._seeds is not None:
            self._seeds.find(inputs, surface)
            surface["cells"] = self._seeds.cells
        surface |= {"most_pixels": self.settings.converged, "sheet": self.settings.sheet}
        maps = self.run_gather(self._program, inputs, into, **surface)
        older = inputs.recent[: self.settings.frames - 1]
        if self._older is None or self.depth_into is None or not older:
            return
        # A picture that is shown as it was drawn keeps its last bits.
        if not all(map(WarpMap.moves_whole_pixels, maps)):
            back, depths, held = [], [], self._fringed[inputs.eye % len(self._fringed)]
            for image in older:
                back.append(self.coefficients(self.maps(inputs, image.view)))
                if not self._fringes:
                    depths.append(image.inverse_depth)
                else:
                    depths.append(held[image][0] if image in held else self._moved(image, inputs))
            self._older.add(older, depths, back, into, self.depth_into, limits)

    def _moved(self, image: EyeImage, inputs: PassInputs) -> moderngl.Texture:
        """Return an inverse depth with its fringes moved, in place of one that is not used now."""
        held = self._fringed[inputs.eye % len(self._fringed)]
        used = inputs.rendered, *inputs.recent[: self.settings.frames - 1]
        known: object = image
        if image not in held:
            (known, *_) = held.keys() - used
        texture, seen = held.pop(known)
        now = image.view.hidden, image.view.fov
        held[image] = texture, now
        which = image is inputs.rendered and seen == now  # strips are those of its view
        read, write = {"rendered_inverse_depth": image.inverse_depth}, {"fringed_inverse_depth": texture}
        named = bind_images(read, write, first=1) | depth_limits(self.settings, image)
        self._fringes[which].uniforms.set(rendered_size=self.rendered_size, **named)
        self._run_fringe[which]()
        self.gpu.barrier()
        return texture
