"""Scenes with fewer triangles and texels, for a client that draws for itself."""

from __future__ import annotations

import ctypes
import io
import struct
import zlib
from collections.abc import Iterable, Sequence
from functools import cache, cached_property, lru_cache, partial
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import SceneError, import_extra, linear_from_srgb, srgb8_from_linear
from ._lamps import indirect_atlas, with_lamps_stopped
from ._mesh import Deformation, Material, Mesh, Texture, chunks_of
from ._scene import Background, Scene

_UNKNOWN_ALBEDO = 0.5
# Black is drawn as this, so that what glows on it has a light: 1.2 % of white in sRGB.
LEAST_ALBEDO = 2.0**-10
WHITE = -1  # index of the texture that is 1 everywhere
_LEAST_TRIANGLES = 2000  # cheap to draw for any client, and a fifth of ten triangles would leave things out
# What a change by 1 along a metre weighs, as a change of position by that many metres; a texture's
# change is in metres on it. Tuned on the pictures of four scenes with 20 % and 5 % of their
# triangles: weights of 0.1 lose 5 dB, twice these 1 dB.
_WEIGHT_OF_LIGHT, _WEIGHT_OF_TEXTURE, WEIGHT_OF_NORMAL = 1.5, 0.7, 0.2
ASIDE = 1e-4  # of the scene's size, between parts that move apart
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear sRGB

Triangles = list[NDArray[np.uint32]]


def reduced(
    scene: Scene, share: float, *, texture: float = 1.0, least: int = _LEAST_TRIANGLES, matt: bool = True
) -> Scene:
    """Return the scene's surfaces with about `share` of their triangles, and baked light.

    Bodies and deformations move as before. matt: mirrors stay as plain surfaces; what is
    see-through or fixed to the head is left out. Else all of these stay as they are. texture: scale
    of the textures' resolution, averaged in linear light. least: triangles that no scene is reduced
    below. Errors: SceneError for a share or a scale that is not above 0 and at most 1; MachineError
    without meshoptimizer.
    """
    if not 0 < texture <= 1:
        raise SceneError(f"textures at {texture:g} of their resolution: expected more than 0 and at most 1")
    if not 0 < share <= 1:
        raise SceneError(f"share {share:g} of a scene's triangles: expected more than 0 and at most 1")
    surfaces = [mesh for mesh in scene.meshes if mesh.is_surface and (matt or not mesh.material.reflectivity)]
    share = max(share, min(1.0, least / max(1, sum(len(mesh.triangles) for mesh in surfaces))))
    triangles = fewer_triangles(surfaces, share)
    pairs = zip(surfaces, triangles, strict=True)
    fewer = {id(mesh): _with_triangles(mesh, kept, matt=matt) if len(kept) else None for mesh, kept in pairs}
    meshes = [one for mesh in scene.meshes if (one := fewer.get(id(mesh), None if matt else mesh)) is not None]
    textures = list(scene.textures)
    if texture != 1:
        textures = [Texture(t.name, partial(scaled, t, texture), t.srgb, t.repeat, t.emission) for t in textures]
    return attrs.evolve(scene, meshes=meshes, textures=textures)


def scaled(texture: Texture, scale: float) -> NDArray[np.uint8]:
    """Return its image at that scale, averaged in linear light; a side has one texel at least."""
    from PIL import Image

    image = texture.image
    if scale == 1:
        return image
    size = tuple(max(1, round(scale * side)) for side in image.shape[1::-1])
    linear = image / np.float32(255)
    if texture.srgb:
        linear[..., :3] = linear_from_srgb(image[..., :3])
    channels = [Image.fromarray(np.ascontiguousarray(linear[..., k])) for k in range(image.shape[2])]
    made = np.stack([np.asarray(channel.resize(size, Image.Resampling.BOX)) for channel in channels], axis=-1)
    smaller = np.rint(255 * made).astype(np.uint8)
    if texture.srgb:
        smaller[..., :3] = srgb8_from_linear(made[..., :3])
    return np.asarray(smaller)


def unlit(scene: Scene) -> Scene:
    """Return the scene under light of 1: every surface's texture times its material's colour.

    Without an albedo its baked colour at a luminance of 0.5 is taken. Black is at least
    LEAST_ALBEDO.
    """
    meshes = [attrs.evolve(mesh, light=_albedo(mesh)) for mesh in scene.meshes]
    return attrs.evolve(scene, meshes=meshes, lamps=())


def only_light(scene: Scene) -> Scene:
    """Return the scene as `unlit` leaves it out: white surfaces and sky under the light there is.

    Per vertex, the light times the albedo of `unlit` is the baked colour: exact over a triangle
    with one albedo or one light. For textures that glow see `only_emission`.
    """
    light = [(mesh, mesh.light / _albedo(mesh), np.ones_like(mesh.light)) for mesh in scene.meshes]
    meshes = [attrs.evolve(mesh, light=own, texture=WHITE, albedo=white) for mesh, own, white in light]
    return attrs.evolve(scene, meshes=meshes, background=Background.uniform((1.0, 1.0, 1.0)))


def only_emission(scene: Scene) -> Scene | None:
    """Return the scene without any light but what its textures emit; None where none does."""
    if all(texture.emission is None for texture in scene.textures):
        return None
    meshes = [attrs.evolve(mesh, light=np.zeros_like(mesh.light)) for mesh in scene.meshes]
    return attrs.evolve(scene, meshes=meshes, background=Background())


def _albedo(mesh: Mesh) -> NDArray[Any]:
    luminance = (mesh.light @ _LUMINANCE)[:, None]
    guess = np.where(
        luminance > 0, _UNKNOWN_ALBEDO * mesh.light / np.where(luminance > 0, luminance, 1), _UNKNOWN_ALBEDO
    )
    return np.asarray(np.maximum(guess if mesh.albedo is None else mesh.albedo, LEAST_ALBEDO))


def fewer_triangles(meshes: Sequence[Mesh], share: float) -> Triangles:
    """Return `share` of all triangles, for each mesh as indices into its own vertices.

    Collapses go by errors of position, light, texture and normal; borders and seams stay closed;
    meshes that meet in a vertex still meet there, unless they move apart. Two calls return the
    same. Errors: MachineError without meshoptimizer. Source: Garland and Heckbert 1997, Surface
    Simplification Using Quadric Error Metrics; Hoppe 1999, New Quadric Metric for Simplifying
    Meshes with Appearance Attributes.
    """
    sizes, count = [len(mesh.positions) for mesh in meshes], sum(len(mesh.triangles) for mesh in meshes)
    if share == 1 or not count:
        return [mesh.triangles for mesh in meshes]
    starts, owner = np.cumsum([0, *sizes]), np.repeat(np.arange(len(meshes)), sizes)
    names = ("positions", "normals", "uv", "light")
    position, normal, uv, light = (np.concatenate([getattr(m, name) for m in meshes]) for name in names)
    corners = np.concatenate([m.triangles + s for m, s in zip(meshes, starts, strict=False)])
    # Vertices count as one surface where their positions are equal, so what moves by itself is put
    # a little aside.
    moves_with = [mesh.body if mesh.deformation is None else -1 - k for k, mesh in enumerate(meshes)]
    _, part = np.unique(moves_with, return_inverse=True)
    aside = ASIDE * np.ptp(position, axis=0).max() * part[owner]
    scale = np.array([_metres_per_uv(mesh) for mesh in meshes])[owner]
    looks = [_WEIGHT_OF_LIGHT * light, _WEIGHT_OF_TEXTURE * scale[:, None] * uv, WEIGHT_OF_NORMAL * normal]
    table = np.concatenate([position + aside[:, None], *looks, owner[:, None]], axis=1, dtype=np.float32)
    _, first, which = np.unique(table, axis=0, return_index=True, return_inverse=True)
    indices = which.reshape(-1)[corners].astype(np.uint32).ravel()
    kept, simplifier = np.empty_like(indices), _simplifier()
    places, looks_of = (np.ascontiguousarray(table[first, part]) for part in (slice(3), slice(3, -1)))
    how = {"target_index_count": 3 * round(share * count), "target_error": 1e6, "options": simplifier.SIMPLIFY_PRUNE}
    found = simplifier.simplify_with_attributes(kept, indices, places, looks_of, np.ones(looks_of.shape[1]), **how)
    corners = first[kept[:found].reshape(-1, 3)]
    return [(corners[owner[corners[:, 0]] == k] - starts[k]).astype(np.uint32) for k in range(len(meshes))]


@cache
def _simplifier() -> Any:
    """Return meshoptimizer's simplifier; 0.2.30 does not declare its parameters to ctypes."""
    module = import_extra("meshoptimizer.simplifier", "meshoptimizer", "reduce")
    array, number = ctypes.c_void_p, ctypes.c_size_t
    arrays = [array, array, number, array, number, number, array, number, array, number, array]
    module.lib.meshopt_simplifyWithAttributes.argtypes = [*arrays, number, ctypes.c_float, ctypes.c_uint, array]
    module.lib.meshopt_simplifyWithAttributes.restype = number
    return module


def _metres_per_uv(mesh: Mesh) -> float:
    """Return the mean size of a texture on the mesh; 0 without one."""
    if mesh.texture < 0:
        return 0.0
    p, uv = mesh.positions[mesh.triangles].astype(np.float64), mesh.uv[mesh.triangles].astype(np.float64)
    area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum()
    (a, b), (c, d) = (uv[:, 1] - uv[:, 0]).T, (uv[:, 2] - uv[:, 0]).T
    painted = np.abs(a * d - b * c).sum()
    return float(np.sqrt(area / painted)) if painted > 0 else 0.0


@attrs.frozen(eq=False)
class _Subset:
    """A deformation of some of its vertices."""

    whole: Deformation
    kept: NDArray[np.integer]

    def positions(self, time_ns: int) -> NDArray[np.float64]:
        return np.asarray(self.whole.positions(time_ns)[self.kept])

    def velocities(self, time_ns: int) -> NDArray[np.float64]:
        return np.asarray(self.whole.velocities(time_ns)[self.kept])


def _with_triangles(mesh: Mesh, triangles: NDArray[np.uint32], *, matt: bool = False) -> Mesh:
    """Return the mesh with these triangles and their vertices only; matt: in plain material."""
    kept, which = np.unique(triangles, return_inverse=True)
    arrays = {name: getattr(mesh, name) for name in ("positions", "normals", "uv", "light", "albedo", "light_uv")}
    rows: dict[str, Any] = {name: None if array is None else array[kept] for name, array in arrays.items()}
    soft = None if mesh.deformation is None else _Subset(mesh.deformation, kept)
    material = Material() if matt else mesh.material
    return attrs.evolve(mesh, triangles=which.reshape(-1, 3), deformation=soft, material=material, **rows)


# A stand-in for the whole scene has as few triangles as this, or this share of them.
_STAND_IN_TRIANGLES, STAND_IN_SHARE = 2000, 0.02
# Scales at which a texture crosses, one after the other.
SCALES = COARSEST, COARSE, HALF, FULL = (1 / 32, 1 / 8, 1 / 2, 1.0)
_COUNT = struct.Struct("<I")


def partial_scene(scene: Scene, share: float, texture: float, *, lit: bool) -> Scene:
    """Return what a client has of a scene: the scene itself where nothing is reduced.

    Mirrors, and what is see-through or fixed to the head, are whole; lamps stand still. lit: with
    baked light, else as `unlit`. Else as of `reduced`.
    """
    scene = with_lamps_stopped(scene)
    if (share, texture) != (1, 1):
        scene = reduced(scene, share, texture=texture, matt=False)
    return scene if lit else unlit(scene)


@lru_cache(maxsize=2)  # the sender's and the receiver's of one run
def pieces_of(scene: Scene, share: float, texture: float, *, lit: bool) -> Pieces:
    """Return the pieces of a partial_scene; one object for the same arguments."""
    return Pieces(partial_scene(scene, share, texture, lit=lit))


class Pieces:
    """A scene in pieces: plain surfaces and textures are sent.

    All else is known at the start: materials, motions, sky, lamps with the light between surfaces,
    the sizes of pieces, mirrors, and what is see-through or fixed to the head. cut: (mesh, its
    pieces) in the order of the scene; `meshes` are the pieces of all of them.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.cut = [(mesh, _cut(mesh)) for mesh in scene.meshes]
        self.at_start = [mesh for mesh, parts in self.cut if not parts]
        self.meshes: list[Mesh] = [part for _, parts in self.cut for part in parts]
        # Where something is see-through, its texture says what kind of sheet it is.
        at_start = {mesh.texture for mesh in scene.meshes if not mesh.is_surface}
        self._textures_at_start = sorted(at_start - {-1})
        # (texture, scale), as they are numbered after the meshes.
        every = {each for mesh in scene.meshes for each in (mesh.texture, mesh.material.normal_map)}
        used = sorted(every - at_start - {-1})
        self.levels = [(texture, scale) for scale in SCALES for texture in used]
        self._number_of_level = {level: 1 + len(self.meshes) + n for n, level in enumerate(self.levels)}

    @cached_property
    def stand_ins(self) -> list[Mesh | None]:
        """For each mesh one with few triangles, None where that is too small to be missed."""
        count = sum(len(mesh.triangles) for mesh in self.meshes)
        kept = fewer_triangles(self.meshes, max(STAND_IN_SHARE, min(1.0, _STAND_IN_TRIANGLES / max(1, count))))
        return [_with_triangles(mesh, few) if len(few) else None for mesh, few in zip(self.meshes, kept, strict=True)]

    @cached_property
    def light(self) -> NDArray[np.float16] | None:
        """The indirect light of the lamps' instant as the light atlas; None without lamps."""
        return indirect_atlas(self.scene, 0) if self.scene.lamps else None

    @cached_property
    def things(self) -> tuple[bytes, ...]:
        """What is sent: all stand-ins, then each mesh, then each level."""
        standing = [(k, mesh) for k, mesh in enumerate(self.stand_ins) if mesh is not None]
        return (
            self._packed(standing),
            *(self._packed([(k, mesh)]) for k, mesh in enumerate(self.meshes)),
            *(_png(scaled(self.scene.textures[texture], scale)) for texture, scale in self.levels),
        )

    @property
    def count(self) -> int:
        return 1 + len(self.meshes) + len(self.levels)

    def number_of_mesh(self, index: int) -> int:
        return 1 + index

    def number_of_level(self, texture: int, scale: float) -> int:
        return self._number_of_level[texture, scale]

    @property
    def first(self) -> list[int]:
        """The things that make a whole picture, if a coarse one."""
        return [0, *(self._number_of_level[level] for level in self.levels if level[1] == COARSEST)]

    @cached_property
    def start_bytes(self) -> int:
        """Bytes that cross at the start, packed, where the rest comes in pieces."""
        outline = [(len(m.positions), len(m.triangles), m.texture, m.double_sided, m.body) for m in self.meshes]
        stood = [(0, 0) if m is None else (len(m.positions), len(m.triangles)) for m in self.stand_ins]
        sizes = [self.scene.textures[texture].image.shape for texture, _ in self.levels]
        numbers = np.array([*np.ravel(outline), *np.ravel(stood), *np.ravel(sizes)], np.int32)
        light = 0 if self.light is None else len(zlib.compress(self.light.tobytes()))
        return self._bytes_of(self.at_start, self._textures_at_start) + len(zlib.compress(numbers.tobytes())) + light

    @cached_property
    def whole_bytes(self) -> int:
        """Bytes of the whole scene, packed, where all of it crosses at the start."""
        used = {*self._textures_at_start, *(texture for texture, _ in self.levels)}
        return self._bytes_of([*self.at_start, *self.meshes], used)

    def _bytes_of(self, meshes: Sequence[Mesh], textures: Iterable[int]) -> int:
        """Return the bytes of meshes, textures, and all that they emit, packed."""
        images = [self.scene.textures[texture].image for texture in textures]
        images += [each.emission.image for each in self.scene.textures if each.emission is not None]
        return len(self._packed(list(enumerate(meshes)))) + sum(len(_png(image)) for image in images)

    def under_lamps(self, mesh: Mesh) -> bool:
        """Return whether the scene's lamps light a mesh, by its normals and light atlas."""
        return bool(self.scene.lamps) and mesh.light_uv is not None

    @property
    def most_blockers(self) -> int:
        """How many triangles stop light at most: of each mesh, or what stands in for it."""
        pairs = [*zip(self.meshes, self.stand_ins, strict=True), *((mesh, None) for mesh in self.at_start)]
        return sum(
            max(len(mesh.triangles), len(other.triangles) if other is not None else 0)
            for mesh, other in pairs
            if self.under_lamps(mesh)
        )

    def _packed(self, meshes: Sequence[tuple[int, Mesh]]) -> bytes:
        """Return meshes with their indices, and what lamps take of those under them."""
        sizes = np.array([(k, len(mesh.positions), len(mesh.triangles)) for k, mesh in meshes], np.uint32)
        rows = [np.hstack([mesh.positions, mesh.uv, mesh.light]) for _, mesh in meshes]
        lit = [mesh for _, mesh in meshes if self.under_lamps(mesh)]
        albedo = (np.full_like(one.light, _UNKNOWN_ALBEDO) if one.albedo is None else one.albedo for one in lit)
        more = [np.hstack([one.normals, one.light_uv, own]) for one, own in zip(lit, albedo, strict=True)]  # type: ignore
        vertices, further = (np.concatenate([np.zeros((0, 8), np.float32), *each]) for each in (rows, more))
        corners = np.concatenate([np.zeros((0, 3), np.uint32), *(mesh.triangles for _, mesh in meshes)])
        planes = sizes.tobytes()
        for array in (vertices, corners, further):  # differences from row to row, equal bytes of all rows together
            values = np.ascontiguousarray(array).view(np.uint8).reshape(len(array), 4 * array.shape[1])
            planes += np.diff(values, axis=0, prepend=np.zeros((1, values.shape[1]), np.uint8)).T.tobytes()
        return _COUNT.pack(len(sizes)) + zlib.compress(planes)

    def blank(self) -> Scene:
        """Return the scene as it is known at the start: what is sent has its sizes, but no content.

        In the order of the scene's meshes each is its pieces, or itself; the stand-ins come last.
        """
        meshes = [part for mesh, parts in self.cut for part in (map(self._blank, parts) if parts else (mesh,))]
        meshes += [self._blank(mesh) for mesh in self.stand_ins if mesh is not None]
        known = {*self._textures_at_start}
        textures = [each if k in known else _grey(each) for k, each in enumerate(self.scene.textures)]
        return attrs.evolve(self.scene, meshes=meshes, textures=textures)

    def meshes_in(self, number: int, thing: bytes) -> list[tuple[int, Mesh]]:
        """Return the meshes of a thing (0: stand-ins), each with its index; [] for a level."""
        if number > len(self.meshes):
            return []
        known = self.meshes if number else self.stand_ins
        (count,) = _COUNT.unpack_from(thing)
        whole = zlib.decompress(thing[_COUNT.size :])
        sizes = np.frombuffer(whole, np.uint32, 3 * count).reshape(count, 3)
        _, vertices, triangles = sizes.sum(axis=0).tolist()
        at, after = sizes.nbytes, sizes.nbytes + 32 * vertices + 12 * triangles
        rows = _from_byte_planes(whole[at : at + 32 * vertices], (vertices, 8), np.float32)
        corners = _from_byte_planes(whole[at + 32 * vertices : after], (triangles, 3), np.uint32)
        further = _from_byte_planes(whole[after:], ((len(whole) - after) // 32, 8), np.float32)
        found, row, corner, lit_row = list[tuple[int, Mesh]](), 0, 0, 0
        for k, of_rows, of_corners in sizes.tolist():
            mesh = known[k]
            assert mesh is not None
            lit = further[lit_row : lit_row + of_rows] if self.under_lamps(mesh) else None
            found.append((k, _with_arrays(mesh, rows[row : row + of_rows], corners[corner : corner + of_corners], lit)))
            row, corner, lit_row = row + of_rows, corner + of_corners, lit_row + (0 if lit is None else of_rows)
        return found

    def _blank(self, mesh: Mesh) -> Mesh:
        vertices, triangles = len(mesh.positions), len(mesh.triangles)
        rows = np.zeros((vertices, 8), np.float32)
        return _with_arrays(mesh, rows, np.zeros((triangles, 3), np.uint32), rows if self.under_lamps(mesh) else None)

    def level_in(self, number: int, thing: bytes) -> tuple[int, float, NDArray[np.uint8]]:
        from PIL import Image

        with Image.open(io.BytesIO(thing)) as image:
            return *self.levels[number - 1 - len(self.meshes)], np.asarray(image)


def _cut(mesh: Mesh) -> list[Mesh]:
    """Return the pieces of a plain surface: chunks, or all that deforms; none of others."""
    if not mesh.is_surface or mesh.material.reflectivity:
        return []
    if mesh.deformation is not None:
        return [mesh] if len(mesh.triangles) else []
    chunks = chunks_of(mesh)
    return [mesh] if len(chunks) == 1 else [_with_triangles(mesh, chunk) for chunk in chunks]


def _from_byte_planes(data: bytes, shape: tuple[int, int], kind: type) -> NDArray[Any]:
    planes = np.frombuffer(data, np.uint8).reshape(-1, shape[0]) if shape[0] else np.zeros((4 * shape[1], 0), np.uint8)
    values = np.cumsum(planes, axis=1, dtype=np.uint8).T
    return np.ascontiguousarray(values).view(kind).reshape(shape)


def _with_arrays(
    mesh: Mesh, rows: NDArray[np.float32], triangles: NDArray[np.uint32], lit: NDArray[np.float32] | None
) -> Mesh:
    """Return the mesh with nothing of its own but what was packed of it.

    rows: (n, 8) positions, uv and light; lit: (n, 8) normals, light_uv and albedo, under lamps.
    """
    normals, light_uv, albedo = np.zeros((len(rows), 3), np.float32), None, None
    if lit is not None:
        normals, light_uv, albedo = lit[:, :3], lit[:, 3:5], lit[:, 5:]
    own: dict[str, Any] = {"positions": rows[:, :3], "uv": rows[:, 3:5], "light": rows[:, 5:], "triangles": triangles}
    return attrs.evolve(mesh, **own, normals=normals, light_uv=light_uv, albedo=albedo)


def _grey(texture: Texture) -> Texture:
    image = lambda: np.full_like(texture.image, 128)  # noqa: E731
    return Texture(texture.name, image, texture.srgb, texture.repeat, texture.emission)


def _png(image: NDArray[np.uint8]) -> bytes:
    from PIL import Image

    out = io.BytesIO()
    Image.fromarray(image).save(out, "PNG")
    return out.getvalue()
