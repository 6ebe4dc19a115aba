"""The kind of warps through one homography: a single bilinear sample per pixel."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .gather import GatherWarp

if TYPE_CHECKING:
    from ...gpu.textures import Canvas
    from ..inputs import PassInputs


class HomographyWarp(GatherWarp):
    """A gather through a 3x3 matrix that does not depend on depth."""

    reads = ("rendered.colour",)

    @property
    def clamps(self) -> bool:
        """Whether the outermost pixels of the rendered picture go on beyond its border."""
        return False

    def prepare(self) -> None:
        self._program = self.gather("warps/rotation.comp", CLAMP=int(self.clamps))

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        self.bind_beside(self._program, inputs)
        self.run_gather(self._program, inputs, into)
