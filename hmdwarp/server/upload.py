"""A scene's arrays as GPU buffers, in chunks small enough to cull."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ..gpu.context import Gpu
from ..gpu.textures import check_size, flip_rows
from ..scenes import Mesh, Scene, Texture
from .projection import boxes_of
from .visibility import Chunks, Visibility

SRGB8_ALPHA8 = 0x8C43
CHUNK_TRIANGLES = 1024


@attrs.frozen(eq=False)
class Batch:
    """The state that chunks drawn together share."""

    texture: moderngl.Texture
    # Whether both sides of a triangle are visible; else back faces are culled.
    double_sided: bool


def chunks_of(mesh: Mesh) -> list[NDArray[np.uint32]]:
    """Return the mesh's triangles in compact pieces of at most CHUNK_TRIANGLES."""
    triangles = mesh.triangles
    if len(triangles) <= CHUNK_TRIANGLES:
        return [triangles] if len(triangles) else []
    order = np.argsort(_morton(mesh.positions[triangles].mean(axis=1)), kind="stable")
    return np.array_split(triangles[order], -(-len(triangles) // CHUNK_TRIANGLES))


def _morton(points: NDArray) -> NDArray[np.uint64]:
    """Return the Z-order of points, 10 bits per axis: close in order is close in space."""
    low, high = points.min(axis=0), points.max(axis=0)
    cell = ((points - low) / max(float((high - low).max()), 1e-30) * 1023).astype(np.uint64)
    code = np.zeros(len(points), np.uint64)
    for bit in range(10):
        for axis in range(3):
            code |= ((cell[:, axis] >> np.uint64(bit)) & np.uint64(1)) << np.uint64(3 * bit + axis)
    return code


def upload_texture(gpu: Gpu, texture: Texture) -> moderngl.Texture:
    """Upload a texture with mipmaps; the sampler decodes sRGB before it filters."""
    height, width = texture.image.shape[:2]
    check_size(gpu.gl, (width, height))
    image = texture.image
    if image.shape[2] == 3:
        image = np.concatenate([image, np.full((height, width, 1), 255, np.uint8)], axis=2)
    data = np.ascontiguousarray(flip_rows(image)).tobytes()
    made = gpu.gl.texture((width, height), 4, data, internal_format=SRGB8_ALPHA8 if texture.srgb else None)
    made.build_mipmaps()
    made.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
    made.repeat_x = made.repeat_y = texture.repeat
    return made


class SceneTextures:
    """A scene's textures on the GPU, by index; -1 is white."""

    def __init__(self, gpu: Gpu, scene: Scene) -> None:
        white = Texture("white", np.full((1, 1, 3), 255, np.uint8), srgb=False)
        self._made = [upload_texture(gpu, texture) for texture in (*scene.textures, white)]

    def __getitem__(self, index: int) -> moderngl.Texture:
        return self._made[index]

    def close(self) -> None:
        """Free them."""
        for texture in self._made:
            texture.release()


class SceneBuffers:
    """Some meshes of a scene on the GPU: a vertex buffer, an index buffer and chunks."""

    def __init__(self, gpu: Gpu, meshes: Sequence[Mesh], textures: SceneTextures) -> None:
        self.batches: list[Batch] = []
        self.chunks: Chunks
        self.visibility: Visibility
        indices = self._cut(meshes, textures)
        self._meshes, self._order = meshes, indices
        self._vertices = gpu.gl.buffer(_vertex_rows(meshes).tobytes() or b"\0" * 32)
        self._indices = gpu.gl.buffer(np.concatenate(indices).astype(np.uint32).tobytes() if indices else b"\0" * 12)

    def move_to(self, positions: NDArray) -> None:
        """Move all vertices, (n, 3) in the order of the meshes; visibility follows."""
        rows = _vertex_rows(self._meshes)
        rows[:, :3] = positions
        self._vertices.write(rows.tobytes())
        corners = positions[np.concatenate(self._order)].astype(np.float64)
        low, high = (extreme.reduceat(corners, self.chunks.first, axis=0) for extreme in (np.minimum, np.maximum))
        self.chunks = attrs.evolve(self.chunks, boxes=boxes_of((low + high) / 2, (high - low) / 2))
        self.visibility = Visibility(self.chunks)

    def _cut(self, meshes: Sequence[Mesh], textures: SceneTextures) -> list[NDArray]:
        """Fill batches and chunks; return the chunks' indices."""
        starts = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
        groups: dict[tuple[bool, int], list[tuple[Mesh, int]]] = {}
        for mesh, start in zip(meshes, starts, strict=False):
            groups.setdefault((mesh.double_sided, mesh.texture), []).append((mesh, int(start)))
        indices, batch_of, boxes = [], [], []
        for (double_sided, texture), members in sorted(groups.items(), key=lambda item: item[0]):
            for mesh, start in members:
                for chunk in chunks_of(mesh):
                    corners = mesh.positions[chunk.ravel()].astype(np.float64)
                    boxes.append((corners.min(axis=0), corners.max(axis=0)))
                    indices.append(chunk.ravel() + np.uint32(start))
                    batch_of.append(len(self.batches))
            self.batches.append(Batch(textures[texture], double_sided))
        count = np.array([len(part) for part in indices], np.int64)
        low, high = np.array(boxes, np.float64).reshape(-1, 2, 3).transpose(1, 0, 2)
        around = boxes_of((low + high) / 2, (high - low) / 2)
        self.chunks = Chunks(np.cumsum(count) - count, count, np.array(batch_of, np.int64), around)
        self.visibility = Visibility(self.chunks)
        return indices

    def vertex_array(
        self, gl: moderngl.Context, program: moderngl.Program, *more: tuple[moderngl.Buffer, str, str], colour: bool
    ) -> moderngl.VertexArray:
        """Return the buffers, and `more` as moderngl takes them, as inputs of `program`."""
        names = ("in_position", "in_uv", "in_light") if colour else ("in_position",)
        layout = "3f4 2f4 3f4" if colour else "3f4 20x1"
        return gl.vertex_array(program, [(self._vertices, layout, *names), *more], self._indices, index_element_size=4)

    def close(self) -> None:
        """Free the buffers."""
        self._vertices.release()
        self._indices.release()


def _vertex_rows(meshes: Sequence[Mesh]) -> NDArray[np.float32]:
    rows = [np.concatenate([mesh.positions, mesh.uv, mesh.light], axis=1) for mesh in meshes]
    return np.concatenate([np.empty((0, 8)), *rows]).astype(np.float32)
