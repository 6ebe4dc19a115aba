"""Warps that draw the scene which the client has, in place of warping a picture."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from ...errors import PlanError
from ...gpu.textures import SCALAR, Canvas, allocate
from ...scenes import Scene
from ..client_scene import ClientScene
from ..inputs import PassInputs
from ..warps import Warp


class ClientDrawing(Warp):
    """Draw for the shown view and instant, with a depth buffer of its own where none is given.

    A subclass draws in run_with_depth().
    """

    kind = "draw"
    needs_compute = False
    depth_reads = ()
    carries = False
    # Whether it is only for scenes whose light moves.
    for_moving_light: ClassVar[bool] = False

    @classmethod
    def unsuited(cls, scene: Scene) -> str:
        still = cls.for_moving_light and not scene.lamps
        return "its light stands still, so that 'model' with baked light is exact" if still else ""

    def prepare(self) -> None:
        if self.geometry is None:
            raise PlanError(f"warp '{self.name}' needs the scene on the client; for frames without one use 'iterative'")
        # Target for depth that is not read; it keeps near surfaces before far ones.
        self._own_depth = allocate(self.gpu.gl, self.shown_size, SCALAR)
        self.prepare_scene(self.geometry)

    @abstractmethod
    def prepare_scene(self, geometry: ClientScene) -> None:
        """Take what is drawn from the client."""

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        self.run_with_depth(inputs, into, self._own_depth)

    def close(self) -> None:
        super().close()
        self._own_depth.release()
