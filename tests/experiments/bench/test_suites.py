"""Named benchmarks: what they run, and the intervals of their means."""

from __future__ import annotations

import itertools
import json

import numpy as np
import pytest
from recorded_folders import taken, write_npz

from hmdwarp.base import InputError, recording_names
from hmdwarp.base.identity import hash_of_files
from hmdwarp.experiments.bench import BenchOptions
from hmdwarp.experiments.bench.bench_run import further
from hmdwarp.experiments.bench.suite_means import clustered_interval, over_all, ranks_of, suite_entry
from hmdwarp.experiments.bench.suites import half_of, halves, suites
from hmdwarp.poses import KINDS
from hmdwarp.report.bench.page import bench_page

T_OF_2 = 4.302653  # Student's t, 97.5 %


def test_the_standard_suite_is_wide_and_both_run_people_antialiased_on_two_halves():
    """The halves share no scene and no head, and each suite has both."""
    fit, held_out = halves()["fit"], halves()["held_out"]
    assert not {*fit["scenes"]} & {*held_out["scenes"]} and not {*fit["heads"]} & {*held_out["heads"]}
    assert {"quick", "standard"} <= set(suites())
    for name in suites():
        options = BenchOptions.of({"suite": name})
        assert options.samples == 4
        assert set(options.recordings) <= set(recording_names()) - set(KINDS)
        every = [half_of(head, scene) for head, scene in itertools.product(options.recordings, options.scenes)]
        assert {*every} == {"fit", "held_out", ""}
        assert {*options.recordings} <= {*fit["heads"], *held_out["heads"]}
    standard = BenchOptions.of({"suite": "standard"})
    assert len(standard.scenes) >= 6 and len(standard.recordings) >= 8
    assert standard.latencies_ms == (50, 200, 400, 800) and "mesh:grid=64" in standard.warps


@pytest.mark.parametrize(
    "said", [{"latency": ["100"]}, {"traces": ["walk"]}, {"samples": 1, "frames": "x"}, {"instants": 3}]
)
def test_what_a_suite_says_is_not_said_beside_it(said):
    with pytest.raises(InputError, match="the suite says what is run"):
        BenchOptions.of({"suite": "quick", **said})


def test_an_interval_is_that_of_all_pairs_of_cases_that_share_a_head_or_a_scene():
    """By pairs, in place of sums by cluster: 4 heads, 3 scenes, some cases missing."""
    cases = [(head, scene) for head in "ABCD" for scene in "xyz" if (head, scene) not in {("A", "x"), ("C", "z")}]
    values = [("ABCD".index(head) + 1) ** 2 + 9 * "xyz".index(scene) for head, scene in cases]
    off = np.array(values) - np.mean(values)
    one, other = np.meshgrid(range(len(cases)), range(len(cases)))
    same = [names[one] == names[other] for names in np.array(cases).T]
    by_head, by_scene, single = (
        count / (count - 1) * float((np.outer(off, off) * shares).sum()) / len(cases) ** 2
        for count, shares in ((4, same[0]), (3, same[1]), (len(cases), one == other))
    )
    low, high = clustered_interval(values, *zip(*cases, strict=True))
    assert by_head + by_scene - single > max(by_head, by_scene)
    # t of the rarer kind, 3 scenes.
    assert (high - low) / 2 == pytest.approx(T_OF_2 * (by_head + by_scene - single) ** 0.5, rel=1e-5)
    assert clustered_interval([1, 3, 1, 3], list("AABB"), list("xyxy")) is None


def test_equals_share_the_better_rank():
    cases = [(head, scene) for head in "ABC" for scene in "xyz"]
    methods = {
        (name, ""): [{"trace": head, "scene": scene, "quality": {"flip": {"mean": value}}} for head, scene in cases]
        for name, value in (("a", 0.1), ("b", 0.1), ("c", 0.2))
    }
    found = {name: rank for (name, _), rank in ranks_of(methods).items()}
    assert found["a"] == found["b"] == {"best": 1.0, "interval": [1, 1]}
    assert found["c"] == {"best": 0.0, "interval": [3, 3]}


def a_case(trace: str, scene: str, warp: str, fill: str = "none", *, flip: float, db: float) -> dict:
    """The row of a method in a case, but for its instants."""
    named = {"trace": trace, "scene": scene, "latency_ms": 200.0, "warp": warp, "fill": fill}
    return {**named, "quality": {"flip": {"mean": flip}, "psnr_db": {"mean": db}}}


def test_means_are_over_all_cases_of_a_method_and_on_the_page():
    rows = []
    heads, scenes = ("mmsys18-3", "eyenavgs-12", "eyenavgs-19"), ("workshop", "lantern", "staircase")  # held out
    methods = (("oracle", -0.01), ("rotation", 0.1), ("iterative", 0.0))
    for (warp, flip), trace, scene in itertools.product(methods, heads, scenes):
        worse, better = 0.1 * (trace == heads[0]), scene == scenes[0]
        row = a_case(trace, scene, warp, "pyramid", flip=flip + worse, db=30 - 10 * flip + better)
        at = {"flip": {"0": flip, "1": flip + 2 * worse}, "psnr_db": {"0": 30.0, "1": 29.0 + better}}
        rows.append(row | {"at_instants": at, "where_seen": {"share": 0.9, "psnr_db": 33.0}})
    oracle, best, other = over_all(rows)
    assert (oracle["warp"], best["warp"], other["warp"]) == ("oracle", "iterative", "rotation")
    assert best["flip"]["mean"] == pytest.approx(0.1 / 3) and (best["heads"], best["scenes"]) == (3, 3)
    assert best["psnr_db"]["interval"][0] < 30.4 < best["psnr_db"]["interval"][1]
    # Three of 18 pictures are bad, so 95 % of them reach the bad ones.
    assert best["flip"]["p95"] == 0.2
    assert best["psnr_db"]["p95"] == 29 and best["where_seen_db"]["mean"] == 33
    assert (best["rank"], other["rank"]) == ({"best": 1, "interval": [1, 1]}, {"best": 0, "interval": [2, 2]})
    assert oracle["rank"] is None and oracle["behind"]["mean"] == pytest.approx(-0.01)
    # Which head it is makes no difference to the difference of methods.
    assert best["behind"]["mean"] == 0 and other["behind"]["interval"] == pytest.approx([0.1, 0.1])
    assert other["halves"]["held_out"]["behind"] == other["behind"] and other["halves"]["fit"]["behind"] is None
    assert suite_entry("", rows) == {}
    page = bench_page({"rows": [], **suite_entry("quick", rows)}).html()
    assert "Suite quick 3: over all heads and scenes" in page and page.count("0.1000 to 0.1000") == 2
    assert "Suite" not in bench_page({"rows": []}).html()


def test_a_rank_is_as_sure_as_heads_and_scenes_agree():
    """One method is better for one head of four by as much as it is worse for another: a coin."""
    apart = {"a": 0.1, "b": -0.1}
    even = [
        a_case(trace, scene, warp, flip=(error := 0.5 + sign * apart.get(trace, 0.0)), db=error)
        | {"at_instants": {name: {"0": 0.5} for name in ("flip", "psnr_db")}}
        for warp, sign in (("one", 1), ("other", -1))
        for trace, scene in itertools.product("abcd", "xyz")
    ]
    one, other = over_all(even)
    assert one["rank"]["interval"] == other["rank"]["interval"] == [1, 2]
    # Draws in which both heads come as often count for both. Of 500, a share of 0.64 is within 0.1.
    assert one["rank"]["best"] == pytest.approx(other["rank"]["best"], abs=0.1)
    assert one["where_seen_db"] is None


# --- what a suite takes besides what ships: scenes by others, recorded sequences ------------------


def test_scenes_and_recorded_sequences_take_part_with_their_hash_and_noise_floor(tmp_path):
    (tmp_path / "hut.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    for name, facts in (("slide", {"noise_floor_db": 31.5}), ("walk", None)):
        (tmp_path / name).mkdir()
        write_npz(tmp_path / name, taken(8))
        if facts:
            (tmp_path / name / "camera.json").write_text(json.dumps(facts))
    places = [str(tmp_path / name) for name in ("hut.obj", "slide", "walk")]
    options = BenchOptions.of({"suite": "quick", "also": places})
    parts = [further(options, place) for place in options.also]
    assert [(part.scenes, part.sizes) for part, _, _ in parts] == [
        ((places[0],), options.sizes),
        (("slide",), ((29, 19),)),  # 36x24 less the guard band
        (("walk",), ((29, 19),)),
    ]
    assert [about["noise_floor_db"] for _, _, about in parts] == [None, 31.5, None]
    assert [about["sha256"] for _, _, about in parts] == [*map(hash_of_files, places)]
    (tmp_path / "slide" / "camera.json").write_text('{"noise_floor_db": "low"}')
    with pytest.raises(InputError, match="noise_floor_db is 'low'; expected a positive number of dB"):
        further(options, options.also[1])
    with pytest.raises(InputError, match="nowhere"):
        further(options, tmp_path / "nowhere.glb")
    with pytest.raises(InputError, match="--also without --suite"):
        BenchOptions.of({"also": places})
