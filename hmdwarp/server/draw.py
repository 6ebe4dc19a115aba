"""Draws a scene for the eyes: linear colour, and inverse depth that is exact to the last float32 bits."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import moderngl

from ..errors import InputError
from ..frames.frame import EyeImage, Frame, Needs
from ..geometry import View, guarded_eyes
from ..gpu.context import Gpu
from ..gpu.textures import COLOUR
from ..registry import unknown_name
from ..scenes import Scene
from .cube import checked_cube_size, draw_cube
from .moving import Moving, moving_parts, stands_still
from .parts import DrawContext, Drawing, Part, parts
from .passes import ScenePasses
from .peel import peel
from .targets import Framebuffers, Target, TargetPool
from .upload import SceneBuffers, SceneTextures
from .wide import draw_wide

Size = tuple[int, int]
MIRRORS = GEOMETRY, SCREEN = "geometry", "screen"


class Server:
    """One scene on the GPU, uploaded once, drawn for any view and instant.

    Rows of what it draws run bottom to top. Background pixels have coverage 1 and inverse depth 0: sky is drawn, not missing.
    What the scene has not, and nobody needs, is never compiled or allocated. mirrors: how plane mirrors are drawn in frames, "geometry"
    (the scene once more, mirrored) or "screen" (rays marched through the picture itself; what it does not show is missing); draw(), which
    is the truth, always takes the first. Errors: UnknownNameError for another word.
    """

    def __init__(self, gpu: Gpu, scene: Scene, mirrors: str = GEOMETRY) -> None:
        self.gpu, self.scene, self._marched = gpu, scene, _is_marched(mirrors)
        self._textures = SceneTextures(gpu, scene)
        still = [mesh for mesh in scene.meshes if mesh.is_surface and stands_still(mesh)]
        self._buffers = SceneBuffers(gpu, still, self._textures)
        self._moving = moving_parts(gpu, scene, self._textures)
        self._framebuffers = Framebuffers(gpu.gl)
        self._pools: dict[tuple, TargetPool] = {}
        self._colour = ScenePasses(gpu, scene, self._buffers, colour=True, moving=self._moving)
        self._depth: ScenePasses | None = None
        self._behind: dict[tuple[Moving, ...], ScenePasses] = {}
        self._parts: dict[str, Part] = {}
        self._chosen: dict[Needs, list[Part]] = {}
        self._easel = DrawContext(gpu, scene, self._textures, self._framebuffers, self._colour, self.acquire)

    def draw(self, view: View, size: Size, into: Target | None = None, time_ns: int = 0) -> EyeImage:
        """The whole picture of `view` in (w, h) pixels at `time_ns`, colour and inverse depth, into `into` or a target of the server's own.

        Errors: InputError for a size of 0 or beyond the GL limit, or another than the target's.
        """
        return self._draw(view, size, Drawing(view, size, time_ns), into)

    def _draw(self, view: View, size: Size, drawing: Drawing, into: Target | None = None) -> EyeImage:
        target = into if into is not None else self.acquire(size)
        _check_same_size(target.size, size)
        self._colour.draw(view, self._framebuffers.over(target.colour, target.inverse_depth), drawing.time_ns)
        eye = EyeImage(view, target.colour, target.inverse_depth, drawn_ns=drawing.time_ns)
        for part in self._parts_for(drawing.needs):
            eye = part.add(eye, drawing)
        return eye

    def _parts_for(self, needs: Needs) -> list[Part]:
        """Those that the scene has, or that are asked for as layers; made when first needed."""
        if needs not in self._chosen:
            chosen = sorted(
                (part for part in parts if part.in_scene(self.scene) or part.wanted(needs)), key=lambda part: part.order
            )
            for part in chosen:
                if part.name not in self._parts:
                    self._parts[part.name] = part(self._easel)
            self._chosen[needs] = [self._parts[part.name] for part in chosen]
        return self._chosen[needs]

    def draw_depth(self, view: View, size: Size, into: moderngl.Texture, time_ns: int = 0) -> moderngl.Texture:
        """Inverse depth alone, into an r32f texture: what a client that has the geometry knows by itself."""
        _check_same_size(into.size, size)
        if self._depth is None:
            self._depth = ScenePasses(self.gpu, self.scene, self._buffers, colour=False, moving=self._moving)
        self._depth.draw(view, self._framebuffers.over(into), time_ns)
        for part in self._parts_for(Needs()):
            part.add_depth(view, time_ns, into)
        return into

    def draw_frame(
        self, views: Sequence[View], drawn_ns: int, size: Size, guard: float = 1.0, needs: Needs | None = None
    ) -> Frame:
        """All eyes into pooled targets, each with its field of view enlarged by `guard` (see guarded_eyes), with what `needs` asks for.

        The frame's views are the enlarged ones. Give the frame back with recycle(). Errors: InputError for a guard below 1, and for a
        cube beyond the GL limit.
        """
        eyes, needs = [], needs if needs is not None else Needs()
        fovs, grown = guarded_eyes(views, guard, size)
        for view, fov in zip(views, fovs, strict=True):
            drawing = Drawing(view, size, drawn_ns, needs, self._marched)
            eye = self._with_surroundings(self._draw(View(view.pose, fov, view.head_from_eye), grown, drawing), needs)
            eyes.append(attrs.evolve(eye, wide=draw_wide(self._draw, drawing)) if needs.wide else eye)
        return Frame(tuple(eyes), drawn_ns, self.scene.effects)

    def _with_surroundings(self, eye: EyeImage, needs: Needs) -> EyeImage:
        if needs.layers:
            behind = self._passes_behind(needs)
            eye = attrs.evolve(
                eye, layers=peel(behind, self._framebuffers, self.pool(eye.size).acquire, eye, needs.layers)
            )
        if needs.cube:
            size = checked_cube_size(eye.view, eye.size, self.gpu.max_texture_size)
            cube = self.cube_pool(size).acquire().colour
            draw_cube(self.gpu.gl, self._colour, eye.view, self._framebuffers.over(cube), eye.drawn_ns)
            eye = attrs.evolve(eye, cube=cube)
        return eye

    def _passes_behind(self, needs: Needs) -> ScenePasses:
        """Of what lies behind. What the client moves is no part of it: then it is what fills the place that something left."""
        moving = tuple(one for one in self._moving if not one.moved_by_client(needs))
        if moving not in self._behind:
            self._behind[moving] = ScenePasses(
                self.gpu, self.scene, self._buffers, colour=True, peel=True, moving=moving
            )
        return self._behind[moving]

    def recycle(self, frame: Frame) -> None:
        """Take the frame's textures back; whoever still looks at them will see a later frame."""
        for eye in frame.eyes:
            self.pool(eye.size).release(eye.colour)
            for texture in eye.textures():
                for pool in self._pools.values():
                    if pool.lent(texture):
                        pool.release(texture)

    def acquire(self, size: Size, kind: tuple[int, str] = COLOUR, *, depth: bool = True) -> Target:
        """A target from the pool of its kind; recycle() takes it back with the frame it is part of."""
        return self._pool(size, kind, depth=depth).acquire()

    def pool(self, size: Size) -> TargetPool:
        """The server's targets of that size."""
        return self._pool(size, COLOUR, depth=True)

    def cube_pool(self, size: Size) -> TargetPool:
        """Targets of that size for cubes, which have no inverse depth."""
        return self._pool(size, COLOUR, depth=False)

    def _pool(self, size: Size, kind: tuple[int, str], *, depth: bool) -> TargetPool:
        key = (size, kind, depth)
        if key not in self._pools:
            self._pools[key] = TargetPool(self.gpu, size, kind, depth=depth)
        return self._pools[key]

    def close(self) -> None:
        """Free everything the server holds, its targets included."""
        for part in self._parts.values():
            part.close()
        for passes in (self._colour, self._depth, *self._behind.values()):
            if passes is not None:
                passes.close()
        self._framebuffers.close()
        for pool in self._pools.values():
            pool.close()
        for owner in (self._buffers, *self._moving):
            owner.close()
        self._textures.close()


def _is_marched(mirrors: str) -> bool:
    if mirrors not in MIRRORS:
        raise unknown_name("kind of mirrors", mirrors, list(MIRRORS))
    return mirrors == SCREEN


def _check_same_size(found: Size, wanted: Size) -> None:
    if tuple(found) != tuple(wanted):
        raise InputError(
            f"target is {found[0]}x{found[1]} pixels, the picture {wanted[0]}x{wanted[1]}: they must be the same"
        )
