"""Sheets that are blended over a picture, sorted by triangle for every drawing, farthest first."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ...geometry import Pose
from ...gpu.scopes import drawing_into
from ..projection import clip_from_eye

if TYPE_CHECKING:
    from ...geometry import View
    from ...gpu.shaders import Draw
    from ...scenes import Mesh
    from ._base import DrawContext

Blending = tuple[int, int, int, int]
# rgb and alpha: factor of the source, factor of the destination. OpenGL's numbers: moderngl lacks
# the names.
_SRC1_COLOR, _SRC1_ALPHA = 0x88F9, 0x8589
OVER_KEEPING_COVERAGE = (moderngl.ONE, _SRC1_COLOR, moderngl.ONE, moderngl.ZERO)
OVER = (moderngl.ONE, _SRC1_COLOR, moderngl.ONE, _SRC1_ALPHA)
THROUGH = (moderngl.ZERO, _SRC1_COLOR, moderngl.ONE, moderngl.ZERO)


@attrs.frozen(eq=False)
class _Run:
    """Triangles of one mesh that are drawn in one call: index range and mesh number."""

    mesh: int
    first: int
    count: int


class Sheets:
    """Some meshes of a scene on the GPU, drawn in order of distance.

    Triangles that intersect, or large ones close together, may come in the wrong order where they
    overlap.
    """

    def __init__(self, context: DrawContext, meshes: Sequence[Mesh]) -> None:
        self._context, self._meshes = context, tuple(meshes)
        self._starts = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
        self._positions = [mesh.positions.astype(np.float64) for mesh in meshes]
        gl = context.gpu.gl
        self._vertices = gl.buffer(_rows(self._meshes).tobytes() or b"\0" * 32, dynamic=True)
        self._indices = gl.buffer(reserve=12 * max(1, sum(len(mesh.triangles) for mesh in meshes)), dynamic=True)
        self._arrays: dict[moderngl.Program, moderngl.VertexArray] = {}
        self._written_ns: int | None = None
        self._order: tuple[tuple, list[_Run], list[NDArray]] | None = None

    def draw(
        self,
        program: Draw,
        view: View,
        time_ns: int,
        framebuffer: moderngl.Framebuffer,
        blending: Blending | None,
        *,
        hidden_by_surfaces: bool = False,
    ) -> None:
        """Draw all sheets of `view` at that instant, farthest first.

        blending: None to draw depth, of which the nearest wins. hidden_by_surfaces: whether blended
        sheets are tested against the depth buffer.
        """
        runs, eye_from = self._ordered(view, time_ns)
        gl, clip = self._context.gpu.gl, clip_from_eye(view.fov)
        vertices = self._array(program)
        flags = (moderngl.BLEND if blending else 0) | (
            moderngl.DEPTH_TEST if hidden_by_surfaces or blending is None else 0
        )
        framebuffer.depth_mask = blending is None
        with drawing_into(framebuffer, flags):
            if blending is not None:
                gl.blend_func = blending  # type: ignore[assignment]  # its stub knows two factors
            for run in runs:
                mesh = self._meshes[run.mesh]
                (gl.disable if mesh.double_sided else gl.enable)(moderngl.CULL_FACE)
                self._context.textures[mesh.texture].use(0)
                tint = {"tint": mesh.material.tint} if program.uniforms.declares("tint") else {}
                program.uniforms.set(
                    clip_from_scene=clip @ eye_from[run.mesh], surface=0, opacity=mesh.material.opacity, **tint
                )
                vertices.render(moderngl.TRIANGLES, vertices=run.count, first=run.first)
            # Mesa refuses to draw into two textures while a second source is set, blended or not.
            gl.blend_func = moderngl.DEFAULT_BLENDING  # type: ignore[assignment]
        framebuffer.depth_mask = True

    def _array(self, program: Draw) -> moderngl.VertexArray:
        if program.program not in self._arrays:
            lit = "in_light" in program.program  # the compiler removes it when only depth is drawn
            layout, names = ("3f4 2f4 3f4", ("in_light",)) if lit else ("3f4 2f4 12x", ())
            inputs = [(self._vertices, layout, "in_position", "in_uv", *names)]
            self._arrays[program.program] = self._context.gpu.gl.vertex_array(
                program.program, inputs, self._indices, index_element_size=4
            )
        return self._arrays[program.program]

    def _ordered(self, view: View, time_ns: int) -> tuple[list[_Run], list[NDArray]]:
        """Return the runs, farthest first, and eye_from_mesh (4x4) of each mesh.

        Cached for the next call: the draws of one picture follow each other.
        """
        key = (view.pose, view.head_from_eye, time_ns)
        if self._order is None or any(a is not b and a != b for a, b in zip(self._order[0], key, strict=True)):
            self._deform(time_ns)
            eye_from = [self._eye_from(mesh, view, time_ns) for mesh in self._meshes]
            self._order = (key, self._sorted(eye_from), eye_from)
        return self._order[1:]

    def _deform(self, time_ns: int) -> None:
        if time_ns == self._written_ns or all(mesh.deformation is None for mesh in self._meshes):
            return
        for index, mesh in enumerate(self._meshes):
            if mesh.deformation is not None:
                self._positions[index] = np.asarray(mesh.deformation.positions(time_ns), np.float64).reshape(
                    mesh.positions.shape
                )
        rows = _rows(self._meshes)
        rows[:, :3] = np.concatenate(self._positions)
        self._vertices.write(rows.tobytes())
        self._written_ns = time_ns

    def _eye_from(self, mesh: Mesh, view: View, time_ns: int) -> NDArray[np.float64]:
        """Return 4x4, relative to the eye before any rotation.

        Head-locked meshes are placed in the head's space.
        """
        scene = self._context.scene
        place = Pose() if mesh.material.head_locked else Pose(scene.origin_m)
        if mesh.body:
            place = scene.bodies[mesh.body - 1].motion.state(time_ns).pose
        return place.relative_to(view.head_from_eye if mesh.material.head_locked else view.pose).matrix()

    def _sorted(self, eye_from: Sequence[NDArray]) -> list[_Run]:
        """Write the indices by the distance of the triangles' middles; return the runs."""
        if not self._meshes:
            return []
        squared = []
        for mesh, positions, matrix in zip(self._meshes, self._positions, eye_from, strict=True):
            middle = positions[mesh.triangles].mean(axis=1) @ matrix[:3, :3].T + matrix[:3, 3]
            squared.append((middle**2).sum(axis=1))
        order = np.argsort(-np.concatenate(squared), kind="stable")
        pieces = [mesh.triangles + np.uint32(start) for mesh, start in zip(self._meshes, self._starts, strict=False)]
        owner = np.repeat(np.arange(len(pieces)), [len(piece) for piece in pieces])[order]
        self._indices.write(np.concatenate(pieces)[order].astype(np.uint32).tobytes() or b"\0" * 12)
        return list(_runs(owner))

    def close(self) -> None:
        """Free the buffers."""
        for vertices in self._arrays.values():
            vertices.release()
        self._vertices.release()
        self._indices.release()


def _runs(owner: NDArray) -> Iterator[_Run]:
    borders = np.flatnonzero(np.diff(owner)) + 1
    for start, stop in zip([0, *borders], [*borders, len(owner)], strict=True):
        if stop > start:
            yield _Run(int(owner[start]), 3 * int(start), 3 * int(stop - start))


def _rows(meshes: Sequence[Mesh]) -> NDArray[np.float32]:
    rows = [np.concatenate([mesh.positions, mesh.uv, mesh.light], axis=1) for mesh in meshes]
    return np.concatenate([np.empty((0, 8)), *rows]).astype(np.float32)
