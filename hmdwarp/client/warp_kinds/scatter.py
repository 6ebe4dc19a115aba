"""The kind of warps in which rendered pixels move, and the keys that decide which one wins."""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property
from typing import ClassVar

import moderngl

from ...errors import InputError
from ...geometry import WarpMap, view_map
from ...gpu.context import Gpu
from ...gpu.shaders import Compute
from ...gpu.textures import Canvas
from ..inputs import PassInputs
from ..warps import KEY_BYTES, Warp

SHOWN_COLOUR, RENDERED_COLOUR, RENDERED_DEPTH, SHOWN_DEPTH = range(4)  # image units
_UNITS = {
    "rendered_colour": RENDERED_COLOUR,
    "rendered_inverse_depth": RENDERED_DEPTH,
    "shown_colour": SHOWN_COLOUR,
    "shown_inverse_depth": SHOWN_DEPTH,
}
LONGEST_SIDE = 2**14  # a rank has 15 bits for a row and 15 for a column, one of each to spare


class ScatterWarp(Warp):
    """A warp in which rendered pixels move by their own depth."""

    kind = "scatter"
    reads = ("rendered.colour", "rendered.inverse_depth")
    depth_reads: ClassVar[tuple[str, ...] | None] = ("rendered.inverse_depth",)

    def forward_map(self, inputs: PassInputs) -> WarpMap:
        """Return the map from rendered to shown pixels."""
        return view_map(inputs.rendered.view, self.rendered_size, inputs.shown, self.shown_size)

    @cached_property
    def _constants(self) -> dict[str, object]:
        return {**self._size_uniforms, **_UNITS}

    def bind(self, inputs: PassInputs, into: Canvas) -> None:
        """Bind the rendered picture and the result as images for compute shaders."""
        inputs.rendered.colour.bind_to_image(RENDERED_COLOUR, read=True, write=False)
        inputs.rendered.inverse_depth.bind_to_image(RENDERED_DEPTH, read=True, write=False)
        into.bind_for_writing(SHOWN_COLOUR)
        if self.depth_into is not None:
            self.depth_into.bind_to_image(SHOWN_DEPTH, read=False, write=True)

    @property
    def depth_defines(self) -> dict[str, object]:
        """Defines of the shader that writes the shown pixels."""
        return {"WRITES_DEPTH": 1} if self.output.depth else {}

    def set(self, program: Compute, **more: object) -> None:
        """Set the sizes, the image units, and those of `more` that the program declares."""
        program.uniforms.settle(self._constants)
        program.uniforms.set_declared(**more)

    def empty_keys(self, words: int = 1) -> moderngl.Buffer:
        """Return keys of `words` 32-bit words for each shown pixel, all 0: nothing has landed.

        Errors: InputError for a picture beyond the GPU's buffer size.
        """
        check_room(self.gpu, self.name, self.shown_size, KEY_BYTES * words)
        buffer = self.gpu.gl.buffer(reserve=KEY_BYTES * words * self.shown_size[0] * self.shown_size[1])
        buffer.clear()
        return buffer


class OrderedScatter(ScatterWarp):
    """A scatter in which the last rendered pixel in some order wins.

    The shader `warps/NAME.comp` computes the order. Invocations may run in any order: each rendered
    pixel offers its rank, and the largest wins. The pass that copies the colours clears the keys
    again.
    """

    def prepare(self) -> None:
        if max(self.rendered_size) > LONGEST_SIDE:
            wide, high = self.rendered_size
            raise InputError(
                f"a rendered picture of {wide}x{high}: '{self.name}' takes at most {LONGEST_SIDE} pixels a side"
            )
        path, defines, shaders = f"warps/{self.name}.comp", self.defines(), self.gpu.shaders
        self._scatter = shaders.compute(path, grid="rendered", PASS=0, **defines)
        self._resolve = shaders.compute(path, PASS=1, **defines, **self.depth_defines)
        self._keys = self.empty_keys()

    def defines(self) -> dict[str, object]:
        """Return further defines of the shader."""
        return {}

    @abstractmethod
    def order(self, inputs: PassInputs) -> dict[str, object]:
        """Return the uniforms that define the order."""

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        forward, order = self.forward_map(inputs), self.order(inputs)
        self.bind(inputs, into)
        self._keys.bind_to_storage_buffer(0)
        for program, size in ((self._scatter, self.rendered_size), (self._resolve, self.shown_size)):
            self.gpu.barrier()
            self.set(program, H=forward.H, e=forward.e, **order)
            program.run(*size)

    def close(self) -> None:
        super().close()
        self._keys.release()


def check_room(gpu: Gpu, name: str, size: tuple[int, int], bytes_per_pixel: int, header: int = 0) -> None:
    """Raise InputError if one shader buffer cannot hold so many bytes per shown pixel."""
    pixels = (gpu.gl.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"] - header) // (4 * bytes_per_pixel) * 4
    if size[0] * size[1] > pixels:
        wanted = f"a shown picture of {size[0]}x{size[1]}: '{name}' keeps {bytes_per_pixel} bytes a pixel"
        raise InputError(f"{wanted}, this GPU has room for {pixels} pixels")
