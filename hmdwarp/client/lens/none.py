"""No lens: the shown picture goes to the panel as it is."""

from __future__ import annotations

from ...geometry import Fov
from ...gpu.textures import Canvas
from . import LensPass, lenses


@lenses.register
class NoLens(LensPass):
    """Leave the picture undistorted; the plan leaves this pass out."""

    name = "none"
    summary = "no distortion: for flat screens and for runtimes that distort by themselves"
    source = "the baseline of every lens"
    is_pass = False

    def prepare(self) -> None:
        """Do nothing."""

    def run(self, shown: Canvas, fov: Fov, eye: int, into: Canvas) -> None:
        raise AssertionError("the plan leaves this lens out")
