"""Sheets (surfaces with holes, overlays, panels, what light passes in part), the occluded, light.

Sheets are blended over a picture, sorted by triangle for every drawing, farthest first. What is
occluded, by depth peeling. Source: Everitt 2001, Interactive Order-Independent Transparency.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, ClassVar

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ....frames import EyeImage, Surface, Transparent
from ....frames.layers import Outbox, Update
from ....frames.layers.panels import PanelDelivery, first_things, things_of, with_showing
from ....geometry import Pose, View
from ....gpu import Draw
from ....gpu.textures import Owner, drawing_into
from ....scenes import Material, Mesh, Panel, Scene, is_cutout, only_light
from ..passes import SAME_SURFACE, Moving, SceneBuffers, ScenePasses, SceneTextures, clip_from_eye, moving_parts
from . import DrawContext, Drawing, Part, Sender, Sending, parts

Array = NDArray[np.float64]
# How source and destination are combined: of rgb and alpha the factor of each, and the equation.
Blending = tuple[tuple[int, int, int, int], int]
_Rgba = tuple[float, float, float, float]
_TWO_DEPTHS = (2, "f4")  # rg32f
_SRC1_COLOR, _SRC1_ALPHA = 0x88F9, 0x8589  # OpenGL's names; moderngl lacks them
_OVER_KEEPING_COVERAGE = (moderngl.ONE, _SRC1_COLOR, moderngl.ONE, moderngl.ZERO), moderngl.FUNC_ADD
_OVER = (moderngl.ONE, _SRC1_COLOR, moderngl.ONE, _SRC1_ALPHA), moderngl.FUNC_ADD
_THROUGH = (moderngl.ZERO, _SRC1_COLOR, moderngl.ONE, moderngl.ZERO), moderngl.FUNC_ADD
_MOST = (moderngl.ONE, moderngl.ONE, moderngl.ONE, moderngl.ONE), moderngl.MAX

# Textures that one draw call can choose from: at least 16 units, fewer the three from 0 on.
_SLOTS, _FIRST_UNIT = 13, 3
_KIND = np.dtype([("clip_from_here", "<f4", (4, 4)), ("passes", "<f4", 4), ("slot", "<u4"), ("one_sided", "<u4", 3)])
_FIELDS = {"position": "3f4", "uv": "2f4", "light": "3f4", "coloured": "3f4", "mesh": "1u4"}  # of a vertex
_VERTEX = np.dtype([(name, f"<{form[1:]}", int(form[0])) for name, form in _FIELDS.items()])
_Run = tuple[int, int, Mapping[int, int]]  # of triangles that one call draws: first index, count, texture of each slot


class Sheets(Owner):
    """Some meshes of a scene on the GPU, drawn in order of distance.

    All share one index buffer, which one call draws, or one for each run of triangles whose
    textures fit. Triangles that intersect, or large ones close together, may come in the wrong
    order: that changes how much of each one's own light is seen, not what passes nor how near.
    """

    def __init__(self, context: DrawContext, meshes: Sequence[Mesh]) -> None:
        self._context, self._meshes = context, tuple(meshes)
        starts = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
        self._vertices_of = [slice(*ends) for ends in pairwise(starts)]
        triangles = [mesh.triangles + np.uint32(start) for mesh, start in zip(meshes, starts, strict=False)]
        self._triangles = np.concatenate([np.empty((0, 3), np.uint32), *triangles])
        self._mesh_of = np.repeat(np.arange(len(meshes)), [len(mesh.triangles) for mesh in meshes])
        self._rows = np.zeros(int(starts[-1]), _VERTEX)
        # Share of each colour that passes where the mesh covers, its texture apart.
        colours = [np.ones_like(one.light) if one.albedo is None else np.clip(one.albedo, 0, 1) for one in meshes]
        for index, (mesh, ends) in enumerate(zip(meshes, self._vertices_of, strict=True)):
            transmission, rows = mesh.material.transmission, self._rows[ends]
            rows["position"], rows["uv"], rows["mesh"] = mesh.positions, mesh.uv, index
            rows["light"], rows["coloured"] = mesh.light * np.float32(1 - transmission), transmission * colours[index]
        # (3, m), each coordinate by itself: three times as fast as (m, 3)
        self._middles = np.ascontiguousarray(_middles(self._rows["position"].astype(np.float64), self._triangles))
        self._places = [(mesh.material.head_locked, mesh.body) for mesh in meshes]
        self._textures = sorted({mesh.texture for mesh in meshes})
        self._kinds = np.zeros(len(meshes), _KIND)  # what the shaders know of each mesh, all but its place
        for kind, mesh in zip(self._kinds, meshes, strict=True):
            kind["passes"] = (*mesh.material.tint, mesh.material.opacity)
            kind["slot"], kind["one_sided"] = self._slot(mesh.texture), not mesh.double_sided
        gl = context.gpu.gl
        self._vertices = self.own(gl.buffer(self._rows.tobytes() or b"\0" * _VERTEX.itemsize, dynamic=True))
        self._indices = self.own(gl.buffer(reserve=max(12, self._triangles.nbytes), dynamic=True))
        self._kinds_on_gpu = self.own(gl.buffer(reserve=max(1, len(meshes)) * _KIND.itemsize, dynamic=True))
        self._arrays: dict[moderngl.Program, moderngl.VertexArray] = {}
        self._written_ns: int | None = None
        # For one picture, which has several drawings: its key, the runs, and eye_from_mesh of each.
        self._order: tuple[tuple[object, ...], list[_Run], list[Array]] = ((), [], [])

    def program(self, fragment: str = "pane", **defines: int) -> Draw:
        slots = max(1, min(len(self._textures), _SLOTS))
        return self._context.gpu.shaders.draw("server/pane.vert", f"server/{fragment}.frag", SLOTS=slots, **defines)

    def colour(self, tests: int = 0, eye: EyeImage | None = None, *, covers: bool = True) -> Draw:
        """Return the program of their colour. tests, covers: see pane.frag; eye: tested against."""
        program = self.program(TESTS=tests, COLOUR=1)
        program.uniforms.set(covers=float(covers))
        return program if eye is None else self.tested(program, eye, tests)

    def tested(self, program: Draw, eye: EyeImage, tests: int) -> Draw:
        """Return a program that tests against the depth of an eye's picture."""
        eye.inverse_depth.use(1)
        program.uniforms.set(picture=1, keep=1 - SAME_SURFACE, **({"nearest": 2} if tests == 2 else {}))
        return program

    def draw(
        self,
        program: Draw,
        view: View,
        time_ns: int,
        into: moderngl.Texture,
        blending: Blending | None,
        *,
        empty: _Rgba | None = None,
        hidden_by_surfaces: bool = False,
    ) -> None:
        """Draw all sheets, farthest first; without blending depth, of which the nearest wins."""
        (_, runs, eye_from), gl, vertices = self._ordered(view, time_ns), self._context.gpu.gl, self._array(program)
        framebuffer = self._context.framebuffers.over(into)
        if empty is not None:
            with drawing_into(framebuffer):
                framebuffer.clear(color=empty)
        if runs:
            clip = clip_from_eye(view.fov)
            self._kinds["clip_from_here"] = [(clip @ from_here).T for from_here in eye_from]
            self._kinds_on_gpu.write(self._kinds.tobytes())
            self._kinds_on_gpu.bind_to_storage_buffer(0)
        tests_depth = hidden_by_surfaces or blending is None
        flags = (moderngl.BLEND if blending else 0) | (moderngl.DEPTH_TEST if tests_depth else 0)
        if not any(mesh.double_sided for mesh in self._meshes):
            flags |= moderngl.CULL_FACE  # sooner than the shader, which leaves out the backs of the one-sided
        framebuffer.depth_mask = blending is None
        with drawing_into(framebuffer, flags):
            if blending is not None:
                # The stubs know two factors, and want two equations.
                gl.blend_func, gl.blend_equation = blending  # type: ignore[assignment]
            for first, count, textures in runs:
                for slot, texture in textures.items():
                    self._context.textures[texture].use(_FIRST_UNIT + slot)
                vertices.render(moderngl.TRIANGLES, vertices=count, first=first)
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
            gl, key = self._context.gpu.gl, program.program
            self._arrays[key] = self.own(gl.vertex_array(key, inputs, self._indices, index_element_size=4))
        return self._arrays[program.program]

    def _ordered(self, view: View, time_ns: int) -> tuple[object, list[_Run], list[Array]]:
        """Return the order, and write the indices by the distance of the triangles' middles."""
        key = (view.pose, view.head_from_eye, time_ns)
        before = self._order[0]
        if before and all(a is b or a == b for a, b in zip(before, key, strict=True)):
            return self._order
        deforming = [(index, mesh) for index, mesh in enumerate(self._meshes) if mesh.deformation is not None]
        if time_ns != self._written_ns and deforming:
            for index, mesh in deforming:
                assert mesh.deformation is not None
                positions = np.asarray(mesh.deformation.positions(time_ns), np.float64).reshape(mesh.positions.shape)
                self._rows["position"][self._vertices_of[index]] = positions
                self._middles[:, self._mesh_of == index] = _middles(positions, mesh.triangles)
            self._vertices.write(self._rows.tobytes())
            self._written_ns = time_ns
        scene, places = self._context.scene, {}
        for head_locked, body in set(self._places):  # head-locked meshes are placed in the head's space
            pose = Pose() if head_locked else Pose(scene.origin_m)
            if body:
                pose = scene.bodies[body - 1].motion.state(time_ns).pose
            places[head_locked, body] = pose.relative_to(view.head_from_eye if head_locked else view.pose).matrix()
        runs: list[_Run] = []
        if len(self._triangles):
            eyes = {place: -matrix[:3, :3].T @ matrix[:3, 3] for place, matrix in places.items()}
            eye = np.array([eyes[place] for place in self._places]).T
            away = self._middles - (eye[:, :1] if len(eyes) == 1 else eye[:, self._mesh_of])
            away *= away
            order = _farthest_first(away.sum(axis=0))
            self._indices.write(self._triangles.take(order, axis=0).tobytes())
            runs = list(self._runs(order))
        self._order = key, runs, [places[place] for place in self._places]
        return self._order

    def _runs(self, order: NDArray[np.intp]) -> Iterator[_Run]:
        """Cut a row of triangles where a slot would need another texture than it has."""
        if len(self._textures) <= _SLOTS:
            yield 0, 3 * len(order), {self._slot(texture): texture for texture in self._textures}
            return
        textures = np.array([mesh.texture for mesh in self._meshes])[self._mesh_of[order]]
        slots = {texture: self._slot(texture) for texture in self._textures}
        changes = [0, *(np.flatnonzero(np.diff(textures)) + 1).tolist()]
        first = 0
        used: dict[int, int] = {}
        for at, texture in zip(changes, textures[changes].tolist(), strict=True):
            if used.setdefault(slots[texture], texture) != texture:
                yield 3 * first, 3 * (at - first), used
                first, used = at, {slots[texture]: texture}
        yield 3 * first, 3 * (len(textures) - first), used


def _middles(positions: Array, triangles: NDArray[np.uint32]) -> Array:
    middles: Array = positions[triangles].mean(axis=1).T
    return middles


def _farthest_first(squared: Array) -> NDArray[np.intp]:
    """Return np.argsort(-squared, kind="stable") by a radix sort, in a fifth of the time."""
    digits = np.ascontiguousarray((~squared.view(np.uint64)).astype("<u8").view("<u2").reshape(-1, 4).T)
    order = np.argsort(digits[0], kind="stable")
    for digit in digits[1:]:
        order = order[np.argsort(digit[order], kind="stable")]
    return order


class _SheetsPart(Part):
    has: ClassVar[staticmethod[[Scene, Mesh], bool]]  # whether a mesh of the scene is one of its sheets

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        scene = context.scene
        self._sheets = self.own(Sheets(context, [mesh for mesh in scene.meshes if self.has(scene, mesh)]))

    @classmethod
    def in_scene(cls, scene: Scene) -> bool:
        return any(cls.has(scene, mesh) for mesh in scene.meshes)


@parts.register
class Cutouts(_SheetsPart):
    """Drawn before all other parts, against the surfaces' depth, not as part of a veil."""

    name, order = "cutouts", 0
    has = staticmethod(is_cutout)

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        program = self._sheets.colour()
        self._sheets.draw(program, eye.view, eye.drawn_ns, eye.colour, _OVER_KEEPING_COVERAGE, hidden_by_surfaces=True)
        self.add_depth(eye.view, eye.drawn_ns, eye.inverse_depth)
        return eye

    def add_depth(self, view: View, time_ns: int, into: moderngl.Texture) -> None:
        self._sheets.draw(self._sheets.program("cutout"), view, time_ns, into, None)


@parts.register
class Overlay(_SheetsPart):
    name, order = "overlay", 95
    has = staticmethod(lambda _, mesh: mesh.material.head_locked)

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        if "overlay" not in drawing.needs:
            program = self._sheets.colour()
            self._sheets.draw(program, eye.view, drawing.time_ns, eye.colour, _OVER_KEEPING_COVERAGE)
            return eye
        into = self.context.acquire(drawing.shown_size or drawing.size, depth=False).colour
        program = self._sheets.colour(covers=False)
        self._sheets.draw(program, drawing.view, drawing.time_ns, into, _OVER, empty=(0.0, 0.0, 0.0, 0.0))
        return eye.having(overlay=into)


@parts.register
class Transparency(_SheetsPart):
    """Blended in, sheets keep the depth behind; as a layer they are one veil at the nearest."""

    name, order = "transparency", 70
    has = staticmethod(lambda scene, mesh: mesh.material.see_through and not is_cutout(scene, mesh))

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        sheets, view, time_ns = self._sheets, eye.view, eye.drawn_ns
        if "transparent" not in drawing.needs:
            sheets.draw(sheets.colour(1, eye), view, time_ns, eye.colour, _OVER_KEEPING_COVERAGE)
            return eye
        veil, passing = self.context.acquire(eye.size), self.context.acquire(eye.size, depth=False).colour
        nearest = self.kept("nearest", eye.size, _TWO_DEPTHS, depth=False).colour
        depths = sheets.tested(sheets.program(TESTS=1, COLOUR=0), eye, 1)
        sheets.draw(depths, view, time_ns, nearest, _MOST, empty=(-1.0, -1.0, 0.0, 0.0))
        # Write the depth of the nearest sheet that is not hidden, else of the nearest of all.
        nearest.bind_to_image(0, read=True, write=False)
        veil.inverse_depth.bind_to_image(1, read=False, write=True)
        program = self.context.gpu.shaders.compute("server/veil_depth.comp")
        program.uniforms.set(nearest=0, inverse_depth=1)
        program.run(*veil.inverse_depth.size)
        self.context.gpu.barrier()
        nearest.use(2)
        for into, through, blending in ((veil.colour, 0.0, _OVER_KEEPING_COVERAGE), (passing, 1.0, _THROUGH)):
            empty = (through, through, through, 0.0)
            sheets.draw(sheets.colour(2, eye), view, time_ns, into, blending, empty=empty)
        return eye.having(transparent=Transparent(Surface(veil.colour, veil.inverse_depth), passing))


@parts.register
class Peeled(Part):
    """Surfaces behind the picture's own, nearest first, without what the client moves."""

    name, order = "peeled", 100

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._passes: dict[tuple[ScenePasses, tuple[Moving, ...]], ScenePasses] = {}

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        plain = self.context.passes_for(drawing)
        moving = tuple(mover for mover in plain.moving if mover.layer not in drawing.needs)
        if (plain, moving) not in self._passes:
            self._passes[plain, moving] = self.own(plain.peeling(moving))
        passes = self._passes[plain, moving]
        before, surfaces = eye.inverse_depth, []
        for _ in range(drawing.needs["peeled"]):
            target = self.context.acquire(eye.size)
            before.use(1)
            into = self.context.framebuffers.over(target.colour, target.inverse_depth)
            passes.draw(eye.view, into, eye.drawn_ns, in_front=1, keep=1 - SAME_SURFACE)
            surfaces.append(Surface(target.colour, target.inverse_depth))
            before = target.inverse_depth
        return eye.having(peeled=tuple(surfaces))


@parts.register
class Light(Part):
    name, order = "light", -1  # before cut-outs, which it would draw over

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        gpu, scene = context.gpu, only_light(context.scene)
        textures = self.own(SceneTextures(gpu, scene))
        still = [mesh for mesh in scene.meshes if mesh.is_surface and mesh.stands_still]
        buffers = self.own(SceneBuffers(gpu, still, textures))
        moving = [self.own(one) for one in moving_parts(gpu, scene, textures)]
        # Lamps light it as they light the scene itself: between white surfaces there is more light.
        lighting = context.colour.lighting
        self._passes = self.own(ScenePasses(gpu, scene, buffers, colour=True, moving=moving, lighting=lighting))

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        if "light" not in drawing.needs:
            return eye
        self.context.draw_colour(self._passes, eye.view, eye.colour, eye.drawn_ns)
        return eye.having(light=True)


@parts.register
class Panels(Sending[PanelDelivery, "_PanelSender"]):
    """Sheets at their own places, the farthest first; in the world with a depth of their own."""

    name, order = "panels", 88

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._drawn: list[_DrawnPanel] | None = None

    @classmethod
    def in_scene(cls, scene: Scene) -> bool:
        return bool(scene.panels)

    def make_sender(self, wanted: PanelDelivery) -> _PanelSender:
        return _PanelSender(self.context.scene.panels, wanted)

    def of_frame(self, views: Sequence[View], drawing: Drawing) -> Mapping[str, Any]:
        updates = {wanted: self.sender(wanted).update(drawing.time_ns) for wanted in self.needed(drawing)}
        return {"panels": updates} if updates else {}

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        if "panels" not in drawing.needs:
            if self._drawn is None:
                self._drawn = [self.own(_DrawnPanel(self.context, panel)) for panel in self.context.scene.panels]
            for drawn in sorted(self._drawn, key=lambda one: -one.panel.away_m(eye.view)):
                drawn.draw(eye)
        return eye


class _DrawnPanel(Owner):
    """One panel as sheets of a scene of its own, whose origin is the panel's place."""

    def __init__(self, context: DrawContext, panel: Panel) -> None:
        self.panel, self._gpu = panel, context.gpu
        origin = (0.0, 0.0, 0.0) if panel.head_locked else panel.pose.position_m
        of_pose = panel.pose if panel.head_locked else attrs.evolve(panel.pose, position_m=(0.0, 0.0, 0.0))
        material = Material(see_through=not panel.head_locked, head_locked=panel.head_locked)
        mesh = panel.quad.mesh("panel")
        mesh = attrs.evolve(
            mesh, positions=of_pose.transform(mesh.positions), double_sided=False, material=material, albedo=None
        )
        meshes = [attrs.evolve(mesh, texture=index) for index in range(len(panel.pictures))]
        scene = Scene("panel", "", meshes, panel.pictures, origin_m=origin)
        own = attrs.evolve(context, scene=scene, textures=self.own(SceneTextures(context.gpu, scene, lent=True)))
        self._sheets = [self.own(Sheets(own, [mesh])) for mesh in scene.meshes]

    def draw(self, eye: EyeImage) -> None:
        """Draw it over the picture of an eye, whose inverse depth is bound."""
        sheets, panel = self._sheets[self.panel.showing(eye.drawn_ns)], self.panel
        program = sheets.colour(int(panel.occluded), eye if panel.occluded else None)
        sheets.draw(program, eye.view, eye.drawn_ns, eye.colour, _OVER_KEEPING_COVERAGE)
        if not panel.head_locked:
            sheets.draw(sheets.program("cutout"), eye.view, eye.drawn_ns, eye.inverse_depth, _MOST)
            self._gpu.barrier()  # llvmpipe lets shaders read inverse depth as it was before


class _PanelSender(Sender):
    def __init__(self, panels: Sequence[Panel], wanted: PanelDelivery) -> None:
        self._panels, self._wanted = panels, wanted
        self._first = first_things(panels)
        self.book = Outbox(things_of(panels))

    def _needed(self, now_ns: int) -> list[int]:
        shown = (first + each.showing(now_ns) for first, each in zip(self._first, self._panels, strict=True))
        return [0, *shown] if self._panels else []

    def has_more(self, now_ns: int) -> bool:
        self.book.settle(now_ns)
        return not self.book.waiting.isdisjoint(self._needed(now_ns))

    def update(self, now_ns: int) -> Update:
        self.book.settle(now_ns)
        update = self.book.update(self._needed(now_ns), self._wanted.budget, now_ns)
        return with_showing(update, now_ns, [each.showing(now_ns) for each in self._panels])
