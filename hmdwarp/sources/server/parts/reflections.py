"""Reflections: drawn into the picture, or a layer with the depth of the mirrored world."""

from __future__ import annotations

from collections.abc import Sequence

import moderngl
import numpy as np
from numpy.typing import NDArray

from ....frames import EyeImage, Mirrored, Reflection, Surface
from ....geometry import Fov, Mirror, Pose, View
from ....geometry.view import mirrors_in_eye, tangents_of_pixels
from ....gpu.textures import COLOUR, Owner, drawing_into
from ....scenes import Scene, SceneMirror
from ..passes import NEAR_M, SAME_SURFACE, Place, ScenePasses, clear_depth, clip_from_eye, draw_cube, eye_from_scene
from ..targets import Target
from . import DrawContext, Drawing, Part, parts


@parts.register
class Reflections(Part):
    """Plane mirrors: the scene again, mirrored. Curved ones: a cube map around each."""

    name, order = "reflections", 10

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        shaders = context.gpu.shaders
        mirrors = context.scene.mirrors
        kinds = [Ball if mirror.shape.is_curved else _MirrorSurface for mirror in mirrors]
        self._surfaces = [self.own(kind(context, mirror)) for kind, mirror in zip(kinds, mirrors, strict=True)]
        self._mirrored: _MirroredPasses | None = None
        self._take = shaders.compute("server/mirror_take.comp")
        self._compose = shaders.compute("server/mirror_compose.comp")

    @classmethod
    def in_scene(cls, scene: Scene) -> bool:
        return bool(scene.mirrors)

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        needed = drawing.needs.get("reflection", Mirrored(0))
        kinds = [(one, Mirrored.CURVED if one.mirror.shape.is_curved else Mirrored.PLANE) for one in self._surfaces]
        layered, baked = ([one for one, kind in kinds if (kind in needed) is given] for given in (True, False))
        if baked:
            seen, surface = self.kept("seen", eye.size), self.kept("surface", eye.size, depth=False)
            self._draw(eye, baked, seen, surface, drawing.marched)
            eye.colour.bind_to_image(0, read=True, write=True)
            surface.colour.bind_to_image(1, read=True, write=False)
            seen.inverse_depth.bind_to_image(2, read=True, write=False)
            seen.colour.filter = (moderngl.LINEAR, moderngl.LINEAR)
            seen.colour.use(0)
            units = {"picture": 0, "surface": 1, "seen_inverse_depth": 2, "seen": 0}
            pixel = (1 / eye.size[0], 1 / eye.size[1])
            mirrors = _uniforms_of([one.mirror for one in baked], eye.view, eye.size)
            self._compose.uniforms.set(size=eye.size, seen_pixel=pixel, **units, **mirrors)
            self.context.gpu.barrier()
            self._compose.run(*eye.size)
            self.context.gpu.barrier()
        if not needed:
            return eye
        seen, surface = self.context.acquire(eye.size), self.context.acquire(eye.size, COLOUR, depth=False)
        self._draw(eye, layered, seen, surface, drawing.marched)
        shapes = tuple(surface.mirror.shape for surface in layered)
        # The pixels in which any of them may be visible.
        found = [one for shape in shapes if (one := _bounds_in_view(shape, eye.view, eye.size)) is not None]
        low_x, low_y, high_x, high_y = zip(*found or [(0, 0, 0, 0)], strict=True)
        bounds = min(low_x), min(low_y), max(high_x), max(high_y)
        mirrored = Surface(seen.colour, seen.inverse_depth)
        return eye.having(reflection=Reflection(mirrored, surface.colour, shapes, bounds))

    def _draw(
        self, eye: EyeImage, chosen: Sequence[_MirrorSurface], seen: Target, surface: Target, marched: bool
    ) -> None:
        over = self.context.framebuffers.over
        over(seen.colour).clear()
        over(seen.inverse_depth).clear(red=-1.0)
        onto = over(surface.colour)
        onto.clear(alpha=1.0)
        for mirrored in chosen:
            mirrored.draw_surface(eye, onto)
        mirrors = _uniforms_of([surface.mirror for surface in chosen], eye.view, eye.size)
        # Plane mirrors come first and ignore balls: at the rim of a ball's triangles something else
        # shows.
        planes = mirrors | {"mirror_count": sum(not surface.mirror.shape.is_curved for surface in chosen)}
        for number, one in enumerate(chosen):
            if isinstance(one, Ball):
                side = _FACE_PIXELS + 2
                around = self.kept(f"around {id(one)}", (3 * side, 2 * side))
                one.draw_image(eye, number, mirrors, over(seen.colour, seen.inverse_depth), around)
            elif (bounds := _bounds_in_view(one.mirror.shape, eye.view, eye.size)) is not None:
                program, behind = self._take, Target(eye.colour, eye.inverse_depth)
                if marched:
                    program = self.context.gpu.shaders.compute("server/mirror_march.comp")
                else:
                    self._mirrored = self._mirrored or self.own(_MirroredPasses(self.context))
                    behind = self.kept("behind", eye.size)
                    onto = over(behind.colour, behind.inverse_depth)
                    self._mirrored.draw_behind(one.mirror.shape, eye.view, onto, bounds, eye.drawn_ns)
                for unit, texture in enumerate((seen.colour, seen.inverse_depth, behind.colour, behind.inverse_depth)):
                    texture.bind_to_image(unit, read=unit > 1, write=unit < 2)
                units = {"seen_colour": 0, "seen_inverse_depth": 1, "behind_colour": 2, "behind_inverse_depth": 3}
                program.uniforms.set(taken=number, **units, **{"from": bounds[:2], "to": bounds[2:]}, **planes)
                self.context.gpu.barrier()
                program.run(bounds[2] - bounds[0], bounds[3] - bounds[1])
                self.context.gpu.barrier()


Array = NDArray[np.float64]
Uniforms = dict[str, object]
Bounds = tuple[int, int, int, int]  # x, y of the first pixel, x, y after the last
APRON_M = 0.4  # as in shaders/lib/mirrors.glsl
# Per 90 degrees of a curved mirror's surroundings: the ball shrinks a face to about 50 pixels where
# it covers 150 itself.
_FACE_PIXELS = 160
_CLIP_DISTANCE_0 = 0x3000


def _plane_in_eye(mirror: Mirror, view: View) -> Array:
    """Return the mirror's plane, (4,): times (x, y, z, 1) in eye space, metres in front of it."""
    eye_from_world = view.pose.rotation_matrix.T
    normal = eye_from_world @ mirror.normal
    return np.array([*normal, -normal @ (eye_from_world @ (mirror.centre_m - view.pose.position_m))])


def _bounds_in_view(mirror: Mirror, view: View, size: tuple[int, int]) -> Bounds | None:
    """Return the pixels in which a mirror (a plane one: with its apron) may be visible, or None."""
    if mirror.is_curved:  # the bounds of the cube around a ball; near the eye, those of the picture
        signs = np.stack(np.meshgrid((-1, 1), (-1, 1), (-1, 1)), axis=-1).reshape(-1, 3)
        corners = mirror.centre_m + mirror.radius_m * signs - view.pose.position_m
        corners = corners @ view.pose.rotation_matrix
        ahead = -corners[:, 2] >= NEAR_M
        return _bounds_of(corners, view, size) if ahead.all() else (0, 0, *size) if ahead.any() else None
    if _plane_in_eye(mirror, view)[3] <= 0:
        return None
    grow = [half * (1 + APRON_M / np.linalg.norm(half)) for half in (mirror.right_m, mirror.up_m)]
    signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], np.float64)
    corners = mirror.centre_m + signs @ np.array(grow) - view.pose.position_m
    corners = corners @ view.pose.rotation_matrix
    ahead, kept = -corners[:, 2] - NEAR_M, []  # what of it is ahead (Sutherland and Hodgman 1974)
    for here, there in ((0, 1), (1, 2), (2, 3), (3, 0)):
        if ahead[here] >= 0:
            kept.append(corners[here])
        if (ahead[here] >= 0) != (ahead[there] >= 0):
            share = ahead[here] / (ahead[here] - ahead[there])
            kept.append(corners[here] + (corners[there] - corners[here]) * share)
    return _bounds_of(np.array(kept), view, size) if kept else None


def _bounds_of(corners: Array, view: View, size: tuple[int, int]) -> Bounds | None:
    pixels = corners[:, :2] / -corners[:, 2:] - np.array(view.fov.tangents[[0, 2]])
    pixels /= np.array(tangents_of_pixels(view, size)["tangent_step"])
    low = np.clip(np.floor(pixels.min(axis=0)), 0, size).astype(int)
    high = np.clip(np.ceil(pixels.max(axis=0)), 0, size).astype(int)
    return (int(low[0]), int(low[1]), int(high[0]), int(high[1])) if (high > low).all() else None


class _MirroredPasses(ScenePasses):
    """The scene behind a plane mirror, in the eye's own pixels; one bounce."""

    vertex = "server/mirrored.vert"

    _mirror: Mirror  # the one being drawn

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context.gpu, context.scene, context.colour.buffers, colour=True, moving=context.colour.moving)

    def draw_behind(
        self, mirror: Mirror, view: View, framebuffer: moderngl.Framebuffer, bounds: Bounds, time_ns: int
    ) -> None:
        self._mirror = mirror
        named, gl = tangents_of_pixels(view, framebuffer.size), self._gl
        start, step = np.array(named["tangent_start"]), np.array(named["tangent_step"])
        low, high = start + step * bounds[:2], start + step * bounds[2:]
        seen = View(view.pose, Fov.from_tangents((low[0], high[0], low[1], high[1])))  # these pixels alone
        clear_depth(gl, framebuffer)
        gl.front_face = "cw"
        gl.enable_direct(_CLIP_DISTANCE_0)
        self.draw_into(seen, framebuffer, (bounds[0], bounds[1], bounds[2] - bounds[0], bounds[3] - bounds[1]), time_ns)
        gl.disable_direct(_CLIP_DISTANCE_0)
        gl.front_face = "ccw"
        framebuffer.viewport = (0, 0, *framebuffer.size)

    def _seen_from(self, view: View, place: Place) -> Place:
        """Return the place of the eye behind the mirror; no visibility is cached for it."""
        plane, behind_from_eye = _plane_in_eye(self._mirror, view), np.eye(4)
        behind_from_eye[:3] -= 2 * np.outer(plane[:3], plane)
        self._surface.uniforms.set(before_mirror=plane @ place.eye_from_here)
        behind_from_here = behind_from_eye @ place.eye_from_here
        return Place(behind_from_here, np.linalg.inv(behind_from_here)[:3, 3].astype(np.float64))

    def _world_from_ndc(self, view: View) -> Array:
        normal = self._mirror.normal
        return (np.eye(3) - 2 * np.outer(normal, normal)) @ super()._world_from_ndc(view)


class _MirrorSurface(Owner):
    def __init__(self, context: DrawContext, mirror: SceneMirror) -> None:
        self.mirror, self._context = mirror, context
        gl, shaders = context.gpu.gl, context.gpu.shaders
        parts = ((one, np.concatenate([one.positions, one.uv, one.normals], axis=1)) for one in mirror.meshes)
        rows = np.concatenate([part[mesh.triangles.ravel()] for mesh, part in parts])
        self._vertices = self.own(gl.buffer(rows.astype(np.float32).tobytes()))
        mapped = {"NORMAL_MAP": 1} if mirror.normal_map >= 0 else {}
        self._surface = shaders.draw("server/mirror_surface.vert", "server/mirror_surface.frag", **mapped)
        inputs = ("3f4 2f4 12x", "in_position", "in_uv") if mapped else ("3f4 20x", "in_position")
        self._drawn = self.own(gl.vertex_array(self._surface.program, [(self._vertices, *inputs)]))

    def draw_surface(self, eye: EyeImage, framebuffer: moderngl.Framebuffer) -> None:
        clip = clip_from_eye(eye.view.fov) @ eye_from_scene(eye.view, self._context.scene.origin_m)
        uniforms: dict[str, object] = {"reflectivity": self.mirror.shape.reflectivity}
        uniforms |= {"shown_inverse_depth": 1, "keep": 1 - SAME_SURFACE}
        if self.mirror.normal_map >= 0:
            self._context.textures[self.mirror.normal_map].use(0)
            uniforms |= {"normal_map": 0, "normal_scale": self.mirror.normal_scale}
        eye.inverse_depth.use(1)
        self._surface.uniforms.set(clip_from_scene=clip, **uniforms)
        with drawing_into(framebuffer, moderngl.CULL_FACE):
            self._drawn.render(moderngl.TRIANGLES)


class Ball(_MirrorSurface):
    """A curved mirror; its surroundings are drawn again only where they have changed."""

    def __init__(self, context: DrawContext, mirror: SceneMirror) -> None:
        super().__init__(context, mirror)
        gl = context.gpu.gl
        self._image = context.gpu.shaders.draw("server/mirror_surface.vert", "server/mirror_ball.frag", CURVED=1)
        layout = [(self._vertices, "3f4 8x 3f4", "in_position", "in_normal")]
        self._curved = self.own(gl.vertex_array(self._image.program, layout))
        self._around: Target | None = None
        # Of the surroundings that were drawn: instant if anything moves, and revisions.
        self._around_of: tuple[int, int, int] | None = None

    def draw_image(
        self, eye: EyeImage, taken: int, mirrors: Uniforms, framebuffer: moderngl.Framebuffer, around: Target
    ) -> None:
        """Draw the reflection in mirror number `taken`. mirrors: uniforms of all of them."""
        view = eye.view
        from_scene = eye_from_scene(view, self._context.scene.origin_m)
        passes = self._context.colour
        for drawing in passes.moving:
            drawing.set_time(eye.drawn_ns)
        key = (eye.drawn_ns if passes.moving else 0, passes.revision, self._context.textures.revision)
        if self._around is not around or self._around_of != key:
            centre = View(Pose(self.mirror.shape.centre_m), Fov.from_tangents((-1, 1, -1, 1)))
            over = self._context.framebuffers.over(around.colour, around.inverse_depth)
            draw_cube(self._context.gpu.gl, passes, centre, over, eye.drawn_ns)
            over.viewport = (0, 0, *over.size)
            self._around, self._around_of = around, key
        around.colour.filter = (moderngl.LINEAR, moderngl.LINEAR)
        around.colour.use(0)
        around.inverse_depth.use(1)
        places: dict[str, object] = {
            "clip_from_scene": clip_from_eye(view.fov) @ from_scene,
            "eye_from_scene": from_scene,
        }
        places |= {"world_from_eye": view.pose.rotation_matrix, "face_size": float(around.size[0] // 3)}
        self._image.uniforms.set(taken=taken, around=0, around_inverse_depth=1, **places, **mirrors)
        with drawing_into(framebuffer, moderngl.CULL_FACE):
            self._curved.render(moderngl.TRIANGLES)


def _uniforms_of(mirrors: Sequence[SceneMirror], view: View, size: tuple[int, int]) -> Uniforms:
    return mirrors_in_eye([mirror.shape for mirror in mirrors], view) | tangents_of_pixels(view, size)
