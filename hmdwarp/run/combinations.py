"""Combinations of warp and fill to compare: cases, batches, and refreshes."""

from __future__ import annotations

import importlib
import itertools
import time
from collections.abc import Iterable, Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..client.inputs import History, PassInputs
from ..client.plan import Plan, build_plan
from ..client.strategies import has_own_link
from ..client.warp_kinds import ArrayWarp
from ..colour import picture_from_linear
from ..frames import Needs
from ..frames.layers import Layer, layers
from ..geometry import View
from ..gpu.textures import Canvas, download
from ..link import Link, LinkOptions, Pacer
from ..options import Choice, NoSettings
from ..resources import install_line
from .replay_setup import Schedule

OPENCV = "cv2.warpFrame"
# By name: the system, as in the baselines of a warp.
OUTSIDE = {OPENCV: "OpenCV"}
# Knows the truth's depth: see Oracle.
ORACLE = "oracle"
# What runs without a plan of its own, on frames with colour and depth.
PLANLESS = (*OUTSIDE, ORACLE)
FAR_M = 1e4  # for what is infinitely far, which OpenCV takes for a pixel without depth
# OpenCV's threads wait busily for more work, on the cores that the next method needs.
SPIN_S = 0.02


def missing(name: str) -> str:
    """Return why one of PLANLESS cannot run here, "" if it can."""
    if name == ORACLE:
        return ""
    try:
        found = hasattr(importlib.import_module("cv2"), "warpFrame")
    except ImportError as error:
        return f"OpenCV is not installed ({error}): {install_line('bench')}"
    return "" if found else f"this OpenCV has no warpFrame ({name} came with 5.0): {install_line('bench')}"


def opencv_camera(view: View, size: tuple[int, int]) -> NDArray[np.float64]:
    """Return the 3x3 camera matrix of a view.

    OpenCV looks along +z with y down, and has pixel centres at whole numbers.
    """
    left, right, down, up = view.fov.tangents
    wide, high = size
    x, y = wide / (right - left), high / (up - down)
    return np.array([[x, 0, -left * x - 0.5], [0, y, up * y - 0.5], [0, 0, 1]])


class OpenCvWarp(ArrayWarp):
    """cv2.warpFrame: the whole rendered picture with one camera, as the function demands.

    The shown view is cut out of it.
    """

    name = OPENCV
    carries = False  # it takes bytes

    def prepare(self) -> None:
        self._cv2 = importlib.import_module("cv2")

    def arrays(self, inputs: PassInputs) -> tuple[Any, ...]:
        """Return the arguments of cv2.warpFrame, and what of its picture is shown."""
        rendered, (wide, high) = inputs.rendered, self.shown_size
        inverse_depth = download(rendered.inverse_depth)
        known = np.isfinite(inverse_depth) & (inverse_depth >= 0)
        depth = (1 / np.maximum(np.where(known, inverse_depth, 1), 1 / FAR_M)).astype(np.float32)
        mask = np.where(known, 255, 0).astype(np.uint8)
        camera = opencv_camera(rendered.view, rendered.size)
        # Half a pixel to the right and down: warpFrame rounds places down to whole pixels.
        to_nearest = np.eye(4)
        to_nearest[0, 2], to_nearest[1, 2] = 0.5 / camera[0, 0], 0.5 / camera[1, 1]
        to_camera = np.diag([1.0, -1.0, -1.0, 1.0])
        moved = rendered.view.pose.relative_to(inputs.shown.pose).matrix()  # points, to the shown eye
        motion = to_nearest @ to_camera @ moved @ to_camera
        # The shown part: a guard band adds whole pixels.
        own = opencv_camera(inputs.shown, self.shown_size)
        x, y = (round(camera[k, 2] - own[k, 2]) for k in (0, 1))
        picture = picture_from_linear(download(rendered.colour))
        return depth, picture, mask, motion, camera, np.s_[y : y + high, x : x + wide]

    def warp(self, *given: Any) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return sRGB and coverage of the shown part."""
        *arguments, shown = given
        _, warped, covered = self._cv2.warpFrame(*arguments)
        return warped[shown], covered[shown]

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        super().run(inputs, into)
        done_ns = time.perf_counter_ns()
        while time.perf_counter_ns() < done_ns + SPIN_S * 1e9:  # not asleep: a core that has slept is slow for a while
            pass


def outside_plan(name: str) -> Plan:
    """Return the plan of one of PLANLESS; of the oracle, what it is compared beside."""
    plan = build_plan((), "forward", "none", "none", client_geometry=False)
    return attrs.evolve(plan, choice=Choice(OpenCvWarp, NoSettings())) if name == OPENCV else plan


# For the compensators of one batch on a GPU; a software renderer may use part of the machine's
# memory.
GPU_BATCH_BYTES = 2 << 30
MEMORY_PART = 0.2
# Per canvas pixel; and per rendered pixel what a warp keeps: keys, depths, vertices.
_COLOUR_BYTES, _OWN_BYTES = 8, 32
Size = tuple[int, int]


@attrs.frozen(order=True)
class Case:
    """The conditions that all combinations share, so that they can be compared."""

    scene: str
    recording: str
    latency_ms: float
    size: Size
    # None for the display's.
    server_rate_hz: float | None = None


@attrs.frozen
class Combination:
    """One warp with its settings and one fill, or a strategy made of them."""

    warp: str
    fill: str
    # Of one of PLANLESS: a plan that reads what it reads.
    plan: Plan
    # With its settings, if it was named as one.
    strategy: str = ""

    @property
    def is_outside(self) -> bool:
        """Whether no warp of ours runs: another library's, or the oracle."""
        return self.warp in PLANLESS

    @property
    def group(self) -> str:
        """Name of those whose pictures have the same holes: the warp, or the strategy by itself."""
        return self.strategy or self.warp

    @property
    def needs_every_frame(self) -> bool:
        """Whether a frame differs if one before it is left out, which no measured refresh shows."""
        own_link = bool(self.strategy) and has_own_link(self.strategy)
        return own_link or any(layer.builds_on_frames for layer in self._layers)

    @property
    def has_own_frames(self) -> bool:
        """Whether it shares no late frames: those of another plan would not do."""
        return self.needs_every_frame or any(layer.made_from_picture for layer in self._layers)

    @property
    def _layers(self) -> list[type[Layer]]:
        return [layers.get(name) for name in self.plan.needs]

    @property
    def remembers(self) -> bool:
        """Whether its picture depends on earlier refreshes."""
        return any(fill.entry.remembers for fill in self.plan.fills)


def batches(
    combinations: Sequence[Combination], rendered_size: Size, shown_size: Size, most_bytes: float, pictures: int = 0
) -> list[list[Combination]]:
    """Return groups of combinations that fit in `most_bytes` together.

    A group needs its older frames equally far apart; all fills of a warp stay together. Warps that
    need no older frames join the first group. What has late frames of its own is a group by itself.
    pictures: that are kept of each, as sRGB.
    """
    own = [[c] for c in combinations if c.has_own_frames]
    shared = [c for c in combinations if not c.has_own_frames]
    kept = 3 * pictures * shown_size[0] * shown_size[1]
    return (_shared_batches(shared, rendered_size, shown_size, most_bytes, kept) if shared else []) + own


def _shared_batches(
    combinations: Sequence[Combination], rendered_size: Size, shown_size: Size, most_bytes: float, kept: int
) -> list[list[Combination]]:
    spacings = sorted({c.plan.needs.others.spacing_ns for c in combinations if c.plan.needs.others.past})
    first = spacings[0] if spacings else 0
    found: list[list[Combination]] = []
    for spacing in spacings or [first]:
        fitting = [
            c
            for c in combinations
            if (c.plan.needs.others.spacing_ns if c.plan.needs.others.past else first) == spacing
        ]
        current: list[Combination] = []
        for _, group in itertools.groupby(fitting, key=lambda c: c.warp):
            together = list(group)
            if current and sum(kept + _bytes(c, rendered_size, shown_size) for c in (*current, *together)) > most_bytes:
                found.append(current)
                current = []
            current += together
        found.append(current)
    return found


def _bytes(combination: Combination, rendered_size: Size, shown_size: Size) -> int:
    plan, rendered = combination.plan, rendered_size[0] * rendered_size[1]
    canvases = 1 + len(plan.fills) + len(plan.effect_passes) + plan.lens.is_pass
    kept = sum(fill.entry.bytes_kept(rendered, fill.settings) for fill in plan.fills)
    return 2 * canvases * _COLOUR_BYTES * shown_size[0] * shown_size[1] + _OWN_BYTES * rendered + kept


def instants_of(count: int, wanted: int) -> list[int]:
    """Return at most `wanted` of the refreshes 0..count-1, evenly spread.

    Each has a predecessor if there are two refreshes.
    """
    wanted = min(wanted, max(1, count // 2))
    return [min(count - 1, max(1, int((k + 0.5) * count / wanted))) for k in range(wanted)]


@attrs.frozen
class _Drawn:
    drawn_ns: int


def frames_used(
    schedule: Schedule, link_ns: int, needs: Needs, looked_at: Iterable[int], server_rate_hz: float | None = None
) -> dict[int, list[int]]:
    """Return the instants of the frames that the refreshes `looked_at` show or look back to.

    By the number of the refresh at which the loop draws them.

    Other frames need not be drawn. The result comes from running the link and the history
    themselves on frames without pictures.
    """
    wanted, used = set(looked_at), set[int]()
    drawn: dict[int, list[int]] = {}
    pacer = Pacer(server_rate_hz, schedule.rate_hz)
    history = History(needs.others, lambda frame: None)
    link: Link[_Drawn] = LinkOptions().link(link_ns, discard=history.offer)
    for number, instant_ns in schedule.numbered():
        drawn[number] = pacer.due(instant_ns)
        for drawn_ns in drawn[number]:
            link.send(_Drawn(drawn_ns), drawn_ns)
        newest = link.newest(instant_ns)
        if number in wanted and number >= 0:
            used |= {frame.drawn_ns for frame in (newest, *history.frames, *history.recent) if frame is not None}
    return {number: [instant for instant in instants if instant in used] for number, instants in drawn.items()}
