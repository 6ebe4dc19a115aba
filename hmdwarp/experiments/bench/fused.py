"""Fused warps: one resample from late picture to panel against two, in sharpness and time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...client.compensator import Compensator
from ...client.inputs import PassInputs
from ...client.lens import lenses
from ...client.plan import needs_of
from ...colour import picture_from_linear
from ...gpu.textures import Canvas, download
from ...metrics import Compared, QualityJob, QualityPool, sharpness
from ...run.combinations import instants_of
from ...run.frame_rows import stage_columns
from ...run.replay_setup import ReplaySetup
from ...run.side_by_side import refreshes
from ...run.whole_pictures import WholePictures
from ...sources.server.targets import Target, TargetPool
from .cases import plan_of
from .options import BenchOptions

INSTANTS = 3
SUPERSAMPLING = 3
FORMS = ("fused", "separate")
EYE = 0


@attrs.frozen(eq=False)
class _Pair:
    """A warp in both forms, with its times and sharpness."""

    warp: str
    compensators: dict[str, Compensator]
    times: dict[str, list[float]] = attrs.field(factory=lambda: {form: [] for form in FORMS})
    sharpness: dict[str, list[float]] = attrs.field(factory=lambda: {form: [] for form in FORMS})


def pairs_of(setup: ReplaySetup, options: BenchOptions, warps: list[str], lens: str) -> list[_Pair]:
    """Return the warps that can be fused with the lens."""
    pairs = []
    for warp in warps:
        plan = plan_of(options, setup.scene, warp, "none", lens)
        if plan.warp.fuses:
            fused = plan_of(options, setup.scene, warp, "none", lens, fused=True)
            pairs.append(_Pair(warp, {"fused": setup.compensator(fused), "separate": setup.compensator(plan)}))
    return pairs


class PanelTruth:
    """The truth on the panel: the scene without latency, through the lens.

    It is drawn at several times the resolution and averaged in linear light.
    """

    def __init__(self, setup: ReplaySetup, lens: str) -> None:
        self._setup = setup
        wide, high = setup.size
        most = setup.gpu.max_texture_size // max(wide, high)
        self._times = max(1, min(SUPERSAMPLING, most))
        self._size = (self._times * wide, self._times * high)
        self._targets = TargetPool(setup.gpu, self._size)
        # A canvas is sampled bilinearly, as the lens expects; a target of the server is not.
        self._shown, self._panel = Canvas(setup.gpu.gl, self._size), Canvas(setup.gpu.gl, self._size)
        self._target = Target(self._shown.texture, self._targets.acquire().inverse_depth)
        self._lens = lenses.get(lens)(setup.gpu, setup.headset, self._size)

    def __call__(self, inputs: PassInputs) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
        """Return the sRGB picture (h, w, 3) and the lit pixels (h, w), top row first."""
        self._setup.server.draw(inputs.shown, self._size, self._target, inputs.shown_ns)
        self._lens.run(self._shown, inputs.shown.fov, inputs.eye, self._panel)
        self._setup.gpu.gl.memory_barrier()
        large = download(self._panel.texture).astype(np.float32)
        wide, high = self._setup.size
        mean = large.reshape(high, self._times, wide, self._times, 4).mean(axis=(1, 3))
        return picture_from_linear(mean), mean[..., 3] == 1

    def close(self) -> None:
        """Free the large pictures."""
        self._targets.close()
        self._shown.release()
        self._panel.release()


def fused_rows(
    setup: ReplaySetup,
    options: BenchOptions,
    warps: list[str],
    lens: str,
    pool: QualityPool,
    instants: int,
    rounds: int,
    step: Callable[[], None],
) -> list[dict[str, Any]]:
    """Return the `fused` of bench.json: the left eye at up to INSTANTS refreshes, both forms."""
    pairs = pairs_of(setup, options, warps, lens)
    truth_of, whole = PanelTruth(setup, lens), WholePictures(setup.server)
    numbers = instants_of(setup.schedule.count, min(INSTANTS, instants))
    needs = needs_of(compensator.plan for pair in pairs for compensator in pair.compensators.values())
    try:
        for number, refresh in refreshes(setup, needs, numbers):
            pool.wait()
            inputs = {
                pair.warp: whole.inputs(setup.loop, refresh, pair.compensators["fused"].plan)[EYE] for pair in pairs
            }
            _time(setup, pairs, inputs, rounds)
            truth, seen = truth_of(refresh.inputs[EYE])
            for pair in pairs:
                _compare(pair, inputs[pair.warp], number, truth, seen, pool)
            setup.gpu.timer.collect()
            step()
        pool.wait()
    finally:
        whole.close()
        truth_of.close()
    return [_row(pair, numbers, pool) for pair in pairs]


def _time(setup: ReplaySetup, pairs: list[_Pair], inputs: dict[str, PassInputs], rounds: int) -> None:
    setup.gpu.timer.collect()
    for round_ in range(rounds + 1):  # the first to warm up
        for pair in pairs:
            for form in FORMS if round_ % 2 else FORMS[::-1]:
                pair.compensators[form].run(inputs[pair.warp])
                total = stage_columns(setup.gpu.timer.collect())["total_ms"]
                if round_:
                    pair.times[form].append(total)


def _compare(
    pair: _Pair, inputs: PassInputs, number: int, truth: NDArray[np.uint8], seen: NDArray[np.bool_], pool: QualityPool
) -> None:
    panels = {form: download(pair.compensators[form].run(inputs).panel.texture) for form in FORMS}
    both = seen & np.logical_and.reduce([panel[..., 3] == 1 for panel in panels.values()])
    for form, panel in panels.items():
        picture = picture_from_linear(panel)
        found = sharpness(picture, truth, both)
        if found is not None:
            pair.sharpness[form].append(found)
        pool.submit((pair.warp, form, number), QualityJob(Compared(picture, truth, inputs.shown)))


def _row(pair: _Pair, numbers: list[int], pool: QualityPool) -> dict[str, Any]:
    milliseconds = {form: float(np.median(pair.times[form])) for form in FORMS}
    figures = pool.results
    means = {
        name: {form: float(np.mean([figures[pair.warp, form, number][name] for number in numbers])) for form in FORMS}
        for name in ("psnr_db", "flip")
    }
    sharp = {form: float(np.mean(pair.sharpness[form])) if pair.sharpness[form] else None for form in FORMS}
    return {
        "warp": pair.warp,
        "fused_ms": milliseconds["fused"],
        "separate_ms": milliseconds["separate"],
        "speedup": milliseconds["separate"] / milliseconds["fused"],
        **means,
        "sharpness": sharp,
    }
