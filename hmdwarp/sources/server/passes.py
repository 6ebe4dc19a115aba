"""Draw a scene's surfaces and its background into any framebuffer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

import moderngl

from ...geometry import View
from ...geometry.cube import FACES, face_views
from ...gpu.context import Gpu, drawing_into
from ...gpu.shaders import Draw
from ...scenes import Scene
from .lighting import Indirect, Lighting
from .upload import STAYS, Batch, Moving, Place, SceneBuffers, emits
from .visibility import Draws, Visibility, clip_from_eye, draws_of, eye_from_scene, visible, world_from_ndc

# A surface must not peel out from under itself. It is drawn with the same bits again; 2^-16 leaves
# room for drivers that round differently.
SAME_SURFACE = 2.0**-16
Viewport = tuple[int, int, int, int]  # x, y, w, h in pixels


class ScenePasses:
    """The two draws of a picture: surfaces (those of `buffers`, then `moving`), and the background.

    colour: draw colour and inverse depth, else inverse depth alone. peel: draw only what lies
    behind a picture drawn before, see shaders/lib/peel.glsl; its uniforms go into draw().
    indirect: with lamps, where indirect light comes from; see `lighting`. lighting: in place of
    that; its maker closes it.
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
        indirect: Indirect = Indirect.OWN,
        lighting: Lighting | None = None,
    ) -> None:
        self._gpu, self._gl, self.scene, self.buffers = gpu, gpu.gl, scene, buffers
        self._colour, self.moving = colour, tuple(moving)
        # Where the light of the scene's lamps comes from; baked light needs none.
        own = colour and scene.lamps and lighting is None
        self._made = Lighting(gpu, scene, indirect) if own else None
        self.lighting = lighting or self._made
        defines = ({"COLOUR": 1} if colour else {}) | ({"PEEL": 1} if peel else {})
        # What colours are made of; receivers have none.
        self._coloured = colour and not (self.lighting is not None and self.lighting.source is Indirect.RECEIVERS)
        shown = defines if self._coloured else {name: one for name, one in defines.items() if name != "COLOUR"}
        lit = self._lit_defines()
        self._is_lit = bool(lit)
        self._emits = self._coloured and emits(scene)
        shining = {"EMISSION": 1} if self._emits else {}
        self._surface = gpu.shaders.draw(self.vertex, self.fragment, **shown, **lit, **shining)
        self._background = gpu.shaders.draw("server/background.vert", "server/background.frag", **defines)
        self._vertices = self._vertex_array(gpu, buffers)
        self._of_moving = [self._vertex_array(gpu, drawing.buffers) for drawing in self.moving]
        self._empty = gpu.gl.vertex_array(self._background.program, [])

    def _vertex_array(self, gpu: Gpu, buffers: SceneBuffers) -> moderngl.VertexArray:
        return buffers.vertex_array(gpu.gl, self._surface.program, *self._more(buffers), colour=self._coloured)

    def _lit_defines(self) -> Mapping[str, object]:
        return self.lighting.defines if self.lighting is not None else {}

    def _more(self, buffers: SceneBuffers) -> list[tuple[Any, ...]]:
        """Return further inputs of the vertex stage, as moderngl takes them."""
        return [self.lighting.more(buffers.meshes, albedo=self._coloured)] if self.lighting is not None else []

    def peeling(self, moving: Sequence[Moving]) -> ScenePasses:
        """Return passes of the same light that peel, with these moving parts alone."""
        return ScenePasses(self._gpu, self.scene, self.buffers, colour=True, peel=True, moving=moving)

    @property
    def revision(self) -> int:
        """Counts changes of what is drawn, apart from textures."""
        return self.buffers.revision + sum(drawing.buffers.revision for drawing in self.moving)

    def draw(self, view: View, framebuffer: moderngl.Framebuffer, time_ns: int = 0, **uniforms: object) -> None:
        """Draw the whole picture at that instant over the previous content."""
        clear_depth(self._gl, framebuffer)
        self.draw_into(view, framebuffer, None, time_ns, **uniforms)

    def draw_into(
        self,
        view: View,
        framebuffer: moderngl.Framebuffer,
        viewport: Viewport | None,
        time_ns: int = 0,
        **uniforms: object,
    ) -> None:
        """Draw `view` into a part of a framebuffer, None for all of it.

        Its depth must be cleared.
        """
        whole = viewport if viewport is not None else (0, 0, *framebuffer.size)
        self._begin(view, whole, time_ns)
        self._surface.uniforms.set(**uniforms)
        self._background.uniforms.set(**uniforms)
        self._set_background(view)
        for drawing in self.moving:
            drawing.set_time(time_ns)
        if self.lighting is not None:
            self.lighting.use(self._surface.uniforms, time_ns)
        gl = self._gl
        framebuffer.viewport = whole
        with drawing_into(framebuffer, moderngl.DEPTH_TEST):
            gl.depth_func = "<="  # the background lies exactly at the far end
            still = Place(eye_from_scene(view, self.scene.origin_m), view.pose.position_m - self.scene.origin_m)
            if self._is_lit:
                self._surface.uniforms.set(scene_from_here=STAYS)
            self._draw_surfaces(self._vertices, self.buffers, view, still, self.buffers.visibility)
            for one, vertices in zip(self.moving, self._of_moving, strict=True):
                if self._is_lit:
                    lit = one.scene_from_here(self.scene.lit_ns(time_ns))
                    self._surface.uniforms.set(scene_from_here=lit)
                self._draw_surfaces(vertices, one.buffers, view, one.place(view))
            self._draw_background()
            gl.depth_func = "<"

    def _begin(self, view: View, viewport: Viewport, time_ns: int) -> None:
        """Prepare what the surfaces' shader reads, before anything is drawn."""

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
        for batch in draw_chunks(self._gl, vertices, buffers, draws):
            if self._coloured:
                batch.use(self._surface.uniforms, emits=self._emits)

    def _seen_from(self, view: View, place: Place) -> Place:
        """Return where surfaces are seen from."""
        return place

    def _set_background(self, view: View) -> None:
        if self._colour:
            sky = self.scene.background
            light = {"zenith": sky.zenith, "horizon": sky.horizon, "ground": sky.ground}
            self._background.uniforms.set(world_from_ndc=world_from_ndc(view), **light)

    def close(self) -> None:
        """Free the vertex arrays; the shader library owns programs, the scene buffers."""
        for vertices in (self._vertices, *self._of_moving):
            vertices.release()
        if self._made is not None:
            self._made.close()
        self._empty.release()


def draw_chunks(
    gl: moderngl.Context, vertices: moderngl.VertexArray, buffers: SceneBuffers, draws: Draws
) -> Iterator[Batch]:
    """Draw some chunks of some buffers; yield each batch before it is drawn."""
    culled = None
    for index, spans in draws:
        batch = buffers.batches[index]
        if batch.double_sided is culled or culled is None:
            culled = not batch.double_sided
            (gl.enable if culled else gl.disable)(moderngl.CULL_FACE)
        yield batch
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
    """Draw one moving thing at that instant into the bound framebuffer, by any program.

    The program takes clip_from_scene. textured: bind each batch's texture to unit 0.
    emitting: it includes lib/emission.glsl.
    """
    one.set_time(time_ns)
    place = one.place(view)
    clip = clip_from_eye(view.fov) @ place.eye_from_here
    draw.uniforms.set(clip_from_scene=clip)
    chunks = one.buffers.chunks
    for batch in draw_chunks(gl, vertices, one.buffers, draws_of(chunks, visible(chunks.boxes, clip), place.eye)):
        if textured:
            batch.use(draw.uniforms, emits=emitting)


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
