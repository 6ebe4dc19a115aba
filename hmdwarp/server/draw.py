"""Draws a scene for the eyes: linear colour, and inverse depth that is exact to the last float32 bits."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import moderngl

from ..errors import InputError
from ..frame import EyeImage, Frame, Needs
from ..geometry import View
from ..gpu.context import Gpu
from ..scenes import Scene
from .cube import checked_cube_size, draw_cube
from .passes import ScenePasses
from .peel import peel
from .targets import Framebuffers, Target, TargetPool
from .upload import SceneBuffers


class Server:
    """One scene on the GPU, uploaded once, drawn for any view.

    Rows of what it draws run bottom to top. Background pixels have coverage 1 and inverse depth 0: sky is drawn, not missing.
    """

    def __init__(self, gpu: Gpu, scene: Scene) -> None:
        self.gpu, self.scene = gpu, scene
        self._buffers = SceneBuffers(gpu, scene)
        self._framebuffers = Framebuffers(gpu.gl)
        self._pools: dict[tuple[tuple[int, int], bool], TargetPool] = {}
        self._colour = ScenePasses(gpu, scene, self._buffers, colour=True)
        self._depth: ScenePasses | None = None
        self._behind: ScenePasses | None = None

    def draw(self, view: View, size: tuple[int, int], into: Target | None = None) -> EyeImage:
        """Colour and inverse depth of `view` in (w, h) pixels, into `into` or a target of the server's own pool.

        Errors: InputError for a size of 0 or beyond the GL limit, or another than the target's.
        """
        target = into if into is not None else self.pool(size).acquire()
        _check_same_size(target.size, size)
        self._colour.draw(view, self._framebuffers.over(target.colour, target.inverse_depth))
        return EyeImage(view, target.colour, target.inverse_depth)

    def draw_depth(self, view: View, size: tuple[int, int], into: moderngl.Texture) -> moderngl.Texture:
        """Inverse depth alone, into an r32f texture: what a client that has the geometry knows by itself."""
        _check_same_size(into.size, size)
        if self._depth is None:
            self._depth = ScenePasses(self.gpu, self.scene, self._buffers, colour=False)
        self._depth.draw(view, self._framebuffers.over(into))
        return into

    def draw_frame(
        self, views: Sequence[View], drawn_ns: int, size: tuple[int, int], guard: float = 1.0, needs: Needs | None = None
    ) -> Frame:
        """All eyes into pooled targets, each with its field of view enlarged by `guard` (see Fov.guarded), with what `needs` asks for.

        The frame's views are the enlarged ones. Give the frame back with recycle(). Errors: InputError for a guard below 1, and for a
        cube beyond the GL limit.
        """
        eyes, needs = [], needs if needs is not None else Needs()
        for view in views:
            fov, grown = view.fov.guarded(guard, size)
            eyes.append(self._with_needs(self.draw(View(view.pose, fov), grown), needs))
        return Frame(tuple(eyes), drawn_ns, self.scene.effects)

    def _with_needs(self, eye: EyeImage, needs: Needs) -> EyeImage:
        if needs.layers:
            if self._behind is None:
                self._behind = ScenePasses(self.gpu, self.scene, self._buffers, colour=True, peel=True)
            eye = attrs.evolve(eye, layers=peel(self._behind, self._framebuffers, self.pool(eye.size).acquire, eye, needs.layers))
        if needs.cube:
            size = checked_cube_size(eye.view, eye.size, self.gpu.max_texture_size)
            cube = self.cube_pool(size).acquire().colour
            draw_cube(self.gpu.gl, self._colour, eye.view, self._framebuffers.over(cube))
            eye = attrs.evolve(eye, cube=cube)
        return eye

    def recycle(self, frame: Frame) -> None:
        """Take the frame's textures back; whoever still looks at them will see a later frame."""
        for eye in frame.eyes:
            for picture in (eye, *eye.layers):
                self.pool(eye.size).release(picture.colour)
            if eye.cube is not None:
                self.cube_pool(eye.cube.size).release(eye.cube)

    def pool(self, size: tuple[int, int]) -> TargetPool:
        """The server's targets of that size."""
        return self._pool(size, depth=True)

    def cube_pool(self, size: tuple[int, int]) -> TargetPool:
        """Targets of that size for cubes, which have no inverse depth."""
        return self._pool(size, depth=False)

    def _pool(self, size: tuple[int, int], *, depth: bool) -> TargetPool:
        if (size, depth) not in self._pools:
            self._pools[size, depth] = TargetPool(self.gpu, size, depth=depth)
        return self._pools[size, depth]

    def close(self) -> None:
        """Free everything the server holds, its targets included."""
        for passes in (self._colour, self._depth, self._behind):
            if passes is not None:
                passes.close()
        self._framebuffers.close()
        for pool in self._pools.values():
            pool.close()
        self._buffers.close()


def _check_same_size(found: tuple[int, int], wanted: tuple[int, int]) -> None:
    if tuple(found) != tuple(wanted):
        raise InputError(f"target is {found[0]}x{found[1]} pixels, the picture {wanted[0]}x{wanted[1]}: they must be the same")
