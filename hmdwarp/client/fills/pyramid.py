"""Push-pull through a pyramid that prefers the background."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import attrs

from ...geometry import view_map
from ...gpu import Compute, Gpu
from ...gpu.textures import COLOUR, Owner, allocate, tiles
from ..inputs import PassInputs, ShownPicture
from ..settings import limited
from . import fills
from ._base import Fill, HolePieces

_DEPTH_AND_HOLES = (4, "f4")  # rgba32f
# Up to texels of 2^LOCAL_LEVELS pixels, the farthest surface is preferred if it makes up
# LEAST_LOCAL of the hole borders below a texel. Above that it must make up LEAST_BORDER, and no
# longer replaces nearer surfaces. Borders of cracks weigh CRACK_BORDER.
LOCAL_LEVELS, LEAST_LOCAL, LEAST_BORDER, CRACK_BORDER = 6, 2.0**-10, 0.23, 2.0**-20
# The same share, on all levels, where the nearest surface would lie outside the rendered view. At
# 0.8 the edge of a wall before a hall goes on better, but path traced sequences lose up to 0.2 dB;
# at 0.35 they lose nothing.
LEAST_BEYOND = 0.35
NEVER = 1e6  # a threshold that no share of holes reaches
TOP = 64  # texels a side of the level whose followers one work group computes
_FIRST, _SECOND = (1, 2), (3, 4)  # image units of colour and depth of two levels, or of the picture
_FILLED, _FILLED_DEPTH = 0, 5
_PULLED = {"below_colour": _FIRST[0], "below_depth": _FIRST[1], "level_colour": _SECOND[0], "level_depth": _SECOND[1]}


@attrs.frozen
class _PyramidSettings:
    """When the background is preferred, and what is one surface: see depth_limits of warps."""

    # Share of empty pixels in a part of the picture from which on the background is preferred to
    # nearer surfaces.
    holes: float = limited(0.4, above=True, of="(from 2 on nothing is preferred)")
    tolerance: float = limited(0.2)
    floor: float = limited(0.02)  # 1/m


class _Level(Owner):
    """One level of the pyramid."""

    def __init__(self, gpu: Gpu, size: tuple[int, int]) -> None:
        self.size = size
        self.colour = self.own(allocate(gpu.gl, size, COLOUR))  # and weight
        # Inverse depth (-1: none), share of empty pixels, and weight of the hole borders.
        self.depth = self.own(allocate(gpu.gl, size, _DEPTH_AND_HOLES))
        self.framebuffer = self.own(gpu.gl.framebuffer([self.colour, self.depth]))

    def binding(self, units: tuple[int, int], *, read: bool = True, write: bool = False) -> list[Callable[[], None]]:
        pairs = zip((self.colour, self.depth), units, strict=True)
        return [partial(texture.bind_to_image, unit, read=read, write=write) for texture, unit in pairs]


@attrs.frozen(eq=False)
class _Step:
    """One pass between two levels, as it runs at every frame."""

    program: Compute
    uniforms: dict[str, object]  # those that do not depend on the views
    bind: Sequence[Callable[[], None]]
    run: Callable[[], object]


@fills.register
class Pyramid(Fill):
    """Average the pixels at hole borders to ever coarser levels, which fill holes of any width.

    Where the rendered view would have seen the nearer side go on, the farther one is preferred:
    what is empty there was occluded. Beyond the border of that view either may go on: the farther
    one is preferred only if it makes up a third of the hole's border.
    """

    name = "pyramid"
    reads = ("shown.colour", "shown.inverse_depth")
    writes = ("shown.colour", "shown.inverse_depth")
    complete = True
    drops_depth = True
    Settings = _PyramidSettings

    def prepare(self) -> None:
        shaders = self.gpu.shaders
        self._first_pull = shaders.compute("fills/pyramid_pull.comp", FROM_PICTURE=1)
        self._pull = shaders.compute("fills/pyramid_pull.comp", FROM_PICTURE=0, grid="shown")
        deep = int(self.depth_read)
        self._last_push = shaders.compute("fills/pyramid_push.comp", INTO_PICTURE=1, LISTED=1, WITH_DEPTH=deep)
        self._first_push, self._push = (
            shaders.compute("fills/pyramid_push.comp", INTO_PICTURE=0, LISTED=k) for k in (1, 0)
        )
        pieces = HolePieces(self.gpu, self.name, self.shown_size, with_depth=self.depth_read, coarse=True)
        self._pieces = self.own(pieces)
        size = self.shown_size
        self._levels: list[_Level] = []
        while size != (1, 1) or not self._levels:
            # The last one that is a pass of its own; what follows it is not, but for the next.
            is_start = len(self._levels) > 1 and max(size) <= TOP
            size = tiles(size, 2)
            self._levels.append(self.own(_Level(self.gpu, size)))
            if is_start:
                break
        # None for a picture that is too small for it.
        self._top = shaders.compute("fills/pyramid_top.comp") if is_start else None
        self._pulls, self._pushes = self._steps_down(), self._steps_up()

    def _steps_down(self) -> list[_Step]:
        """Return the passes from the picture to the coarsest level."""
        steps = []
        for number, level in enumerate(self._levels):
            below = self._levels[number - 1] if number else None
            bind = level.binding(_SECOND, read=False, write=True)
            bind += below.binding(_FIRST) if below is not None else []
            if below is not None and level is self._levels[-1] and self._top is not None:
                uniforms = {
                    "start_size": below.size,
                    "levels": 1 + (max(level.size) - 1).bit_length(),
                    "first_pixels": 2.0 ** len(self._levels),
                    "local_levels": max(LOCAL_LEVELS - number, 0),
                    "least_borders": (LEAST_LOCAL, LEAST_BORDER),
                    "least_shares": (self.settings.holes, NEVER),
                    "depth_tolerance": self.settings.tolerance,
                    "depth_floor": self.settings.floor,
                    **_PULLED,
                }
                # It completes this level from those that are no textures.
                steps.append(_Step(self._top, uniforms, bind, self._top.program.run))
                continue
            pixels = 2.0 ** (number + 1)
            uniforms = {"below_size": self.shown_size if below is None else below.size, "level_size": level.size}
            uniforms |= {"texel_pixels": pixels, **_PULLED, **self._limits(number)}
            if below is None:
                uniforms |= {"shown_size": level.size}
                run = partial(self._pieces.run_coarse, self._first_pull)
                steps.append(_Step(self._first_pull, uniforms, bind, run))
            else:
                uniforms |= {"crack_border": CRACK_BORDER if number == 1 else 1.0}
                steps.append(_Step(self._pull, uniforms, bind, self._pull.over(*self.shown_size, round(pixels))))
        return steps

    def _steps_up(self) -> list[_Step]:
        """Return the passes from the coarsest level to the picture."""
        steps = []
        for number in range(len(self._levels) - 1, -1, -1):
            above = self._levels[number]
            uniforms = {"above_colour": _FIRST[0], "above_depth": _FIRST[1], "above_size": above.size}
            uniforms |= self._limits(number)
            if number == 0:
                uniforms |= {"warped": _SECOND[0], "filled": _FILLED, "shown_size": self.shown_size}
                uniforms |= {"texel_pixels": 1.0, **({"filled_depth": _FILLED_DEPTH} if self.depth_read else {})}
                run = partial(self._pieces.run, self._last_push)
                steps.append(_Step(self._last_push, uniforms, above.binding(_FIRST), run))
                break
            level, program = self._levels[number - 1], self._push if number > 1 else self._first_push
            uniforms |= {"level_colour": _SECOND[0], "level_depth": _SECOND[1], "level_size": level.size}
            uniforms |= {"texel_pixels": 2.0**number}
            uniforms |= {"least_holes": self.settings.holes if number - 1 < LOCAL_LEVELS else NEVER}
            below = program.over(*level.size)
            if number == 1:
                uniforms |= {"shown_size": level.size}
                below = partial(self._pieces.run_coarse, program)
            steps.append(_Step(program, uniforms, [*above.binding(_FIRST), *level.binding(_SECOND, write=True)], below))
        return steps

    def _limits(self, number: int) -> dict[str, float]:
        least = LEAST_LOCAL if number < LOCAL_LEVELS else LEAST_BORDER
        return {"depth_tolerance": self.settings.tolerance, "depth_floor": self.settings.floor, "least_border": least}

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        self._pieces.find(picture, into)
        back = view_map(inputs.middle, self.shown_size, inputs.rendered.view, self.rendered_size)
        place = {"back_H": back.H, "back_e": back.e, "rendered_size": self.rendered_size, "least_beyond": LEAST_BEYOND}
        for level in self._levels[: -1 if self._top is not None else None]:
            level.framebuffer.clear()  # texels not stored below have no hole and no weight
        picture.colour.texture.bind_to_image(_FIRST[0], read=True, write=False)
        picture.depth.bind_to_image(_FIRST[1], read=True, write=False)
        for step in (*self._pulls, *self._pushes):
            for bind in step.bind:
                bind()
            if step.program is self._last_push:
                picture.colour.texture.bind_to_image(_SECOND[0], read=True, write=False)
                into.colour.texture.bind_to_image(_FILLED, read=False, write=True)
                if self.depth_read:
                    into.depth.bind_to_image(_FILLED_DEPTH, read=False, write=True)
            step.program.uniforms.set(**({} if step.program is self._first_pull else place), **step.uniforms)
            step.run()
            self.gpu.barrier()
