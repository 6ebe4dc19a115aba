"""Lens models on the GPU: one file each, registered by name.

Their coefficients belong to the headsets.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import moderngl

from ...geometry import Fov
from ...gpu.context import Gpu
from ...gpu.shaders import Compute
from ...gpu.textures import Canvas
from ...headsets import Headset
from ...registry import Registry

# Image unit of the picture that programs for the panel read.
TEXELS_UNIT = 7
# Of a program that includes lib/panel.glsl. ROWS: pixels of a column per invocation. TEXELS: image
# loads instead of the sampler. On llvmpipe 32 rows take 0.8 of the time of 8, because the ends of
# the visible part are computed once per column. A GPU needs many invocations.
SOFTWARE_DEFINES = {"ROWS": 32, "TEXELS": 1}
GPU_DEFINES = {"ROWS": 4}


def bind_texels(program: Compute, picture: moderngl.Texture) -> None:
    """Bind the picture that a panel program reads by image loads, if it uses them."""
    if program.uniforms.declares("rendered_texels"):
        picture.bind_to_image(TEXELS_UNIT, read=True, write=False)
        program.uniforms.set(rendered_texels=TEXELS_UNIT)


class LensPass(ABC):
    """Distort the shown picture so that the headset's lens undoes it."""

    name: ClassVar[str]
    summary: ClassVar[str]
    source: ClassVar[str]
    reads: ClassVar[tuple[str, ...]] = ("shown.colour",)
    is_pass: ClassVar[bool] = True  # False if there is nothing to do.
    # The shader library with `prepare_lens`, `vec3 lens_scales(vec2 on_lens)` and their uniforms; a
    # gather warp that is fused with the lens includes it too. "" if there is none.
    library: ClassVar[str] = ""

    def __init__(self, gpu: Gpu, headset: Headset, panel_size: tuple[int, int]) -> None:
        self.gpu, self.headset, self.panel_size = gpu, headset, panel_size
        self.prepare()

    @abstractmethod
    def prepare(self) -> None:
        """Compile the programs; run() does not.

        Errors: InputError if the headset has no coefficients for this lens.
        """

    @abstractmethod
    def run(self, shown: Canvas, fov: Fov, eye: int, into: Canvas) -> None:
        """Write the panel picture of eye 0 (left) or 1 (right) into `into`."""

    def library_defines(self) -> dict[str, object]:
        """Return the defines of a program that includes `library`, for this lens and device."""
        return dict(SOFTWARE_DEFINES if self.gpu.is_software else GPU_DEFINES)

    def library_uniforms(self, fov: Fov, eye: int) -> dict[str, object]:
        """Return the uniforms of `library` for one eye."""
        raise NotImplementedError(f"lens '{self.name}' cannot be fused with a warp")

    @classmethod
    def bytes_moved(cls, panel_pixels: int) -> int:
        """Return the least bytes that one eye's panel moves: one colour each way."""
        return 16 * panel_pixels


lenses: Registry[type[LensPass]] = Registry("lens", __name__)

__all__ = ["GPU_DEFINES", "SOFTWARE_DEFINES", "LensPass", "bind_texels", "lenses"]
