"""A scene's plain surfaces as points: cut into small cells, each sampled as densely as needed."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..colour import linear_from_srgb, srgb8_from_linear
from ._mesh import Mesh, Texture, morton
from ._photons import of_atlas
from ._scene import Scene
from .radiosity import OFF_M, direct_light, lamps_at, lit_meshes, mean_colour, moved_meshes, transport_of

Array = NDArray[np.float64]

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
class VoxelSurfaces:
    """What lies in the cells: for each cell and each way a surface faces there, one piece."""

    cells: NDArray[np.int64]  # (n,) x + size * (y + size * z), ascending
    places: Array  # (n, 3) the middle of each, metres from the scene's origin
    normals: Array  # (n, 3)
    areas: Array  # (n,) in faces of a cell
    albedo: Array  # (n, 3) linear

    def __len__(self) -> int:
        return len(self.cells)


def voxel_surfaces(scene: Scene, grid: VoxelGrid, time_ns: int = 0) -> VoxelSurfaces:
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


def _merged(pieces: Array, grid: VoxelGrid) -> VoxelSurfaces:
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
    return VoxelSurfaces(kept // several**3, places, normals, total[:, 0], means[:, 6:9])


# A cell is at most so long, or so much of its distance from the viewpoint, whichever is more.
CELL_M, CELL_SHARE = 0.25, 1 / 8
# Bits of a position on each axis of its cell: the error is at most 1/2046 of the cell's edge.
POSITION_BITS = 10
_STEPS = (1 << POSITION_BITS) - 1
_MOST_SPLITS = 64
# Digits of a place in a triangle, base 4, and of the index of a point, base 2.
_TRIANGLE_DIGITS, _INDEX_BITS = 8, 24
_QUARTERS = 3 * np.vstack([np.zeros(3), np.eye(3)])  # the middle one, and those at the corners


@attrs.frozen(eq=False)
class SurfacePoints:
    """Some points of a cell, as they are sent."""

    # (n,) three times POSITION_BITS from x up, in steps of the cell's edge from its lowest corner.
    positions: NDArray[np.uint32]
    normals: NDArray[np.uint8]  # (n, 2) octahedral, in the axes of the positions
    colours: NDArray[np.uint8]  # (n, 3) sRGB of texture times light, clipped at 1


class PointCells:
    """Cells of plain surfaces, each on one side of one mesh and facing about one way.

    What deforms, is see-through or fixed to the head has none. A point's colour is the texture
    times the light, as the server draws it, filtered to the requested spacing: it is rounded to
    8 bits of sRGB, which is off by half a step at most, light beyond 1 is clipped, and what varies
    within the spacing is averaged over squares of texels. Lamps stand where they are at the start,
    and their light is looked up at the corners of triangles no longer than a cell.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        # Of each texture that was looked up, by its id, see _levels; and those made of emissions.
        self._levels: dict[int, list[NDArray[np.float32]]] = {}
        self._shining: dict[int, Texture] = {}
        meshes = [mesh for mesh in scene.meshes if mesh.is_surface and mesh.deformation is None]
        rows, owner = _split(meshes, scene)
        self._meshes = meshes
        corners = rows[:, :, :3]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area = np.linalg.norm(across, axis=1) / 2
        keep = area > 0
        rows, owner, area, across = rows[keep], owner[keep], area[keep], across[keep]
        cell = _cells(rows, owner, across, meshes, scene)
        order = np.lexsort((morton(rows[:, :, :3].mean(axis=1)), cell)) if len(cell) else np.argsort(cell)
        self._rows, self._area, cell = rows[order], area[order], cell[order]
        self._normal = across[order] / (2 * self._area[:, None])
        if scene.lamps:
            _light_up(self._rows, self._normal, owner[order], meshes, scene)
        self._texels = _texels_per_metre(self._rows, self._area, owner[order], meshes, scene)
        self.count = int(cell[-1]) + 1 if len(cell) else 0
        self._first = np.searchsorted(cell, np.arange(self.count + 1))
        starts = self._first[:-1]

        def of_cells(reduce: np.ufunc, values: Array) -> Array:
            return reduce.reduceat(values, starts) if self.count else np.zeros((0, *values.shape[1:]))

        low = of_cells(np.minimum, self._rows[:, :, :3].min(axis=1))
        high = of_cells(np.maximum, self._rows[:, :, :3].max(axis=1))
        # (n, 3) lowest corner and half size in metres, relative to the scene's origin or in the
        # frame of the body; (n,) the edge of the cube that holds it, and the area.
        self.low, self.halves = low.astype(np.float32).astype(np.float64), (high - low) / 2
        self.edge = np.maximum((high - self.low).max(axis=1, initial=0), 1e-6).astype(np.float32).astype(np.float64)
        self.area = of_cells(np.add, self._area)
        self._mesh_of = owner[order][starts] if self.count else np.zeros(0, np.int64)
        self.body = np.array([meshes[k].body for k in self._mesh_of], np.int64)
        self.double_sided = np.array([meshes[k].double_sided for k in self._mesh_of], bool)
        # The mean direction that a cell faces, of length 1, and the least cosine to any of its
        # triangles.
        mean = of_cells(np.add, self._normal)
        self.facing = mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-30)
        cosine = np.einsum("ij,ij->i", self._normal, self.facing[cell])
        self.least_cosine = of_cells(np.minimum, cosine)

    @cached_property
    def centres(self) -> Array:
        """(n, 3) middle of each cell's box."""
        return self.low + self.halves

    def points(self, cell: int, first: int, count: int, spacing: float) -> SurfacePoints:
        """Return points `first` to `first + count` of a cell's sequence.

        Any run of the sequence is spread evenly over the cell's surface. spacing: metres over which
        the texture is averaged.
        """
        own = slice(int(self._first[cell]), int(self._first[cell + 1]))
        ends = np.cumsum(self._area[own])
        at = _spread(np.arange(first, first + count)) * ends[-1]
        which = np.minimum(np.searchsorted(ends, at, side="right"), len(ends) - 1)
        weights = _in_triangle(np.clip(1 - (ends[which] - at) / self._area[own][which], 0, 1))
        found = np.einsum("nk,nkc->nc", weights, self._rows[own][which])
        steps = np.rint((found[:, :3] - self.low[cell]) / self.edge[cell] * _STEPS).clip(0, _STEPS).astype(np.uint32)
        packed = steps[:, 0] | steps[:, 1] << np.uint32(POSITION_BITS) | steps[:, 2] << np.uint32(2 * POSITION_BITS)
        mesh, texels = self._meshes[int(self._mesh_of[cell])], self._texels[own][which] * spacing
        light = self._texture(mesh, found[:, 3:5], texels)
        light = light * found[:, 5:8] + self._emission(mesh, found[:, 3:5], texels)
        colours = srgb8_from_linear(np.minimum(light, 1).astype(np.float32))
        return SurfacePoints(packed, octahedral(self._normal[own][which]), colours)

    def _texture(self, mesh: Mesh, uv: Array, texels: Array) -> Array:
        """Return the texture's linear colour, averaged over squares of about so many texels."""
        if mesh.texture < 0:
            return np.ones((len(uv), 3))
        return self._looked_up(self.scene.textures[mesh.texture], uv, texels)

    def _emission(self, mesh: Mesh, uv: Array, texels: Array) -> Array:
        """Return what its surface emits there; averaged alike."""
        texture = self.scene.textures[mesh.texture] if mesh.texture >= 0 else None
        if texture is None or texture.emission is None:
            return np.zeros((len(uv), 3))
        key = id(texture.emission)
        if key not in self._shining:
            self._shining[key] = Texture("emission", texture.emission.image, repeat=texture.emission.repeat)
        ratio = np.sqrt(texture.emission.image[..., 0].size / texture.image[..., 0].size)
        return self._looked_up(self._shining[key], uv, texels * ratio) * texture.emission.factor

    def _looked_up(self, texture: Texture, uv: Array, texels: Array) -> Array:
        if id(texture) not in self._levels:
            self._levels[id(texture)] = _levels(texture)
        levels = self._levels[id(texture)]
        level = np.clip(np.rint(np.log2(np.maximum(texels, 1e-9))), 0, len(levels) - 1).astype(int)
        out = np.empty((len(uv), 3))
        for number in np.unique(level):
            out[level == number] = _bilinear(levels[number], uv[level == number], repeat=texture.repeat)
        return out


def _spread(index: NDArray[np.int64]) -> Array:
    """Return places from 0 to 1, those of any run far apart: van der Corput's sequence."""
    bits = (index[:, None] >> np.arange(_INDEX_BITS)) & 1
    return bits @ 0.5 ** np.arange(1, _INDEX_BITS + 1) + 0.5 ** (_INDEX_BITS + 1)


def _in_triangle(place: Array) -> Array:
    """Return (n, 3) weights of the corners: the place from 0 to 1 on a path through a triangle.

    Each digit, base 4, chooses one of the quarters into which its middles divide it.
    Source: Basu and Owen 2015, Low discrepancy constructions in the triangle.
    """
    digits = []
    for _ in range(_TRIANGLE_DIGITS):
        digits.append(np.minimum(np.floor(4 * place), 3).astype(int))
        place = 4 * place - digits[-1]
    # Three times the middle of the last quarter, in weights of the corners of the one before, and
    # so on back to the triangle's: halves of whole numbers, so exact.
    weights = np.ones((len(place), 3))
    for digit in reversed(digits):
        weights = np.where(digit[:, None] == 0, 3 - weights, weights + _QUARTERS[digit]) / 2
    return np.asarray(weights / 3)


def octahedral(normals: Array) -> NDArray[np.uint8]:
    """Return unit vectors as (n, 2) bytes: off by at most 0.7 degrees.

    Source: Cigolle et al. 2014, A Survey of Efficient Representations for Independent Unit Vectors.
    """
    flat = normals / np.abs(normals).sum(axis=1, keepdims=True)
    signs = np.where(flat[:, :2] >= 0, 1.0, -1.0)
    folded = np.where(flat[:, 2:] < 0, (1 - np.abs(flat[:, 1::-1])) * signs, flat[:, :2])
    return np.asarray(np.rint((folded * 0.5 + 0.5) * 254).astype(np.uint8))


def _limit(centres: Array, lengths: Array, body: NDArray[Any], eye: Array) -> Array:
    """Return the longest edge that a triangle there may have."""
    away = np.maximum(np.linalg.norm(centres - eye, axis=1) - lengths, 0)
    return np.maximum(CELL_M, np.where(body > 0, 0, CELL_SHARE * away))


def _eye(scene: Scene) -> Array:
    return scene.viewpoint.position_m - scene.origin_m


def _light_up(rows: Array, normals: Array, owner: NDArray[np.int64], meshes: list[Mesh], scene: Scene) -> None:
    """Put in place of the albedo at each corner what it shows under the lamps of the start."""
    transport, lamps = transport_of(scene), lamps_at(scene, 0)
    atlas = transport.atlas(transport.indirect(transport.direct(lamps)))
    for number, mesh in enumerate(meshes):
        own = np.flatnonzero(owner == number)
        if mesh.light_uv is None or not len(own):
            continue
        # A little inside: at an edge the next surface begins.
        places = (0.9 * rows[own, :, :3] + 0.1 * rows[own, :, :3].mean(axis=1, keepdims=True)).reshape(-1, 3)
        facing = np.repeat(normals[own], 3, axis=0)
        if mesh.body:
            pose = scene.bodies[mesh.body - 1].motion.state(scene.lit_ns(0)).pose
            places, facing = pose.transform(places) - scene.origin_m, pose.rotation.apply(facing)
        light = direct_light(transport.blockers, places + OFF_M * facing, facing, lamps)
        light += of_atlas(atlas, rows[own, :, 8:].reshape(-1, 2))
        rows[own, :, 5:8] *= light.reshape(-1, 3, 3)


def _split(meshes: list[Mesh], scene: Scene) -> tuple[Array, NDArray[np.int64]]:
    """Return (m, 3, 10) of small triangles, and their meshes.

    Positions, uv, light (albedo where lamps light it) and place in the light atlas.
    """
    parts = []
    for mesh in meshes:
        lit = scene.lamps and mesh.light_uv is not None
        light = mesh.albedo if lit and mesh.albedo is not None else mesh.light
        places = mesh.light_uv if mesh.light_uv is not None else np.zeros_like(mesh.uv)
        parts.append(np.concatenate([mesh.positions, mesh.uv, light, places], axis=1)[mesh.triangles])
    rows = np.concatenate([np.zeros((0, 3, 10)), *parts])
    owner = np.repeat(np.arange(len(meshes)), [len(mesh.triangles) for mesh in meshes])
    body = np.array([mesh.body for mesh in meshes], np.int64)
    done: list[tuple[Array, NDArray[Any]]] = []
    for _ in range(_MOST_SPLITS):
        edges = np.linalg.norm(np.roll(rows, -1, axis=1)[:, :, :3] - rows[:, :, :3], axis=2)
        longest = edges.max(axis=1, initial=0)
        large = longest > _limit(rows[:, :, :3].mean(axis=1), longest, body[owner], _eye(scene))
        done.append((rows[~large], owner[~large]))
        rows, owner, start = rows[large], owner[large], edges[large].argmax(axis=1)
        if not len(rows):
            break
        a, b, c = (rows[np.arange(len(rows)), (start + k) % 3] for k in range(3))
        middle = (a + b) / 2
        rows = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
        owner = np.concatenate([owner, owner])
    return np.concatenate([one for one, _ in done]), np.concatenate([one for _, one in done])


def _cells(rows: Array, owner: NDArray[Any], across: Array, meshes: list[Mesh], scene: Scene) -> NDArray[np.int64]:
    """Return the number of each triangle's cell."""
    body = np.array([mesh.body for mesh in meshes], np.int64)
    centres = rows[:, :, :3].mean(axis=1)
    level = np.floor(np.log2(_limit(centres, np.zeros(len(rows)), body[owner], _eye(scene)) / CELL_M)).astype(np.int64)
    place = np.floor(centres / (CELL_M * 2.0**level)[:, None]).astype(np.int64)
    axis = np.abs(across).argmax(axis=1)
    side = 2 * axis + (across[np.arange(len(across)), axis] < 0)
    keys = np.column_stack([owner, side, level, place])
    return np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1).astype(np.int64)


def _texels_per_metre(rows: Array, area: Array, owner: NDArray[Any], meshes: list[Mesh], scene: Scene) -> Array:
    texels = [0 if m.texture < 0 else np.prod(scene.textures[m.texture].image.shape[:2]) for m in meshes]
    (ax, ay), (bx, by) = ((rows[:, k, 3:5] - rows[:, 0, 3:5]).T for k in (1, 2))
    on_texture = np.abs(ax * by - ay * bx) / 2 * np.array([*texels, 0], float)[owner]
    return np.asarray(np.sqrt(on_texture / area))


def _levels(texture: Texture) -> list[NDArray[np.float32]]:
    """Return the linear image and its halves, down to one texel."""
    image = texture.image[..., :3]
    linear = linear_from_srgb(image) if texture.srgb else image / 255
    levels: list[NDArray[np.float32]] = [np.asarray(linear, np.float32)]
    while max(levels[-1].shape[:2]) > 1:
        last: NDArray[np.floating] = levels[-1]
        for axis in (0, 1):
            if last.shape[axis] > 1:
                pairs = last.take(range(last.shape[axis] // 2 * 2), axis)
                last = (
                    pairs.take(range(0, pairs.shape[axis], 2), axis) + pairs.take(range(1, pairs.shape[axis], 2), axis)
                ) / 2
        levels.append(last)
    return levels


def _bilinear(image: Array, uv: Array, *, repeat: bool) -> Array:
    height, width = image.shape[:2]
    at = np.column_stack([uv[:, 0] * width, (1 - uv[:, 1]) * height]) - 0.5
    low = np.floor(at)
    share = at - low
    out = np.zeros((len(uv), 3))
    for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1)):
        corner = low.astype(np.int64) + (dx, dy)
        x, y = (
            corner[:, k] % size if repeat else corner[:, k].clip(0, size - 1) for k, size in enumerate((width, height))
        )
        weight = (share[:, 0] if dx else 1 - share[:, 0]) * (share[:, 1] if dy else 1 - share[:, 1])
        out += weight[:, None] * image[y, x]
    return out
