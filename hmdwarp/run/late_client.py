"""A client that takes its time: a late picture is seen later, and away from its place."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ..client.compensator import Compensator, EyeResult
from ..client.inputs import PassInputs
from ..frames import EyeImage
from ..geometry import Pose, View
from ..gpu.context import Gpu
from ..gpu.textures import download, flip_rows
from ..pipeline.loop import Refresh
from ..pipeline.planning import build_plan_for
from ..poses import quaternions
from .frame_rows import Row
from .misses import MEASURED, STANDS, TURNED, Misses, miss_figures
from .replay_setup import ReplaySetup
from .truth import is_measured

Array = NDArray[np.float64]
_POINTS = 17  # a row and a column of the late frame
_MOST_EYES = 2
_MOST_LOOKED_AT = 16  # of the refreshes in a row that show one picture; between them it is interpolated


class SeenOffset:
    """Angles between where points of the late frame are seen and where they are.

    The points are on a grid over the frame, as far away as its depth says; where it has no depth at
    all, infinitely far. turned: pictures are turned to the newest head, else they stand.
    """

    def __init__(self, *, turned: bool) -> None:
        self._turned = turned
        self._made: Refresh | None = None
        self._points: list[tuple[Array, Array]] = []

    def off_deg(self, made: Refresh, refresh: Refresh) -> float:
        """Return the RMS over the points of all eyes. made: when its picture was made."""
        if made is refresh:
            return 0.0
        if made is not self._made:
            self._look(made, (_sampled(inputs.rendered) for inputs in made.inputs))
        return self._rms_deg(made, [inputs.shown for inputs in refresh.inputs])

    def between_deg(
        self, made: Refresh, depths: Iterable[Array], then: Refresh, missed: int, periods: int
    ) -> list[float]:
        """Return it for each of the missed refreshes that showed a picture again.

        depths: as of DepthSamples, of the frame of `made`. then: the next picture, so many periods
        later; the head keeps its speed in between.
        """
        self._look(made, depths)
        shares = np.arange(1, missed + 1) / periods
        looked_at = np.linspace(shares[0], shares[-1], min(missed, _MOST_LOOKED_AT))
        pairs = [(a.shown, b.shown) for a, b in zip(made.inputs, then.inputs, strict=False)]
        found = [self._rms_deg(made, [_between(a, b, float(share)) for a, b in pairs]) for share in looked_at]
        return [float(off) for off in np.interp(shares, looked_at, found)]

    def _look(self, made: Refresh, depths: Iterable[Array]) -> None:
        self._made = made
        self._points = [_points_of(i.rendered, depth) for i, depth in zip(made.inputs, depths, strict=True)]

    def _rms_deg(self, made: Refresh, now: Sequence[View]) -> float:
        views = zip(self._points, [inputs.shown for inputs in made.inputs], now, strict=False)
        angles = [self._angles(points, then, view) for points, then, view in views]
        return float(np.degrees(np.sqrt(np.mean(np.concatenate(angles) ** 2))))

    def _angles(self, points: tuple[Array, Array], then: View, now: View) -> Array:
        seen, right = (_ways(points, view) for view in (then, now))
        if not self._turned:
            seen = seen @ then.pose.rotation_matrix @ now.pose.rotation_matrix.T
        apart, together = (np.linalg.norm(ways, axis=1) for ways in (seen - right, seen + right))
        return np.asarray(2 * np.arctan2(apart, together))


class DepthSamples:
    """Inverse depth of late frames at the points of a SeenOffset, without waiting for the GPU.

    take() starts; before() returns those of the refresh before, which are finished long ago.
    """

    def __init__(self, gpu: Gpu) -> None:
        self._gl = gpu.gl
        self._program = gpu.shaders.compute("live/depths.comp")
        size = 4 * _MOST_EYES * _POINTS**2
        self._now, self._before = (gpu.gl.buffer(reserve=size) for _ in range(2))

    def take(self, inputs: Sequence[PassInputs]) -> None:
        """Sample the frame of each eye. Call once for each picture."""
        self._now, self._before = self._before, self._now
        self._now.bind_to_storage_buffer(0)
        for slot, eye in enumerate(inputs):
            depth = eye.rendered.inverse_depth
            depth.bind_to_image(0, read=True, write=False)
            self._program.uniforms.set(inverse_depth=0, size=depth.size, points=_POINTS, slot=slot)
            self._program.run(_POINTS, _POINTS)
        self._gl.memory_barrier(moderngl.BUFFER_UPDATE_BARRIER_BIT)

    def before(self, eyes: int) -> list[Array]:
        """Return (17, 17) for each eye, the top row first, of the picture before the last one."""
        every = np.frombuffer(self._before.read(), np.float32).reshape(_MOST_EYES, _POINTS, _POINTS)
        return [flip_rows(one.astype(np.float64)) for one in every[:eyes]]

    def close(self) -> None:
        """Free the buffers."""
        for buffer in (self._now, self._before):
            buffer.release()


def _sampled(eye: EyeImage) -> Array:
    inverse = download(eye.inverse_depth)
    rows, columns = ((np.arange(_POINTS) + 0.5) * side / _POINTS for side in inverse.shape[:2])
    found: Array = inverse.reshape(inverse.shape[:2])[np.ix_(rows.astype(int), columns.astype(int))].astype(np.float64)
    return found


def _points_of(eye: EyeImage, depths: Array) -> tuple[Array, Array]:
    """Return homogeneous points in the world, (n, 3) times the inverse depth, (n, 1).

    All of the late frame that the picture may show.
    """
    found = depths.reshape(-1, 1)
    inverse = np.where((found >= 0).any(), found, 0.0)
    ways = eye.view.rays((_POINTS, _POINTS)).reshape(-1, 3) @ eye.view.pose.rotation_matrix.T
    points, drawn = ways + eye.view.pose.position_m * inverse, inverse[:, 0] >= 0
    return points[drawn], inverse[drawn]


def _between(a: View, b: View, share: float) -> View:
    turned = quaternions.slerp(a.pose.orientation_xyzw.tolist(), b.pose.orientation_xyzw.tolist(), share)
    return View(Pose(a.pose.position_m + share * (b.pose.position_m - a.pose.position_m), turned), a.fov)


def _ways(points: tuple[Array, Array], view: View) -> Array:
    """Return the unit vectors, (n, 3), from an eye to the points."""
    ways = points[0] - view.pose.position_m * points[1]
    return np.asarray(ways / np.linalg.norm(ways, axis=1, keepdims=True))


MISS_COLUMNS = ("frame", "time_s", "stale", "off_deg", "took_ms")


@attrs.frozen
class _Work:
    """A picture in the making."""

    # The refresh it is made for, and the one that first shows it.
    instant_ns: int
    seen: int
    took_ms: float


@attrs.frozen(eq=False)
class Seen:
    """What a refresh showed."""

    refresh: Refresh
    # Whether its picture was seen before.
    stale: bool
    # From when to when the client worked on it, in ns; None for a stale one.
    work_ns: tuple[int, int] | None


class LateClient:
    """Show what the client has finished by each refresh.

    The first picture is there in time. Without misses every refresh is that of the loop, bit for
    bit. The loop makes a picture when it is first seen, for the refresh it was to be made for, so
    that the one before stands until then.
    """

    def __init__(self, setup: ReplaySetup, misses: Misses) -> None:
        self._setup, self._misses = setup, misses
        self._period_ms = 1e3 / setup.schedule.rate_hz
        self._turner = _turner(setup) if misses.turns else None
        self._offset = SeenOffset(turned=misses.turns)
        self._work: _Work | None = None
        self._made: Refresh | None = None
        self._took_ms = 0.0
        # (frame, time_s, stale, off_deg, took_ms) of each refresh.
        self._rows: list[tuple[int, float, bool, float, float | None]] = []

    def at(self, number: int, instant_ns: int) -> Seen | None:
        """Return what refresh `number` shows, None before the first frame has arrived."""
        if self._work is None:
            self._begin(number, instant_ns)
        work, made = self._work, self._made
        assert work is not None
        stale = work.seen > number
        if not stale:
            self._work = None
            made = self._made = self._setup.loop.show(work.instant_ns)
            self._took_ms = work.took_ms
        if made is None:
            return None
        refresh = made if made.shown_ns == instant_ns else self._again(made, instant_ns, stale=stale)
        self._add(refresh, made, None if stale else work.took_ms)
        begun_ns = work.instant_ns - round(self._period_ms * 1e6)
        return Seen(refresh, stale, None if stale else (begun_ns, begun_ns + round(work.took_ms * 1e6)))

    def _begin(self, number: int, instant_ns: int) -> None:
        made, loop = self._made, self._setup.loop
        if made is None or not self._misses.times_ms:
            loop.settle()
        else:
            loop.settle(((("warp", self._took_ms / len(made.eyes)),),) * len(made.eyes))
        took_ms = self._next_ms(number)
        late = self._misses.refreshes(took_ms, self._period_ms) - 1 if made is not None else 0
        self._work = _Work(instant_ns, number + late, took_ms)

    def _next_ms(self, number: int) -> float:
        """Return how long the client takes for the picture that it begins now."""
        given = self._misses.times_ms
        if not given:
            return sum(ms for stages in self._made.stage_ms for _, ms in stages) if self._made is not None else 0.0
        return given[number % len(given)]

    def _again(self, made: Refresh, instant_ns: int, *, stale: bool) -> Refresh:
        refresh = self._setup.loop.again(made, instant_ns)
        if self._turner is not None:
            turned = tuple(self._turned(self._turner, *pair) for pair in zip(made.eyes, refresh.inputs, strict=True))
            self._setup.gpu.timer.collect()
            refresh = attrs.evolve(refresh, eyes=turned)
        return refresh if stale else attrs.evolve(refresh, laps=made.laps)

    def _turned(self, turner: Compensator, made: EyeResult, inputs: PassInputs) -> EyeResult:
        assert made.shown is not None  # options refuse a warp that is fused with the lens
        picture = attrs.evolve(inputs.rendered, view=made.view, colour=made.shown.texture, carried={})
        return turner.run(PassInputs(picture, inputs.shown, inputs.eye, shown_ns=inputs.shown_ns))

    def _add(self, refresh: Refresh, made: Refresh, took_ms: float | None) -> None:
        off = self._offset.off_deg(made, refresh)
        time_s = (refresh.shown_ns - self._setup.track.start_ns) * 1e-9
        self._rows.append((len(self._rows), time_s, took_ms is None, off, took_ms))

    def rows(self) -> Iterator[Row]:
        """Yield the rows of misses.csv, one for each refresh."""
        for row in self._rows:
            yield {**dict(zip(MISS_COLUMNS, row, strict=True)), "stale": int(row[2])}

    def entry(self) -> dict[str, Any]:
        """Return the `miss` of summary.json."""
        stale = [row[2] for row in self._rows]
        every = self._setup.options.metrics_every
        measured = [row[2] for row in self._rows if is_measured(row[0], every)]
        return {
            "budget_ms": self._misses.budget_ms or self._period_ms,
            "times": "given" if self._misses.times_ms else MEASURED,
            "show": TURNED if self._misses.turns else STANDS,
            **miss_figures(stale, [row[3] for row in self._rows]),
            "stale_share_measured": sum(measured) / len(measured),
        }


def _turner(setup: ReplaySetup) -> Compensator:
    """Return what turns a finished picture, before the lens."""
    turning = attrs.evolve(setup.options.with_pair("rotation", "none"), effects="none", strategy="", client="")
    return setup.pipeline.compensator_of_shown(build_plan_for(turning, setup.headset, None))
