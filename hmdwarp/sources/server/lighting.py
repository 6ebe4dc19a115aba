"""Light of moving lamps on the GPU, for the passes that draw a scene."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ...gpu.context import Gpu
from ...gpu.shaders import Inputs, Uniforms
from ...gpu.textures import COLOUR, allocate
from ...scenes import ATLAS, MOST_LAMPS, Mesh, Scene, blockers_of, indirect_atlas, lamps_at, receivers_of

INDIRECT_UNIT, BLOCKERS_UNIT, SPLATS_UNIT = 6, 7, 8


class Indirect(enum.Enum):
    """Where the indirect light of a scene with lamps comes from, by the defines of shaders."""

    # Solved for the instant that is drawn; the light atlas `Lighting.indirect`, which its owner
    # sets; a picture of it, `Lighting.splats`.
    OWN, ATLAS, SPLATS = "own", "atlas", "splats"
    # A grid of voxels, see parts/voxels.py.
    VOXELS = "voxels"
    # Nowhere: in place of colour, drawn are the normal and what `Lighting.indirect` holds.
    RECEIVERS = "receivers"


_DEFINES = {
    Indirect.SPLATS: ("LAMPS", "SPLATTED"),
    Indirect.VOXELS: ("LAMPS", "VOXELS"),
    Indirect.RECEIVERS: ("RECEIVERS",),
}


class Lighting:
    """Direct and indirect light of a scene with lamps.

    most_blockers: triangles that stop light, at most; None for those of the scene.
    """

    def __init__(
        self, gpu: Gpu, scene: Scene, source: Indirect = Indirect.OWN, most_blockers: int | None = None
    ) -> None:
        self._gl, self._scene, self.source = gpu.gl, scene, source
        self._own = allocate(gpu.gl, ATLAS, COLOUR) if source is Indirect.OWN else None
        self.indirect = self._own
        self.splats: Inputs | None = None
        if most_blockers is None:
            most_blockers = len(receivers_of(scene).blockers.corners)
        self._blockers = gpu.gl.texture((3, max(1, most_blockers)), 4, dtype="f4")
        self._written = b""
        self._blockers.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._light: bytes = b""
        self._buffers: list[tuple[Sequence[Mesh], moderngl.Buffer]] = []

    def _rows(self, time_ns: int) -> NDArray[np.float64]:
        """Return (n, 3, 4), the rows of each triangle that stops light at an instant."""
        return receivers_of(self._scene, time_ns).blockers.rows

    def _atlas(self, time_ns: int) -> NDArray[np.float16]:
        """Return the indirect light of an instant as the light atlas."""
        return indirect_atlas(self._scene, time_ns)

    def more(self, meshes: Sequence[Mesh], *, albedo: bool = True) -> tuple[Any, ...]:
        """Return further inputs of the vertex stage, as moderngl takes them.

        albedo: whether the shader reads it.
        """
        buffer = self._gl.buffer(_all_rows(meshes))
        self._buffers.append((meshes, buffer))
        if not albedo:
            return (buffer, "3f4 2f4 12x1", "in_normal", "in_light_uv")
        return (buffer, "3f4 2f4 3f4", "in_normal", "in_light_uv", "in_albedo")

    @property
    def defines(self) -> dict[str, object]:
        """Defines of the scene's shaders."""
        return dict.fromkeys(_DEFINES.get(self.source, ("LAMPS",)), 1)

    def use(self, uniforms: Uniforms, time_ns: int) -> None:
        """Set the uniforms and bind the textures for an instant."""
        light = self.use_lamps(uniforms, time_ns) if self.source is not Indirect.RECEIVERS else b""
        if self.source is Indirect.SPLATS:
            assert self.splats is not None, "splats are set before anything is drawn"
            self.splats.use(uniforms, SPLATS_UNIT)
            return
        if self._own is not None and self._light != light:
            self._own.write(self._atlas(time_ns).tobytes())
            self._light = light
        assert self.indirect is not None, "late indirect light is set before anything is drawn"
        uniforms.set(indirect=INDIRECT_UNIT, texels=self.indirect.width / ATLAS[0])
        self.indirect.use(INDIRECT_UNIT)

    def use_lamps(self, uniforms: Uniforms, time_ns: int) -> bytes:
        """Set what direct light takes, for an instant; return what tells its light apart."""
        blocking = self._rows(time_ns)
        rows = blocking.astype(np.float32).tobytes()
        if rows != self._written:
            self._blockers.write(rows, viewport=(0, 0, 3, len(blocking)))
            self._written = rows
        lamps = lamps_at(self._scene, time_ns)
        places, colours = np.zeros((MOST_LAMPS, 4), np.float32), np.zeros((MOST_LAMPS, 4), np.float32)
        for number, (place, colour) in enumerate(lamps):
            places[number], colours[number, :3] = place, colour
        uniforms.set(
            lamp_place=places.ravel(),
            lamp_colour=colours.ravel(),
            lamp_count=len(lamps),
            blocker_count=len(blocking),
            blockers=BLOCKERS_UNIT,
        )
        self._blockers.use(BLOCKERS_UNIT)
        return places.tobytes() + rows

    def close(self) -> None:
        """Free its textures and buffers."""
        for each in (self._blockers, self._own, *(buffer for _, buffer in self._buffers)):
            if each is not None:
                each.release()


class ArrivingLight(Lighting):
    """Light of a scene whose meshes arrive: what is here stops the lamps' light.

    scene: its lamps stand still; its meshes may be empty. atlas: indirect light of the whole scene.
    most_blockers: see Lighting.
    """

    def __init__(self, gpu: Gpu, scene: Scene, atlas: NDArray[np.float16], most_blockers: int) -> None:
        super().__init__(gpu, scene, most_blockers=most_blockers)
        self._whole, self._here = atlas, np.empty((0, 3, 4))

    def put(self, meshes: Sequence[Mesh]) -> None:
        """Light, and shade by, these meshes from now on; buffers have theirs already."""
        self._here = blockers_of(self._scene, meshes).rows
        for those, buffer in self._buffers:
            buffer.write(_all_rows(those))

    def _rows(self, time_ns: int) -> NDArray[np.float64]:
        return self._here

    def _atlas(self, time_ns: int) -> NDArray[np.float16]:
        return self._whole


def _all_rows(meshes: Sequence[Mesh]) -> bytes:
    """Return the rows of all meshes; of none, those of one vertex that no triangle has."""
    rows = [_vertex_rows(mesh) for mesh in meshes]
    return np.concatenate([np.empty((0, 8)), *rows]).astype(np.float32).tobytes() or b"\0" * 32


def _vertex_rows(mesh: Mesh) -> NDArray[np.float32]:
    """Return (n, 8): normal, place in the light atlas (-1 for none) and albedo."""
    count = len(mesh.positions)
    places = mesh.light_uv if mesh.light_uv is not None else np.full((count, 2), -1.0)
    albedo = mesh.albedo if mesh.albedo is not None else np.full((count, 3), 0.5)
    return np.concatenate([mesh.normals, places, albedo], axis=1).astype(np.float32)
