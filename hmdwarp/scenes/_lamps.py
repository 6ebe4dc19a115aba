"""What lamps light and what stops their light; who finds the light between surfaces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import ClassVar

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import NoSettings, Registry, SceneError
from ._draft import Notes
from ._mesh import Mesh, Texture
from ._scene import ATLAS, MOST_LAMPS, Lamp, Scene

Array = NDArray[np.float64]
Light = tuple[Array, tuple[float, float, float]]  # place and fading, colour; see lamps_at
LEAST_AREA = 1e-12  # of a triangle, twice, in m2: its axes are divided by this
CONVERGED = "converged"


class IndirectLight:
    """A way to find the light between surfaces under lamps; --indirect names it.

    That called CONVERGED is that of the truth; it has `atlas` in place of a layer.
    """

    name: ClassVar[str]
    Settings: ClassVar[type] = NoSettings
    layer: ClassVar[str] = ""  # whose amount its settings are

    @classmethod
    def unsuited(cls, scene: Scene) -> str:
        """Return why it is not for the scene, "" if it is."""
        return ""

    @classmethod
    def atlas(cls, scene: Scene, time_ns: int) -> NDArray[np.float16]:
        """Return what it finds for an instant as the light atlas, (h, w, 4), bottom row first."""
        raise NotImplementedError


lights: Registry[type[IndirectLight]] = Registry("indirect light", "", "lights")


def indirect_atlas(scene: Scene, time_ns: int) -> NDArray[np.float16]:
    """Return the converged light of an instant as the light atlas. Errors: SceneError."""
    if CONVERGED not in lights:
        what = f"scene '{scene.name}' has lamps, and no indirect light '{CONVERGED}' is installed"
        raise SceneError(f"{what}: install the whole of hmdwarp, or use a scene with baked light")
    return lights.get(CONVERGED).atlas(scene, time_ns)


def lit_meshes(meshes: Sequence[Mesh]) -> list[Mesh]:
    """Return the meshes that stand still and that lamps light: they have places in the atlas."""
    return [mesh for mesh in meshes if mesh.light_uv is not None and not mesh.body]


def moved_meshes(scene: Scene, time_ns: int, meshes: Sequence[Mesh] | None = None) -> list[Mesh]:
    """Return the lit meshes of bodies, or of those given, in the scene's axes at an instant."""
    moved = []
    for mesh in scene.meshes if meshes is None else meshes:
        lit_ns = scene.lit_ns(time_ns)
        if mesh.light_uv is not None and mesh.body:
            pose = scene.bodies[mesh.body - 1].motion.state(lit_ns).pose
            positions = pose.transform(mesh.positions.astype(np.float64)) - scene.origin_m
            moved.append(attrs.evolve(mesh, positions=positions, normals=pose.rotation.apply(mesh.normals)))
    return moved


def with_lamps_stopped(scene: Scene, time_ns: int = 0) -> Scene:
    """Return the scene in the light of that instant, whatever moves: what can be baked."""
    return attrs.evolve(scene, light_ns=time_ns) if scene.lamps else scene


def lamps_at(scene: Scene, time_ns: int) -> list[Light]:
    """Return (place and fading, colour) of lamps, relative to the scene's origin."""
    at, origin = scene.lit_ns(time_ns), np.append(scene.origin_m, 0)
    places = ((lamp, lamp.place(at)) for lamp in scene.lamps)
    return [(np.append(place - place[3] * origin, lamp.fading(at)), lamp.light(at)) for lamp, place in places]


@attrs.frozen
class LitInstant:
    """An instant, which is another one where something lit is elsewhere."""

    where: bytes
    time_ns: int = attrs.field(eq=False)

    @classmethod
    def of(cls, scene: Scene, time_ns: int) -> LitInstant:
        """Return the instant in which the light is at `time_ns`."""
        lit_ns, lit = scene.lit_ns(time_ns), {mesh.body for mesh in scene.meshes if mesh.light_uv is not None} - {0}
        return cls(b"|".join(scene.bodies[number - 1].lit_as(lit_ns) for number in sorted(lit)), lit_ns)


def corners_of(meshes: Sequence[Mesh]) -> Array:
    return np.concatenate([np.empty((0, 3, 3)), *(mesh.positions[mesh.triangles] for mesh in meshes)])


def triangle_axes(corners: Array) -> Array:
    """Return (n, 3, 4) rows that take a point (x, y, z, 1) to each triangle's own axes.

    (u, v) along two edges, w along the normal in metres; inside u, v, 1 - u - v are 0 or more.
    """
    a, b, c = corners.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    turned = np.linalg.inv(np.stack([b - a, c - a, normal], axis=2)) if len(a) else np.empty((0, 3, 3))
    return np.concatenate([turned, -(turned @ a[..., None])], axis=2)


def blocking(scene: Scene, time_ns: int = 0, meshes: Sequence[Mesh] | None = None) -> Array:
    """Return the triangle_axes of what stops light at an instant, of the scene or these meshes."""
    if meshes is None:
        return _blocking_at(scene, LitInstant.of(scene, time_ns))
    corners = corners_of([*lit_meshes(meshes), *moved_meshes(scene, time_ns, meshes)])
    a, b, c = corners.transpose(1, 0, 2)
    return triangle_axes(corners[np.linalg.norm(np.cross(b - a, c - a), axis=1) > LEAST_AREA])


@lru_cache(maxsize=4)  # each pass of an instant asks
def _blocking_at(scene: Scene, instant: LitInstant) -> Array:
    return blocking(scene, instant.time_ns, scene.meshes)


BORDER = 1  # texels around each place, so that light never blends with another's
TEXEL_M = 0.35  # of the finest light
# A triangle by itself takes one texel with its border; the light of some scene takes the rays of
# all patches against all triangles.
MOST_TRIANGLES = 2 * (ATLAS[0] // 3) * (ATLAS[1] // 3)
_MOST_MEETINGS, MOST_PATCHES = 200_000, 1200
MEAN_LIGHT = 0.5  # that a white surface shows: a file says no exposure
SAME = 1e-3  # of two corners, as a share of the side between
_SQUARE = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])  # a chart's corners, in its size


def lit_by(
    lamps: list[Lamp], meshes: list[Mesh], lit: list[bool], textures: Sequence[Texture], origin: Array, notes: Notes
) -> tuple[list[Mesh], list[Lamp]]:
    """Return the meshes with places in the light atlas, and the lamps as bright as is shown.

    lit: of each mesh, whether lamps light it. Where they cannot, a note says why, and none is left.
    origin: of the scene, which meshes are relative to.
    """
    triangles = sum(len(mesh.triangles) for mesh, is_one in zip(meshes, lit, strict=True) if is_one)
    placed: list[Mesh] | str
    if len(lamps) > MOST_LAMPS:
        placed = f"there are {len(lamps)}, expected at most {MOST_LAMPS}"
    elif any(mesh.material.reflectivity for mesh in meshes):
        placed = "something mirrors, expected matt surfaces"
    elif any(texture.emission is not None for texture in textures):
        placed = "a texture shines, expected none that does"
    elif not 0 < triangles <= MOST_TRIANGLES:
        size = f"{ATLAS[0]}x{ATLAS[1]} texels"
        placed = f"{triangles:,} lit triangles, expected 1 to {MOST_TRIANGLES}: the light atlas has {size}"
    else:
        placed = _in_atlas(meshes, lit)
    if isinstance(placed, str):
        notes.add(f"its lamps are left out, and a plain light from above is used: {placed}")
        return meshes, []
    shown, factor = _exposed(lamps, placed, origin)
    notes.add(f"its candelas and lux are shown times {factor:.3g}: a white surface they light has {MEAN_LIGHT:g}")
    return placed, shown


@attrs.frozen(eq=False)
class _Chart:
    """A parallelogram of two triangles, or one triangle: what lies together in the atlas."""

    mesh: int
    triangles: NDArray[np.int64]  # (k, 3) of its corners, in the order of the file
    corners: tuple[int, ...]  # vertices of the mesh, one after another around it
    sides_m: tuple[float, ...]

    def texels(self, texel_m: float) -> tuple[int, int]:
        wide, high = (max(1, round(side / texel_m)) for side in self.sides_m)
        return min(wide, ATLAS[0] - 2 * BORDER), min(high, ATLAS[1] - 2 * BORDER)

    def places(self, low: Array, texels: tuple[int, int]) -> Array:
        """Return the place of each corner; a triangle holds the centre of its first texel."""
        if len(self.corners) == 3:
            return low + _SQUARE[[0, 1, 3]] * (np.array(texels) + 0.5)
        return low + _SQUARE * texels


def _in_atlas(meshes: Sequence[Mesh], lit: Sequence[bool]) -> list[Mesh] | str:
    """Return the meshes with places for those that are lit, or why they do not fit.

    Light is as fine as the atlas and the time to solve it allow: TEXEL_M or coarser. A vertex of
    two places is there twice.
    """
    charts = [chart for index, mesh in enumerate(meshes) if lit[index] for chart in _charts(index, mesh)]
    triangles = sum(len(chart.triangles) for chart in charts)
    for texel_m in TEXEL_M * 1.25 ** np.arange(40):
        texels = [chart.texels(texel_m) for chart in charts]
        patches = sum(wide * high for wide, high in texels)
        least = patches == len(charts)
        is_quick = patches <= MOST_PATCHES and patches * triangles <= _MOST_MEETINGS
        if (is_quick or least) and (lows := _packed(texels)) is not None:
            places = [chart.places(low, size) for chart, low, size in zip(charts, lows, texels, strict=True)]
            own = [[both for both in zip(charts, places, strict=True) if both[0].mesh == k] for k in range(len(meshes))]
            return [_cut(mesh, own[index]) if lit[index] else mesh for index, mesh in enumerate(meshes)]
        if least:
            break
    return f"{len(charts):,} flat pieces, which do not fit the light atlas of {ATLAS[0]}x{ATLAS[1]} texels"


def _packed(texels: Sequence[tuple[int, int]]) -> list[Array] | None:
    """Return the lowest corner of each, tallest first in rows; None where they do not fit."""
    lows: list[Array] = [np.zeros(2)] * len(texels)
    column = row = tallest = 0
    for index in sorted(range(len(texels)), key=lambda one: -texels[one][1]):
        wide, high = (side + 2 * BORDER for side in texels[index])
        if column + wide > ATLAS[0]:
            column, row, tallest = 0, row + tallest, 0
        if row + high > ATLAS[1]:
            return None
        lows[index] = np.array([column, row]) + float(BORDER)
        column, tallest = column + wide, max(tallest, high)
    return lows


def _charts(index: int, mesh: Mesh) -> Iterator[_Chart]:
    """Yield a mesh's charts: neighbours that make a parallelogram together, then the others."""
    positions, faces = mesh.positions.astype(np.float64), mesh.triangles.astype(np.int64)
    one, other = (positions[faces[:, corner]] - positions[faces[:, 0]] for corner in (1, 2))
    faces = faces[np.linalg.norm(np.cross(one, other), axis=1) > 1e-9]  # without area nothing is lit
    of_edge: dict[tuple[int, ...], list[int]] = {}
    for number, face in enumerate(faces.tolist()):
        for k in range(3):
            of_edge.setdefault(tuple(sorted((face[k], face[k - 1]))), []).append(number)
    free, found = set(range(len(faces))), list[tuple[list[int], tuple[int, ...]]]()
    for edge, both in of_edge.items():
        if len(both) == 2 and free >= set(both):
            first, second = ((set(faces[number].tolist()) - set(edge)).pop() for number in both)
            across = positions[edge[0]] + positions[edge[1]] - positions[first] - positions[second]
            long_m = float(np.linalg.norm(positions[edge[0]] - positions[edge[1]]))
            if first != second and np.linalg.norm(across) <= SAME * long_m:
                free -= set(both)
                found.append((both, (first, edge[0], second, edge[1])))
    found += [([number], tuple(faces[number].tolist())) for number in sorted(free)]
    for numbers, corners in found:
        sides_m = tuple(float(np.linalg.norm(positions[corners[end]] - positions[corners[0]])) for end in (1, -1))
        yield _Chart(index, (faces[numbers][..., None] == corners).argmax(axis=-1), corners, sides_m)


def _cut(mesh: Mesh, charts: Sequence[tuple[_Chart, Array]]) -> Mesh:
    """Return a mesh whose vertices have places in the atlas: those of each chart by themselves."""
    vertices, places, faces = list[int](), list[Array](), list[Array]()
    for chart, at in charts:
        faces.extend(chart.triangles + len(vertices))
        vertices.extend(chart.corners)
        places.extend(at)
    kept, albedo = np.array(vertices, int), mesh.albedo if mesh.albedo is not None else mesh.light
    rows = {name: getattr(mesh, name)[kept] for name in ("positions", "normals", "uv")}
    triangles, light_uv = np.array(faces, int).reshape(-1, 3), np.array(places).reshape(-1, 2)
    return attrs.evolve(mesh, **rows, light=albedo[kept], albedo=albedo[kept], triangles=triangles, light_uv=light_uv)


def _exposed(lamps: Sequence[Lamp], meshes: Sequence[Mesh], origin: Array) -> tuple[list[Lamp], float]:
    """Return the lamps so scaled that white surfaces show MEAN_LIGHT on average, and the factor.

    Over what stands still and faces a lamp at time 0, whatever lies between.
    """
    corners = np.concatenate([mesh.positions[mesh.triangles] for mesh in lit_meshes(meshes)]).astype(float) + origin
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(across, axis=1)
    light = np.zeros(len(area))
    for lamp in lamps:
        place, fading = lamp.place(0), lamp.fading(0)
        ways = place[:3] - corners.mean(axis=1) * place[3]
        far = np.maximum(np.linalg.norm(ways, axis=1), 1e-3)
        fades = np.clip(fading[3] - ways @ fading[:3] / far, 0, 1) ** 2
        cosine = np.maximum((ways * across).sum(axis=1) / far / area, 0)
        light += max(lamp.colour) * fades * cosine / (far**2 if place[3] else 1)
    total = float(area @ light)
    factor = MEAN_LIGHT * float(area[light > 0].sum()) / total if total > 0 else 1.0
    return [attrs.evolve(lamp, colour=tuple((factor * np.array(lamp.colour)).tolist())) for lamp in lamps], factor
