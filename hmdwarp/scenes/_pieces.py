"""A scene cut into pieces that can be sent one by one, and what is drawn until they arrive."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterable, Sequence
from functools import cached_property, lru_cache
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ._lamps import indirect_atlas, with_lamps_stopped
from ._mesh import Mesh, Texture, chunks_of
from ._reduce import UNKNOWN_ALBEDO, fewer_triangles, reduced, scaled, unlit, with_triangles
from ._scene import Scene

# A stand-in for the whole scene has as few triangles as this, or this share of them.
STAND_IN_TRIANGLES, STAND_IN_SHARE = 2000, 0.02
# Scales at which a texture crosses, one after the other.
SCALES = COARSEST, COARSE, HALF, FULL = (1 / 32, 1 / 8, 1 / 2, 1.0)
_COUNT = struct.Struct("<I")


def partial_scene(scene: Scene, share: float, texture: float, *, lit: bool) -> Scene:
    """Return what a client has of a scene: the scene itself where nothing is reduced.

    Mirrors, and what is see-through or fixed to the head, are whole; lamps stand still.
    Parameters, errors: as of `reduced`; lit: with baked light, else as `unlit`.
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
    """A scene in pieces.

    Plain surfaces and textures are sent. Materials, motions, sky, lamps with the indirect light of
    all surfaces, and how many vertices and triangles each piece has are known at the start; so are
    mirrors and what is see-through or fixed to the head, which are few.

    cut: (mesh, its pieces) in the order of the scene. `meshes` are the pieces of all of them.
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
        kept = fewer_triangles(self.meshes, max(STAND_IN_SHARE, min(1.0, STAND_IN_TRIANGLES / max(1, count))))
        return [with_triangles(mesh, few) if len(few) else None for mesh, few in zip(self.meshes, kept, strict=True)]

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
        """How many things are sent."""
        return 1 + len(self.meshes) + len(self.levels)

    def number_of_mesh(self, index: int) -> int:
        """Return the number of the thing that brings a mesh."""
        return 1 + index

    def number_of_level(self, texture: int, scale: float) -> int:
        """Return the number of the thing that brings a texture at one of SCALES."""
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
        albedo = (np.full_like(one.light, UNKNOWN_ALBEDO) if one.albedo is None else one.albedo for one in lit)
        more = [np.hstack([one.normals, one.light_uv, own]) for one, own in zip(lit, albedo, strict=True)]  # type: ignore
        vertices, further = (np.concatenate([np.zeros((0, 8), np.float32), *each]) for each in (rows, more))
        corners = np.concatenate([np.zeros((0, 3), np.uint32), *(mesh.triangles for _, mesh in meshes)])
        planes = sizes.tobytes()
        for array in (vertices, corners, further):  # differences from row to row, equal bytes of all rows together
            values = np.ascontiguousarray(array).view(np.uint8).reshape(len(array), 4 * array.shape[1])
            planes += np.diff(values, axis=0, prepend=np.zeros((1, values.shape[1]), np.uint8)).T.tobytes()
        return _COUNT.pack(len(sizes)) + zlib.compress(planes)

    def blank(self) -> Scene:
        """Return the scene as it is known at the start.

        What is sent has its sizes, but no content. In the order of the scene's meshes each is its
        pieces, or itself; the stand-ins come last.
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
        """Return a mesh of the same sizes and nature without content."""
        vertices, triangles = len(mesh.positions), len(mesh.triangles)
        rows = np.zeros((vertices, 8), np.float32)
        return _with_arrays(mesh, rows, np.zeros((triangles, 3), np.uint32), rows if self.under_lamps(mesh) else None)

    def level_in(self, number: int, thing: bytes) -> tuple[int, float, NDArray[np.uint8]]:
        """Return the texture, its scale and the image that a thing brings."""
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
    return [mesh] if len(chunks) == 1 else [with_triangles(mesh, chunk) for chunk in chunks]


def _from_byte_planes(data: bytes, shape: tuple[int, int], kind: type) -> NDArray[Any]:
    planes = np.frombuffer(data, np.uint8).reshape(-1, shape[0]) if shape[0] else np.zeros((4 * shape[1], 0), np.uint8)
    values = np.cumsum(planes, axis=1, dtype=np.uint8).T
    return np.ascontiguousarray(values).view(kind).reshape(shape)


def _with_arrays(
    mesh: Mesh, rows: NDArray[np.float32], triangles: NDArray[np.uint32], lit: NDArray[np.float32] | None
) -> Mesh:
    """Return the mesh with nothing of its own but what was packed of it.

    rows: (n, 8) positions, places on the texture and light; lit: (n, 8) normals, places in the
    light atlas and albedo, of a mesh under lamps.
    """
    return attrs.evolve(
        mesh,
        positions=rows[:, :3],
        uv=rows[:, 3:5],
        light=rows[:, 5:],
        triangles=triangles,
        normals=np.zeros((len(rows), 3), np.float32) if lit is None else lit[:, :3],
        light_uv=None if lit is None else lit[:, 3:5],
        albedo=None if lit is None else lit[:, 5:],
    )


def _grey(texture: Texture) -> Texture:
    """Return a texture of the same size and nature without content."""
    image = lambda: np.full_like(texture.image, 128)  # noqa: E731
    return Texture(texture.name, image, texture.srgb, texture.repeat, texture.emission)


def _png(image: NDArray[np.uint8]) -> bytes:
    """Return an image as PNG, which loses nothing."""
    from PIL import Image

    out = io.BytesIO()
    Image.fromarray(image).save(out, "PNG")
    return out.getvalue()
