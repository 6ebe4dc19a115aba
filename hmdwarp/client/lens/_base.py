"""What every lens pass is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from ...geometry import Fov
    from ...gpu.context import Gpu
    from ...gpu.textures import Canvas
    from ...headsets import Headset


class LensPass(ABC):
    """Distorts the shown picture so that the headset's lens undoes it. is_pass: False where nothing is to be done.

    look: the shader library with `vec3 lens_scales(float r2)` and its uniforms, which a gather warp that is fused with the lens
    includes too.
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

    def look_uniforms(self, fov: Fov, eye: int) -> dict[str, object]:
        """The uniforms of `look` for one eye."""
        raise NotImplementedError(f"lens '{self.name}' has no look of its own")

    @classmethod
    def bytes_moved(cls, panel_pixels: int) -> int:
        """What one eye's panel must at least read and write in memory: one colour of 8 bytes each way."""
        return 16 * panel_pixels
