"""What is on changes while the run goes on.

No more is thrown away than must be, what cannot be changes nothing, nothing is left behind.
"""

from __future__ import annotations

import math

import attrs
import pytest

import hmdwarp.pipeline.sizes
from hmdwarp.display import Command
from hmdwarp.errors import InputError, MachineError
from hmdwarp.run import LiveOptions, PipelineHost
from hmdwarp.run.host import changed

from .gl_objects import living
from .offscreen import OffscreenDisplay

MS = 1_000_000
LATENCY_MS = 50.0


class Running:
    """A host on a display of its own, one refresh after the other.

    shown: (shown_ns, drawn_ns or None) of each.
    """

    def __init__(self, gpu, **options) -> None:
        view = options.get("view", "both")
        self.display = OffscreenDisplay(gpu=gpu, view=view)
        self.host = PipelineHost(
            self.display, LiveOptions(**{"scene": "planes", "latency_ms": LATENCY_MS, "fill": "none", **options})
        )
        self.shown: list[tuple[int, int | None]] = []
        self.sent: list[tuple[int, float]] = []  # (drawn_ns, latency in ms) of each frame

    def go(self, count: int) -> Running:
        for _ in range(count):
            tick = self.display.wait()
            now_ns = self.display.now_ns()
            self.host.run.loop.draw(now_ns)
            self.sent.append((now_ns, self.host.options.latency_ms))
            refresh = self.host.run.loop.show(tick.shown_ns)
            self.display.show(refresh)
            self.shown.append((tick.shown_ns, refresh.frame.drawn_ns if refresh is not None else None))
        return self

    def set(self, **values: object) -> Running:
        self.host.change(attrs.evolve(self.host.options, **values))
        return self

    @property
    def ages_ms(self) -> list[float | None]:
        return [None if drawn_ns is None else (shown_ns - drawn_ns) / MS for shown_ns, drawn_ns in self.shown]

    def __enter__(self) -> Running:
        return self

    def __exit__(self, *_: object) -> None:
        self.host.close()
        self.display.close()


# --- latency


@pytest.mark.parametrize("latency_ms", [0.0, 20.0, 55.0, 120.0])
def test_frames_under_way_arrive_as_they_would_have(gpu, latency_ms):
    """The newest of those that have arrived is shown at each refresh, by the latency each was sent
    with.

    Pictures never stop.
    """
    with Running(gpu) as running:
        pipeline = running.go(12).host.run
        running.set(latency_ms=latency_ms).go(20)
        assert running.host.run is pipeline
        assert running.host.options.latency_ms == latency_ms
        for (shown_ns, drawn_ns), number in zip(running.shown, range(1, 33), strict=True):
            arrived = [sent_ns for sent_ns, latency in running.sent[:number] if sent_ns + latency * MS <= shown_ns]
            assert drawn_ns == max(arrived, default=None)
        assert None not in running.ages_ms[12:]
        # A picture is asked for 20 ms before it is seen, and frames are drawn every 10 ms.
        assert running.ages_ms[-1] == max(20.0, -(-latency_ms // 10) * 10)


def test_the_server_predicts_for_the_new_latency(gpu):
    """As a run that began with it."""

    def ahead_ms(running: Running) -> float:
        running.go(40)
        frame = running.host.run.loop.show(running.display.wait().shown_ns).frame
        return (frame.head.time_ns - frame.drawn_ns) / MS

    with Running(gpu, predict="constant_velocity") as running:
        assert ahead_ms(running) == LATENCY_MS
        assert ahead_ms(running.set(latency_ms=150.0)) == 150.0


def test_a_latency_that_no_memory_holds_is_refused(gpu, monkeypatch):
    """2 GB of frames, on a machine that has 0.1."""
    if not gpu.is_software:
        pytest.skip("frames lie in a GPU's own memory, whose size OpenGL does not tell")
    monkeypatch.setattr(hmdwarp.pipeline.sizes, "memory_bytes", lambda: 1e8)
    with Running(gpu) as running:
        running.go(8)
        with pytest.raises(MachineError, match="this machine has 0.1 GB"):
            running.set(latency_ms=100_000.0)
        assert running.host.options.latency_ms == LATENCY_MS
        assert running.go(3).ages_ms[-3:] == [50.0] * 3


# --- passes


@pytest.mark.parametrize(
    "values", [{"warp": "backward"}, {"fill": "interpolate"}, {"lens": "none"}, {"warp": "mesh", "fill": "pyramid"}]
)
def test_passes_that_read_the_same_are_exchanged_between_two_pictures(gpu, values):
    with Running(gpu) as running:
        pipeline, before = running.go(8).host.run, running.host.run.loop.compensator.plan
        frames = {drawn_ns for drawn_ns, _ in running.sent}
        running.set(**values).go(1)
        assert running.host.run is pipeline
        assert running.shown[-1][1] in frames  # drawn before the change
        assert running.host.run.loop.compensator.plan is not before
        assert running.go(3).ages_ms[-3:] == [50.0] * 3


@pytest.mark.parametrize(
    "values",
    [{"warp": "layered"}, {"warp": "multi"}, {"fill": "wide"}, {"scene": "spheres"}, {"guard": 1.25}, {"view": "flat"}],
)
def test_changes_that_need_other_frames_restart_the_pipeline(gpu, values):
    """Its first picture comes when its first frame has arrived.

    50 ms, shown 20 ms after it is asked for, every 10 ms.
    """
    with Running(gpu) as running:
        pipeline = running.go(8).host.run
        running.set(**values).go(8)
        assert running.host.run is not pipeline
        assert running.ages_ms[8:] == [None] * 3 + [50.0] * 5


# --- what cannot be

IMPOSSIBLE = [
    {"warp": "fward"},
    {"fill": "intrpolate"},
    {"scene": "roon"},
    {"effects": "mirors"},
    {"lens": "cubic"},
    {"guard": 400.0},
    {"guard": 400.0, "view": "flat"},
    {"latency_ms": math.inf},
    {"warp": "multi", "view": "flat"},
    {"warp": "environment", "fill": "fward", "latency_ms": 10.0},
    {"size": (60_000, 8)},
]


@pytest.mark.parametrize("values", IMPOSSIBLE, ids=lambda values: " ".join(map(str, values.values())))
def test_an_impossible_change_leaves_all_as_it_was(gpu, values):
    with Running(gpu) as running:
        host = running.go(8).host
        before = (host.options, host.run, host.run.plans, host.run.source, running.display.eyes, running.display.size)
        objects = living()
        with pytest.raises(InputError):
            running.set(**values)
        assert (
            host.options,
            host.run,
            host.run.plans,
            host.run.source,
            running.display.eyes,
            running.display.size,
        ) == before
        assert living() - objects == {} or set(living() - objects) == {
            "Program"
        }  # compiled ones are kept for the next time
        assert running.go(2).ages_ms[-2:] == [50.0] * 2


def test_a_warp_for_two_eyes_is_refused_in_the_flat_view(gpu):
    with Running(gpu, view="flat") as running:
        running.go(8)
        with pytest.raises(InputError, match="the flat view has one eye"):
            running.set(warp="multi")
        assert running.go(1).ages_ms[-1] == 50.0


# --- nothing is left behind

TOUR = [
    Command("latency"), Command("latency", back=True), Command("warp", "backward"), Command("fill", "pyramid"),
    Command("warp", "layered"), Command("guard"), Command("guard", back=True), Command("scene", "spheres"),
    Command("view"), Command("lens"), Command("lens"), Command("view"), Command("effects", "none"),
    Command("effects", "auto"), Command("scene", "planes"), Command("fill", "none"), Command("warp", "forward"),
]  # fmt: skip


def test_a_tour_of_all_changes_leaves_nothing_on_the_gpu(gpu):
    """The second and the third time round, nothing is there that was not there after the first.

    Textures, buffers, programs.
    """
    with Running(gpu) as running:
        counts = []
        for _ in range(3):
            for command in TOUR:
                running.host.change(changed(running.host.options, command))
                running.go(1)
            running.go(8)
            counts.append(living())
        assert counts[1] == counts[2] == counts[0]
        assert counts[0]["Texture"] > 10  # or nothing was counted
