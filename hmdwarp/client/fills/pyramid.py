"""Push-pull through a pyramid that prefers the background."""

from __future__ import annotations

import attrs
import moderngl

from ...geometry import WarpMap
from ...gpu.context import Gpu
from ...gpu.shaders import Compute
from ...gpu.textures import COLOUR, allocate, release_all, tiles
from ..fill_parts import HolePieces
from ..inputs import PassInputs, ShownPicture
from . import fills
from ._base import Fill

DEPTH_AND_HOLES = (4, "f4")  # rgba32f
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
class PyramidSettings:
    """When to prefer the background.

    Inverse depths belong to one surface if they differ by at most tolerance * (the smaller one +
    floor).
    """

    # Share of empty pixels in a part of the picture from which on the background is preferred to
    # nearer surfaces.
    holes: float = 0.4
    tolerance: float = 0.2
    floor: float = 0.02  # 1/m

    def __attrs_post_init__(self) -> None:
        if not all(0 <= value < float("inf") for value in (self.tolerance, self.floor)):
            raise ValueError("tolerance and floor must be 0 or more")
        if not 0 < self.holes < float("inf"):
            raise ValueError(f"holes={self.holes}: expected more than 0; from 2 on nothing is preferred")


@attrs.frozen(eq=False)
class _Level:
    """One level of the pyramid."""

    size: tuple[int, int]
    colour: moderngl.Texture  # rgba16f colour and weight
    # rgba32f: inverse depth (-1: none), share of empty pixels, and weight of the hole borders.
    depth: moderngl.Texture
    framebuffer: moderngl.Framebuffer

    @classmethod
    def allocated(cls, gpu: Gpu, size: tuple[int, int]) -> _Level:
        textures = allocate(gpu.gl, size, COLOUR), allocate(gpu.gl, size, DEPTH_AND_HOLES)
        return cls(size, *textures, gpu.gl.framebuffer(list(textures)))

    def bind(self, units: tuple[int, int], *, read: bool = True, write: bool = False) -> None:
        self.colour.bind_to_image(units[0], read=read, write=write)
        self.depth.bind_to_image(units[1], read=read, write=write)

    def release(self) -> None:
        release_all(self.framebuffer, self.colour, self.depth)


@fills.register
class Pyramid(Fill):
    """Average the pixels at hole borders to ever coarser levels, which fill holes of any width.

    Where the rendered view would have seen the nearer side go on, the farther one is preferred:
    what is empty there was occluded. Beyond the border of that view either may go on: the farther
    one is preferred only if it makes up a third of the hole's border.
    """

    name = "pyramid"
    summary = "fills holes of any width smoothly from what borders on them, from the background where there is one"
    reads = ("shown.colour", "shown.inverse_depth")
    writes = ("shown.colour", "shown.inverse_depth")
    source = "Gortler et al. 1996, The Lumigraph (push-pull); the preference for the background is this project's"
    complete = True
    drops_depth = True
    Settings = PyramidSettings

    def prepare(self) -> None:
        shaders = self.gpu.shaders
        self._first_pull = shaders.compute("fills/pyramid_pull.comp", FROM_PICTURE=1)
        self._pull = shaders.compute("fills/pyramid_pull.comp", FROM_PICTURE=0, grid="shown")
        deep = int(self.depth_read)
        self._last_push = shaders.compute("fills/pyramid_push.comp", INTO_PICTURE=1, LISTED=1, WITH_DEPTH=deep)
        self._first_push, self._push = (
            shaders.compute("fills/pyramid_push.comp", INTO_PICTURE=0, LISTED=k) for k in (1, 0)
        )
        self._pieces = HolePieces(self.gpu, self.name, self.shown_size, with_depth=self.depth_read, coarse=True)
        size = self.shown_size
        self._levels: list[_Level] = []
        while size != (1, 1) or not self._levels:
            # The last one that is a pass of its own; what follows it is not, but for the next.
            is_start = len(self._levels) > 1 and max(size) <= TOP
            size = tiles(size, 2)
            self._levels.append(_Level.allocated(self.gpu, size))
            if is_start:
                break
        # None for a picture that is too small for it.
        self._top = shaders.compute("fills/pyramid_top.comp") if is_start else None
        placed = (self._pull, self._first_push, self._push, self._last_push, self._top)
        self._placed = [program for program in placed if program is not None]

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        self._pieces.find(picture, into)
        back = WarpMap.between(inputs.middle, self.shown_size, inputs.rendered.view, self.rendered_size)
        for program in self._placed:
            place = {"back_H": back.H, "back_e": back.e, "rendered_size": self.rendered_size}
            program.uniforms.set(least_beyond=LEAST_BEYOND, **place)
        self._pull_all(picture)
        for below, above in reversed(list(zip(self._levels, self._levels[1:], strict=False))):
            self._push_one(below, above)
        picture.colour.texture.bind_to_image(_SECOND[0], read=True, write=False)
        into.colour.bind_for_writing(_FILLED)
        self._read_above(self._last_push, self._levels[0])
        uniforms = {"warped": _SECOND[0], "filled": _FILLED, "shown_size": self.shown_size, "texel_pixels": 1.0}
        if self.depth_read:
            into.depth.bind_to_image(_FILLED_DEPTH, read=False, write=True)
            uniforms["filled_depth"] = _FILLED_DEPTH
        self._last_push.uniforms.set(**uniforms)
        self._pieces.run(self._last_push)

    def _pull_all(self, picture: ShownPicture) -> None:
        first = self._levels[0]
        for level in self._levels[: -1 if self._top is not None else None]:
            level.framebuffer.clear()  # texels not stored below have no hole and no weight
        picture.colour.texture.bind_to_image(_FIRST[0], read=True, write=False)
        picture.depth.bind_to_image(_FIRST[1], read=True, write=False)
        self._write_level(self._first_pull, self.shown_size, first)
        self._first_pull.uniforms.set(shown_size=first.size)
        self._pieces.run_coarse(self._first_pull)
        for below, level in zip(self._levels, self._levels[1:], strict=False):
            below.bind(_FIRST)
            if self._top is not None and level is self._levels[-1]:
                self._run_top(self._top, below, level)
            else:
                self._write_level(self._pull, below.size, level)
                self._pull.uniforms.set(crack_border=CRACK_BORDER if below is first else 1.0)
                self._pull.run(*self.shown_size, round(self._texel_pixels(level)))
            self.gpu.barrier()

    def _run_top(self, program: Compute, start: _Level, level: _Level) -> None:
        """Compute the last level that is a texture, and complete it from those that are not."""
        level.bind(_SECOND, read=False, write=True)
        program.uniforms.set(
            start_size=start.size,
            levels=1 + (max(level.size) - 1).bit_length(),
            first_pixels=2.0 ** len(self._levels),
            local_levels=max(LOCAL_LEVELS - self._levels.index(level), 0),
            least_borders=(LEAST_LOCAL, LEAST_BORDER),
            least_shares=(self.settings.holes, NEVER),
            depth_tolerance=self.settings.tolerance,
            depth_floor=self.settings.floor,
            **_PULLED,
        )
        program.program.run()

    def _write_level(self, program: Compute, below_size: tuple[int, int], level: _Level) -> None:
        level.bind(_SECOND, read=False, write=True)
        sizes = {"below_size": below_size, "level_size": level.size, "texel_pixels": self._texel_pixels(level)}
        program.uniforms.set(**sizes, **_PULLED, **self._limits(level))

    def _push_one(self, level: _Level, above: _Level) -> None:
        first = level is self._levels[0]
        program = self._first_push if first else self._push
        level.bind(_SECOND, write=True)
        self._read_above(program, above)
        program.uniforms.set(
            level_colour=_SECOND[0],
            level_depth=_SECOND[1],
            level_size=level.size,
            texel_pixels=self._texel_pixels(level),
            least_holes=self.settings.holes if self._is_local(level) else NEVER,
        )
        if first:
            program.uniforms.set(shown_size=level.size)
            self._pieces.run_coarse(program)
            return
        program.run(*level.size)
        self.gpu.barrier()

    def _read_above(self, program: Compute, above: _Level) -> None:
        above.bind(_FIRST)
        program.uniforms.set(
            above_colour=_FIRST[0], above_depth=_FIRST[1], above_size=above.size, **self._limits(above)
        )

    def _limits(self, level: _Level) -> dict[str, float]:
        least = LEAST_LOCAL if self._is_local(level) else LEAST_BORDER
        return {"depth_tolerance": self.settings.tolerance, "depth_floor": self.settings.floor, "least_border": least}

    def _texel_pixels(self, level: _Level) -> float:
        return float(2.0 ** (self._levels.index(level) + 1))

    def _is_local(self, level: _Level) -> bool:
        return self._levels.index(level) < LOCAL_LEVELS

    def close(self) -> None:
        self._pieces.close()
        release_all(*self._levels)
