"""Motion that frames carry: of rigid bodies, and the velocity of each pixel.

The rendered picture's moving pixels advance to the instant at which they are shown; the view stays
the one that the picture was rendered for.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import attrs
import moderngl
import numpy as np

from ...base import InputError, MachineError
from ...frames import EyeImage, Needs
from ...geometry import Pose, RigidState, View, WarpMap, view_map
from ...gpu import Gpu
from ...gpu.textures import COLOUR, SCALAR, Owner, allocate, bind_images, drawing_into
from ...scenes import REACH_M, swing_seconds
from ..inputs import PassInputs
from ..warps.mesh import steepest
from . import RenderedPass, effects

STEEPEST_DEG = 85.0  # angle from facing; steeper planes tear, as in the mesh warps
NEAREST_M = 0.02
MOST_BODIES = 4096
MOST_SIDE = 2**16 - 1  # a pixel's index has 16 bits a side
QUADS = 2**14  # in one draw: a corner's index has 16 bits
ROWS, _DRAW_BYTES, MAP_FLOATS = 32, 20, 16  # as in shaders/effects/motion_split.comp, motion_order.comp and motion.glsl
STILL = 1e-9  # pixels: rounding of a body at rest, far below any motion
RIGID, SOFT = "rigid_motion", "soft_motion"


def body_map(state: RigidState, age_ns: int, view: View, size: tuple[int, int]) -> WarpMap:
    """Return the map of a body's rendered pixels to where the same view shows it `age_ns` later.

    It is the map of an eye that moves the other way. Source: McMillan and Bishop 1995, eq. 8-10.
    """
    rendered, after = (pose.relative_to(view.pose) for pose in (state.pose, state.after(age_ns)))
    return view_map(View(after @ rendered.inverse(), view.fov), size, View(Pose(), view.fov), size)


def rests(moved: WarpMap) -> bool:
    """Return whether a map leaves every pixel in place."""
    return bool(np.abs(moved.H - np.eye(3)).max() <= STILL and np.abs(moved.e).max() <= STILL)


class _Moved(Owner):
    """One rendered picture after its motion."""

    def __init__(self, gpu: Gpu, size: tuple[int, int], depth: moderngl.Renderbuffer) -> None:
        self.colour, self.inverse_depth = (self.own(allocate(gpu.gl, size, kind)) for kind in (COLOUR, SCALAR))
        self.framebuffer = self.own(gpu.gl.framebuffer([self.colour, self.inverse_depth], depth))


class MotionPass(RenderedPass):
    """Moves bodies by their pose and speed, and deforming things by their velocity.

    Velocities are extrapolated for swing_seconds() and REACH_M at most. Every moving pixel is drawn
    as the square it covers, with a depth test against everything else, and leaves a hole behind.
    Both kinds move at once: the velocities and ids of one no longer fit after the other has moved.
    """

    name = "motion"
    reads = ("rendered.colour", "rendered.inverse_depth", "rendered.ids", "rendered.velocity")

    @classmethod
    def reads_for(cls, parts: frozenset[str]) -> tuple[str, ...]:
        return (*cls.reads[:2], *cls.reads[2:3] * (RIGID in parts), *cls.reads[3:] * (SOFT in parts))

    def prepare(self) -> None:
        blocks, wide, high = self.gpu.gl.info["GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS"], *self.rendered_size
        if blocks < 2:
            raise MachineError(
                f"vertex shaders of this GPU read {blocks} buffers: moving things needs 2; use --effects "
                f"no-{RIGID},no-{SOFT}"
            )
        if max(wide, high) > MOST_SIDE:
            raise InputError(
                f"a rendered picture of {wide}x{high}: moving things takes at most {MOST_SIDE} pixels a side"
            )
        defines = {"RIGID": int(RIGID in self.parts), "SOFT": int(SOFT in self.parts)}
        shaders, gl = self.gpu.shaders, self.gpu.gl
        self._split = shaders.compute("effects/motion_split.comp", IMAGES=1, **defines)
        self._order, self._list = (shaders.compute(f"effects/motion_{name}.comp") for name in ("order", "list"))
        self._draw = shaders.draw("effects/motion.vert", "effects/motion.frag", IMAGES=0, **defines)
        self._words, self._draws = wide * -(-high // ROWS), -(-wide * high // QUADS)
        # Body maps; masks, prefix counts, draws, the list: bound in the order of the shaders'
        # numbers.
        masks, draws = 4 * self._words, _DRAW_BYTES * self._draws
        sizes = (4 * MAP_FLOATS * MOST_BODIES, masks, masks, draws, 4 * wide * high)
        self._buffers = [self.own(gl.buffer(reserve=size)) for size in sizes]
        corners = 4 * np.arange(QUADS)[:, None] + np.array([0, 1, 2, 2, 1, 3])
        indices = self.own(gl.buffer(corners.astype(np.uint16).tobytes()))
        array = gl.vertex_array(self._draw.program, [], index_buffer=indices, index_element_size=2)
        self._array, depth = self.own(array), self.own(gl.depth_renderbuffer(self.rendered_size))
        self._moved = [self.own(_Moved(self.gpu, self.rendered_size, depth)) for _ in range(self.tools.images)]

    def run(self, inputs: PassInputs) -> PassInputs:
        into = iter(self._moved)
        return inputs.having(self._image(image, inputs.shown_ns - image.drawn_ns, into) for image in inputs.images)

    def _image(self, image: EyeImage, age_ns: int, free: Iterator[_Moved]) -> EyeImage:
        """Return the image as it is `age_ns` later; the same object where nothing has moved.

        The result has no ids and velocities: they no longer fit.
        """
        ids = image.get("ids") if RIGID in self.parts else None
        maps = [body_map(state, age_ns, image.view, image.size) for state in ids.bodies] if ids is not None else []
        if len(maps) > MOST_BODIES:
            raise InputError(f"a frame with {len(maps)} bodies: '{self.name}' takes {MOST_BODIES} at most")
        soft = "velocity" in image and SOFT in self.parts and swing_seconds(age_ns) != 0
        if not soft and all(map(rests, maps)):
            return image
        into = next(free)
        named = {"steepest": steepest(image.view, self.rendered_size, STEEPEST_DEG), "body_count": len(maps)}
        from_tangent = image.view.fov.pixel_from_tangent(self.rendered_size)
        named |= {"rendered_size": self.rendered_size, "pixel_from_eye": from_tangent @ np.diag([1.0, 1.0, -1.0])}
        named |= {"seconds": swing_seconds(age_ns), "reach_m": REACH_M, "nearest": 1 / NEAREST_M}
        named |= {"words": self._words, "draws": self._draws, "draw_quads": QUADS}
        named |= self._bind(image, maps, into)
        for program, size in (
            (self._split, self.rendered_size),
            (self._order, (1, 1)),
            (self._list, self.rendered_size),
        ):
            program.uniforms.set_declared(**named)
            program.run(*size)
            self.gpu.barrier()
        self._draw_moving(named, into)
        moved = attrs.evolve(image, colour=into.colour, inverse_depth=into.inverse_depth)
        return moved.having(ids=None, velocity=None)

    def _bind(self, image: EyeImage, maps: Sequence[WarpMap], into: _Moved) -> dict[str, Any]:
        """Bind all that the programs read and write; return the units."""
        numbers = image["ids"].numbers if "ids" in image else None
        found = {"rendered_ids": numbers, "rendered_velocity": image.get("velocity")}
        read = {"rendered_colour": image.colour, "rendered_inverse_depth": image.inverse_depth}
        read |= {name: texture for name, texture in found.items() if texture is not None}
        for unit, texture in enumerate(read.values()):  # each is sampled in the unit in which it is an image
            texture.use(unit)
        write = {"still_colour": into.colour, "still_inverse_depth": into.inverse_depth}
        if maps:
            # The columns of H, then e; the first column's fourth number is 1 for a moving body.
            table = np.zeros((len(maps), 4, 4), np.float32)
            for row, one in zip(table, maps, strict=True):
                row[:3, :3], row[3, :3], row[0, 3] = one.H.T, one.e, not rests(one)
            self._buffers[0].write(table.tobytes())
        for binding, buffer in enumerate(self._buffers):
            buffer.bind_to_storage_buffer(binding)
        return bind_images(read, write)

    def _draw_moving(self, named: dict[str, Any], into: _Moved) -> None:
        gl = self.gpu.gl
        self._draw.uniforms.set_declared(**named)
        mask = into.framebuffer.color_mask
        into.framebuffer.color_mask = ((False,) * 4,) * 2  # type: ignore[assignment]  # one mask for each attachment
        with drawing_into(into.framebuffer, moderngl.DEPTH_TEST | moderngl.CULL_FACE):
            into.framebuffer.clear(depth=1.0)
        # Outside the scope: moderngl 5.13 applies a mask only when it binds the framebuffer again.
        into.framebuffer.color_mask = mask
        with drawing_into(into.framebuffer, moderngl.DEPTH_TEST | moderngl.CULL_FACE):
            gl.depth_func = "<"
            self._array.render_indirect(self._buffers[3], moderngl.TRIANGLES, count=self._draws)
        self.gpu.barrier()


effects.declare("rigid_motion", MotionPass, Needs(ids=True), applies=lambda _, mesh: mesh.body > 0)

effects.declare("soft_motion", MotionPass, Needs(velocity=True), applies=lambda _, mesh: mesh.deformation is not None)
