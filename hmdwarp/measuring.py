"""Compares what the loop shows with what a renderer without latency would have shown, on every n-th refresh."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .client.compensator import Compensator, EyeResult
from .client.plan import build_plan
from .colour import picture_from_linear
from .frame import EyeImage
from .gpu.textures import download
from .loop import Refresh
from .metrics.job import Compared, QualityJob
from .metrics.pool import QualityPool
from .rig import Rig
from .server.targets import TargetPool

# The two things measured at a refresh: the asked-for warp and the one it is compared with.
MAIN, AGAINST = 0, 1
Key = tuple[int, int, int]  # (refresh, eye, MAIN or AGAINST)


class Probe:
    """Draws the truth at the shown views, reads pictures back and hands them to the measuring processes.

    Flicker needs the refresh before a measured one too, so that one is drawn and read as well, but not measured.
    """

    def __init__(self, rig: Rig, pool: QualityPool, keep_every: int | None) -> None:
        self._rig, self._pool, self._keep_every = rig, pool, keep_every
        self._every = rig.options.metrics_every
        self._target = TargetPool(rig.gpu, rig.size).acquire()
        self._against = self._baseline()
        self._before: dict[tuple[int, int], tuple[int, Compared]] = {}
        self.against_ms: dict[tuple[int, int], tuple[tuple[str, float], ...]] = {}

    def _baseline(self) -> Compensator | None:
        options = self._rig.options
        if options.against in ("", options.warp):
            return None
        return self._rig.compensator(build_plan(self._rig.scene.effects, options.against, "none", "none", client_geometry=True))

    def wants(self, number: int) -> bool:
        """Whether refresh `number` is measured, or is the neighbour of a measured one."""
        return number % self._every == 0 or (number + 1) % self._every == 0

    def look(self, number: int, refresh: Refresh) -> None:
        """Read back both eyes of refresh `number`, and submit them if it is a measured one."""
        for eye, result in enumerate(refresh.eyes):
            late = refresh.frame.eyes[eye]
            truth = self._rig.server.draw(result.view, self._rig.size, self._target)
            picture = picture_from_linear(download(truth.colour))
            # The neighbour of a measured refresh is read for flicker alone.
            depth = None if number % self._every else download(truth.inverse_depth)
            self._take(number, eye, MAIN, late, result, picture, depth)
            if self._against is not None:
                other = self._against.run(self._rig.loop.given(refresh, self._against.plan.needs)[eye])
                self.against_ms[number, eye] = tuple(self._rig.gpu.timer.collect())
                self._take(number, eye, AGAINST, late, other, picture, depth)

    def _take(
        self,
        number: int,
        eye: int,
        which: int,
        late: EyeImage,
        result: EyeResult,
        truth: NDArray[np.uint8],
        truth_inverse_depth: NDArray[np.float32] | None,
    ) -> None:
        now = Compared(picture_from_linear(download(result.shown.texture)), truth, result.view)
        before_number, before = self._before.get((eye, which), (None, None))
        self._before[eye, which] = (number, now)
        if truth_inverse_depth is None:
            return
        job = QualityJob(
            now,
            before if before_number == number - 1 else None,
            download(result.warped.texture)[..., 3],
            truth_inverse_depth,
            late.view,
            late.size,
            late=picture_from_linear(download(late.colour)) if which == MAIN else None,
        )
        keep = which == MAIN and self._keep_every is not None and number % self._keep_every == 0
        self._pool.submit((number, eye, which), job, keep=keep)
