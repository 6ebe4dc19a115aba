"""Indirect light from a grid of voxels that all views share.

Source: Crassin, Neyret, Sainz, Green and Eisemann 2011, Interactive Indirect Illumination Using
Voxel Cone Tracing; Crassin et al. 2013, CloudLight.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ..base import InputError
from ..client.strategies import Strategy, strategies
from ..frames import EyeImage
from ..frames.layers import Layer, between, layers
from ..geometry import View
from ..gpu import Compute, Uniforms
from ..gpu.textures import COLOUR, allocate, drawing_into, release_all
from ..scenes import IndirectLight, Mesh, Scene, lights, lit_meshes, moved_meshes
from ..sources.server import Lighting, SceneBuffers, ScenePasses
from ..sources.server.parts import DrawContext, Drawing, Part, parts
from ..sources.server.passes import Moving, Viewport
from ..sources.server.targets import MOST_SETTINGS, LastUsed
from .radiosity import mean_colour

Array = NDArray[np.float64]
SIZES = (8, 16, 32, 64, 128, 256)
MOST_CONES = 32


def _one_of(known: tuple[int, ...]) -> Any:
    def check(_: object, field: attrs.Attribute[int], value: int) -> None:
        if value not in known:
            raise ValueError(f"{field.name} is {value}: expected one of {', '.join(map(str, known))}")

    return check


@attrs.frozen(order=True)
class VoxelLight:
    """How the server finds indirect light."""

    # Cells of the grid on each axis.
    size: int = attrs.field(default=64, validator=_one_of(SIZES))
    # Cones that look from each pixel, and from each cell at each bounce.
    cones: int = attrs.field(default=6, validator=between(4, MOST_CONES))
    # How often light goes from cell to cell before pixels look.
    bounces: int = attrs.field(default=4, validator=between(0, 16))
    # Times a second that the grid is lit anew, at most.
    updates: float = attrs.field(default=10.0, validator=between(1e-6, 1e6))


@layers.register
class VoxelLayer(Layer):
    """Adds nothing to a frame: the picture itself has another light. The amount is a VoxelLight."""

    name = "voxels"
    summary = "the picture's indirect light is looked up in a grid of voxels that views share; it adds no bytes"
    drawn_by = "voxels"
    apart = True
    # The grid is lit for the first frame of each update.
    builds_on_frames = True
    lights = True
    nothing, something = None, VoxelLight(size=16)

    @classmethod
    def merged(cls, amount: VoxelLight, other: VoxelLight) -> VoxelLight:
        if amount != other:
            raise InputError(f"frames lit by {amount} and by {other}: a frame has one light; run them apart")
        return amount

    @classmethod
    def pictures(cls, amount: VoxelLight) -> tuple[str, ...]:
        return ()

    @classmethod
    def kept_bytes(cls, amount: VoxelLight) -> int:
        """Return those of six grids of 8 bytes a cell, with all coarser levels."""
        return 6 * 8 * amount.size**3 * 8 // 7

    @classmethod
    def textures(cls, data: Any) -> Iterable[moderngl.Texture]:
        return ()


@lights.register
class VoxelsInPlace(IndirectLight):
    """Light by --indirect voxels."""

    name = layer = "voxels"
    Settings = VoxelLight

    @classmethod
    def unsuited(cls, scene: Scene) -> str:
        if not scene.meshes:
            return "it is not drawn here, and its light is in its frames"
        return "" if scene.lamps else "its light stands still, and what is baked is exact"


_ON_PLANE = 1e-9  # cells by which a corner may pass a plane and still lie on it
_NORMAL_STEPS = 16  # pieces of one cell whose normals agree to 1 / 16 are one


@attrs.frozen(eq=False)
class VoxelGrid:
    """A cube of `size` cells a side around all surfaces that stand still and that lamps light.

    The outermost lie in the middle of a cell, with a cell to spare: no rounding puts them in two.
    What moves beyond counts in the outermost cells.
    """

    low: Array  # (3,) its lowest corner, metres from the scene's origin
    cell_m: float
    size: int

    @classmethod
    def around(cls, scene: Scene, size: int) -> VoxelGrid:
        """Return the grid of a scene; one of a metre where nothing is lit."""
        corners = np.concatenate([np.zeros((0, 3)), *(mesh.positions for mesh in lit_meshes(scene.meshes))])
        low, high = (corners.min(axis=0), corners.max(axis=0)) if len(corners) else (np.zeros(3), np.ones(3))
        cell_m = max(float((high - low).max()), 1e-6) / (size - 3)
        return cls((low + high) / 2 - cell_m * size / 2, cell_m, size)


@attrs.frozen(eq=False)
class _VoxelSurfaces:
    """What lies in the cells: for each cell and each way a surface faces there, one piece."""

    cells: NDArray[np.int64]  # (n,) x + size * (y + size * z), ascending
    places: Array  # (n, 3) the middle of each, metres from the scene's origin
    normals: Array  # (n, 3)
    areas: Array  # (n,) in faces of a cell
    albedo: Array  # (n, 3) linear

    def __len__(self) -> int:
        return len(self.cells)


def voxel_surfaces(scene: Scene, grid: VoxelGrid, time_ns: int = 0) -> _VoxelSurfaces:
    """Return all lit surfaces at an instant, cut along the cells; no area is lost."""
    return _merged(
        np.concatenate([_still_pieces(scene, grid), _pieces(scene, moved_meshes(scene, time_ns), grid)]), grid
    )


@lru_cache(maxsize=2)
def _still_pieces(scene: Scene, grid: VoxelGrid) -> Array:
    return _pieces(scene, lit_meshes(scene.meshes), grid)


def _pieces(scene: Scene, meshes: Sequence[Mesh], grid: VoxelGrid) -> Array:
    """Return (n, 3, 9) triangles: places in cells, normals and albedo of the corners."""
    kinds = [np.zeros((0, 3, 9))]
    for mesh in meshes:
        albedo = mesh.albedo if mesh.albedo is not None else np.full_like(mesh.positions, 0.5)
        texture = mean_colour(scene.textures[mesh.texture]) if mesh.texture >= 0 else np.ones(3)
        places = (mesh.positions.astype(np.float64) - grid.low) / grid.cell_m
        kinds.append(np.concatenate([places, mesh.normals, albedo * texture], axis=1)[mesh.triangles])
    pieces = np.concatenate(kinds)
    for axis in range(3):
        pieces = _cut(pieces, axis)
    return pieces


def _cut(pieces: Array, axis: int) -> Array:
    """Return (n, 3, k) triangles of which none crosses a whole number on that axis."""
    whole = []
    while len(pieces):
        along = pieces[..., axis]
        first = np.floor(along.min(axis=1) + _ON_PLANE)
        crossed = np.ceil(along.max(axis=1) - _ON_PLANE) - first - 1
        whole.append(pieces[crossed <= 0])
        pieces, middle = pieces[crossed > 0], (first + 1 + crossed // 2)[crossed > 0]
        pieces = _halves(pieces, axis, middle)
    return np.concatenate([np.zeros((0, *pieces.shape[1:])), *whole])


def _halves(pieces: Array, axis: int, planes: Array) -> Array:
    """Return the triangles cut in two along a plane each, which crosses them."""
    order = np.argsort(pieces[..., axis], axis=1, kind="stable")
    a, b, c = np.take_along_axis(pieces, order[..., None], axis=1).transpose(1, 0, 2)

    def on_plane(p: Array, q: Array, where: Array) -> Array:
        share = ((where - p[:, axis]) / (q[:, axis] - p[:, axis]))[:, None]
        cut = p + share * (q - p)
        cut[:, axis] = where
        return cut

    far = on_plane(a, c, planes)
    below = b[:, axis] <= planes
    out = []
    for alone, other, pair, chosen in ((c, a, b, below), (a, c, b, ~below)):
        lone, end, mid, cut = alone[chosen], other[chosen], pair[chosen], far[chosen]
        near = np.where((mid[:, axis] == planes[chosen])[:, None], mid, 0)
        crossing = mid[:, axis] != planes[chosen]
        near[crossing] = on_plane(mid[crossing], lone[crossing], planes[chosen][crossing])
        out += [np.stack(corners, axis=1) for corners in ((lone, near, cut), (end, mid, near), (end, near, cut))]
    return np.concatenate(out)


def _merged(pieces: Array, grid: VoxelGrid) -> _VoxelSurfaces:
    """Return the pieces of each cell that face the same way as one."""
    a, b, c = pieces[..., :3].transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    pieces, areas = pieces[areas > 0], areas[areas > 0]
    middle = pieces.mean(axis=1)
    cells = np.clip(np.floor(middle[:, :3]).astype(np.int64), 0, grid.size - 1) @ grid.size ** np.arange(3)
    ways = np.rint((1 + np.clip(middle[:, 3:6], -1, 1)) * _NORMAL_STEPS).astype(np.int64)
    several = 2 * _NORMAL_STEPS + 1
    kept, which = np.unique(cells * several**3 + ways @ several ** np.arange(3), return_inverse=True)
    columns = np.column_stack([areas, areas[:, None] * middle]).T
    total: Array = np.stack([np.bincount(which, column, len(kept)) for column in columns], axis=1).astype(np.float64)
    means = total[:, 1:] / total[:, :1]
    normals = means[:, 3:6] / np.maximum(np.linalg.norm(means[:, 3:6], axis=1, keepdims=True), 1e-12)
    places = grid.low + grid.cell_m * means[:, :3]
    return _VoxelSurfaces(kept // several**3, places, normals, total[:, 0], means[:, 6:9])


_FACING_UNIT = 8  # as in shaders/lib/voxels.glsl
_PLACE_UNIT, _NORMAL_UNIT, _LIGHT_UNIT = 3, 4, 5
_PLACES = (4, "f4")


@parts.register
class VoxelPart(Part):
    """Draws the plain surfaces itself, in a scene with lamps; all light of others is baked."""

    name = "voxels"
    order = 1

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._made: LastUsed[VoxelLight, tuple[_VoxelLighting, ScenePasses]] = LastUsed()

    def passes_for(self, drawing: Drawing) -> ScenePasses | None:
        context, settings = self.context, drawing.needs.get("voxels")
        if settings is None or not context.scene.lamps:
            return None

        def make() -> tuple[_VoxelLighting, ScenePasses]:
            lighting, plain = _VoxelLighting(context, settings), context.colour
            return lighting, ScenePasses(
                context.gpu, context.scene, plain.buffers, colour=True, moving=plain.moving, lighting=lighting
            )

        passes = self._made.made(settings, make)[-1]
        self._free(self._made.beyond(MOST_SETTINGS))
        return passes

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        return eye.having(voxels=drawing.needs["voxels"]) if "voxels" in drawing.needs else eye

    def close(self) -> None:
        self._free(self._made.values())

    @staticmethod
    def _free(made: Iterable[tuple[_VoxelLighting, ScenePasses]]) -> None:
        for lighting, passes in made:
            passes.close()
            lighting.close()


@attrs.define(eq=False)
class _Small:
    """A picture of half the size: places, normals and what cones gather there."""

    place: moderngl.Texture
    normal: moderngl.Texture
    light: moderngl.Texture
    # What it shows: a view at an instant.
    view: View | None = None
    time_ns: int = 0


class _VoxelLighting(Lighting):
    """Direct light of the scene's lamps, and a grid of what all surfaces send.

    The grid is lit anew for the first picture of each update. Cones look into it from the pixels of
    pictures of half the size; those of sizes that were drawn are kept.
    """

    defines = ("LAMPS", "VOXELS")

    def __init__(self, context: DrawContext, settings: VoxelLight) -> None:
        gpu, scene = context.gpu, context.scene
        super().__init__(gpu, scene)
        self.gpu, self.settings, self._framebuffers = gpu, settings, context.framebuffers
        self.grid = grid = VoxelGrid.around(scene, settings.size)
        self._update: int | None = None
        gl = gpu.gl
        # Pieces, what lamps give each, what each sends, cells.
        self._storage = tuple(gl.buffer(reserve=16) for _ in range(4))
        self._filled = np.zeros(0, np.int64)
        self._cut(0)
        self._facing = [gl.texture3d((grid.size,) * 3, 4, dtype="f2") for _ in range(6)]
        for grid_of_way in self._facing:
            grid_of_way.write(b"\0" * (8 * grid.size**3))
            grid_of_way.build_mipmaps()
            grid_of_way.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
            grid_of_way.repeat_x = grid_of_way.repeat_y = grid_of_way.repeat_z = False
        self._direct, self._gather, self._fill, self._look = (
            gpu.shaders.compute(f"cloudlight/voxel_{name}.comp") for name in ("direct", "gather", "fill", "look")
        )
        self._places = _PlacePasses(self, scene, context.colour.buffers, context.colour.moving)
        self._small: dict[tuple[int, int], _Small] = {}
        cones, width = cones_of(settings.cones)
        sky = scene.background
        self._constants = {
            "grid_low": tuple(grid.low.tolist()),
            "cell_m": float(grid.cell_m),
            "grid_size": float(grid.size),
            "cones": np.resize(cones, (MOST_CONES, 3)).ravel(),
            "cone_count": settings.cones,
            "cone_width": width,
            "sky_zenith": sky.zenith,
            "sky_horizon": sky.horizon,
            "sky_ground": sky.ground,
        }

    def _cut(self, time_ns: int) -> None:
        """Take the surfaces as they are at an instant."""
        surfaces = voxel_surfaces(self._scene, self.grid, time_ns)
        self._piece_count = len(surfaces)
        numbers, first, counts = np.unique(surfaces.cells, return_index=True, return_counts=True)
        # Cells that a surface has left are entered once more, empty.
        left = np.setdiff1d(self._filled, numbers)
        none = np.zeros_like(left)
        cells = np.concatenate([np.stack([numbers, first, counts]), np.stack([left, none, none])], axis=1)
        self._filled, self._cell_count = numbers, cells.shape[1]
        rows = np.zeros((len(surfaces), 3, 4), np.float32)
        rows[:, 0, :3], rows[:, 0, 3] = surfaces.places, surfaces.areas
        rows[:, 1, :3], rows[:, 2, :3] = surfaces.normals, surfaces.albedo
        entries = np.zeros((self._cell_count, 4), np.uint32)
        entries[:, :3] = cells.T
        sent = bytes(16 * len(surfaces))
        for buffer, content in zip(self._storage, (rows.tobytes(), sent, sent, entries.tobytes()), strict=True):
            if content:
                buffer.orphan(len(content))
                buffer.write(content)

    def use(self, uniforms: Uniforms, view: View, viewport: Viewport, time_ns: int) -> None:
        self._light_up(time_ns)
        x, y, wide, high = viewport
        size = (wide + 1) // 2, (high + 1) // 2
        small = self._drawn(view, size, time_ns)
        for unit, texture in ((_PLACE_UNIT, small.place), (_NORMAL_UNIT, small.normal), (_LIGHT_UNIT, small.light)):
            texture.use(unit)
        uniforms.set(
            near_place_of=_PLACE_UNIT,
            near_normal_of=_NORMAL_UNIT,
            near_light_of=_LIGHT_UNIT,
            corner=(float(x), float(y)),
            near_scale=(size[0] / wide, size[1] / high),
        )
        self.use_lamps(uniforms, time_ns)
        self.set_grid(uniforms)

    def _drawn(self, view: View, size: tuple[int, int], time_ns: int) -> _Small:
        """Return what cones gather in a view's picture of that size."""
        if size not in self._small:
            place, normal, light = (allocate(self.gpu.gl, size, kind) for kind in (_PLACES, _PLACES, COLOUR))
            self._small[size] = _Small(place, normal, light)
        small = self._small[size]
        if small.view is view and small.time_ns == time_ns:
            return small
        small.view, small.time_ns = view, time_ns
        framebuffer = self._framebuffers.over(small.place, small.normal)
        with drawing_into(framebuffer):
            framebuffer.clear(depth=1.0)
        self._places.draw_into(view, framebuffer, None, time_ns)
        small.place.use(_PLACE_UNIT)
        small.normal.use(_NORMAL_UNIT)
        small.light.bind_to_image(0, read=False, write=True)
        uniforms = self._look.uniforms
        self.set_grid(uniforms)
        uniforms.set(near_place_of=_PLACE_UNIT, near_normal_of=_NORMAL_UNIT, near_light=0, near_size=size)
        self._look.run(*size)
        self.gpu.barrier()
        return small

    def set_grid(self, uniforms: Uniforms) -> None:
        """Set the uniforms of lib/voxels.glsl and bind its textures."""
        uniforms.set(**self._constants)
        for unit, one in enumerate(self._facing, _FACING_UNIT):
            one.use(unit)

    def _light_up(self, time_ns: int) -> None:
        """Light the grid for an instant, unless its update has been."""
        # The thousandth keeps frames that are drawn at the very rate of the updates apart.
        update = int(time_ns * self.settings.updates * 1e-9 + 1e-3)
        if update == self._update:
            return
        self._update = update
        if self._scene.lit_moves:
            self._cut(time_ns)
        if not self._piece_count:
            return
        for binding, buffer in enumerate(self._storage):
            buffer.bind_to_storage_buffer(binding)
        self.use_lamps(self._direct.uniforms, time_ns)
        self._over_pieces(self._direct)
        self._enter()
        for _ in range(self.settings.bounces):
            self.set_grid(self._gather.uniforms)
            self._over_pieces(self._gather)
            self._enter()

    def _over_pieces(self, program: Compute) -> None:
        program.uniforms.set(piece_count=self._piece_count)
        program.run(self._piece_count)
        self.gpu.barrier()

    def _enter(self) -> None:
        """Enter what the surfaces send into the grid, and make its levels."""
        for unit, one in enumerate(self._facing):
            one.bind_to_image(unit, read=False, write=True)
        self._fill.uniforms.set(cell_count=self._cell_count, grid_size=self.grid.size)
        self._fill.run(self._cell_count)
        self.gpu.barrier()
        for grid_of_way in self._facing:
            grid_of_way.build_mipmaps()

    def close(self) -> None:
        self._places.close()
        super().close()
        small = (each for one in self._small.values() for each in (one.place, one.normal, one.light))
        release_all(*self._storage, *self._facing, *small)


def cones_of(count: int) -> tuple[NDArray[np.float32], float]:
    """Return (count, 3) ways of cones around (0, 0, 1), and how wide they are at a distance of 1.

    Each has the same share of Lambert's cosine, and a solid angle of its share of the half space.
    Source: Pharr, Jakob and Humphreys 2016, Physically Based Rendering, 13.6.3 (Malley's method);
    Vogel 1979, A Better Way to Construct the Sunflower Head.
    """
    radius = np.sqrt((np.arange(count) + 0.5) / count)
    angle = np.arange(count) * math.pi * (3 - math.sqrt(5))
    ways = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - radius**2)])
    return ways.astype(np.float32), 2 * math.tan(math.acos(1 - 1 / count))


class _PlacePasses(ScenePasses):
    """Places and normals of the surfaces; where there is none all is 0."""

    fragment = "cloudlight/places.frag"

    def __init__(self, lighting: _VoxelLighting, scene: Scene, buffers: SceneBuffers, moving: Sequence[Moving]) -> None:
        self._lit_by = lighting
        super().__init__(lighting.gpu, scene, buffers, colour=False, moving=moving)

    def _lit_defines(self) -> Mapping[str, int]:
        return {"LAMPS": 1}

    def _more(self, buffers: SceneBuffers) -> list[tuple[Any, ...]]:
        return [self._lit_by.more(buffers.meshes, albedo=False)]

    def _draw_background(self) -> None:
        pass


@strategies.register
class VoxelStrategy(Strategy):
    """For scenes whose light moves. Warp and fill are free; settings are those of the light."""

    name = "voxels"
    summary = (
        "the server sends a picture with depth, lit from a grid of voxels that all its users share, and the client "
        "warps it; --warp and --fill say how; at none of nine measured settings nearer than a late picture"
    )
    crosses = "colour and depth; layers of effects; colour alone for a warp that reads no depth"
    client = "shows the picture, or warps it and fills the holes"
    late = "what was hidden, and all light"
    classes = (1, 2, 3)
    source = "Crassin et al. 2013, CloudLight"
    warp = ""

    @classmethod
    def options(cls, settings: str) -> dict[str, Any]:
        """Return the options of a run that it sets. settings: of the light."""
        return {"indirect": f"{cls.name}:{settings}" if settings else cls.name}
