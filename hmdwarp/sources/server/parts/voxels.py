"""Indirect light from a grid of voxels that all views share.

Source: Crassin, Neyret, Sainz, Green and Eisemann 2011, Interactive Indirect Illumination Using
Voxel Cone Tracing; Crassin et al. 2013, CloudLight.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ....frames import EyeImage
from ....frames.layers.voxels import MOST_CONES, VoxelLight
from ....geometry import View
from ....gpu.context import Gpu, drawing_into
from ....gpu.shaders import Compute, Uniforms
from ....gpu.textures import COLOUR, allocate, release_all
from ....scenes import Scene, VoxelGrid, voxel_surfaces
from ..passes import Indirect, Lighting, ScenePasses, Viewport
from ..targets import MOST_SETTINGS, Framebuffers, LastUsed
from ..upload import Moving, SceneBuffers
from . import DrawContext, Drawing, Part, parts

FACING_UNIT = 8  # as in shaders/lib/voxels.glsl
_PLACE_UNIT, _NORMAL_UNIT, _LIGHT_UNIT = 3, 4, 5
_PLACES = (4, "f4")


@parts.register
class Voxels(Part):
    """Draws the plain surfaces itself, in a scene with lamps; all light of others is baked."""

    name = "voxels"
    order = 1

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._made: LastUsed[VoxelLight, tuple[VoxelLighting, NearLight, VoxelPasses]] = LastUsed()

    def passes_for(self, drawing: Drawing) -> ScenePasses | None:
        context, settings = self.context, drawing.needs.get("voxels")
        if settings is None or not context.scene.lamps:
            return None

        def make() -> tuple[VoxelLighting, NearLight, VoxelPasses]:
            lighting = VoxelLighting(context.gpu, context.scene, settings)
            near = NearLight(lighting, context.scene, context.colour, context.framebuffers)
            return lighting, near, VoxelPasses(lighting, near, context.colour)

        passes = self._made.made(settings, make)[-1]
        self._free(self._made.beyond(MOST_SETTINGS))
        return passes

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        return eye.having(voxels=drawing.needs["voxels"]) if "voxels" in drawing.needs else eye

    def close(self) -> None:
        self._free(self._made.values())

    @staticmethod
    def _free(made: Iterable[tuple[VoxelLighting, NearLight, VoxelPasses]]) -> None:
        for lighting, near, passes in made:
            passes.close()
            near.close()
            lighting.close()


class VoxelLighting(Lighting):
    """Direct light of the scene's lamps, and a grid of what all surfaces send.

    The grid is lit anew for the first picture of each update.
    """

    def __init__(self, gpu: Gpu, scene: Scene, settings: VoxelLight) -> None:
        super().__init__(gpu, scene, Indirect.VOXELS)
        self.gpu, self.settings = gpu, settings
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
        names = ("voxel_direct", "voxel_gather", "voxel_fill")
        self._direct, self._gather, self._fill = (gpu.shaders.compute(f"server/{name}.comp") for name in names)
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

    @property
    def bytes(self) -> int:
        """Bytes of the grid and what fills it on the GPU."""
        levels = sum(max(1, self.grid.size >> level) ** 3 for level in range(self.grid.size.bit_length()))
        return 6 * 8 * levels + sum(buffer.size for buffer in self._storage)

    def use(self, uniforms: Uniforms, time_ns: int) -> None:
        self.light(time_ns)
        self.use_lamps(uniforms, time_ns)
        self.set_grid(uniforms)

    def set_grid(self, uniforms: Uniforms) -> None:
        """Set the uniforms of lib/voxels.glsl and bind its textures."""
        uniforms.set(**self._constants)
        for unit, one in enumerate(self._facing, FACING_UNIT):
            one.use(unit)

    def light(self, time_ns: int) -> None:
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
        super().close()
        release_all(*self._storage, *self._facing)


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


class PlacePasses(ScenePasses):
    """Places and normals of the surfaces; where there is none all is 0."""

    fragment = "server/places.frag"

    def __init__(self, lighting: VoxelLighting, scene: Scene, buffers: SceneBuffers, moving: Sequence[Moving]) -> None:
        self._lit_by = lighting
        super().__init__(lighting.gpu, scene, buffers, colour=False, moving=moving)

    def _lit_defines(self) -> Mapping[str, int]:
        return {"LAMPS": 1}

    def _more(self, buffers: SceneBuffers) -> list[tuple[Any, ...]]:
        return [self._lit_by.more(buffers.meshes, albedo=False)]

    def _draw_background(self) -> None:
        pass


@attrs.define(eq=False)
class _Small:
    """A picture of half the size: places, normals and what cones gather there."""

    place: moderngl.Texture
    normal: moderngl.Texture
    light: moderngl.Texture
    # What it shows: a view at an instant.
    view: View | None = None
    time_ns: int = 0


class NearLight:
    """What cones gather at the pixels of pictures of half the size.

    Those of sizes that were drawn are kept.
    """

    def __init__(self, lighting: VoxelLighting, scene: Scene, plain: ScenePasses, framebuffers: Framebuffers) -> None:
        self._lighting, self._framebuffers = lighting, framebuffers
        self._places = PlacePasses(lighting, scene, plain.buffers, plain.moving)
        self._look = lighting.gpu.shaders.compute("server/voxel_look.comp")
        self._small: dict[tuple[int, int], _Small] = {}

    def use(self, uniforms: Uniforms, view: View, viewport: Viewport, time_ns: int) -> None:
        """Set the uniforms of lib/voxel_near.glsl and bind its textures, for a view's picture."""
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

    def _drawn(self, view: View, size: tuple[int, int], time_ns: int) -> _Small:
        gpu = self._lighting.gpu
        if size not in self._small:
            place, normal, light = (allocate(gpu.gl, size, kind) for kind in (_PLACES, _PLACES, COLOUR))
            self._small[size] = _Small(place, normal, light)
        small = self._small[size]
        if small.view is view and small.time_ns == time_ns:
            return small
        small.view, small.time_ns = view, time_ns
        self._lighting.light(time_ns)
        framebuffer = self._framebuffers.over(small.place, small.normal)
        with drawing_into(framebuffer):
            framebuffer.clear(depth=1.0)
        self._places.draw_into(view, framebuffer, None, time_ns)
        small.place.use(_PLACE_UNIT)
        small.normal.use(_NORMAL_UNIT)
        small.light.bind_to_image(0, read=False, write=True)
        uniforms = self._look.uniforms
        self._lighting.set_grid(uniforms)
        uniforms.set(near_place_of=_PLACE_UNIT, near_normal_of=_NORMAL_UNIT, near_light=0, near_size=size)
        self._look.run(*size)
        gpu.barrier()
        return small

    def close(self) -> None:
        """Free its textures and vertex arrays."""
        self._places.close()
        for small in self._small.values():
            release_all(small.place, small.normal, small.light)
        self._small.clear()


class VoxelPasses(ScenePasses):
    """The passes of a picture whose indirect light comes from a grid."""

    def __init__(self, lighting: VoxelLighting, near: NearLight, plain: ScenePasses, **peel: Any) -> None:
        options = {"moving": plain.moving, **peel}
        super().__init__(lighting.gpu, plain.scene, plain.buffers, colour=True, lighting=lighting, **options)
        self._lit_by, self._near = lighting, near

    def peeling(self, moving: Sequence[Moving]) -> ScenePasses:
        return VoxelPasses(self._lit_by, self._near, self, peel=True, moving=moving)

    def _begin(self, view: View, viewport: Viewport, time_ns: int) -> None:
        self._near.use(self._surface.uniforms, view, viewport, time_ns)
