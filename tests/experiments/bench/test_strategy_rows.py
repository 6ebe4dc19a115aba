"""Rows of strategies in a bench, each with the late frames that it shares or has by itself."""

from __future__ import annotations

import math

import attrs
import pytest
from bench_files import WITHOUT_PAGE
from replays import CHEAPER, replayed, scene_for

from hmdwarp.base import PlanError
from hmdwarp.client.strategies import has_own_link, strategies
from hmdwarp.experiments.bench import bench
from hmdwarp.experiments.bench.cases import combinations_of, common_start_s
from hmdwarp.experiments.bench.options import FILLS
from hmdwarp.link import CHANGES
from hmdwarp.metrics import QUALITY
from hmdwarp.pipeline.options import DEFAULT_FILL, DEFAULT_WARP
from hmdwarp.poses import load_trace
from hmdwarp.run import RunOptions
from hmdwarp.run.measuring import batches
from hmdwarp.scenes import load_scene

from .test_bench import TINY

NAMES = [CHEAPER.get(name, name) for name in strategies.names()]
LATENCY_MS = 100.0
OPTIONS = attrs.evolve(
    TINY, warps=(), fills=FILLS, recordings=("look-around",), latencies_ms=(LATENCY_MS,), headset="flat-90",
    start_s=0.5, seconds=0.2, guard=1.2, instants=2,
)  # fmt: skip
MEASURED = ((3, 0), (9, 1))  # the refreshes of twelve that are measured, each with its eye: they take turns


@pytest.fixture(scope="module")
def rows(tmp_path_factory) -> dict[str, dict]:
    """The row of each strategy in its scene; those of one scene in one bench."""
    found = {}
    for scene in sorted({scene_for(name) for name in NAMES}):
        named = tuple(name for name in NAMES if scene_for(name) == scene)
        out = tmp_path_factory.mktemp("bench") / scene
        with WITHOUT_PAGE:
            result = bench(attrs.evolve(OPTIONS, strategies=named, scenes=(scene,), out=out))
        found |= {row["strategy"]: row for row in result.data["rows"]}
    return found


def alone(name: str) -> RunOptions:
    """A replay of the strategy over the same way, said by its options."""
    way = {"proxy_latency": 0.75 * LATENCY_MS, "latency": 0.25 * LATENCY_MS} if name == "proxy" else {}
    said = {"strategy": name, "scene": scene_for(name), "latency": LATENCY_MS, **way}
    named = ("headset", "rate_hz", "start_s", "seconds", "guard", "workers")
    same = {field: getattr(OPTIONS, field) for field in named}
    more = {"size": OPTIONS.sizes[0], "predict": "cautious", "lens": "none", "against": "", "images": 0}
    return RunOptions.of(said, trace="look-around", metrics_every=1, **same, **more)


@pytest.mark.parametrize("name", NAMES)
def test_figures_are_those_of_a_replay_that_draws_every_frame(rows, name, tmp_path):
    pictures = replayed(attrs.evolve(alone(name), out=tmp_path / "run")).rows
    wanted = [row for row in pictures if (row["frame"], row["eye"]) in MEASURED]
    assert len(wanted) == len(MEASURED)
    # A fill that remembers has seen fewer refreshes than in a replay; no fill changes the holes.
    exact = ("hole_share",) if "memory" in rows[name]["fill"] else QUALITY
    for figure in exact:
        assert rows[name]["quality"][figure]["mean"] == math.fsum(row[figure] for row in wanted) / 2, figure


def test_all_stand_beside_each_other_as_one_case(rows):
    assert rows.keys() == set(NAMES)
    for row in rows.values():
        assert row["latency_ms"] == LATENCY_MS and row["frames"] == len(MEASURED)
        assert list(row["at_instants"]["flip"]) == [str(number) for number, _ in MEASURED]
        assert row["client"] and row["time_ms"]["total"]["median"] > 0
    # The light alone is warped by the default chain: other pictures, of the same warp and fill.
    light, usual = rows["light"], rows["depth_image"]
    assert (light["warp"], light["fill"]) == (usual["warp"], usual["fill"]) == (DEFAULT_WARP, DEFAULT_FILL)
    assert light["quality"]["psnr_db"] != usual["quality"]["psnr_db"]


def test_strategies_that_set_the_link_have_late_frames_of_their_own():
    assert {name for name in NAMES if has_own_link(name)} == {"proxy", "views"}
    assert has_own_link("proxy:client=rotation") and not has_own_link("multi:frames=2")


def test_combinations_that_depend_on_earlier_frames_are_batched_alone():
    asked = attrs.evolve(OPTIONS, warps=("forward", "points"), fills=("none", "pyramid"), strategies=("views", "multi"))
    every = combinations_of(asked, load_scene("planes"))
    found = [[c.group for c in batch] for batch in batches(every, (8, 8), (8, 8), 1e9)]
    assert found == [["forward", "forward", "multi"], ["points"], ["points"], ["views"]]


def test_all_begin_at_the_refresh_at_which_the_last_of_them_has_a_frame():
    """75 ms and 25 ms are five refreshes and two, 100 ms over one link are six."""
    walk, early = load_trace("walk").track, attrs.evolve(OPTIONS, recordings=("walk",), start_s=0.0)
    assert common_start_s(early, walk, 60.0) == 6 / 60
    assert common_start_s(attrs.evolve(early, strategies=("views", "proxy")), walk, 60.0) == 7 / 60


def test_a_strategy_keeps_what_it_sets_of_the_link_that_all_have():
    named = RunOptions.of({"strategy": "views"}, trace="walk")
    shared = attrs.evolve(RunOptions.of({"server_rate": 30.0}, trace="walk"), trace="walk")
    over = named.over(120.0, shared.network, shared.coding)
    assert (over.network.server_rate_hz, over.network.send, over.latency_ms) == (30.0, CHANGES, 120.0)


def test_an_unsuited_strategy_is_refused_with_the_reason(tmp_path):
    with pytest.raises(PlanError, match="its light stands still"):
        bench(attrs.evolve(OPTIONS, strategies=("photons",), scenes=("planes",), out=tmp_path / "bench"))
