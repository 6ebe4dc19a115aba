"""Gathers: each shown pixel finds where it was rendered, by one map, a cube or a depth.

One shader function per warp runs for the shown view or fused with the lens, for all rows at once or
row by row.
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import attrs
import moderngl
import numpy as np

from ...base import NoSettings, PlanError
from ...frames import EyeImage, Needs
from ...frames.layers.pictures import FoveatedPicture
from ...geometry import FoveaGrid, Pose, View, WarpMap, face_views, view_map
from ...gpu import Compute
from ...gpu.hidden import Grid
from ...gpu.textures import Canvas, bind_images
from ..inputs import PassInputs
from ..lens import bind_texels
from ..settings import limited
from . import warps
from ._base import Warp, pixel_of

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
            uniforms["shown_inverse_depth"] = _SHOWN_DEPTH
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
USUAL_LIMITS = {"depth_tolerance": DEPTH_TOLERANCE, "depth_floor": DEPTH_FLOOR}


def last_centre(size: tuple[int, int]) -> dict[str, object]:
    """Return the uniform of lib/rendered_surface.glsl: the centre of the picture's last pixel."""
    return {"last_centre": (size[0] - 0.5, size[1] - 0.5)}


def depth_limits(settings: Any, rendered: EyeImage) -> dict[str, object]:
    """Return the uniforms of the comparison: the settings' tolerance, and a floor under it.

    Two inverse depths are of one surface if they differ by at most tolerance * (the smaller one +
    floor). Coded depth is off by depth_error, which the floor takes in. A tolerance of 0 stays 0.
    """
    more = rendered.depth_error / settings.tolerance if settings.tolerance else 0.0
    return {"depth_tolerance": settings.tolerance, "depth_floor": settings.floor + more}


class HomographyWarp(GatherWarp):
    """A gather through a 3x3 matrix that does not depend on depth."""

    reads = ("rendered.colour",)
    samples_grid = True

    def prepare(self) -> None:
        clamps = getattr(self.settings, "edge", "empty") == "clamp"
        self._program = self.gather("warps/rotation.comp", CLAMP=int(clamps))

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
        self._plane = self.own(self.gpu.gl.buffer(reserve=16))

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


@warps.register
class NoWarp(HomographyWarp):
    """Show the rendered picture at its place in the field of view; a guard band is cut off."""

    name = "none"
    needs_compute = False
    Settings = NoSettings
    imposter = True

    def map_between(self, shown: View, rendered: View) -> WarpMap:
        return super().map_between(View(rendered.pose, shown.fov), rendered)


@attrs.frozen
class _RotationSettings(GatherSettings):
    """What is shown beyond the border of the rendered picture."""

    # clamp: its outermost pixels go on, so that no border is seen. Nothing counts as a hole then.
    edge: Literal["empty", "clamp"] = "empty"


@warps.register
class Rotation(HomographyWarp):
    """Rotate the picture with the head; ignore the eye's translation (asynchronous time warp)."""

    name = "rotation"
    needs_compute = False
    Settings = _RotationSettings
    baselines = {"edge=clamp": "most streamers"}

    def map_between(self, shown: View, rendered: View) -> WarpMap:
        return super().map_between(
            View(Pose(rendered.pose.position_m, shown.pose.orientation_xyzw), shown.fov), rendered
        )


@warps.register
class Planar(PlaneWarp):
    """A gather through the fronto-parallel plane at the median inverse depth."""

    name = "planar"
    shader = "warps/planar.comp"


@warps.register
class Similarity(PlaneWarp):
    """A gather through the similarity nearest to the planar map around the middle of the view.

    It has the planar map's value there, and of all rotations with scale the one whose derivative is
    nearest to the planar map's in the sense of least squares over all directions.
    """

    name = "similarity"
    shader = "warps/similarity.comp"
    scans_out = False  # one similarity for the whole picture

    def own_uniforms(self, inputs: PassInputs) -> dict[str, object]:
        (wide, high), named = self.shown_size, dict[str, object]()
        for name, view, size in (
            ("shown", inputs.shown, self.shown_size),
            ("rendered", inputs.rendered.view, self.rendered_size),
        ):
            named[f"{name}_per_tangent"] = tuple(view.fov.pixel_from_tangent(size).diagonal()[:2].tolist())
        return {"middle": (wide / 2, high / 2), **named}


@warps.register
class Shift(HomographyWarp):
    """Move the picture so that the middle of the view is where the head's turn puts it."""

    name = "shift"
    needs_compute = False

    def map_between(self, shown: View, rendered: View) -> WarpMap:
        """Return the translation; where the middle lies behind the rendered eye, w < 0."""
        left, right, down, up = shown.fov.tangents
        middle = np.array([(left + right) / 2, (down + up) / 2, -1.0])
        to = (rendered.pose.rotation.inv() * shown.pose.rotation).apply(middle)
        offset = to[:2] / abs(to[2]) - middle[:2]
        moved = np.array([[1.0, 0, offset[0]], [0, 1, offset[1]], [0, 0, 1 if to[2] < 0 else -1]])
        into = rendered.fov.pixel_from_tangent(self.rendered_size)
        return WarpMap(into @ moved @ np.linalg.inv(shown.fov.pixel_from_tangent(self.shown_size)), np.zeros(3))


_EYE_FROM_HOMOGENEOUS = np.diag([1.0, 1.0, -1.0])  # the tangent point (x, y, 1) lies at (x, y, -1)


@warps.register
class Environment(GatherWarp):
    """A gather from a cube map around the rendered eye: one bilinear sample per pixel, no depth."""

    name = "environment"
    needs_compute = False
    Settings = NoSettings
    reads = ("rendered.cube",)
    resamples = True
    carries = False
    depth_reads = None

    def prepare(self) -> None:
        self._program = self.gather("warps/environment.comp")

    @classmethod
    def needs(cls, settings: Any) -> Needs:
        return Needs(cube=True)

    def map_between(self, shown: View, rendered: View) -> WarpMap:
        """Return the map from shown pixels to directions in the axes of the rendered eye."""
        turn = rendered.pose.rotation.inv() * shown.pose.rotation
        tangent_from_pixel = np.linalg.inv(shown.fov.pixel_from_tangent(self.shown_size))
        return WarpMap(turn.as_matrix() @ _EYE_FROM_HOMOGENEOUS @ tangent_from_pixel, np.zeros(3))

    def picture(self, inputs: PassInputs) -> moderngl.Texture:
        cube: moderngl.Texture = inputs.rendered["cube"]
        return cube

    def bind_colour(self, inputs: PassInputs, unit: int, maps: list[WarpMap]) -> None:
        cube, shown, chosen = inputs.rendered["cube"], inputs.shown, moderngl.LINEAR
        if self.output.lens is None and not self.output.scanout and np.abs(shown.fov.tangents).max() <= 1 + 1e-9:
            here = View(Pose(shown.pose.position_m, inputs.rendered.view.pose.orientation_xyzw), shown.fov)
            side = cube.size[0] // 3
            of_faces = (view_map(shown, self.shown_size, face, (side, side)) for face in face_views(here, side))
            if any(each.moves_whole_pixels() for each in of_faces):  # each pixel is one of one face
                chosen = moderngl.NEAREST
        cube.filter = (chosen, chosen)
        cube.use(unit)

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        if (cube := inputs.rendered.get("cube")) is None:
            lacks = "warp 'environment' needs a cube map around the eye, which this frame lacks"
            raise PlanError(f"{lacks}; frames from a scene have it")
        side = float(cube.size[0] // 3)
        self.run_gather(self._program, inputs, into, face_size=side, rendered_pixel=pixel_of(cube.size))


@attrs.frozen
class _BackwardSettings(GatherSettings):
    """When a rendered depth agrees with the client's: as depth_limits says."""

    # off: no rendered depth is sent or compared. Every place in the rendered picture counts, so
    # what was hidden takes the colour of what hid it.
    test: Literal["on", "off"] = "on"
    tolerance: float = limited(DEPTH_TOLERANCE)
    floor: float = limited(DEPTH_FLOOR)  # 1/m


@warps.register
class Backward(GatherWarp):
    """A gather with the client's own depth; a test against the rendered depth leaves holes."""

    name = "backward"
    needs_compute = False
    reads = ("rendered.colour", "rendered.inverse_depth", "client.inverse_depth")
    Settings = _BackwardSettings
    depth_reads = ("client.inverse_depth",)
    scans_out = False  # the client's depth is drawn at one instant

    def prepare(self) -> None:
        self._tests = self.settings.test == "on"
        self._program = self.gather("warps/backward.comp", TEST=int(self._tests))

    @classmethod
    def reads_for(cls, settings: Any) -> tuple[str, ...]:
        """Return `reads`, without the rendered depth where nothing is compared with it."""
        return cls.reads if settings.test == "on" else tuple(n for n in cls.reads if n != "rendered.inverse_depth")

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        if inputs.client_inverse_depth is None:
            raise PlanError(
                "warp 'backward' needs the client's own depth, so a scene; for frames without one use 'forward'"
            )
        read = {"client_inverse_depth": inputs.client_inverse_depth}
        tested: dict[str, object] = {}
        if self._tests:
            read["rendered_inverse_depth"] = inputs.rendered.inverse_depth
            tested = depth_limits(self.settings, inputs.rendered)
        self.run_gather(self._program, inputs, into, **bind_images(read, first=1), **tested)
