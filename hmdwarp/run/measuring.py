"""What a run showed, against what should be seen: truth, comparisons, combinations side by side."""

from __future__ import annotations

import functools
import importlib
import itertools
import math
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from .. import metrics
from ..base import Choice, NoSettings, install_line, picture_from_linear
from ..client import Compensator, EyeResult, History, PassInputs, Plan, build_plan, needs_of
from ..client.strategies import has_own_link
from ..client.warp_kinds import ArrayWarp
from ..frames import EyeImage, Frame, Needs
from ..frames.layers import PICTURE, Layer, layers
from ..geometry import Fov, View, WarpMap, gaze_tangent, looking
from ..gpu import Canvas, download, flip_rows, upload
from ..link import Link, LinkOptions, Pacer
from ..metrics import psnr
from ..pipeline import Loop, Reads, Refresh
from ..pipeline.remote import NoTruth
from ..pipeline.sizes import build_plan_for, plan_against
from ..sources.server import Renderer
from .run import ReplayRun, Schedule
from .run_summary import Row, stage_columns

# Over half a band the picture turns by a quarter of a pixel, up to the limit on bands; each band is
# drawn separately.
PIXELS_PER_BAND = 0.5
MOST_BANDS = 64
NEAR_M = 1.0  # nearest surface considered; nearer ones move by more as the head moves


@attrs.frozen(eq=False)
class Truth:
    """What an eye should see, top row first; no depth where it is not requested."""

    colour: NDArray[np.float16]
    inverse_depth: NDArray[np.float32] | None

    @functools.cached_property
    def picture(self) -> NDArray[np.uint8]:
        """The colour as sRGB, (h, w, 3)."""
        return picture_from_linear(self.colour)


def draw_truth(server: Renderer, inputs: PassInputs, size: tuple[int, int], *, depth: bool = True) -> Truth:
    """Return the scene as the eye should see it at this refresh, (w, h) pixels before the lens.

    Errors: NoTruth.
    """

    def drawn(view: View, rows: int) -> Truth:
        image = server.draw(view, (size[0], rows), time_ns=inputs.shown_ns)
        try:
            # Where a camera knows no depth, what it saw counts as infinitely far.
            inverse = np.maximum(download(image.inverse_depth), 0) if depth else None
            return Truth(_black_where_hidden(download(image.colour), view), inverse)
        finally:
            server.pool(image.size).release(image.colour)

    if inputs.shown_last is None:
        return drawn(inputs.shown, size[1])
    bands = [drawn(view, rows) for view, rows in bands_of(inputs.shown, inputs.shown_last, size)]
    inverse = np.concatenate([band.inverse_depth for band in bands]) if depth else None
    return Truth(np.concatenate([band.colour for band in bands]), inverse)


def bands_of(first: View, last: View, size: tuple[int, int]) -> Iterator[tuple[View, int]]:
    """Return (view, rows) of each band of a (w, h) picture, from the top.

    The view covers the band's part of the field of view, at the time when its middle lights up. The
    number of bands is what the head's motion requires: a power of 2, so that few sizes are drawn;
    MOST_BANDS and the rows at most.
    """
    turn = first.pose.angle_to(last.pose)
    step = float(np.linalg.norm(last.pose.position_m - first.pose.position_m))
    pixels = math.degrees(turn + step / NEAR_M) * first.fov.pixels_per_degree(size)
    count = min(2 ** math.ceil(math.log2(max(pixels / PIXELS_PER_BAND, 1))), MOST_BANDS, size[1])
    left, right, down, up = first.fov.tangents
    high = size[1]
    ends = np.linspace(0, high, count + 1).round().astype(int)
    for top, bottom in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True):
        low, above = (up - (up - down) * row / high for row in (bottom, top))
        pose = first.pose.towards(last.pose, (top + bottom) / (2 * high))
        yield attrs.evolve(first, pose=pose, fov=Fov.from_tangents((left, right, low, above))), bottom - top


def shown_picture(result: EyeResult) -> NDArray[np.uint8]:
    """Return the picture before the lens: (h, w, 3) sRGB, top row first."""
    assert result.shown is not None
    return _black_where_hidden(picture_from_linear(download(result.shown.texture)), result.view)


def _black_where_hidden(picture: NDArray[Any], view: View) -> NDArray[Any]:
    if view.hidden is None:
        return picture
    return np.where(view.seen((picture.shape[1], picture.shape[0]))[..., None], picture, picture.dtype.type(0))


def coverage(result: EyeResult) -> NDArray[np.floating]:
    """Return the coverage (h, w) after the warp, before the fill."""
    assert result.warped is not None
    return download(result.warped.texture)[..., 3]


class WholePictures:
    """The inputs of plans that run along with others on the same frames.

    Frames for a plan with effects lack what its layers show by themselves (mirrors, glass, the
    HUD), and frames that no plan reads a picture of have none. A plan without such layers gets the
    picture drawn again, once for each frame and eye, and held until the next frame.
    """

    def __init__(self, server: Renderer) -> None:
        self._server = server
        self._frame: Frame | None = None
        self._drawn: dict[int, EyeImage] = {}

    def inputs(self, loop: Loop, refresh: Refresh, plan: Plan) -> tuple[PassInputs, ...]:
        """Return the inputs of the plan for the refresh just shown."""
        every, eye = loop.inputs(refresh, plan.needs), refresh.frame.eyes[0]
        apart = [name for name in eye.carried if layers.get(name).apart]
        is_apart = apart and not any(name in plan.needs for name in apart)
        if not is_apart and eye.left_out.isdisjoint(Reads.of([plan]).names):
            return every
        if refresh.frame is not self._frame:
            self.close()
            self._frame = refresh.frame
        found = []
        for inputs in every:
            image = inputs.rendered
            if inputs.eye not in self._drawn:
                self._drawn[inputs.eye] = self._server.draw(image.view, image.size, time_ns=image.drawn_ns)
                self._server.gpu.timer.collect()
            drawn = self._drawn[inputs.eye]
            whole = attrs.evolve(image, colour=drawn.colour, inverse_depth=drawn.inverse_depth, left_out=frozenset())
            found.append(attrs.evolve(inputs, rendered=whole))
        return tuple(found)

    def close(self) -> None:
        for image in self._drawn.values():
            self._server.pool(image.size).release(image.colour)
        self._drawn, self._frame = {}, None


_GOLDEN = (5**0.5 - 1) / 2


def is_measured(number: int, every: int) -> bool:
    """Return whether refresh `number` is the measured one of its n = `every`.

    Its place among them is spread by the golden ratio, which is in step with no period: of misses,
    of a server's frames, of a head that nods. The first is measured; each run measures the same.
    """
    block, place = divmod(number, every)
    return place == int(every * (block * _GOLDEN % 1))


OPENCV = "cv2.warpFrame"
# By name: the system, as in the baselines of a warp.
OUTSIDE = {OPENCV: "OpenCV"}
# Knows the truth's depth: see Oracle.
ORACLE = "oracle"
# What runs without a plan of its own, on frames with colour and depth.
PLANLESS = (*OUTSIDE, ORACLE)
FAR_M = 1e4  # for what is infinitely far, which OpenCV takes for a pixel without depth
# OpenCV's threads wait busily for more work, on the cores that the next method needs.
_SPIN_S = 0.02


def missing(name: str) -> str:
    """Return why one of PLANLESS cannot run here, "" if it can."""
    if name == ORACLE:
        return ""
    try:
        found = hasattr(importlib.import_module("cv2"), "warpFrame")
    except ImportError as error:
        return f"OpenCV is not installed ({error}): {install_line('bench')}"
    return "" if found else f"this OpenCV has no warpFrame ({name} came with 5.0): {install_line('bench')}"


def _opencv_camera(view: View, size: tuple[int, int]) -> NDArray[np.float64]:
    """Return a view's 3x3 matrix: OpenCV looks along +z, y down, pixel centres at whole numbers."""
    left, right, down, up = view.fov.tangents
    wide, high = size
    x, y = wide / (right - left), high / (up - down)
    return np.array([[x, 0, -left * x - 0.5], [0, y, up * y - 0.5], [0, 0, 1]])


class OpenCvWarp(ArrayWarp):
    """cv2.warpFrame: the whole rendered picture by one camera; the shown view is cut out of it."""

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
        camera = _opencv_camera(rendered.view, rendered.size)
        # Half a pixel to the right and down: warpFrame rounds places down to whole pixels.
        to_nearest = np.eye(4)
        to_nearest[0, 2], to_nearest[1, 2] = 0.5 / camera[0, 0], 0.5 / camera[1, 1]
        to_camera = np.diag([1.0, -1.0, -1.0, 1.0])
        moved = rendered.view.pose.relative_to(inputs.shown.pose).matrix()  # points, to the shown eye
        motion = to_nearest @ to_camera @ moved @ to_camera
        # The shown part: a guard band adds whole pixels.
        own = _opencv_camera(inputs.shown, self.shown_size)
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
        while time.perf_counter_ns() < done_ns + _SPIN_S * 1e9:  # not asleep: a core that has slept is slow for a while
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
    combinations: Sequence[Combination], rendered_size: Size, shown_size: Size, most_bytes: float
) -> list[list[Combination]]:
    """Return groups of combinations that fit in `most_bytes` together.

    A group needs its older frames equally far apart; all fills of a warp stay together. Warps that
    need no older frames join the first group. What has late frames of its own is a group by itself.
    """
    shared = [c for c in combinations if not c.has_own_frames]
    rendered, shown = (size[0] * size[1] for size in (rendered_size, shown_size))

    def bytes_of(combination: Combination) -> int:
        plan = combination.plan
        canvases = 1 + len(plan.fills) + len(plan.effect_passes) + plan.lens.is_pass
        kept = sum(fill.entry.bytes_kept(rendered, fill.settings) for fill in plan.fills)
        return 2 * canvases * _COLOUR_BYTES * shown + _OWN_BYTES * rendered + kept

    others = {c.plan.needs.others.spacing_ns for c in shared if c.plan.needs.others.past}
    spacings = sorted(others) or [0] * bool(shared)
    found: list[list[Combination]] = []
    for spacing in spacings:
        current: list[Combination] = []
        spaced = [(c, c.plan.needs.others) for c in shared]
        fitting = [c for c, other in spaced if (other.spacing_ns if other.past else spacings[0]) == spacing]
        for _, group in itertools.groupby(fitting, key=lambda c: c.warp):
            together = list(group)
            if current and sum(map(bytes_of, (*current, *together))) > most_bytes:
                found.append(current)
                current = []
            current += together
        found.append(current)
    return found + [[c] for c in combinations if c.has_own_frames]


def instants_of(count: int, wanted: int) -> list[int]:
    """Return at most `wanted` refreshes of `count`, evenly spread, with one before if possible."""
    wanted = min(wanted, max(1, count // 2))
    return [min(count - 1, max(1, int((k + 0.5) * count / wanted))) for k in range(wanted)]


@attrs.frozen
class _Drawn:
    drawn_ns: int


def frames_used(
    schedule: Schedule, link_ns: int, needs: Needs, looked_at: Iterable[int], server_rate_hz: float | None = None
) -> dict[int, list[int]]:
    """Return the instants of the frames that the refreshes `looked_at` show or look back to.

    By the number of the refresh at which the loop draws them. It comes from running the link and
    the history themselves on frames without pictures.
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


class Oracle:
    """The truth's own depth in place of a warp's guess.

    Each pixel is taken from the place in the late frame where its true surface lay, if that frame
    saw it: coverage is 1 there. The others, which no late picture holds, are those of the truth. A
    surface that moves by itself counts as unseen where it left its place. plan: for frames' needs.
    """

    def __init__(self, setup: ReplayRun, plan: Plan) -> None:
        self._server, self.plan, self._size = setup.server, plan, setup.sizes.shown
        self._warped, self._shown = ([Canvas(setup.target.gpu.gl, self._size) for _ in range(2)] for _ in range(2))
        for canvas in (*self._warped, *self._shown):
            setup.cleanup.callback(canvas.release)
        self._made: dict[int, tuple[PassInputs, EyeResult]] = {}

    def run(self, inputs: PassInputs) -> EyeResult:
        """Make one eye's picture, once for each refresh; it takes no time of any client."""
        before = self._made.get(inputs.eye)
        if before is not None and before[0].shown is inputs.shown and before[0].shown_ns == inputs.shown_ns:
            return before[1]
        truth = self._server.draw(inputs.shown, self._size, time_ns=inputs.shown_ns)
        try:
            picture, true_depth = download(truth.colour)[..., :3], np.maximum(download(truth.inverse_depth), 0)
        finally:
            self._server.pool(self._size).release(truth.colour)
        rendered = inputs.rendered
        late, late_depth = download(rendered.colour)[..., :3], download(rendered.inverse_depth)
        mapping = WarpMap.between(truth.view, self._size, rendered.view, rendered.size)
        colour, seen = from_late(mapping, true_depth, late, late_depth)
        self._server.gpu.timer.collect()  # of drawing the truth
        warped, shown = self._warped[inputs.eye], self._shown[inputs.eye]
        upload(warped.texture, np.dstack([colour * seen[..., None], seen]))
        upload(shown.texture, np.dstack([np.where(seen[..., None], colour, picture), np.ones(seen.shape)]))
        result = EyeResult(inputs.middle, warped, shown, shown)
        self._made[inputs.eye] = inputs, result
        return result

    def renew(self) -> None:
        """Do nothing: it remembers nothing."""


def from_late(
    mapping: WarpMap, true_depth: NDArray[np.floating], late: NDArray[np.floating], late_depth: NDArray[np.floating]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return the colour (h, w, 3) of each pixel in a late picture, and where that saw its surface.

    mapping: from the shown to the late pixels. true_depth: (h, w), 1/m; late, late_depth: (H, W, 3)
    linear light and (H, W). All rows from the top. A surface was seen where the late frame has its
    inverse depth, within what is no jump of depth. Between pixels that is exact on planes.
    """
    height, width = true_depth.shape
    high, wide = late_depth.shape
    centres = np.mgrid[0:height, 0:width][::-1].transpose(1, 2, 0) + 0.5
    with np.errstate(invalid="ignore"):
        place, expected, w = mapping.apply(centres, flip_rows(true_depth).astype(np.float64))
        place, expected = flip_rows(place), flip_rows(expected)
        x, y = place[..., 0] - 0.5, high - place[..., 1] - 0.5
        inside = (flip_rows(w) > 0) & (x >= 0) & (x <= wide - 1) & (y >= 0) & (y <= high - 1)
    x, y, expected = (np.where(inside, x, 0.0), np.where(inside, y, 0.0), np.where(inside, expected, 0.0))
    column, row = np.minimum(x.astype(int), wide - 2), np.minimum(y.astype(int), high - 2)
    right, below = x - column, y - row
    corners = [(row, column), (row, column + 1), (row + 1, column), (row + 1, column + 1)]
    shares = [(1 - below) * (1 - right), (1 - below) * right, below * (1 - right), below * right]
    both = np.dstack([late, late_depth]).astype(np.float64)
    found = np.sum([share[..., None] * both[corner] for share, corner in zip(shares, corners, strict=True)], axis=0)
    same = np.abs(found[..., 3] - expected) <= metrics.RELATIVE_STEP * expected + metrics.LEAST_STEP
    return found[..., :3], inside & same


# Seconds before each instant at which fills that remember are shown a refresh too. Instants are a
# few seconds apart, so these fills get to know the recording about as a replay of all of it would
# teach them.
RUN_IN_S = (4.0, 3.0, 2.0, 1.0, 0.5)


def refreshes(
    setup: ReplayRun, needs: Needs, numbers: Collection[int], *, every_frame: bool = False
) -> Iterator[tuple[int, Refresh]]:
    """Iterate over the chosen refreshes of a run, counted from 0, in time order.

    Negative numbers are passed over. The results are those of the whole run, but only the frames
    they use are drawn. every_frame: draw all, for frames that depend on each other.
    """
    wanted, last = {number for number in numbers if number >= 0}, max(numbers)
    link_ns, rate_hz = setup.channel.latency_ns, setup.options.network.server_rate_hz
    used = {} if every_frame else frames_used(setup.schedule, link_ns, needs, wanted, rate_hz)
    for number, instant_ns in setup.schedule.numbered():
        if number > last:
            return
        if every_frame:
            setup.loop.draw(instant_ns)
        for drawn_ns in used.get(number, ()):
            setup.loop.draw_at(drawn_ns)
        if number in wanted:
            refresh = setup.loop.show(instant_ns)
            assert refresh is not None
            yield number, refresh
        elif every_frame and number >= 0:
            setup.channel.newest(instant_ns)  # takes what has arrived, as a client that shows it


class SideBySide:
    """The compensators of some combinations in one loop."""

    def __init__(self, setup: ReplayRun, combinations: Sequence[Combination]) -> None:
        self._setup, self._combinations = setup, combinations
        # In the order of the combinations.
        self.compensators: list[Compensator | Oracle] = [
            Oracle(setup, one.plan) if one.warp == ORACLE else setup.compensator(one.plan) for one in combinations
        ]
        self._whole = WholePictures(setup.server)

    def refreshes(self, numbers: Collection[int], instants: Collection[int]) -> Iterator[tuple[int, Refresh]]:
        """Iterate over the chosen refreshes.

        Before the instants among them, fills that remember are shown some of RUN_IN_S earlier too.
        """
        needs, every = needs_of(one.plan for one in self._combinations), False
        taught = set[int]()
        for one in self._combinations:
            every |= one.needs_every_frame
            if one.remembers:
                rate_hz = self._setup.schedule.rate_hz
                taught = {number - round(seconds * rate_hz) for number in instants for seconds in RUN_IN_S}
        for number, refresh in refreshes(self._setup, needs, {*numbers, *taught}, every_frame=every):
            if number in numbers:
                yield number, refresh
                continue
            for compensator, one in zip(self.compensators, self._combinations, strict=True):
                if one.remembers and isinstance(compensator, Compensator):
                    for inputs in self.inputs(compensator, refresh):
                        compensator.learn(inputs)
            self._setup.target.gpu.timer.collect()

    def inputs(self, compensator: Compensator | Oracle, refresh: Refresh) -> tuple[PassInputs, ...]:
        return self._whole.inputs(self._setup.loop, refresh, compensator.plan)

    def truth(self, inputs: PassInputs) -> Truth:
        """Return what an eye should see in the middle of a refresh."""
        return draw_truth(self._setup.server, attrs.evolve(inputs, shown_last=None), self._setup.sizes.shown)

    def pictures(self, refresh: Refresh, eye: int) -> list[metrics.Compared]:
        """Run all for one eye, untimed; return each picture with the truth."""
        truth, shown = self.truth(refresh.inputs[eye]), []
        for compensator in self.compensators:
            result = compensator.run(self.inputs(compensator, refresh)[eye])
            shown.append(metrics.Compared(shown_picture(result), truth.picture, result.view))
        self._setup.target.gpu.timer.collect()
        return shown


# (case, warp, fill, refresh, eye): identifies a picture.
_PictureKey = tuple[Case, str, str, int, int]


@attrs.frozen(eq=False)
class Measured:
    """Figures of one combination in one case; those of its pictures are still in the pool."""

    combination: Combination
    # One row for each timed run of one eye, keyed as frames.csv.
    times: list[Row] = attrs.field(factory=list)
    keys: list[_PictureKey] = attrs.field(factory=list)
    # Of each measured picture, by its refresh: see metrics.block_means.
    blocks: dict[int, NDArray[np.float64]] = attrs.field(factory=dict)
    # Of each, where the late frame saw what the eye should see: pixels of the picture, those seen,
    # and the mean squared error of those, 0..1. Empty without the oracle beside it.
    where_seen: list[tuple[int, int, float]] = attrs.field(factory=list)


class Comparison:
    """Compare the combinations of one batch side by side in the loop of one case.

    Only measured refreshes are shown, spread evenly over the recording, the refresh before each,
    which flicker needs, and some for fills that remember. Both eyes are timed; pictures are
    measured for the left and right eye in turn. Nothing is timed while pictures are measured.
    """

    def __init__(
        self, setup: ReplayRun, case: Case, combinations: Sequence[Combination], pool: metrics.QualityPool, rounds: int
    ) -> None:
        self._setup, self._case, self._pool, self._rounds = setup, case, pool, rounds
        self.measured = [Measured(combination) for combination in combinations]
        self._beside = SideBySide(setup, combinations)
        self._last: list[list[EyeResult]] = [[] for _ in combinations]
        self._turn = 0

    def run(self, instants: int, step: Callable[[], None]) -> None:
        """Visit that many refreshes, calling step() after each."""
        turns = {number: turn for turn, number in enumerate(instants_of(self._setup.schedule.count, instants))}
        before: list[metrics.Compared] = []
        for number, refresh in self._beside.refreshes({*turns, *(number - 1 for number in turns)}, turns):
            if number in turns:
                self._time(refresh)
                self._measure(number, refresh, turns[number] % len(refresh.inputs), before)
                step()
            is_next = number + 1 in turns
            before = self._beside.pictures(refresh, turns[number + 1] % len(refresh.inputs)) if is_next else []

    def _time(self, refresh: Refresh) -> None:
        """Time every combination in each round, in an order that rotates from round to round."""
        self._pool.wait()
        count = len(self._beside.compensators)
        # All warm up once; later the first alone, because an idle processor is slow for a while.
        for round_number in range(-1, self._rounds):
            for place in range(1 if round_number < 0 < self._turn else count):
                index = (place + self._turn) % count
                compensator, self._last[index] = self._beside.compensators[index], []
                compensator.renew()
                for inputs in self._beside.inputs(compensator, refresh):
                    self._last[index].append(compensator.run(inputs))
                    stages = self._setup.target.gpu.timer.collect()
                    if round_number >= 0:
                        row = {"frame": refresh.shown_ns, "eye": inputs.eye, **stage_columns(stages)}
                        self.measured[index].times.append(row)
            self._turn += round_number >= 0

    def _measure(self, number: int, refresh: Refresh, eye: int, before: list[metrics.Compared]) -> None:
        """Submit the pictures of an eye."""
        rendered, truth = refresh.frame.eyes[eye], self._beside.truth(refresh.inputs[eye])
        coverages: dict[str, NDArray[np.floating]] = {}
        handed_in: dict[str, list[tuple[_PictureKey, metrics.QualityJob]]] = {}
        warps = [each.combination.warp for each in self.measured]
        seen = coverage(self._last[warps.index(ORACLE)][eye]) > 0 if ORACLE in warps else None
        for index, (results, measured) in enumerate(zip(self._last, self.measured, strict=True)):
            warp = measured.combination.group
            if warp not in coverages:
                coverages[warp] = coverage(results[eye])
            shown = shown_picture(results[eye])
            if seen is not None:
                error = metrics.error_image(shown[seen], truth.picture[seen])
                measured.where_seen.append((seen.size, int(seen.sum()), float((error**2).sum() / 3)))
            now, previous = metrics.Compared(shown, truth.picture, results[eye].view), before[index] if before else None
            form = (truth.inverse_depth, rendered.view, rendered.size)
            job = metrics.QualityJob(now, previous, coverages[warp], *form, regions=True)
            measured.blocks[number] = metrics.block_means(job.now.shown)
            # Fills with identical pictures share one measurement.
            same = next((key for key, other in handed_in.get(warp, []) if _same_pictures(job, other)), None)
            key = same or (self._case, warp, measured.combination.fill, number, eye)
            measured.keys.append(key)
            if same is None:
                handed_in.setdefault(warp, []).append((key, job))
                self._setup.hand_in(self._pool, key, job)


def _same_pictures(one: metrics.QualityJob, other: metrics.QualityJob) -> bool:
    pairs = ((one.now, other.now), (one.previous, other.previous))
    return all(np.array_equal(a.shown, b.shown) for a, b in pairs if a and b)


# Degrees from the gaze: the fovea and what is nearly as sharp (Strasburger, Rentschler and Jüttner
# 2011, Peripheral vision and pattern recognition: a review).
NEAR_DEG = 5.0


@attrs.define
class NearGaze:
    """Figures of measured pictures whose gaze is known, or asked for."""

    looks_ahead: bool = False  # whether frames without a gaze are drawn for one straight ahead
    _psnr_db: list[float] = attrs.field(factory=list)
    _off_deg: list[float] = attrs.field(factory=list)

    def add(self, now: metrics.Compared, shown: View, rendered: View) -> None:
        """Add a picture. shown: of the eye, with its gaze at that instant. rendered: drawn."""
        near = flip_rows(near_gaze(shown, now.shown.shape[1::-1]))
        if near.any():  # as a picture one pixel high
            self._psnr_db.append(psnr(now.shown[near][None], now.truth[near][None]))
        if rendered.gaze is not None or shown.gaze is None or self.looks_ahead:  # else, as of recordings, not known
            ways = [view.pose.rotation_matrix @ _gaze_ray(view) for view in (shown, rendered)]
            off = float(ways[0] @ ways[1])
            self._off_deg.append(math.degrees(math.acos(min(1.0, off))))

    def entry(self) -> dict[str, Any]:
        """Return the `gaze` of summary.json.

        psnr_db: mean over pictures, within within_deg of the gaze. off_deg: from the gaze that a
        frame was drawn for to that when it is seen, in the world; None where that is never known.
        """
        if not self._off_deg and not self._psnr_db:
            return {}
        off = self._off_deg and {f"p{share}": float(np.percentile(self._off_deg, share)) for share in (50, 95)}
        psnr = math.fsum(self._psnr_db) / len(self._psnr_db) if self._psnr_db else None
        return {"gaze": {"within_deg": NEAR_DEG, "psnr_db": psnr, "off_deg": off or None}}


def near_gaze(view: View, size: tuple[int, int]) -> NDArray[np.bool_]:
    """Return (h, w), the bottom row first: which pixels lie near the gaze."""
    rays = view.rays(size)
    cosine = rays @ _gaze_ray(view) / np.linalg.norm(rays, axis=-1)
    return np.asarray(cosine >= math.cos(math.radians(NEAR_DEG)))


def _gaze_ray(view: View) -> NDArray[np.float64]:
    ray = np.array([*gaze_tangent(view), -1.0])
    return np.asarray(ray / np.linalg.norm(ray))


# The run's own warp; those that it is compared with have 1, 2 and so on.
MAIN = 0


class Probe:
    """Read pictures back: draw the truth for the shown views and submit both for measuring.

    The picture is measured as the eye sees it, before the lens. Where warp and lens are one pass,
    the same warp without the lens runs for it; its time is not counted. Flicker needs the refresh
    before a measured one too, so that one is drawn and read as well, but not measured.
    """

    def __init__(self, setup: ReplayRun, pool: metrics.QualityPool) -> None:
        self._setup, self.pool = setup, pool
        self._every, images = setup.options.metrics_every, setup.options.images
        # One of so many measured pictures is kept, for about options.images of them.
        measured = -(-setup.schedule.count // self._every)
        self._keep_every = max(1, -(-measured // images)) if images else None
        self._unfused: Compensator | None = None
        if setup.plans[0].fused:
            setup.notes.append(
                "Warp and lens are one pass: quality was measured on the same warp without the lens, whose time is not "
                "counted."
            )
            alone = attrs.evolve(setup.options, fused=False, lens="none", fill="none")
            self._unfused = setup.compensator(build_plan_for(alone, setup.source.headset, setup.source.scene))
        self._against = [setup.compensator(plan_against(setup.options, *pair)) for pair in setup.options.compared]
        # Rates all pictures; None where the options do not ask for it.
        self.clips: metrics.Clips | None = None
        if setup.options.jod_s:
            given = {name: getattr(setup.source.headset, name) for name in ("peak_cd_m2", "black_cd_m2")}
            known = {name: value for name, value in given.items() if value is not None}
            display = metrics.ShownOn(setup.schedule.rate_hz, setup.pixels_per_degree, **known)
            self.clips = metrics.Clips(setup.options.jod_s, display)
        self._whole = WholePictures(setup.server)
        self._before: dict[tuple[int, int], tuple[int, metrics.Compared]] = {}
        self._empty: dict[str, list[float]] = {}
        # Pictures that were to be measured.
        self.without_truth = 0
        # Of each comparison, by refresh and eye.
        self.against_ms: list[dict[tuple[int, int], tuple[tuple[str, float], ...]]] = [{} for _ in self._against]
        self.near_gaze = NearGaze(setup.options.fovea is not None)
        if setup.options.scanout_ms:
            how = "follows it row by row" if setup.plans[0].scanout else "shows all rows as in its middle"
            setup.notes.append(
                f"The display scans out for {setup.options.scanout_ms:g} ms; warp '{setup.options.warp}' {how}. The "
                f"truth is drawn in up to {MOST_BANDS} bands, each for its own instant; holes and flicker are told as "
                "in its middle."
            )

    def wants(self, number: int) -> bool:
        """Return whether refresh `number` is measured, precedes a measured one, or is in a clip."""
        return self.clips is not None or is_measured(number, self._every) or is_measured(number + 1, self._every)

    def read(self, number: int, refresh: Refresh) -> None:
        """Read back the eyes that frames were sent for, and submit them if they are measured."""
        for eye in range(min(len(refresh.eyes), self._setup.source.kind.eyes)):
            rendered = refresh.frame.eyes[eye]
            # The predecessor of a measured refresh is read for flicker only.
            measured = is_measured(number, self._every)
            try:
                truth = draw_truth(self._setup.server, refresh.inputs[eye], self._setup.sizes.shown, depth=measured)
            except NoTruth:
                self.without_truth += measured
                continue
            result = refresh.eyes[eye]
            if self._unfused is not None:
                result = self._unfused.run(refresh.inputs[eye])
                self._setup.target.gpu.timer.collect()
            job = self._job((number, eye, MAIN), rendered, result, truth)
            if job is not None:
                for name, canvas in (("warp", None), *result.filled):
                    alpha = coverage(result) if canvas is None else download(canvas.texture)[..., 3]
                    self._empty.setdefault(name, []).append(float((alpha == 0).mean()))
            others = []
            for which, pair in enumerate(self._setup.options.compared, 1):
                against, key = self._against[which - 1], (number, eye, which)
                inputs = self._whole.inputs(self._setup.loop, refresh, against.plan)[eye]
                compared = against.run(inputs)  # without effects
                self.against_ms[which - 1][number, eye] = tuple(self._setup.target.gpu.timer.collect())
                if (its_job := self._job(key, inputs.rendered, compared, truth)) is not None:
                    levels = 255 * self._setup.hand_in(self.pool, key, its_job).flip_map
                    others.append((method_name(*pair), its_job.now.shown, np.rint(levels).astype(np.uint8)))
            if job is not None:
                if refresh.head.gaze is not None or self._setup.options.fovea is not None:
                    (shown,) = looking([result.view], refresh.head.gaze)
                    self.near_gaze.add(job.now, shown, rendered.view)
                keep = self._keep_every is not None and number // self._every % self._keep_every == 0
                job = attrs.evolve(job, beside=tuple(others))
                self._setup.hand_in(self.pool, (number, eye, MAIN), job, keep=keep)

    def filled_shares(self) -> dict[str, float]:
        """Return the share of pixels that each fill of the chain filled, and the rest ("empty")."""
        if not self._empty:
            return {}
        left = {name: sum(shares) / len(shares) for name, shares in self._empty.items()}
        names = list(left)
        filled = {name: left[before] - left[name] for before, name in zip(names, names[1:], strict=False)}
        return {**filled, "empty": left[names[-1]]}

    def _job(
        self, key: tuple[int, int, int], rendered: EyeImage, result: EyeResult, truth: Truth
    ) -> metrics.QualityJob | None:
        """Return what is to be measured; None for a refresh that only flicker and clips need."""
        number, eye, which = key
        now = metrics.Compared(shown_picture(result), truth.picture, result.view)
        if self.clips is not None:
            self.clips.add(number, eye, which, now)
        before_number, before = self._before.get((eye, which), (None, None))
        self._before[eye, which] = (number, now)
        if truth.inverse_depth is None:
            return None
        previous = before if before_number == number - 1 else None
        late, shape = None, (rendered.view, rendered.size)
        if which == MAIN and PICTURE[0] not in rendered.left_out:
            late = picture_from_linear(download(rendered.colour))
        more: dict[str, Any] = {"rendered_picture": late, "regions": which == MAIN}
        return metrics.QualityJob(now, previous, coverage(result), truth.inverse_depth, *shape, **more)


def method_name(warp: str, fill: str) -> str:
    """Return "mesh" or "mesh + pyramid"."""
    return warp if fill == "none" else f"{warp} + {fill}"
