"""Sections of a bench besides its rows: error against motion, and warps fused with the lens."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...client.compensator import Compensator
from ...client.inputs import History, PassInputs
from ...client.lens import lenses
from ...client.plan import needs_of
from ...colour import picture_from_linear
from ...errors import HmdwarpError
from ...geometry import Pose
from ...gpu.textures import Canvas, download
from ...link import LinkOptions
from ...metrics import Compared, QualityJob, QualityPool, sharpness
from ...pipeline.channel import Channel, ChannelSetup
from ...pipeline.frame_coder import Reads
from ...pipeline.loop import Loop
from ...pipeline.source import PoseRequest, ServerFrames
from ...poses import Origin, PoseSample
from ...run.combinations import Combination, instants_of
from ...run.frame_rows import stage_columns
from ...run.replay_setup import ReplaySetup
from ...run.side_by_side import refreshes
from ...run.truth import WholePictures, coverage, shown_picture
from ...scenes import Scene
from ...sources.server.targets import Target, TargetPool
from .cases import plan_of
from .options import BenchOptions

# Of the displacement grid.
METRES, DEGREES = 0.3, 30.0
AXES = ("x", "y", "z", "yaw", "pitch", "roll")
GRID_SIZE = (400, 400)
# (axis, metres or degrees) of every displacement, three to either side. x is right, y up, z
# backwards; yaw left, pitch up, roll left.
OFFSETS = [(axis, k / 3 * (METRES if axis in "xyz" else DEGREES)) for axis in AXES for k in range(-3, 4) if k]
GRID_STEPS = len(OFFSETS) + 1
# Of fused warps.
INSTANTS = 3
SUPERSAMPLING = 3
FORMS = ("fused", "separate")
EYE = 0


def displaced(viewpoint: Pose, axis: str, offset: float) -> Pose:
    """Return world_from_head after a movement in the head's own frame."""
    if axis in ("x", "y", "z"):
        return viewpoint @ Pose(offset * np.eye(3)["xyz".index(axis)])
    half = math.radians(offset) / 2
    about = np.eye(3)[{"pitch": 0, "yaw": 1, "roll": 2}[axis]]
    return viewpoint @ Pose(orientation_xyzw=(*(math.sin(half) * about), math.cos(half)))


class Scripted:
    """A PoseSource: at the viewpoint up to time 0, then each displacement for a nanosecond."""

    def __init__(self, scene: Scene, moves: list[tuple[str, float]]) -> None:
        self._poses = [displaced(scene.viewpoint, axis, offset) for axis, offset in moves]
        self._rest = scene.viewpoint

    def start(self) -> None:
        """Do nothing."""

    def head_at(self, time_ns: int) -> PoseSample:
        """Return the pose. Errors: HmdwarpError after the last displacement."""
        if time_ns > len(self._poses):
            raise HmdwarpError(f"the script has {len(self._poses)} displacements: expected no time after them")
        return PoseSample(time_ns, self._poses[time_ns - 1] if time_ns > 0 else self._rest, Origin.MEASURED)

    def close(self) -> None:
        """Do nothing."""


def grid_rows(
    setup: ReplaySetup, warps: list[Combination], pool: QualityPool, step: Callable[[], None]
) -> list[dict[str, Any]]:
    """Return the `grid` of bench.json: every warp (unfilled combinations), left eye.

    It is the error against motion: one late frame from the scene's viewpoint, and a head moved
    since. setup: has the server, the headset and the size. The head has been at rest before, so
    older frames equal the newest one.
    """
    moves = [("x", 0.0), *OFFSETS]
    with ExitStack() as stack:
        loop = _loop(setup, warps, Scripted(setup.scene, moves), stack)
        compensators = [setup.compensator(c.plan) for c in warps]
        targets = TargetPool(setup.gpu, setup.size)
        stack.callback(targets.close)
        target, whole = targets.acquire(), WholePictures(setup.server)
        stack.callback(whole.close)
        for number in range(len(moves)):
            refresh = loop.show(number + 1)
            assert refresh is not None  # the link has no latency
            truth = setup.server.draw(refresh.inputs[EYE].shown, setup.size, target, refresh.shown_ns)
            picture = picture_from_linear(download(truth.colour))
            for combination, compensator in zip(warps, compensators, strict=True):
                result = compensator.run(whole.inputs(loop, refresh, combination.plan)[EYE])
                shown = Compared(shown_picture(result), picture, result.view)
                setup.hand_in(pool, (combination.warp, number), QualityJob(shown, covered=coverage(result)))
            setup.gpu.timer.collect()
            step()
        pool.wait()
    # By axis and offset, the head at rest once for every axis.
    numbered = [*enumerate(OFFSETS, 1), *((0, (axis, 0.0)) for axis in AXES)]
    numbered.sort(key=lambda entry: (AXES.index(entry[1][0]), entry[1][1]))
    rows = []
    for combination in warps:
        for number, (axis, offset) in numbered:
            figures = pool.results[combination.warp, number]
            means = {name: figures[name] for name in ("psnr_db", "flip", "hole_share")}
            rows.append({"warp": combination.warp, "axis": axis, "offset": offset, **means})
    return rows


def _loop(setup: ReplaySetup, warps: list[Combination], source: Scripted, stack: ExitStack) -> Loop:
    """Return a second loop on the setup's server, whose newest frame was drawn at time 0."""
    needs = needs_of(c.plan for c in warps)
    history = History(needs.others.past, needs.others.spacing_ns, setup.server.recycle)
    stack.callback(history.close)
    through = ChannelSetup(LinkOptions(), 0, setup.schedule.rate_hz, None, Reads(), history.offer)
    channel = Channel(through, setup.server.recycle)
    stack.callback(channel.close)
    request = PoseRequest(source, None, setup.size, setup.options.guard_band, needs)
    frames = ServerFrames(setup.server, request, setup.headset)
    loop = Loop(request, frames, channel, history, setup.compensator(setup.plan), setup.headset)
    for back in range(needs.others.past, -1, -1):
        loop.draw_at(-back * max(1, needs.others.spacing_ns))
    return loop


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


def fused_steps(instants: int) -> int:
    """Return how many instants are measured of so many of a case."""
    return min(INSTANTS, instants)


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
    numbers = instants_of(setup.schedule.count, fused_steps(instants))
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
                _compare(setup, pair, inputs[pair.warp], number, truth, seen, pool)
            setup.gpu.timer.collect()
            step()
        pool.wait()
    finally:
        whole.close()
        truth_of.close()
    return [_fused_row(pair, numbers, pool) for pair in pairs]


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
    setup: ReplaySetup,
    pair: _Pair,
    inputs: PassInputs,
    number: int,
    truth: NDArray[np.uint8],
    seen: NDArray[np.bool_],
    pool: QualityPool,
) -> None:
    panels = {form: download(pair.compensators[form].run(inputs).panel.texture) for form in FORMS}
    both = seen & np.logical_and.reduce([panel[..., 3] == 1 for panel in panels.values()])
    for form, panel in panels.items():
        picture = picture_from_linear(panel)
        found = sharpness(picture, truth, both)
        if found is not None:
            pair.sharpness[form].append(found)
        setup.hand_in(pool, (pair.warp, form, number), QualityJob(Compared(picture, truth, inputs.shown)))


def _fused_row(pair: _Pair, numbers: list[int], pool: QualityPool) -> dict[str, Any]:
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
