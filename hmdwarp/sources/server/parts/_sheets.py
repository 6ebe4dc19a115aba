"""Sheets that are blended over a picture, sorted by triangle for every drawing, farthest first."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ....geometry import Pose, View
from ....gpu.shaders import Draw
from ....gpu.textures import drawing_into, release_all
from ....scenes import Mesh
from ..visibility import clip_from_eye
from . import DrawContext

Array = NDArray[np.float64]
_Place = tuple[bool, int]  # what meshes have in common that stand still to each other: head-locked, body


@attrs.frozen
class Blending:
    # rgb and alpha: factor of the source, factor of the destination.
    factors: tuple[int, int, int, int]
    equation: int = moderngl.FUNC_ADD


_SRC1_COLOR, _SRC1_ALPHA = 0x88F9, 0x8589  # OpenGL's names; moderngl lacks them
OVER_KEEPING_COVERAGE = Blending((moderngl.ONE, _SRC1_COLOR, moderngl.ONE, moderngl.ZERO))
OVER = Blending((moderngl.ONE, _SRC1_COLOR, moderngl.ONE, _SRC1_ALPHA))
THROUGH = Blending((moderngl.ZERO, _SRC1_COLOR, moderngl.ONE, moderngl.ZERO))
MOST = Blending((moderngl.ONE, moderngl.ONE, moderngl.ONE, moderngl.ONE), moderngl.MAX)


# Textures that one draw call can choose from: at least 16 units, fewer the three from 0 on.
_SLOTS, _FIRST_UNIT = 13, 3
_KIND = np.dtype([("clip_from_here", "<f4", (4, 4)), ("passes", "<f4", 4), ("slot", "<u4"), ("one_sided", "<u4", 3)])
_FIELDS = {"position": "3f4", "uv": "2f4", "light": "3f4", "coloured": "3f4", "mesh": "1u4"}  # of a vertex
_VERTEX = np.dtype([(name, f"<{form[1:]}", int(form[0])) for name, form in _FIELDS.items()])


@attrs.frozen(eq=False)
class _Run:
    """Triangles that one call draws: index range, and the texture of each slot."""

    first: int
    count: int
    textures: Mapping[int, int]


@attrs.frozen(eq=False)
class _Order:
    """Runs, farthest first, and eye_from_mesh (4x4) of each mesh."""

    key: tuple[object, ...]
    runs: tuple[_Run, ...]
    eye_from: tuple[Array, ...]


class Sheets:
    """Some meshes of a scene on the GPU, drawn in order of distance.

    All meshes share one index buffer, which one call draws: a vertex knows its mesh, so that those
    in between each other cost no more than those apart. Where the meshes have more textures than
    a call can choose from, it is a call for each run of triangles whose textures fit.

    Triangles that intersect, or large ones close together, may come in the wrong order where they
    overlap. That changes how much of each one's own light is seen; what passes them all, and how
    near they are, does not depend on the order.
    """

    def __init__(self, context: DrawContext, meshes: Sequence[Mesh]) -> None:
        self._context, self._meshes = context, tuple(meshes)
        starts = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
        self._vertices_of = [slice(*ends) for ends in pairwise(starts)]
        self._triangles = np.concatenate(
            [np.empty((0, 3), np.uint32)]
            + [mesh.triangles + np.uint32(start) for mesh, start in zip(meshes, starts, strict=False)]
        )
        self._mesh_of = np.repeat(np.arange(len(meshes)), [len(mesh.triangles) for mesh in meshes])
        self._rows = _rows(self._meshes)
        # (3, m), each coordinate by itself: three times as fast as (m, 3)
        self._middles = np.ascontiguousarray(_middles(self._rows["position"].astype(np.float64), self._triangles))
        self._places = [(mesh.material.head_locked, mesh.body) for mesh in meshes]
        self._textures = sorted({mesh.texture for mesh in meshes})
        self._kinds = np.zeros(len(meshes), _KIND)  # what the shaders know of each mesh, all but its place
        for kind, mesh in zip(self._kinds, meshes, strict=True):
            kind["passes"] = (*mesh.material.tint, mesh.material.opacity)
            kind["slot"], kind["one_sided"] = self._slot(mesh.texture), not mesh.double_sided
        gl = context.gpu.gl
        self._vertices = gl.buffer(self._rows.tobytes() or b"\0" * _VERTEX.itemsize, dynamic=True)
        self._indices = gl.buffer(reserve=max(12, self._triangles.nbytes), dynamic=True)
        self._kinds_on_gpu = gl.buffer(reserve=max(1, len(meshes)) * _KIND.itemsize, dynamic=True)
        self._arrays: dict[moderngl.Program, moderngl.VertexArray] = {}
        self._written_ns: int | None = None
        self._order: _Order | None = None

    def program(self, fragment: str = "pane", **defines: int) -> Draw:
        """Return the program that draws the sheets by a fragment shader of the server."""
        slots = max(1, min(len(self._textures), _SLOTS))
        return self._context.gpu.shaders.draw("server/pane.vert", f"server/{fragment}.frag", SLOTS=slots, **defines)

    def colour(self, *, tests: int = 0, covers: bool = True) -> Draw:
        """Return the program of their colour. tests, covers: see pane.frag."""
        program = self.program(TESTS=tests, COLOUR=1)
        program.uniforms.set(covers=float(covers))
        return program

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

        program: of program() or colour(). blending: None to draw depth, of which the nearest wins.
        hidden_by_surfaces: whether blended sheets are tested against the depth buffer.
        """
        order, gl, vertices = self._ordered(view, time_ns), self._context.gpu.gl, self._array(program)
        if order.runs:
            clip = clip_from_eye(view.fov)
            self._kinds["clip_from_here"] = [(clip @ from_here).T for from_here in order.eye_from]
            self._kinds_on_gpu.write(self._kinds.tobytes())
            self._kinds_on_gpu.bind_to_storage_buffer(0)
        flags = (moderngl.BLEND if blending else 0) | (
            moderngl.DEPTH_TEST if hidden_by_surfaces or blending is None else 0
        )
        if not any(mesh.double_sided for mesh in self._meshes):
            flags |= moderngl.CULL_FACE  # sooner than the shader, which leaves out the backs of the one-sided
        framebuffer.depth_mask = blending is None
        with drawing_into(framebuffer, flags):
            if blending is not None:
                gl.blend_func = blending.factors  # type: ignore[assignment]  # its stub knows two factors
                gl.blend_equation = blending.equation  # type: ignore[assignment]  # the stub wants two
            for run in order.runs:
                for slot, texture in run.textures.items():
                    self._context.textures[texture].use(_FIRST_UNIT + slot)
                vertices.render(moderngl.TRIANGLES, vertices=run.count, first=run.first)
            # Mesa refuses to draw into two textures while a second source is set, blended or not.
            gl.blend_func = moderngl.DEFAULT_BLENDING  # type: ignore[assignment]
            gl.blend_equation = moderngl.FUNC_ADD  # type: ignore[assignment]
        framebuffer.depth_mask = True

    def _slot(self, texture: int) -> int:
        return self._textures.index(texture) % _SLOTS

    def _array(self, program: Draw) -> moderngl.VertexArray:
        if program.program not in self._arrays:
            read = [name for name in _FIELDS if f"in_{name}" in program.program]  # the compiler removes the others
            layout = " ".join(form if name in read else f"{4 * int(form[0])}x" for name, form in _FIELDS.items())
            inputs = [(self._vertices, layout, *(f"in_{name}" for name in read))]
            self._arrays[program.program] = self._context.gpu.gl.vertex_array(
                program.program, inputs, self._indices, index_element_size=4
            )
        return self._arrays[program.program]

    def _ordered(self, view: View, time_ns: int) -> _Order:
        """Return the order, cached for the next call: one picture has several."""
        key = (view.pose, view.head_from_eye, time_ns)
        if self._order is None or any(a is not b and a != b for a, b in zip(self._order.key, key, strict=True)):
            if time_ns != self._written_ns and any(mesh.deformation is not None for mesh in self._meshes):
                for index, mesh in enumerate(self._meshes):
                    if mesh.deformation is not None:
                        positions = np.asarray(mesh.deformation.positions(time_ns), np.float64)
                        positions = positions.reshape(mesh.positions.shape)
                        self._rows["position"][self._vertices_of[index]] = positions
                        self._middles[:, self._mesh_of == index] = _middles(positions, mesh.triangles)
                self._vertices.write(self._rows.tobytes())
                self._written_ns = time_ns
            places = {place: self._eye_from(place, view, time_ns) for place in set(self._places)}
            eye_from = tuple(places[place] for place in self._places)
            self._order = _Order(key, self._sorted(places), eye_from)
        return self._order

    def _eye_from(self, place: _Place, view: View, time_ns: int) -> Array:
        # Head-locked meshes are placed in the head's space.
        scene, (head_locked, body) = self._context.scene, place
        pose = Pose() if head_locked else Pose(scene.origin_m)
        if body:
            pose = scene.bodies[body - 1].motion.state(time_ns).pose
        return pose.relative_to(view.head_from_eye if head_locked else view.pose).matrix()

    def _sorted(self, places: Mapping[_Place, Array]) -> tuple[_Run, ...]:
        """Write the indices by the distance of the triangles' middles; return the runs."""
        if not len(self._triangles):
            return ()
        eyes = {place: -matrix[:3, :3].T @ matrix[:3, 3] for place, matrix in places.items()}
        eye = np.array([eyes[place] for place in self._places]).T
        away = self._middles - (eye[:, :1] if len(eyes) == 1 else eye[:, self._mesh_of])
        away *= away
        order = _farthest_first(away.sum(axis=0))
        self._indices.write(self._triangles.take(order, axis=0).tobytes())
        return tuple(self._runs(order))

    def _runs(self, order: NDArray[np.intp]) -> Iterator[_Run]:
        """Cut a row of triangles where a slot would need another texture than it has."""
        if len(self._textures) <= _SLOTS:
            yield _Run(0, 3 * len(order), {self._slot(texture): texture for texture in self._textures})
            return
        textures = np.array([mesh.texture for mesh in self._meshes])[self._mesh_of[order]]
        slots = {texture: self._slot(texture) for texture in self._textures}
        changes = [0, *(np.flatnonzero(np.diff(textures)) + 1).tolist()]
        first = 0
        used: dict[int, int] = {}
        for at, texture in zip(changes, textures[changes].tolist(), strict=True):
            if used.setdefault(slots[texture], texture) != texture:
                yield _Run(3 * first, 3 * (at - first), used)
                first, used = at, {slots[texture]: texture}
        yield _Run(3 * first, 3 * (len(textures) - first), used)

    def close(self) -> None:
        release_all(*self._arrays.values(), self._vertices, self._indices, self._kinds_on_gpu)


def _middles(positions: Array, triangles: NDArray[np.uint32]) -> Array:
    middles: Array = positions[triangles].mean(axis=1).T
    return middles


def _farthest_first(squared: Array) -> NDArray[np.intp]:
    """Return np.argsort(-squared, kind="stable"), of numbers of 0 or more, in a fifth of the time.

    A radix sort, 16 bits at a time: read as integers, such numbers are in the same order.
    """
    digits = np.ascontiguousarray((~squared.view(np.uint64)).astype("<u8").view("<u2").reshape(-1, 4).T)
    order = np.argsort(digits[0], kind="stable")
    for digit in digits[1:]:
        order = order[np.argsort(digit[order], kind="stable")]
    return order


def _rows(meshes: Sequence[Mesh]) -> NDArray[np.void]:
    rows = np.zeros(sum(len(mesh.positions) for mesh in meshes), _VERTEX)
    # Share of each colour that passes where the mesh covers, its texture apart.
    colours = [np.ones_like(one.light) if one.albedo is None else np.clip(one.albedo, 0, 1) for one in meshes]
    for name, parts in (
        ("position", [mesh.positions for mesh in meshes]),
        ("uv", [mesh.uv for mesh in meshes]),
        ("light", [mesh.light * np.float32(1 - mesh.material.transmission) for mesh in meshes]),
        ("coloured", [mesh.material.transmission * shares for mesh, shares in zip(meshes, colours, strict=True)]),
        ("mesh", [np.full((len(mesh.positions), 1), index) for index, mesh in enumerate(meshes)]),
    ):
        if parts:
            rows[name] = np.concatenate(parts)
    return rows
