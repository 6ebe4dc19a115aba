"""Compares what the loop shows with what a renderer without latency would have shown, on every n-th refresh."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from ..client.compensator import Compensator, EyeResult
from ..colour import picture_from_linear
from ..frames import EyeImage
from ..gpu.textures import download
from ..metrics import Compared, QualityJob, QualityPool
from ..pipeline.loop import Refresh
from ..pipeline.planning import build_plan_for, plan_against
from .rig import Rig
from .truth import MOST_BANDS, draw_truth

# The two things measured at a refresh: the asked-for warp and the one it is compared with.
MAIN, AGAINST = 0, 1
Key = tuple[int, int, int]  # (refresh, eye, MAIN or AGAINST)


class Probe:
    """Draws the truth at the shown views, reads pictures back and hands them to the measuring processes.

    Measured is what the eye sees before the lens. A warp that is fused with the lens does not make that, so the same warp without the
    lens is run for it; what it takes is not counted. The truth of a display that lights up row by row is drawn in bands. Flicker needs
    the refresh before a measured one too, so that one is drawn and read as well, but not measured.
    """

    def __init__(self, rig: Rig, pool: QualityPool, keep_every: int | None) -> None:
        self._rig, self._pool, self._keep_every = rig, pool, keep_every
        self._every = rig.options.metrics_every
        self._unfused = self._without_lens()
        self._against = self._baseline()
        self._before: dict[tuple[int, int], tuple[int, Compared]] = {}
        self._empty: dict[str, list[float]] = {}
        self.against_ms: dict[tuple[int, int], tuple[tuple[str, float], ...]] = {}

        if rig.options.scanout_ms:
            rig.notes.append(_about_scanout(rig))

    def _without_lens(self) -> Compensator | None:
        rig = self._rig
        if not rig.plan.fused:
            return None
        rig.notes.append(
            "Warp and lens are one pass: quality was measured on the same warp without the lens, whose time is not counted."
        )
        alone = attrs.evolve(rig.options, fused=False, lens="none", fill="none")
        return rig.compensator(build_plan_for(alone, rig.headset, rig.scene))

    def _baseline(self) -> Compensator | None:
        options = self._rig.options
        if options.against in ("", options.warp):
            return None
        return self._rig.compensator(plan_against(options.against))

    def wants(self, number: int) -> bool:
        """Whether refresh `number` is measured, or is the neighbour of a measured one."""
        return number % self._every == 0 or (number + 1) % self._every == 0

    def look(self, number: int, refresh: Refresh) -> None:
        """Read back both eyes of refresh `number`, and submit them if it is a measured one."""
        for eye in range(len(refresh.eyes)):
            rendered = refresh.frame.eyes[eye]
            # The neighbour of a measured refresh is read for flicker alone.
            truth = draw_truth(self._rig.server, refresh.inputs[eye], self._rig.size, depth=number % self._every == 0)
            picture, depth = picture_from_linear(truth.colour), truth.inverse_depth
            result = self._before_lens(refresh, eye)
            self._take(number, eye, MAIN, rendered, result, picture, depth)
            if depth is not None:
                self._count_filled(result)
            if self._against is not None:
                self._look_against(number, eye, refresh, picture, depth)

    def _look_against(
        self, number: int, eye: int, refresh: Refresh, truth: NDArray[np.uint8], depth: NDArray[np.float32] | None
    ) -> None:
        """The compared warp knows no effects: its late picture has everything drawn in, nothing as a layer."""
        inputs, server = self._rig.loop.inputs(refresh, self._against.plan.needs)[eye], self._rig.server
        whole = None
        if self._rig.plan.effects:
            whole = server.draw(inputs.rendered.view, inputs.rendered.size, time_ns=inputs.rendered.drawn_ns)
            inputs = attrs.evolve(
                inputs, rendered=attrs.evolve(inputs.rendered, colour=whole.colour, inverse_depth=whole.inverse_depth)
            )
            self._rig.gpu.timer.collect()
        other = self._against.run(inputs)
        self.against_ms[number, eye] = tuple(self._rig.gpu.timer.collect())
        self._take(number, eye, AGAINST, inputs.rendered, other, truth, depth)
        if whole is not None:
            server.pool(whole.size).release(whole.colour)

    def _count_filled(self, result: EyeResult) -> None:
        for name, canvas in (("warp", result.warped), *result.filled):
            self._empty.setdefault(name, []).append(float((download(canvas.texture)[..., 3] == 0).mean()))

    def filled_shares(self) -> dict[str, float]:
        """What share of all pixels of the measured pictures each fill of the chain filled, and what was left ("empty").

        Without warp "auto": its chain changes, so a share of the whole would mean nothing.
        """
        if self._rig.auto is not None or not self._empty:
            return {}
        left = {name: sum(shares) / len(shares) for name, shares in self._empty.items()}
        names = list(left)
        filled = {name: left[before] - left[name] for before, name in zip(names, names[1:], strict=False)}
        return {**filled, "empty": left[names[-1]]}

    def _before_lens(self, refresh: Refresh, eye: int) -> EyeResult:
        if self._unfused is None:
            return refresh.eyes[eye]
        made = self._unfused.run(refresh.inputs[eye])
        self._rig.gpu.timer.collect()
        return made

    def _take(
        self,
        number: int,
        eye: int,
        which: int,
        rendered: EyeImage,
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
            rendered.view,
            rendered.size,
            rendered_picture=picture_from_linear(download(rendered.colour)) if which == MAIN else None,
            regions=which == MAIN,
        )
        keep = which == MAIN and self._keep_every is not None and number % self._keep_every == 0
        self._pool.submit((number, eye, which), job, keep=keep)


def _about_scanout(rig: Rig) -> str:
    how = "follows it row by row" if rig.plan.scanout else "shows all rows as in its middle"
    told = [
        f"The display scans out for {rig.options.scanout_ms:g} ms; warp '{rig.options.warp}' {how}.",
        f"The truth is drawn in up to {MOST_BANDS} bands, each for its own instant; holes and flicker are told as in the middle of it.",
    ]
    return " ".join(told)
