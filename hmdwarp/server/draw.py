"""Draws a scene for the eyes: linear colour, and inverse depth that is exact to the last float32 bits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import moderngl
import numpy as np

from ..errors import InputError
from ..frame import EyeImage, Frame, Needs
from ..geometry import View
from ..gpu.context import Gpu
from ..gpu.shaders import Draw
from ..scenes import Scene
from .projection import clip_from_eye, eye_from_scene, nearest_first, visible, world_from_ndc
from .targets import Framebuffers, Target, TargetPool
from .upload import Chunks, SceneBuffers


class Server:
    """One scene on the GPU, uploaded once, drawn for any view.

    Rows of what it draws run bottom to top. Background pixels have coverage 1 and inverse depth 0: sky is drawn, not missing.
    """

    def __init__(self, gpu: Gpu, scene: Scene) -> None:
        self.gpu, self.scene = gpu, scene
        self._buffers = SceneBuffers(gpu, scene)
        self._framebuffers = Framebuffers(gpu.gl)
        self._pools: dict[tuple[int, int], TargetPool] = {}
        self._colour = self._passes(colour=True)
        self._depth: tuple | None = None

    def _passes(self, *, colour: bool) -> tuple[Draw, moderngl.VertexArray, Draw, moderngl.VertexArray]:
        defines = {"COLOUR": 1} if colour else {}
        surface = self.gpu.shaders.draw("server/scene.vert", "server/scene.frag", **defines)
        background = self.gpu.shaders.draw("server/background.vert", "server/background.frag", **defines)
        empty = self.gpu.gl.vertex_array(background.program, [])
        return surface, self._buffers.vertex_array(self.gpu.gl, surface.program, colour=colour), background, empty

    def draw(self, view: View, size: tuple[int, int], into: Target | None = None) -> EyeImage:
        """Colour and inverse depth of `view` in (w, h) pixels, into `into` or a target of the server's own pool.

        Errors: InputError for a size of 0 or beyond the GL limit, or another than the target's.
        """
        target = into if into is not None else self.pool(size).acquire()
        _check_same_size(target.size, size)
        self._draw(view, self._framebuffers.over(target.colour, target.inverse_depth), self._colour, colour=True)
        return EyeImage(view, target.colour, target.inverse_depth)

    def draw_depth(self, view: View, size: tuple[int, int], into: moderngl.Texture) -> moderngl.Texture:
        """Inverse depth alone, into an r32f texture: what a client that has the geometry knows by itself."""
        _check_same_size(into.size, size)
        if self._depth is None:
            self._depth = self._passes(colour=False)
        self._draw(view, self._framebuffers.over(into), self._depth, colour=False)
        return into

    def draw_frame(
        self, views: Sequence[View], drawn_ns: int, size: tuple[int, int], guard: float = 1.0, needs: Needs | None = None
    ) -> Frame:
        """All eyes into pooled targets, each with its field of view enlarged by `guard` (see Fov.guarded), with what `needs` asks for.

        The frame's views are the enlarged ones. Give the frame back with recycle(). Errors: InputError for a guard below 1.
        """
        eyes = []
        for view in views:
            fov, grown = view.fov.guarded(guard, size)
            eyes.append(self.draw(View(view.pose, fov), grown))
        return Frame(tuple(eyes), drawn_ns, self.scene.effects)

    def recycle(self, frame: Frame) -> None:
        """Take the frame's textures back; whoever still looks at them will see a later frame."""
        for eye in frame.eyes:
            self.pool(eye.size).release(eye.colour)

    def pool(self, size: tuple[int, int]) -> TargetPool:
        """The server's targets of that size."""
        if size not in self._pools:
            self._pools[size] = TargetPool(self.gpu, size)
        return self._pools[size]

    def _draw(self, view: View, framebuffer: moderngl.Framebuffer, passes: tuple, *, colour: bool) -> None:
        gl = self.gpu.gl
        surface, vertices, background, empty = passes
        clip = clip_from_eye(view.fov) @ eye_from_scene(view, self.scene.origin_m)
        surface.uniforms.set(clip_from_scene=clip)
        self._set_background(background, view, colour=colour)
        _clear_depth(gl, framebuffer)
        with gl.scope(framebuffer, moderngl.DEPTH_TEST):
            gl.depth_func = "<="  # the background lies exactly at the far end
            self._draw_surfaces(vertices, clip, view, colour=colour)
            gl.disable(moderngl.CULL_FACE)
            empty.render(moderngl.TRIANGLES, vertices=3)
            gl.depth_func = "<"

    def _draw_surfaces(self, vertices: moderngl.VertexArray, clip: np.ndarray, view: View, *, colour: bool) -> None:
        gl, before = self.gpu.gl, -1
        for index, first, count in _runs(self._buffers.chunks, clip, view.pose.position_m - self.scene.origin_m):
            if index != before:
                batch, before = self._buffers.batches[index], index
                (gl.disable if batch.double_sided else gl.enable)(moderngl.CULL_FACE)
                if colour:
                    batch.texture.use(0)
            vertices.render(moderngl.TRIANGLES, vertices=count, first=first)

    def _set_background(self, background: Draw, view: View, *, colour: bool) -> None:
        if colour:
            sky = self.scene.background
            background.uniforms.set(world_from_ndc=world_from_ndc(view), zenith=sky.zenith, horizon=sky.horizon, ground=sky.ground)

    def close(self) -> None:
        """Free everything the server holds, its targets included."""
        for passes in (self._colour, self._depth):
            for vertices in (passes[1], passes[3]) if passes else ():
                vertices.release()
        self._framebuffers.close()
        for pool in self._pools.values():
            pool.close()
        self._buffers.close()


def _check_same_size(found: tuple[int, int], wanted: tuple[int, int]) -> None:
    if tuple(found) != tuple(wanted):
        raise InputError(f"target is {found[0]}x{found[1]} pixels, the picture {wanted[0]}x{wanted[1]}: they must be the same")


def _clear_depth(gl: moderngl.Context, framebuffer: moderngl.Framebuffer) -> None:
    """Depth alone: every colour is written by a surface or by the background anyway."""
    wanted, nothing = framebuffer.color_mask, (False,) * 4
    framebuffer.color_mask = nothing if len(framebuffer.color_attachments) == 1 else (nothing,) * len(framebuffer.color_attachments)
    with gl.scope(framebuffer):
        framebuffer.clear(depth=1.0)
    framebuffer.color_mask = wanted  # outside the scope: moderngl 5.13 applies a mask only where the framebuffer is bound anew


def _runs(chunks: Chunks, clip: np.ndarray, eye: np.ndarray) -> Iterator[tuple[int, int, int]]:
    """(batch, first index, number of indices) of all that may be seen, near things first, neighbours in one run."""
    seen = np.flatnonzero(visible(chunks.centres, chunks.half_sizes, clip))
    if not len(seen):
        return
    group = nearest_first(chunks.centres, chunks.half_sizes, eye)[seen] * (int(chunks.batch.max()) + 1) + chunks.batch[seen]
    seen = seen[np.argsort(group, kind="stable")]
    group.sort()
    first, end = chunks.first[seen], chunks.first[seen] + chunks.count[seen]
    starts = np.flatnonzero(np.concatenate([[True], (first[1:] != end[:-1]) | (group[1:] != group[:-1])]))
    for start, stop in zip(starts, [*(starts[1:] - 1), len(seen) - 1], strict=True):
        yield int(chunks.batch[seen[start]]), int(first[start]), int(end[stop] - first[start])
