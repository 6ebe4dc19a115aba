"""The kind of warps in which each shown pixel finds where it was rendered.

One shader function per warp runs for the shown view or fused with the lens, for all rows at once or
row by row.
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import attrs
import moderngl
import numpy as np

from ...frames import EyeImage
from ...frames.layers.pictures import FoveatedPicture
from ...geometry import FoveaGrid, View, WarpMap, view_map
from ...gpu.hidden import Grid
from ...gpu.shaders import Compute
from ...gpu.textures import Canvas
from ..inputs import PassInputs
from ..lens import bind_texels
from ..warps import Warp

_COLOUR = 0  # texture unit
_RENDERED_DEPTH, _SHOWN_DEPTH = 4, 5  # image units


@attrs.frozen
class GatherSettings:
    """How colour is sampled between the rendered pixels."""

    # catmull-rom: a cubic through 4 x 4 pixels, sharper and dearer than the mean of 2 x 2.
    resample: Literal["bilinear", "catmull-rom"] = "bilinear"


class GatherWarp(Warp):
    """A warp whose shader has `vec4 gathered(vec2 shown, vec3 base, vec3 parallax)`.

    It returns the colour of the shown pixel at `shown`. `base + parallax * inverse_depth` is the
    rendered pixel (homogeneous) of a point at that inverse depth in the shown view.

    Where WRITES_DEPTH is defined, `gathered` leaves in `found_inverse_depth` the inverse depth of
    what it returns, in the shown view.

    The shader samples by `sampled(p)` of lib/gather.glsl, which uses the sampler or image loads,
    whichever is faster. If the shader defines PREPARE as the name of a function before it includes
    OUTPUT, that function runs once before the loop over rows, for copies of uniforms.
    """

    kind = "gather"
    Settings: ClassVar[type] = GatherSettings
    depth_reads: ClassVar[tuple[str, ...] | None] = ("rendered.inverse_depth",)
    fuses = True
    scans_out = True
    rows: ClassVar[int] = 8  # pixels of one column per invocation; 4 suits heavy shaders
    rows_with_depth: ClassVar[int] = 0  # the same where bilinear samples and the depth are written; 0: as many

    def gather(self, path: str, **defines: object) -> Compute:
        """Return the program of `path` for this warp's output."""
        lens = self.output.lens
        cubic = isinstance(self.settings, GatherSettings) and self.settings.resample == "catmull-rom"
        if lens is None:
            defines |= {"ROWS": (self.depth_into and not cubic and self.rows_with_depth) or self.rows}
        else:
            defines |= lens.panel_defines
        if self.output.scanout:
            defines |= {"SCANOUT": 1}
        if cubic:
            # Image loads take llvmpipe half the time of fetches.
            defines |= {"CATMULL_ROM": 1, **({"TEXELS": 1} if self.gpu.is_software else {})}
        if self.depth_into is not None:
            defines |= {"WRITES_DEPTH": 1}
        if self.output.foveated is not None:
            # A sampler is not exact at centres.
            defines |= {"FOVEATED": 1, "TEXELS": 1}
        grid: Grid = "shown" if lens is None else "panel"
        return self.gpu.shaders.compute(path, grid=grid, OUTPUT=f"lib/to_{grid}.glsl", **defines)

    def map_between(self, shown: View, rendered: View) -> WarpMap:
        """Return the map from shown to rendered pixels."""
        return view_map(shown, self.shown_size, rendered, self.rendered_size)

    def run_gather(self, program: Compute, inputs: PassInputs, into: Canvas, **uniforms: object) -> list[WarpMap]:
        """Bind colour and result, set maps and sizes, run over every pixel; return the maps."""
        maps = self.maps(inputs, inputs.rendered.view)
        self.bind_colour(inputs, _COLOUR, maps)
        into.bind_for_writing(0)
        program.uniforms.settle(self._size_uniforms)
        if self.depth_into is not None:
            self.depth_into.bind_to_image(_SHOWN_DEPTH, read=False, write=True)
            program.uniforms.set(shown_inverse_depth=_SHOWN_DEPTH)
        uniforms |= bind_texels(program, self.picture(inputs))
        program.uniforms.set(rendered_colour=_COLOUR, written=0, **self.coefficients(maps), **uniforms)
        if self.output.foveated is not None:
            found = inputs.rendered.get("foveated")
            # What came whole is as sharp everywhere.
            grid = FoveaGrid(inputs.rendered.size, 2, (0, 0), (0, 0)) if found is None else found.grid
            program.uniforms.set(**grid.uniforms)
        if (lens := self.output.lens) is not None:
            program.uniforms.set(panel_size=into.size, **lens.library_uniforms(inputs.shown.fov, inputs.eye))
        program.run(*into.size)
        return maps

    def bind_beside(self, program: Compute, inputs: PassInputs) -> None:
        """Bind what lib/depth_beside.glsl reads, if the shown depth is written."""
        if self.depth_into is None:
            return
        inputs.rendered.inverse_depth.bind_to_image(_RENDERED_DEPTH, read=True, write=False)
        to_shown = view_map(inputs.rendered.view, self.rendered_size, inputs.middle, self.shown_size)
        ratio = np.append(to_shown.H[2], to_shown.e[2])
        program.uniforms.set(rendered_inverse_depth=_RENDERED_DEPTH, depth_ratio=ratio)

    def picture(self, inputs: PassInputs) -> moderngl.Texture:
        """Return the texture that the shader samples."""
        found: FoveatedPicture | None = inputs.rendered.get("foveated") if self.output.foveated is not None else None
        return inputs.rendered.colour if found is None else found.texture

    def bind_colour(self, inputs: PassInputs, unit: int, maps: list[WarpMap]) -> None:
        """Bind that texture to the sampler."""
        exact = self.output.lens is None and all(map(WarpMap.moves_whole_pixels, maps))
        bind_rendered_colour(inputs.rendered, unit, whole_pixels=exact)

    def maps(self, inputs: PassInputs, to: View) -> list[WarpMap]:
        """Return the map from the shown view; with scan-out at its first, middle and last row."""
        if not self.output.scanout:
            return [self.map_between(inputs.shown, to)]
        first, last = inputs.shown, inputs.shown_last if inputs.shown_last is not None else inputs.shown
        middle = View(first.pose.towards(last.pose, 0.5), first.fov)
        return [self.map_between(view, to) for view in (first, middle, last)]

    def coefficients(self, maps: list[WarpMap]) -> dict[str, np.ndarray]:
        """Return H and e; with scan-out their parabola through three instants, t from 0 to 1.

        t = 0 at the first row, 1 past the last. A head that turns by an angle a during scan-out
        deviates from the parabola by at most a^3 / (72 sqrt 3) rad, in the middle of either half: 5
        degrees (300 a second, 16.7 ms) are 5e-6, half a hundredth of a pixel at 1000 pixels a
        radian. It follows translation exactly. Derived in tests/reference/scanout.py.
        """
        if len(maps) == 1:
            return {"H": maps[0].H, "e": maps[0].e}
        named: dict[str, np.ndarray] = {}
        for name in ("H", "e"):
            first, middle, last = (getattr(warp_map, name) for warp_map in maps)
            square = 2 * (first + last - 2 * middle)
            named |= {name: first, f"{name}_linear": last - first - square, f"{name}_square": square}
        return named


def bind_rendered_colour(rendered: EyeImage, unit: int, *, whole_pixels: bool) -> None:
    """Bind the rendered colour for bilinear samples, or nearest ones if all lie on pixel centres.

    Bilinear hardware computes the centre's coordinate with an error of up to 1e-4 pixels (llvmpipe)
    or 1/512 (GPUs), enough to change the last bit of a dark pixel beside a bright one. Nearest
    samples keep an unmoved head bit-exact.
    """
    chosen = moderngl.NEAREST if whole_pixels else moderngl.LINEAR
    rendered.colour.filter = (chosen, chosen)
    rendered.colour.use(unit)


# Inverse depth is linear across a plane, so between a sampled point and a texel of its footprint it
# changes by at most one pixel's worth of slope. 3 % covers planes seen at up to 80 degrees at 10
# pixels a degree (tan 80 x 0.1 deg = 1 %, on each axis, with the rounding of the client's own
# raster on top); nearer surfaces differ by more than that from those they occlude.
DEPTH_TOLERANCE = 0.03
DEPTH_FLOOR = 0.02  # 1/m: things beyond 50 m count as equally far


def depth_limits(settings: Any, rendered: EyeImage) -> dict[str, object]:
    """Return the uniforms of the comparison: the settings' tolerance, and a floor under it.

    Coded depth is off by depth_error, which the floor takes in: tolerance * floor is the part that
    does not grow with inverse depth. A tolerance of 0 stays 0.
    """
    more = rendered.depth_error / settings.tolerance if settings.tolerance else 0.0
    return {"depth_tolerance": settings.tolerance, "depth_floor": settings.floor + more}


class HomographyWarp(GatherWarp):
    """A gather through a 3x3 matrix that does not depend on depth."""

    reads = ("rendered.colour",)
    samples_grid = True

    @property
    def clamps(self) -> bool:
        """Whether the outermost pixels of the rendered picture go on beyond its border."""
        return False

    def prepare(self) -> None:
        self._program = self.gather("warps/rotation.comp", CLAMP=int(self.clamps))

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        self.bind_beside(self._program, inputs)
        self.run_gather(self._program, inputs, into)


class PlaneWarp(GatherWarp):
    """A gather whose shader reads the median inverse depth, which never leaves the GPU."""

    reads = ("rendered.colour", "rendered.inverse_depth")
    shader: ClassVar[str]

    def prepare(self) -> None:
        self._median = self.gpu.shaders.compute("warps/median.comp")
        self._gather = self.gather(self.shader)
        self._plane = self.gpu.gl.buffer(reserve=16)

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        self._plane.bind_to_storage_buffer(0)
        inputs.rendered.inverse_depth.use(1)
        self.set_sizes(self._median)
        self._median.uniforms.set(rendered_inverse_depth=1)
        self._median.run(1)
        self.gpu.gl.memory_barrier(moderngl.SHADER_STORAGE_BARRIER_BIT)
        self.bind_beside(self._gather, inputs)
        self.run_gather(self._gather, inputs, into, **self.own_uniforms(inputs))

    def own_uniforms(self, inputs: PassInputs) -> dict[str, object]:
        """Return uniforms of this warp's shader alone."""
        return {}

    def close(self) -> None:
        super().close()
        self._plane.release()
