"""Error against motion: one late frame from the scene's viewpoint, and a head moved since."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import numpy as np

from ...client.compensator import Compensator
from ...client.history import History
from ...client.plan import needs_of
from ...colour import picture_from_linear
from ...errors import HmdwarpError
from ...geometry import Pose
from ...gpu.textures import download
from ...link import LinkOptions
from ...metrics import Compared, QualityJob, QualityPool
from ...pipeline.channel import Channel
from ...pipeline.frame_source import ServerFrames
from ...pipeline.layers_read import Reads
from ...pipeline.loop import Loop
from ...pipeline.requested import PoseRequest
from ...poses import Origin, PoseSample
from ...run.combinations import Combination
from ...run.read_back import coverage, shown_picture
from ...run.replay_setup import ReplaySetup
from ...run.whole_pictures import WholePictures
from ...scenes import Scene
from ...sources.server.targets import TargetPool

METRES, DEGREES = 0.3, 30.0
STEPS = 3  # to either side
SIZE = (400, 400)
AXES = ("x", "y", "z", "yaw", "pitch", "roll")


def offsets() -> list[tuple[str, float]]:
    """Return (axis, metres or degrees) of every displacement.

    x is right, y up, z backwards; yaw left, pitch up, roll left.
    """
    shares = [k / STEPS for k in range(-STEPS, STEPS + 1) if k]
    return [(axis, share * (METRES if axis in "xyz" else DEGREES)) for axis in AXES for share in shares]


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

    setup: has the server, the headset and the size. The head has been at rest before, so older
    frames equal the newest one.
    """
    moves = [("x", 0.0), *offsets()]
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
            truth = setup.server.draw(refresh.inputs[0].shown, setup.size, target, refresh.shown_ns)
            picture = picture_from_linear(download(truth.colour))
            for combination, compensator in zip(warps, compensators, strict=True):
                result = compensator.run(whole.inputs(loop, refresh, combination.plan)[0])
                shown = Compared(shown_picture(result), picture, result.view)
                pool.submit((combination.warp, number), QualityJob(shown, covered=coverage(result)))
            setup.gpu.timer.collect()
            step()
        pool.wait()
    return [_row(c.warp, move, pool.results[c.warp, number]) for c in warps for number, move in _with_rest(moves)]


def _loop(setup: ReplaySetup, warps: list[Combination], source: Scripted, stack: ExitStack) -> Loop:
    """Return a second loop on the setup's server, whose newest frame was drawn at time 0."""
    needs = needs_of(c.plan for c in warps)
    history = History(needs.others.past, needs.others.spacing_ns, setup.server.recycle)
    stack.callback(history.close)
    recycle, rate_hz = setup.server.recycle, setup.schedule.rate_hz
    channel = Channel(LinkOptions(), 0, None, Reads(), history.offer, recycle, rate_hz)
    stack.callback(channel.close)
    main: Compensator = setup.compensator(setup.plan)
    request = PoseRequest(source, None, setup.size, setup.options.guard_band, needs)
    frames = ServerFrames(setup.server, request, setup.headset)
    loop = Loop(request, frames, channel, history, main, setup.headset)
    for back in range(needs.others.past, -1, -1):
        loop.draw_at(-back * max(1, needs.others.spacing_ns))
    return loop


def _with_rest(moves: list[tuple[str, float]]) -> list[tuple[int, tuple[str, float]]]:
    """Return (number, move), sorted by axis and offset, the head at rest once for every axis."""
    numbered = [(number, move) for number, move in enumerate(moves) if number]
    numbered += [(0, (axis, 0.0)) for axis in AXES]
    return sorted(numbered, key=lambda entry: (AXES.index(entry[1][0]), entry[1][1]))


def _row(warp: str, move: tuple[str, float], figures: dict[str, float | None]) -> dict[str, Any]:
    axis, offset = move
    return {
        "warp": warp,
        "axis": axis,
        "offset": offset,
        **{name: figures[name] for name in ("psnr_db", "flip", "hole_share")},
    }
