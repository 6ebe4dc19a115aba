"""Runs a plan on the GPU: one eye's late picture in, what the eye should see now out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import attrs
import moderngl

from ..geometry import View
from ..gpu.context import Gpu
from ..gpu.textures import SCALAR, Canvas, allocate
from ..headsets import Headset
from .given import Given
from .plan import Plan
from .warps import Output

Stages = Sequence[tuple[str, float]]
DrawDepth = Callable[[View, tuple[int, int], moderngl.Texture], object]


@attrs.frozen(eq=False)
class EyeResult:
    """One eye after the plan. view: what is shown, half way through the scan-out if the display has one. `warped` holds the coverage
    before the fill, `shown` what the eye sees before the lens, `panel` what goes to the display; a warp that is fused with the lens
    makes the panel alone, the others are None then. The textures belong to the compensator and are written again at the next frame
    of that eye."""

    view: View
    warped: Canvas | None
    shown: Canvas | None
    panel: Canvas


class Compensator:
    """The passes of one plan for one pair of sizes, compiled and allocated at the start; run() only sets and dispatches.

    headset: whose lens is applied; None if the plan has no lens. draw_depth(view, size, into): draws the client's own depth;
    wanted only if the plan has that pass.
    """

    def __init__(
        self,
        gpu: Gpu,
        plan: Plan,
        headset: Headset | None,
        late_size: tuple[int, int],
        shown_size: tuple[int, int],
        draw_depth: DrawDepth | None = None,
    ) -> None:
        self.gpu, self.plan, self.shown_size = gpu, plan, shown_size
        self._draw_depth = draw_depth
        self._client_depth = allocate(gpu.gl, shown_size, SCALAR) if plan.draws_client_depth else None
        lens = plan.lens(gpu, headset, shown_size) if plan.lens.is_pass else None
        self._lens = None if plan.fused else lens
        output = Output(lens if plan.fused else None, plan.scanout)
        self._warp = plan.warp(gpu, late_size, shown_size, plan.choice.settings, output)
        self._fill = plan.fill(gpu, shown_size) if plan.fill.is_pass else None
        self._canvases = [self._canvases_of_one_eye() for _ in range(2)]

    def _canvases_of_one_eye(self) -> tuple[Canvas | None, Canvas | None, Canvas]:
        if self.plan.fused:
            return None, None, Canvas(self.gpu.gl, self.shown_size)
        warped = Canvas(self.gpu.gl, self.shown_size)
        shown = Canvas(self.gpu.gl, self.shown_size) if self._fill else warped
        panel = Canvas(self.gpu.gl, self.shown_size) if self._lens else shown
        return warped, shown, panel

    def run(self, given: Given) -> EyeResult:
        """Every pass of the plan for eye 0 or 1, each timed as a stage of gpu.timer."""
        warped, shown, panel = self._canvases[given.eye]
        given = given if self.plan.scanout else given.at_once()
        stage = self.gpu.timer.stage
        if self._client_depth is not None:
            with stage("client_depth"):
                self._draw_depth(given.shown, self.shown_size, self._client_depth)
            given = attrs.evolve(given, client_inverse_depth=self._client_depth)
        with stage("warp"):
            self._warp.run(given, warped if warped is not None else panel)
            self._publish()
        if self._fill is not None:
            with stage("fill"):
                self._fill.run(warped, shown)
                self._publish()
        if self._lens is not None:
            with stage("lens"):
                self._lens.run(shown, given.shown.fov, given.eye, panel)
                self._publish()
        return EyeResult(given.middle, warped, shown, panel)

    def took(self, stages: Sequence[Stages]) -> None:
        """What the passes of each eye took at a refresh: a single plan has nothing to decide by it."""

    def _publish(self) -> None:
        """Make what a compute pass stored visible to the next pass, to copies and to read-backs."""
        self.gpu.gl.memory_barrier(moderngl.ALL_BARRIER_BITS)

    def close(self) -> None:
        """Free every texture and buffer of the plan."""
        self._warp.close()
        for canvas in {id(c): c for eye in self._canvases for c in eye if c is not None}.values():
            canvas.release()
        if self._client_depth is not None:
            self._client_depth.release()
