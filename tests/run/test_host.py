"""Changes of a run that goes on: what can be is done, what cannot leaves all as it was."""

from __future__ import annotations

import math

import attrs
import pytest
from replays import suited

import hmdwarp.pipeline.sizes
from hmdwarp.base import InputError, MachineError
from hmdwarp.client import parse_warp
from hmdwarp.display import CONTROLS, Command, control
from hmdwarp.headsets import load_headset
from hmdwarp.run import CommandHandler, LiveOptions, PipelineHost
from hmdwarp.run import live_run as handling
from hmdwarp.run.live_run import changed, choices, values
from hmdwarp.scenes import ACTIONS

from .gl_objects import living
from .offscreen import OffscreenDisplay, run_on

MS = 1_000_000
LATENCY_MS = 50.0


class Running:
    """A host on a display of its own, one refresh after the other.

    shown: (shown_ns, drawn_ns or None) of each.
    """

    def __init__(self, gpu, **options) -> None:
        self.display = OffscreenDisplay(gpu=gpu, view=options.get("view", "both"))
        usual = {"scene": "planes", "headset": "rift-dk1", "latency_ms": LATENCY_MS, "fill": "none", "samples": 1}
        self.host = PipelineHost(self.display, LiveOptions(**{**usual, **options}))
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
    {"scene": "roon"},
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

        def state() -> tuple[object, ...]:
            run, display = host.run, running.display
            return host.options, run, run.plans, run.source, display.eyes, display.size

        before, objects = state(), living()
        with pytest.raises(InputError):
            running.set(**values)
        # Programs that were compiled are kept for the next time.
        assert state() == before and set(living() - objects) <= {"Program"}
        assert running.go(2).ages_ms[-2:] == [50.0] * 2


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


ONE_EYE = "the flat view has one eye"


@pytest.fixture
def flat(gpu):
    """A host that cannot do every warp."""
    with OffscreenDisplay(gpu=gpu, view="flat") as display:
        options = LiveOptions(scene="planes", latency_ms=0, warp="forward", fill="none", view="flat")
        host = PipelineHost(display, options)
        yield host
        host.close()


@pytest.mark.parametrize("back", [False, True])
def test_steps_pass_over_what_cannot_be(flat, back):
    said: list[str] = []
    one, seen = CommandHandler(flat, said.append), []
    still = {spec for spec in choices()["warp"] if parse_warp(spec).entry.name not in suited("planes")}
    for _ in range(len(choices()["warp"]) - 1 - len(still)):
        assert one.handle([Command("warp", back=back)])
        seen.append(flat.options.warp)
    assert sorted(seen) == sorted(set(choices()["warp"]) - {"multi"} - still)
    assert flat.options.warp == "forward"
    assert sum(ONE_EYE in line for line in said) == 1
    assert all(ONE_EYE in line or "its light stands still" in line for line in said)


def test_possible_commands_of_several_are_carried_out_and_no_value_replaces_an_impossible_one(flat):
    said: list[str] = []
    one = CommandHandler(flat, said.append)
    assert not one.handle([Command("warp", "multi"), Command("guard", 99)])
    assert flat.options.warp == "forward" and len(said) == 2
    assert one.handle([Command("warp", "multi"), Command("latency", 30.0), Command("warp", "backward")])
    assert (flat.options.warp, flat.options.latency_ms) == ("backward", 30)


def test_a_refusal_is_there_until_it_was_read(flat, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(handling.time, "monotonic", lambda: now[0])
    one = CommandHandler(flat, lambda text: None)
    assert one.refusal == ""
    one.handle([Command("warp", "multi")])
    now[0] += handling.READING_S - 0.1
    assert ONE_EYE in one.refusal
    now[0] += 0.2
    assert one.refusal == ""


def test_in_a_run_the_refusal_stands_over_the_pictures_which_go_on(monkeypatch):
    asked = {3: [Command("warp", "multi")], 5: [Command("warp", "backward")]}
    display = OffscreenDisplay(view="flat", asked=asked, keeps=True)
    options = LiveOptions(
        scene="planes", headset="rift-dk1", latency_ms=0, warp="forward", fill="none", view="flat", pictures=8
    )
    run_on(monkeypatch, display, options)
    assert [ONE_EYE in label for label in display.labels] == [False] * 4 + [True] * 4
    assert len(display.said) == 1
    status = display.statuses[-1]
    assert status.values["warp"] == "backward"
    assert ONE_EYE in status.notice
    assert all(picture.any() for picture in display.pictures)


# What people do in the scene changes no option: tests/run/test_inputs.py.
OURS = [control.name for control in CONTROLS if not control.of_display and control.name not in ACTIONS]
OPTIONS = LiveOptions(scene="room", latency_ms=200, warp="forward", fill="interpolate", guard=1.5)


def test_every_control_of_the_run_has_a_value_and_every_choice_its_words():
    assert set(values(OPTIONS)) == set(OURS)
    assert set(choices()) == {control.name for control in CONTROLS if control.kind == "choice"}
    for name, known in choices().items():
        assert values(OPTIONS)[name] in known
        assert len(set(known)) == len(known) > 1


@pytest.mark.parametrize("name", OURS)
@pytest.mark.parametrize("back", [False, True])
def test_a_step_and_one_back_return(name, back):
    there = changed(OPTIONS, Command(name, back=back))
    assert there != OPTIONS
    assert {other for other in OURS if values(there)[other] != values(OPTIONS)[other]} == {name}
    assert changed(there, Command(name, back=not back)) == OPTIONS


@pytest.mark.parametrize("name", ["latency", "guard"])
@pytest.mark.parametrize("back", [False, True])
def test_numbers_stop_at_their_bounds(name, back):
    """Those beyond, which the command line allows, come back into them."""
    options, bound = OPTIONS, control(name).span[0 if back else 1]
    for _ in range(100):
        options = changed(options, Command(name, back=back))
    beyond = attrs.evolve(OPTIONS, latency_ms=9000, guard=5)
    assert values(options)[name] == bound and values(changed(beyond, Command(name)))[name] == control(name).span[1]


def test_a_value_outside_the_list_steps_into_it():
    """Settings of a warp's own, a scene from a file."""
    special = attrs.evolve(OPTIONS, warp="mesh:cut=slope", scene="model.glb")
    for name in ("warp", "scene"):
        assert values(changed(special, Command(name)))[name] in choices()[name]


TAKEN = [("latency", 333), ("guard", 1.1), ("warp", "mesh:cut=slope"), ("view", "flat"), ("lens", "none")]
REFUSED = [
    ("latency", -1), ("latency", 1e9), ("latency", math.nan), ("latency", "fast"), ("guard", 0.5), ("guard", 3.5),
    ("guard", "auto"), ("view", "sideways"), ("view", True), ("warp", 3), ("quit", None), ("speed", 1),
]  # fmt: skip


def test_possible_values_are_taken_as_they_are_and_impossible_ones_refused_by_name():
    for name, value in TAKEN:
        assert values(changed(OPTIONS, Command(name, value)))[name] == value
    for name, value in REFUSED:
        with pytest.raises(InputError, match=name):
            changed(OPTIONS, Command(name, value))


@pytest.mark.parametrize(
    "scene, headset, has",
    [
        ("planes", "rift-dk1", {"lens", "scenes"}),
        ("planes", "quest-3", {"scenes"}),
        ("playroom", "rift-dk1", {"lens", "scenes", "push", "switch", "grab", "release"}),
    ],
)
def test_controls_are_offered_that_scene_and_headset_can_follow(monkeypatch, gpu, scene, headset, has):
    """And another scene's after it was chosen."""
    first, then = ("planes", "playroom") if scene == "playroom" else (scene, scene)
    monkeypatch.setattr("hmdwarp.display.offscreen.load_headset", lambda _: load_headset(headset))
    display = OffscreenDisplay(gpu=gpu, asked={2: [Command("scene", then)]})
    options = LiveOptions(scene=first, headset=headset, latency_ms=0, warp="none", fill="none", samples=1, pictures=4)
    run_on(monkeypatch, display, options)
    assert display.statuses[-1].has == has
    assert [one.name for one in CONTROLS if one.needs and not display.statuses[-1].offers(one)] == [
        one.name for one in CONTROLS if one.needs and one.needs not in has
    ]
