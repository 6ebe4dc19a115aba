"""A scene's arrays as GPU buffers, in chunks small enough to cull."""

from __future__ import annotations

import functools
from abc import ABC, abstractmethod
from collections.abc import Collection, Sequence
from typing import Any, ClassVar

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ...errors import SceneError
from ...geometry import View
from ...gpu.context import Gpu
from ...gpu.textures import check_size, flip_rows, release_all
from ...scenes import Mesh, Scene, Texture, chunks_of
from .visibility import Chunks, Visibility, boxes_around, eye_from_scene

SRGB8_ALPHA8 = 0x8C43


def emits(scene: Scene) -> bool:
    """Return whether a texture of the scene emits, so that its surfaces need EMISSION."""
    return any(texture.emission is not None for texture in scene.textures)


@attrs.frozen(eq=False)
class Batch:
    """The state that chunks drawn together share."""

    texture: moderngl.Texture
    double_sided: bool  # whether both sides of a triangle are visible; else back faces are culled
    emission: Shine


@attrs.frozen(eq=False)
class Shine:
    """What the surfaces with a texture emit: a texture of its own times a linear colour."""

    texture: moderngl.Texture
    factor: tuple[float, ...] = (0.0, 0.0, 0.0)


def upload_texture(gpu: Gpu, texture: Texture) -> moderngl.Texture:
    """Upload a texture with mipmaps; the sampler decodes sRGB before it filters."""
    height, width = texture.image.shape[:2]
    check_size(gpu.gl, (width, height))
    data = _texels(texture.image)
    made = gpu.gl.texture((width, height), 4, data, internal_format=SRGB8_ALPHA8 if texture.srgb else None)
    made.build_mipmaps()
    made.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
    made.repeat_x = made.repeat_y = texture.repeat
    return made


def _texels(image: NDArray[np.uint8]) -> bytes:
    if image.shape[2] == 3:
        image = np.concatenate([image, np.full((*image.shape[:2], 1), 255, np.uint8)], axis=2)
    return np.ascontiguousarray(flip_rows(image)).tobytes()


_WHITE = Texture("white", np.full((1, 1, 3), 255, np.uint8), srgb=False)


class SceneTextures:
    """A scene's textures on the GPU, by index; -1 is white. lent: unchanging, and shared."""

    def __init__(self, gpu: Gpu, scene: Scene, *, lent: bool = False) -> None:
        def made(one: Texture) -> moderngl.Texture:
            make = functools.partial(upload_texture, gpu, one)
            return gpu.lend(one.image, (one.srgb, one.repeat), make) if lent else make()

        self._gpu, self.revision = gpu, 0  # it counts changes
        self._made = [made(texture) for texture in (*scene.textures, _WHITE)]
        shining = {k: one.emission for k, one in enumerate(scene.textures) if one.emission}
        pictures = {k: Texture("emission", one.image, repeat=one.repeat) for k, one in shining.items()}
        self._shines = {k: Shine(upload_texture(gpu, pictures[k]), one.factor) for k, one in shining.items()}

    def __getitem__(self, index: int) -> moderngl.Texture:
        return self._made[index]

    def shine(self, index: int) -> Shine:
        """Return what the surfaces with that texture emit."""
        return self._shines.get(index) or Shine(self._made[-1])

    def put(self, index: int, image: NDArray[np.uint8]) -> None:
        """Replace the image of one texture by another of the same size."""
        self._made[index].write(_texels(image))
        self._made[index].build_mipmaps()
        self.revision += 1

    def close(self) -> None:
        release_all(*(texture for texture in self._made if not self._gpu.hand_back(texture)))
        release_all(*(shine.texture for shine in self._shines.values()))


class SceneBuffers:
    """Some meshes of a scene on the GPU: a vertex buffer, an index buffer and chunks."""

    def __init__(self, gpu: Gpu, meshes: Sequence[Mesh], textures: SceneTextures) -> None:
        self.batches: list[Batch] = []
        self.meshes, self.revision = list(meshes), 0  # it counts changes
        # Those that are drawn.
        self.chunks: Chunks
        self.visibility: Visibility
        self._starts = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
        groups: dict[tuple[bool, int], list[int]] = {}
        for number, mesh in enumerate(meshes):
            groups.setdefault((mesh.double_sided, mesh.texture), []).append(number)
        # Of all chunks: the mesh of each, its indices, and which are drawn.
        owner, self._order = [], []  # type: list[int], list[NDArray[np.uint32]]
        batch_of, boxes = [], []
        for (double_sided, texture), members in sorted(groups.items(), key=lambda item: item[0]):
            for number in members:
                for chunk in chunks_of(meshes[number]):
                    boxes.append(_extremes(meshes[number], chunk))
                    self._order.append(chunk.ravel() + np.uint32(self._starts[number]))
                    batch_of.append(len(self.batches))
                    owner.append(number)
            self.batches.append(Batch(textures[texture], double_sided, textures.shine(texture)))
        count = np.array([len(part) for part in self._order], np.int64)
        around = boxes_around(*np.array(boxes, np.float64).reshape(-1, 2, 3).transpose(1, 0, 2))
        self._all = Chunks(np.cumsum(count) - count, count, np.array(batch_of, np.int64), around)
        self._owner = np.array(owner, np.int64)
        self.draw_only(range(len(meshes)))
        self._vertices = gpu.gl.buffer(_vertex_rows(meshes).tobytes() or b"\0" * 32)
        indices = np.concatenate([np.empty(0), *self._order]).astype(np.uint32)
        self._indices = gpu.gl.buffer(indices.tobytes() or b"\0" * 12)

    def move_to(self, positions: NDArray[np.float32]) -> None:
        """Move all vertices, (n, 3) in the order of the meshes; visibility follows."""
        if not self._order:
            return
        rows = _vertex_rows(self.meshes)
        rows[:, :3] = positions
        self._vertices.write(rows.tobytes())
        corners = positions[np.concatenate(self._order)].astype(np.float64)
        low, high = (extreme.reduceat(corners, self._all.first, axis=0) for extreme in (np.minimum, np.maximum))
        self._all = attrs.evolve(self._all, boxes=boxes_around(low, high))
        self._choose()

    def put(self, number: int, mesh: Mesh) -> None:
        """Replace the arrays of a mesh by as many others, at rest until they are moved."""
        start = int(self._starts[number])
        self.meshes[number] = mesh
        self._vertices.write(_vertex_rows([mesh]).tobytes(), offset=_ROW_BYTES * start)
        boxes = self._all.boxes.copy()
        for chunk, triangles in zip(np.flatnonzero(self._owner == number).tolist(), chunks_of(mesh), strict=True):
            self._order[chunk] = indices = triangles.ravel() + np.uint32(start)
            self._indices.write(indices.astype(np.uint32).tobytes(), offset=4 * int(self._all.first[chunk]))
            boxes[:, [chunk]] = boxes_around(*(corner[None] for corner in _extremes(mesh, triangles)))
        self._all = attrs.evolve(self._all, boxes=boxes)
        self._choose()

    def draw_only(self, numbers: Collection[int]) -> None:
        """Draw these meshes alone from now on."""
        self._drawn = np.isin(self._owner, list(numbers))
        self._choose()

    def _choose(self) -> None:
        every, drawn = self._all, self._drawn
        self.chunks = Chunks(every.first[drawn], every.count[drawn], every.batch[drawn], every.boxes[:, drawn])
        self.visibility = Visibility(self.chunks)
        self.revision += 1

    def vertex_array(
        self, gl: moderngl.Context, program: moderngl.Program, *more: tuple[Any, ...], colour: bool
    ) -> moderngl.VertexArray:
        """Return the buffers, and `more` as moderngl takes them, as inputs of `program`."""
        names = ("in_position", "in_uv", "in_light") if colour else ("in_position",)
        layout = "3f4 2f4 3f4" if colour else "3f4 20x1"
        return gl.vertex_array(program, [(self._vertices, layout, *names), *more], self._indices, index_element_size=4)

    def close(self) -> None:
        self._vertices.release()
        self._indices.release()


def _extremes(mesh: Mesh, triangles: NDArray[np.uint32]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    corners = mesh.positions[triangles.ravel()].astype(np.float64)
    return corners.min(axis=0), corners.max(axis=0)


_ROW_BYTES = 4 * (3 + 2 + 3)


def _vertex_rows(meshes: Sequence[Mesh]) -> NDArray[np.float32]:
    rows = [np.concatenate([mesh.positions, mesh.uv, mesh.light], axis=1) for mesh in meshes]
    return np.concatenate([np.empty((0, 8)), *rows]).astype(np.float32)


STAYS = np.eye(4)
STAYS.flags.writeable = False


@attrs.frozen(eq=False)
class Place:
    """An eye in the space that positions are relative to."""

    eye_from_here: NDArray[np.float64]  # 4x4
    eye: NDArray[np.float64]  # (3,) metres


class Moving(ABC):
    # The layer that describes its motion: the client of a frame with that layer moves it.
    layer: ClassVar[str]
    buffers: SceneBuffers  # its triangles

    @abstractmethod
    def set_time(self, time_ns: int) -> None:
        """Move it to its place at that instant; do nothing for the same instant again."""

    @abstractmethod
    def place(self, view: View) -> Place:
        """Return the place of the view's eye at the instant set last."""

    def scene_from_here(self, time_ns: int) -> NDArray[np.float64]:
        """Return the 4x4 that takes its positions to the scene's axes at an instant."""
        return STAYS

    def close(self) -> None:
        self.buffers.close()


class MovingBody(Moving):
    """All meshes of body number `number` (1 + its index)."""

    layer = "ids"

    def __init__(self, gpu: Gpu, scene: Scene, meshes: Sequence[Mesh], textures: SceneTextures) -> None:
        self.number = meshes[0].body
        self.buffers = SceneBuffers(gpu, meshes, textures)
        self._body, self._origin_m = scene.bodies[self.number - 1], scene.origin_m

    def set_time(self, time_ns: int) -> None:
        # Not kept for the next time: what people did by that instant may have come since.
        self._pose = self._body.motion.state(time_ns).pose

    def place(self, view: View) -> Place:
        return Place(self._pose.relative_to(view.pose).matrix(), view.pose.relative_to(self._pose).position_m)

    def scene_from_here(self, time_ns: int) -> NDArray[np.float64]:
        matrix = self._body.motion.state(time_ns).pose.matrix()
        matrix[:3, 3] -= self._origin_m
        return matrix


class DeformingMesh(Moving):
    """One mesh whose vertices move by themselves: uploaded again for each instant that is drawn."""

    layer = "velocity"

    def __init__(self, gpu: Gpu, scene: Scene, mesh: Mesh, textures: SceneTextures) -> None:
        self.buffers = SceneBuffers(gpu, [mesh], textures)
        assert mesh.deformation is not None
        self.mesh, self._deformation, self._origin_m = mesh, mesh.deformation, scene.origin_m
        self._set_ns: int | None = None
        # The arrays that were moved, which may be replaced.
        self._moved = mesh

    def set_time(self, time_ns: int) -> None:
        if time_ns != self._set_ns or self.buffers.meshes[0] is not self._moved:
            self.buffers.move_to(self.positions(time_ns))
            self._set_ns, self._moved = time_ns, self.buffers.meshes[0]

    def positions(self, time_ns: int) -> NDArray[np.float32]:
        """Return its vertices, (n, 3) metres relative to the scene's origin, at any instant."""
        return _checked(self.mesh, "positions", self._deformation.positions(time_ns))

    def velocities(self) -> NDArray[np.float32]:
        """Return its vertices' velocities, (n, 3) m/s in world axes, at the last set instant."""
        assert self._set_ns is not None
        return _checked(self.mesh, "velocities", self._deformation.velocities(self._set_ns))

    def place(self, view: View) -> Place:
        return Place(eye_from_scene(view, self._origin_m), view.pose.position_m - self._origin_m)


def _checked(mesh: Mesh, what: str, values: NDArray[Any]) -> NDArray[np.float32]:
    array = np.ascontiguousarray(values, np.float32)
    if array.shape != mesh.positions.shape:
        raise SceneError(
            f"mesh '{mesh.name}': its deformation gives {what} of shape {array.shape}, expected {mesh.positions.shape}"
        )
    if not np.isfinite(array).all():
        raise SceneError(f"mesh '{mesh.name}': its deformation gives {what} that are not finite numbers")
    return array


def moving_parts(gpu: Gpu, scene: Scene, textures: SceneTextures) -> tuple[Moving, ...]:
    surfaces = [mesh for mesh in scene.meshes if mesh.is_surface]
    numbers = sorted({mesh.body for mesh in surfaces if mesh.body})
    bodies = [
        MovingBody(gpu, scene, [mesh for mesh in surfaces if mesh.body == number], textures) for number in numbers
    ]
    return (*bodies, *(DeformingMesh(gpu, scene, mesh, textures) for mesh in surfaces if mesh.deformation is not None))
