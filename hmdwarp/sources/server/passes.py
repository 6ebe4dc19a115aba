"""Draw a scene's surfaces and its background into any framebuffer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import moderngl
import numpy as np
from numpy.typing import NDArray

from ...geometry import View
from ...geometry.cube import FACES, face_views
from ...gpu.context import Gpu
from ...gpu.shaders import Draw, Uniforms
from ...gpu.textures import COLOUR, allocate, drawing_into, release_all
from ...scenes import ATLAS, MOST_LAMPS, Mesh, Scene, blocking, indirect_atlas, lamps_at
from .upload import STAYS, Moving, Place, SceneBuffers, emits
from .visibility import Draws, Visibility, clip_from_eye, draws_of, eye_from_scene, visible, world_from_ndc

EMISSION_UNIT = 3  # above those of lib/lamps.glsl, which scenes without emission alone have
INDIRECT_UNIT, BLOCKERS_UNIT = 6, 7
Viewport = tuple[int, int, int, int]  # x, y, w, h in pixels


class Lighting:
    """Direct light of lamps; subclasses add the rest. most_blockers: triangles in its way."""

    defines: ClassVar[tuple[str, ...]] = ("LAMPS",)  # of shaders, for where it is
    coloured: ClassVar[bool] = True  # whether colours are drawn, or data in their place

    def __init__(self, gpu: Gpu, scene: Scene, most_blockers: int | None = None) -> None:
        self._gl, self._scene = gpu.gl, scene
        if most_blockers is None:
            most_blockers = len(blocking(scene))
        self._blockers = gpu.gl.texture((3, max(1, most_blockers)), 4, dtype="f4")
        self._written = b""
        self._blockers.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self._buffers: list[tuple[Sequence[Mesh], moderngl.Buffer]] = []

    def _rows(self, time_ns: int) -> NDArray[np.float64]:
        return blocking(self._scene, time_ns)

    def more(self, meshes: Sequence[Mesh], *, albedo: bool = True) -> tuple[Any, ...]:
        """Return further inputs of the vertex stage, as moderngl takes them, albedo if read."""
        buffer = self._gl.buffer(_all_rows(meshes))
        self._buffers.append((meshes, buffer))
        if not albedo:
            return (buffer, "3f4 2f4 12x1", "in_normal", "in_light_uv")
        return (buffer, "3f4 2f4 3f4", "in_normal", "in_light_uv", "in_albedo")

    def use(self, uniforms: Uniforms, view: View, viewport: Viewport, time_ns: int) -> None:
        """Set the uniforms and bind the textures for a view at an instant."""
        raise NotImplementedError

    def use_atlas(self, uniforms: Uniforms, atlas: moderngl.Texture) -> None:
        """Take indirect light from an atlas, as fine as the scene's or finer."""
        uniforms.set(indirect=INDIRECT_UNIT, texels=atlas.width / ATLAS[0])
        atlas.use(INDIRECT_UNIT)

    def use_lamps(self, uniforms: Uniforms, time_ns: int) -> bytes:
        """Set what direct light takes, for an instant; return what tells its light apart."""
        blocking = self._rows(time_ns)
        rows = blocking.astype(np.float32).tobytes()
        if rows != self._written:
            self._blockers.write(rows, viewport=(0, 0, 3, len(blocking)))
            self._written = rows
        lamps = lamps_at(self._scene, time_ns)
        places, cones, colours = np.zeros((3, MOST_LAMPS, 4), np.float32)
        for number, (place, colour) in enumerate(lamps):
            places[number], cones[number], colours[number, :3] = place[:4], place[4:], colour
        uniforms.set(
            lamp_place=places.ravel(),
            lamp_cone=cones.ravel(),
            lamp_colour=colours.ravel(),
            lamp_count=len(lamps),
            blocker_count=len(blocking),
            blockers=BLOCKERS_UNIT,
        )
        self._blockers.use(BLOCKERS_UNIT)
        return places.tobytes() + cones.tobytes() + colours.tobytes() + rows

    def close(self) -> None:
        release_all(self._blockers, *(buffer for _, buffer in self._buffers))


class ConvergedLight(Lighting):
    """With indirect light that is solved for the instant that is drawn."""

    def __init__(self, gpu: Gpu, scene: Scene, most_blockers: int | None = None) -> None:
        super().__init__(gpu, scene, most_blockers)
        self._indirect = allocate(gpu.gl, ATLAS, COLOUR)
        self._light = b""

    def _atlas(self, time_ns: int) -> NDArray[np.float16]:
        return indirect_atlas(self._scene, time_ns)

    def use(self, uniforms: Uniforms, view: View, viewport: Viewport, time_ns: int) -> None:
        light = self.use_lamps(uniforms, time_ns)
        if self._light != light:
            self._indirect.write(self._atlas(time_ns).tobytes())
            self._light = light
        self.use_atlas(uniforms, self._indirect)

    def close(self) -> None:
        super().close()
        self._indirect.release()


class ArrivingLight(ConvergedLight):
    """Light of a scene whose meshes arrive and stop its still lamps' light. atlas: of the whole."""

    def __init__(self, gpu: Gpu, scene: Scene, atlas: NDArray[np.float16], most_blockers: int) -> None:
        super().__init__(gpu, scene, most_blockers)
        self._whole, self._here = atlas, np.empty((0, 3, 4))

    def put(self, meshes: Sequence[Mesh]) -> None:
        """Light, and shade by, these meshes from now on; buffers have theirs already."""
        self._here = blocking(self._scene, meshes=meshes)
        for those, buffer in self._buffers:
            buffer.write(_all_rows(those))

    def _rows(self, time_ns: int) -> NDArray[np.float64]:
        return self._here

    def _atlas(self, time_ns: int) -> NDArray[np.float16]:
        return self._whole


def _all_rows(meshes: Sequence[Mesh]) -> bytes:
    """Return the rows of all meshes; of none, those of one vertex that no triangle has."""
    rows = [np.empty((0, 8))]  # normal, place in the light atlas (-1 for none) and albedo
    for mesh in meshes:
        count = len(mesh.positions)
        places = mesh.light_uv if mesh.light_uv is not None else np.full((count, 2), -1.0)
        albedo = mesh.albedo if mesh.albedo is not None else np.full((count, 3), 0.5)
        rows.append(np.concatenate([mesh.normals, places, albedo], axis=1))
    return np.concatenate(rows).astype(np.float32).tobytes() or b"\0" * 32


# A surface must not peel out from under itself. It is drawn with the same bits again; 2^-16 leaves
# room for drivers that round differently.
SAME_SURFACE = 2.0**-16


class ScenePasses:
    """The two draws of a picture: surfaces (those of `buffers`, then `moving`), and the background.

    colour: with inverse depth, else that alone. peel: only what lies behind an earlier picture, see
    shaders/lib/peel.glsl. light: kind of the lamps' light; lighting: in its place, the caller's.
    """

    vertex: ClassVar[str] = "server/scene.vert"
    fragment: ClassVar[str] = "server/scene.frag"

    def __init__(
        self,
        gpu: Gpu,
        scene: Scene,
        buffers: SceneBuffers,
        *,
        colour: bool,
        peel: bool = False,
        moving: Sequence[Moving] = (),
        light: type[Lighting] = ConvergedLight,
        lighting: Lighting | None = None,
    ) -> None:
        self._gpu, self._gl, self.scene, self.buffers = gpu, gpu.gl, scene, buffers
        self._colour, self.moving = colour, tuple(moving)
        # Where the light of the scene's lamps comes from; baked light needs none.
        own = colour and scene.lamps and lighting is None
        self._made = light(gpu, scene) if own else None
        self.lighting = lighting or self._made
        defines = ({"COLOUR": 1} if colour else {}) | ({"PEEL": 1} if peel else {})
        # What colours are made of; data in their place have none.
        self._coloured = colour and (self.lighting is None or self.lighting.coloured)
        shown = defines if self._coloured else {name: one for name, one in defines.items() if name != "COLOUR"}
        lit, self._emits = self._lit_defines(), self._coloured and emits(scene)
        self._is_lit, shining = bool(lit), {"EMISSION": 1} if self._emits else {}
        self._surface = gpu.shaders.draw(self.vertex, self.fragment, **shown, **lit, **shining)
        self._background = gpu.shaders.draw("server/background.vert", "server/background.frag", **defines)
        self._vertices, *self._of_moving = (
            each.vertex_array(gpu.gl, self._surface.program, *self._more(each), colour=self._coloured)
            for each in (buffers, *(drawing.buffers for drawing in self.moving))
        )
        self._empty = gpu.gl.vertex_array(self._background.program, [])

    def _lit_defines(self) -> Mapping[str, object]:
        return dict.fromkeys(self.lighting.defines, 1) if self.lighting is not None else {}

    def _more(self, buffers: SceneBuffers) -> list[tuple[Any, ...]]:
        return [self.lighting.more(buffers.meshes, albedo=self._coloured)] if self.lighting is not None else []

    def peeling(self, moving: Sequence[Moving]) -> ScenePasses:
        """Return passes of the same light that peel, with these moving parts alone."""
        return ScenePasses(
            self._gpu, self.scene, self.buffers, colour=True, peel=True, moving=moving, lighting=self.lighting
        )

    @property
    def revision(self) -> int:
        """Counts changes of what is drawn, apart from textures."""
        return self.buffers.revision + sum(drawing.buffers.revision for drawing in self.moving)

    def draw(self, view: View, framebuffer: moderngl.Framebuffer, time_ns: int = 0, **uniforms: object) -> None:
        """Draw the whole picture at that instant over the previous content."""
        clear_depth(self._gl, framebuffer)
        self._gpu.shaders.hidden.cover(view, framebuffer, -1.0, **({"COLOUR": 1} if self._colour else {}))
        self.draw_into(view, framebuffer, None, time_ns, **uniforms)

    def draw_into(
        self,
        view: View,
        framebuffer: moderngl.Framebuffer,
        viewport: Viewport | None,
        time_ns: int = 0,
        **uniforms: object,
    ) -> None:
        """Draw `view` into a viewport of a framebuffer whose depth is clear, None for all of it."""
        whole = viewport if viewport is not None else (0, 0, *framebuffer.size)
        if uniforms:
            self._surface.uniforms.set(**uniforms)
            self._background.uniforms.set(**uniforms)
        self._set_background(view)
        for drawing in self.moving:
            drawing.set_time(time_ns)
        if self.lighting is not None:
            self.lighting.use(self._surface.uniforms, view, whole, time_ns)
        gl, framebuffer.viewport = self._gl, whole
        with drawing_into(framebuffer, moderngl.DEPTH_TEST):
            gl.depth_func = "<="  # the background lies exactly at the far end
            still = Place(eye_from_scene(view, self.scene.origin_m), view.pose.position_m - self.scene.origin_m)
            if self._is_lit:
                self._surface.uniforms.set(scene_from_here=STAYS)
            self._draw_surfaces(self._vertices, self.buffers, view, still, self.buffers.visibility)
            for one, vertices in zip(self.moving, self._of_moving, strict=True):
                if self._is_lit:
                    self._surface.uniforms.set(scene_from_here=one.scene_from_here(self.scene.lit_ns(time_ns)))
                self._draw_surfaces(vertices, one.buffers, view, one.place(view))
            self._draw_background()
            gl.depth_func = "<"
        framebuffer.viewport = (0, 0, *framebuffer.size)

    def _draw_background(self) -> None:
        self._gl.disable(moderngl.CULL_FACE)
        self._empty.render(moderngl.TRIANGLES, vertices=3)

    def _draw_surfaces(
        self,
        vertices: moderngl.VertexArray,
        buffers: SceneBuffers,
        view: View,
        place: Place,
        visibility: Visibility | None = None,
    ) -> None:
        """Draw the visible chunks. visibility: for what is static in the world's axes."""
        seen_from = self._seen_from(view, place)
        if seen_from is not place:
            place, visibility = seen_from, None
        clip = clip_from_eye(view.fov) @ place.eye_from_here
        self._surface.uniforms.set(clip_from_scene=clip)
        if visibility is None:
            draws = draws_of(buffers.chunks, visible(buffers.chunks.boxes, clip), place.eye)
        else:
            draws = visibility.near(view.pose.unit_quaternion, place.eye, view.fov)
        uniforms = self._surface.uniforms if self._coloured else None
        draw_chunks(self._gl, vertices, buffers, draws, uniforms, emits=self._emits)

    def _seen_from(self, view: View, place: Place) -> Place:
        return place

    def _set_background(self, view: View) -> None:
        if self._colour:
            sky = self.scene.background
            light = {"zenith": sky.zenith, "horizon": sky.horizon, "ground": sky.ground}
            self._background.uniforms.set(world_from_ndc=world_from_ndc(view), **light)

    def close(self) -> None:
        for vertices in (self._vertices, *self._of_moving):
            vertices.release()
        if self._made is not None:
            self._made.close()
        self._empty.release()


def draw_chunks(
    gl: moderngl.Context,
    vertices: moderngl.VertexArray,
    buffers: SceneBuffers,
    draws: Draws,
    uniforms: Uniforms | None,
    *,
    emits: bool,
) -> None:
    """Draw chunks. uniforms: where textures are sampled, on unit 0. emits: emission too."""
    culled = None
    for index, spans in draws:
        batch = buffers.batches[index]
        if batch.double_sided is culled or culled is None:
            culled = not batch.double_sided
            (gl.enable if culled else gl.disable)(moderngl.CULL_FACE)
        if uniforms is not None:
            batch.texture.use(0)
            if emits:
                batch.emission.texture.use(EMISSION_UNIT)
                uniforms.set(emission=EMISSION_UNIT, emission_factor=batch.emission.factor)
        for first, count in spans:
            vertices.render(moderngl.TRIANGLES, vertices=count, first=first)


def draw_moving(
    gl: moderngl.Context,
    draw: Draw,
    one: Moving,
    vertices: moderngl.VertexArray,
    view: View,
    time_ns: int,
    *,
    textured: bool = True,
    emitting: bool = False,
) -> None:
    """Draw one moving thing by a program that takes clip_from_scene, textures on unit 0."""
    one.set_time(time_ns)
    place = one.place(view)
    clip = clip_from_eye(view.fov) @ place.eye_from_here
    draw.uniforms.set(clip_from_scene=clip)
    chunks = one.buffers.chunks
    draws = draws_of(chunks, visible(chunks.boxes, clip), place.eye)
    draw_chunks(gl, vertices, one.buffers, draws, draw.uniforms if textured else None, emits=emitting)


def clear_depth(gl: moderngl.Context, framebuffer: moderngl.Framebuffer) -> None:
    """Clear depth alone: surfaces or the background write every colour anyway."""
    before, nothing, count = framebuffer.color_mask, (False,) * 4, len(framebuffer.color_attachments)
    framebuffer.color_mask = nothing if count == 1 else (nothing,) * count  # type: ignore[assignment]
    with drawing_into(framebuffer):
        framebuffer.clear(depth=1.0)
    # Outside the scope: moderngl 5.13 applies a mask only when it binds the framebuffer again.
    framebuffer.color_mask = before


def draw_cube(
    gl: moderngl.Context, passes: ScenePasses, view: View, framebuffer: moderngl.Framebuffer, time_ns: int = 0
) -> None:
    """Draw the six faces of geometry.cube around the eye of `view` into 3n x 2n pixels."""
    side = framebuffer.size[0] // 3
    clear_depth(gl, framebuffer)
    for face, seen in zip(FACES, face_views(view, side), strict=True):
        passes.draw_into(seen, framebuffer, (face.column * side, face.row * side, side, side), time_ns)
