"""What every lens pass is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    import moderngl

    from ...geometry import Fov
    from ...gpu.context import Gpu
    from ...gpu.shaders import Compute
    from ...gpu.textures import Canvas
    from ...headsets import Headset


# Image unit of the picture that programs for the panel look into.
TEXELS_UNIT = 7


def panel_defines(gpu: Gpu) -> dict[str, object]:
    """How a program that includes lib/panel.glsl does its pixels: ROWS of a column in one invocation, by image loads or the sampler.

    llvmpipe: 32 rows take 0.8 of the time of 8, because the ends of what sees are looked for once, and a blind neighbourhood costs one
    row in 32. A GPU wants invocations.
    """
    return {"ROWS": 32, "TEXELS": 1} if gpu.is_software else {"ROWS": 4}


def bind_texels(program: Compute, picture: moderngl.Texture) -> None:
    """Bind what a program for the panel looks into by image loads, if it does."""
    if program.uniforms.declares("rendered_texels"):
        picture.bind_to_image(TEXELS_UNIT, read=True, write=False)
        program.uniforms.set(rendered_texels=TEXELS_UNIT)


class LensPass(ABC):
    """Distorts the shown picture so that the headset's lens undoes it. is_pass: False where nothing is to be done.

    look: the shader library with `prepare_lens`, `vec3 lens_scales(vec2 on_lens)` and their uniforms, which a gather warp that is
    fused with the lens includes too.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    source: ClassVar[str]
    reads: ClassVar[tuple[str, ...]] = ("shown.colour",)
    is_pass: ClassVar[bool] = True
    look: ClassVar[str] = ""

    def __init__(self, gpu: Gpu, headset: Headset, panel_size: tuple[int, int]) -> None:
        self.gpu, self.headset, self.panel_size = gpu, headset, panel_size
        self.prepare()

    @abstractmethod
    def prepare(self) -> None:
        """Compile the programs; run() does not. Errors: InputError if the headset has no coefficients for this lens."""

    @abstractmethod
    def run(self, shown: Canvas, fov: Fov, eye: int, into: Canvas) -> None:
        """Write the panel picture of eye 0 (left) or 1 (right) into `into`."""

    def look_defines(self) -> dict[str, object]:
        """The defines of a program that includes `look`: the lens's own, and how its pixels are shared out on this device."""
        return {**panel_defines(self.gpu)}

    def look_uniforms(self, fov: Fov, eye: int) -> dict[str, object]:
        """The uniforms of `look` for one eye."""
        raise NotImplementedError(f"lens '{self.name}' has no look of its own")

    @classmethod
    def bytes_moved(cls, panel_pixels: int) -> int:
        """What one eye's panel must at least read and write in memory: one colour of 8 bytes each way."""
        return 16 * panel_pixels
