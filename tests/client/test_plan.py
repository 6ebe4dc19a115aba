"""The plan over every combination of registered passes: what runs, why, and that nothing else costs anything."""

from __future__ import annotations

import itertools

import attrs
import moderngl
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from worlds import World

from hmdwarp.client.compensator import Compensator
from hmdwarp.client.effects import effects
from hmdwarp.client.fills import fills
from hmdwarp.client.given import Given
from hmdwarp.client.lens import lenses
from hmdwarp.client.plan import CLIENT_DEPTH, LATE, PANEL, SHOWN, Plan, build_plan, needs_of
from hmdwarp.client.warps import warps
from hmdwarp.errors import InputError, PlanError, UnknownNameError
from hmdwarp.gpu.shaders import ShaderLibrary
from hmdwarp.headsets import load_headset
from hmdwarp.scenes.effects import SceneEffect

ALL = list(itertools.product(warps.names(), fills.names(), lenses.names(), [True, False]))
POSSIBLE = [(w, f, n, g) for w, f, n, g in ALL if g or CLIENT_DEPTH not in warps.get(w).reads]


def plan_of(warp: str, fill: str, lens: str, geometry: bool) -> Plan:
    return build_plan(SceneEffect.NONE, warp, fill, lens, client_geometry=geometry)


# --- what is in it -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("choice", POSSIBLE, ids=str)
def test_everything_read_was_written_before(choice):
    plan = plan_of(*choice)
    known = set(LATE)
    for step in plan.steps:
        assert set(step.reads) <= known, step.name
        known |= set(step.writes)
    assert SHOWN in known


@pytest.mark.parametrize("choice", POSSIBLE, ids=str)
def test_every_stage_runs_or_is_left_out_with_a_reason(choice):
    warp, fill, lens, geometry = choice
    plan = plan_of(*choice)
    stages = [step.stage for step in plan.steps]
    left_out = dict(plan.left_out)
    assert stages == [s for s in ("client_depth", "warp", "fill", "lens") if s in stages], "in this order, none twice"
    assert set(stages) | set(left_out) == {"client_depth", "warp", "fill", "lens", *effects.names()}
    assert not set(stages) & set(left_out)
    assert all(reason.strip() for reason in [*left_out.values(), *(step.reason for step in plan.steps)])
    assert ("fill" in stages) == (fill != "none")
    assert ("lens" in stages) == (lens != "none")
    assert ("client_depth" in stages) == (CLIENT_DEPTH in warps.get(warp).reads)
    assert plan.draws_client_depth == ("client_depth" in stages)
    assert (plan.warp.name, plan.fill, plan.lens.name) == (warp, fill, lens)
    assert (PANEL in {w for step in plan.steps for w in step.writes}) == (lens != "none")


@pytest.mark.parametrize("choice", POSSIBLE, ids=str)
def test_a_frame_carries_what_is_read_of_it_and_no_more(choice):
    plan = plan_of(*choice)
    wanted = {name for name in warps.get(choice[0]).reads if name in LATE}
    assert set(plan.layers) == wanted


@pytest.mark.parametrize("warp", warps.names())
def test_reasons_speak_of_what_was_asked_for(warp):
    plan = plan_of(warp, "interpolate", "radial", True)
    text = "\n".join(step.reason for step in plan.steps)
    for entry in (warps.get(warp), fills.get("interpolate"), lenses.get("radial")):
        assert entry.summary in text
    plan = plan_of("rotation", "none", "none", False)
    assert dict(plan.left_out)["client_depth"] == "warp 'rotation' does not read it"


@pytest.mark.parametrize("registry", [warps, fills, lenses], ids=lambda r: r.kind)
def test_every_entry_says_what_it_is_and_reads_what_exists(registry):
    known = {*LATE, CLIENT_DEPTH, SHOWN, PANEL}
    for entry in registry:
        assert entry.summary
        assert entry.source
        assert set(entry.reads) <= known
        if registry is warps:
            assert entry.kind in ("gather", "scatter")
            assert entry.exact_when
            assert entry.gets_wrong
        else:
            assert isinstance(entry.is_pass, bool)


# --- what is refused -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("fill", "lens"), list(itertools.product(fills.names(), lenses.names())))
def test_backward_without_geometry_is_refused(fill, lens):
    with pytest.raises(PlanError) as caught:
        plan_of("backward", fill, lens, False)
    message = str(caught.value)
    assert message == (
        "warp backward reads client.inverse_depth, which no pass before it writes; it needs the scene's geometry on the client"
    )


def test_one_run_keeps_older_frames_one_way():
    plans = [plan_of(f"multi:spacing={ms}", "none", "none", True) for ms in (300, 50)]
    assert needs_of([plans[0], plans[0], plan_of("forward", "none", "none", True)]) == plans[0].needs
    with pytest.raises(InputError, match="50 ms and 300 ms apart"):
        needs_of(plans)


def test_what_is_impossible_is_only_that():
    refused = set(ALL) - set(POSSIBLE)
    assert {choice[0] for choice in refused} == {"backward"}
    assert all(not choice[3] for choice in refused)


@pytest.mark.parametrize(
    ("warp", "fill", "lens", "says"),
    [
        ("forwrd", "none", "none", "unknown warp 'forwrd': did you mean 'forward'? known are "),
        ("rotate", "none", "none", "unknown warp 'rotate': did you mean 'rotation'?"),
        ("forward", "interpolat", "none", "unknown fill 'interpolat': did you mean 'interpolate'?"),
        ("forward", "none", "radal", "unknown lens 'radal': did you mean 'radial'?"),
        ("zzzz", "none", "none", "unknown warp 'zzzz': known are backward"),
        ("", "none", "none", "unknown warp '': known are"),
        ("_base", "none", "none", "unknown warp '_base'"),
        ("_homography", "none", "none", "unknown warp '_homography'"),
        ("Forward", "none", "none", "did you mean 'forward'?"),
    ],
)
def test_unknown_names_get_the_nearest_known_one(warp, fill, lens, says):
    with pytest.raises(UnknownNameError) as caught:
        plan_of(warp, fill, lens, True)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


@given(st.text(max_size=12))
def test_any_text_is_a_plan_or_an_unknown_name(text):
    for choice in ((text, "none", "none"), ("forward", text, "none"), ("forward", "none", text)):
        try:
            assert isinstance(plan_of(*choice, True), Plan)
        except InputError as error:
            names = [part.partition(":")[0].strip() for part in text.split("+")]  # what follows a colon are settings
            assert any(repr(name)[1:-1] in str(error) or name in str(error) for name in (text, text.partition(":")[0], *names))


# --- what it costs -------------------------------------------------------------------------------------------------------

LATE_SIZE, SHOWN_SIZE = (33, 21), (29, 17)


class Costs:
    """What a context was asked to make: programs by path, textures, buffers, framebuffers."""

    def __init__(self, gpu, monkeypatch) -> None:
        self.made: dict[str, list] = {"texture": [], "buffer": [], "framebuffer": []}
        self.library = ShaderLibrary(gpu.gl)
        monkeypatch.setattr(gpu, "shaders", self.library)
        for kind, made in self.made.items():
            monkeypatch.setattr(moderngl.Context, kind, self._counting(getattr(moderngl.Context, kind), made))

    @staticmethod
    def _counting(make, made):
        def counted(*args, **kwargs):
            made.append(make(*args, **kwargs))
            return made[-1]

        return counted

    @property
    def counts(self) -> dict[str, int]:
        return {kind: len(made) for kind, made in self.made.items()} | {"program": self.library.compiled}

    def paths(self) -> set[str]:
        return {part for key in self.library._cache for part in key if isinstance(part, str)}

    def alive(self) -> list:
        return [thing for made in self.made.values() for thing in made if not isinstance(thing.mglo, moderngl.InvalidObject)]


def given_for(gpu, warp: str) -> Given:
    """All that this warp reads, for LATE_SIZE and SHOWN_SIZE."""
    world = World(gpu, 1, LATE_SIZE, SHOWN_SIZE, moved=False)
    world.bring(gpu, warps.get(warp))
    return attrs.evolve(world.given(warps.get(warp)), client_inverse_depth=None)


class HalfMetre:
    """A client whose whole world is 2 m away."""

    def draw_depth(self, view, size, into, time_ns) -> None:
        into.write(np.full(size[::-1], 0.5, np.float32).tobytes(), alignment=1)


@pytest.mark.parametrize("choice", POSSIBLE, ids=str)
def test_passes_left_out_cost_nothing(gpu, monkeypatch, choice):
    warp, fill, lens, _ = choice
    plan, given = plan_of(*choice), given_for(gpu, warp)
    alone = Costs(gpu, monkeypatch)
    warps.get(warp)(gpu, LATE_SIZE, SHOWN_SIZE).close()
    own = alone.counts
    costs = Costs(gpu, monkeypatch)
    compensator = Compensator(gpu, plan, load_headset("rift-dk1"), LATE_SIZE, SHOWN_SIZE, HalfMetre())
    # A canvas per eye for the warp, one more for each pass after it, and the client's depth once.
    canvases = 2 * (1 + (fill != "none") + (lens != "none"))
    assert len(costs.made["texture"]) == own["texture"] + canvases + plan.draws_client_depth
    assert len(costs.made["framebuffer"]) == own["framebuffer"] + canvases
    assert len(costs.made["buffer"]) == own["buffer"]
    others = {path for path in costs.paths() if path not in alone.paths()}
    assert {path.split("/")[0] for path in others} == ({"fills"} if fill != "none" else set()) | ({"lens"} if lens != "none" else set())

    before = costs.counts
    for eye in (0, 1, 0):
        result = compensator.run(attrs.evolve(given, eye=eye))
    assert costs.counts == before, "run() compiles and allocates nothing"
    assert (result.shown is result.warped) == (fill == "none")
    assert (result.panel is result.shown) == (lens == "none")
    stages = [name for name, _ in gpu.timer.collect()]
    assert stages == [step.stage for step in plan.steps] * 3

    compensator.close()
    assert costs.alive() == [], "close() frees everything"


def test_a_second_compensator_compiles_nothing_anew(gpu, monkeypatch):
    costs = Costs(gpu, monkeypatch)
    plan = plan_of("forward", "interpolate", "radial", True)
    first = Compensator(gpu, plan, load_headset("rift-dk1"), LATE_SIZE, SHOWN_SIZE)
    programs = costs.library.compiled
    second = Compensator(gpu, plan, load_headset("rift-dk1"), SHOWN_SIZE, LATE_SIZE)
    assert costs.library.compiled == programs
    first.close()
    second.close()


def test_the_eyes_have_pictures_of_their_own(gpu):
    given = given_for(gpu, "forward")
    compensator = Compensator(gpu, plan_of("forward", "interpolate", "none", True), load_headset("flat-90"), LATE_SIZE, SHOWN_SIZE)
    left = compensator.run(given)
    right = compensator.run(attrs.evolve(given, eye=1))
    assert len({id(c.texture) for c in (left.warped, left.shown, right.warped, right.shown)}) == 4
    compensator.close()
    gpu.timer.collect()


def test_backward_run_without_a_depth_is_refused(gpu):
    warp = warps.get("backward")(gpu, LATE_SIZE, SHOWN_SIZE)
    with pytest.raises(PlanError, match="needs the client's own depth"):
        warp.run(given_for(gpu, "backward"), None)
