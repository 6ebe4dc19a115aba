"""Whole benches, small and real.

What they write, that their figures are a replay's, that nothing but times changes, what is kept.
"""

from __future__ import annotations

import csv
import json

import attrs
import numpy as np
import pytest
from bench_files import WITHOUT_PAGE
from replays import contents, run

from hmdwarp.base import folder
from hmdwarp.experiments.bench import BenchOptions, bench, read
from hmdwarp.experiments.bench.bench_run import NAMES
from hmdwarp.experiments.sweep import KeptOptions
from hmdwarp.link import LinkOptions
from hmdwarp.metrics import QUALITY, STAGES
from hmdwarp.report import validate_summary
from hmdwarp.report.bench.crops import unpacked

SMALL = BenchOptions(
    warps=("forward", "rotation", "backward"), fills=("none", "interpolate"), latencies_ms=(100.0, 200.0),
    scenes=("planes",), recordings=("look-around",), headset="rift-dk1", sizes=((96, 80),), rate_hz=60.0,
    seconds=0.5, guard=1.2,
    samples=1,  # a guarded frame has another raster, and so other mixtures at edges than the truth
    instants=2, rounds=2, workers=0, command="hmdwarp bench",
)  # fmt: skip
TINY = BenchOptions(
    warps=("rotation",), fills=("none",), latencies_ms=(50.0, 100.0), scenes=("planes",), sizes=((48, 40),),
    headset="rift-dk1", rate_hz=60.0, seconds=0.3, guard=1.1, instants=1, rounds=1, workers=0,
)  # fmt: skip
KEYS = {
    *("schema", "hmdwarp", "program", "notes", "command", "machine", "clock", "clocks", "client"),
    *("rows", "winners", "seconds"),
}


def untimed(rows: list[dict]) -> list[dict]:
    return [{key: value for key, value in row.items() if key != "time_ms"} for row in rows]


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    """The whole bench; and the steps it told of."""
    out, steps = tmp_path_factory.mktemp("bench") / "made", []
    result = bench(attrs.evolve(SMALL, out=out), lambda done, total: steps.append((done, total)))
    return out, result, steps


def test_its_files_hold_the_rows(full):
    out, result, steps = full
    made = {name for name in contents(out) if not name.startswith("cases/")}
    assert made == {"bench.csv", "bench.json", "bench.html"}
    assert result.report == out / "bench.html"
    page = result.report.read_text(encoding="utf-8")
    assert "axes of look-around <b>openxr (world=x,y,-z head=x,y,-z), stated by the file</b>" in page
    text = (out / "bench.json").read_text(encoding="utf-8")
    data = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} in bench.json"))
    assert set(data) == KEYS and data == json.loads(json.dumps(result.data))
    assert data["clock"] in ("gpu", "wall") and data["seconds"] > 0
    assert set(data["clocks"]) == {"wall_ms", "gpu_ms", "note"} and data["clocks"]["wall_ms"] > 0
    cases = {(row["latency_ms"], row["warp"], row["fill"]) for row in data["rows"]}
    assert len(data["rows"]) == len(cases) == 2 * 3 * 2
    assert len(repr(result)) < 200 and len(repr(read(out))) < 200
    assert all(shown._repr_html_().count("<tr") > len(cases) for shown in (result, read(out)))
    total = 2 * 2  # two latencies, two instants
    assert steps == [(done, total) for done in range(total + 1)]


def test_rows_are_summaries_and_more_and_the_table_says_the_same(full):
    out, result, _ = full
    with (out / "bench.csv").open(encoding="utf-8", newline="") as file:
        table = list(csv.DictReader(file))
    assert list(table[0]) == NAMES
    for written, row in zip(table, result.data["rows"], strict=True):
        validate_summary(row)
        assert row["frames"] == 2 and row["measured"]["flip"] == 2
        assert sum(region["share"] for region in row["regions"].values()) == pytest.approx(1)
        holes = sum(row["regions"][name]["share"] for name in ("border_holes", "inside_holes"))
        assert holes == pytest.approx(row["quality"]["hole_share"]["mean"])
        assert all(row["time_ms"]["warp"][figure] > 0 for figure in ("median", "p95"))
        assert (written["warp"], written["fill"]) == (row["warp"], row["fill"])
        for name in QUALITY:
            assert float(written[name]) == row["quality"][name]["mean"]
            assert float(written[f"{name}_p95"]) == row["quality"][name]["p95"]
        for stage in STAGES:
            assert float(written[f"{stage}_ms"]) == row["time_ms"][stage]["median"]
        assert float(written["silhouettes_flip"]) == row["regions"]["silhouettes"]["flip"]


@WITHOUT_PAGE
def test_only_times_change(full, tmp_path, monkeypatch):
    """Measured in other threads, and in batches so small that each warp runs alone."""
    monkeypatch.setattr("hmdwarp.run.measuring.GPU_BATCH_BYTES", 1)
    monkeypatch.setattr("hmdwarp.run.measuring.MEMORY_PART", 0.0)
    again = bench(attrs.evolve(SMALL, out=tmp_path, workers=2))
    assert untimed(again.data["rows"]) == untimed(full[1].data["rows"])


@WITHOUT_PAGE
def test_a_case_is_identified_by_content(tmp_path):
    """The content of a trace counts, not its place; who runs it and where it goes do not."""
    first, moved = tmp_path / "first.csv", tmp_path / "there" / "first.csv"
    first.write_bytes((folder("recordings") / "look-around.csv").read_bytes())
    options = attrs.evolve(TINY, recordings=(str(first),), latencies_ms=(50.0,), out=tmp_path / "out")
    assert bench(options).swept.known == 0
    moved.parent.mkdir()
    first.rename(moved)
    resumes = {"command": "hmdwarp bench", "workers": 1, "sweep": KeptOptions(resume=True)}
    same = attrs.evolve(options, recordings=(str(moved),), **resumes)
    assert bench(same).swept.known == 1
    moved.write_bytes(moved.read_bytes() + b"\n")
    assert bench(same).swept.known == 0
    assert bench(attrs.evolve(same, instants=2)).swept.known == 0


def test_baselines_are_named_and_another_librarys_warp_is_a_row(tmp_path):
    """Without latency every one of them shows the picture itself, to what bytes can tell."""
    pytest.importorskip("cv2")
    options = attrs.evolve(
        SMALL, warps=("forward", "rotation:edge=clamp", "mesh:grid=64", "cv2.warpFrame"), latencies_ms=(0.0, 100.0),
        out=tmp_path,
    )  # fmt: skip
    data = bench(options).data
    still, late = ([row for row in data["rows"] if row["latency_ms"] == latency] for latency in (0.0, 100.0))
    systems = {"rotation:edge=clamp": "most streamers", "mesh:grid=64": "CloudXR.js", "cv2.warpFrame": "OpenCV"}
    assert {row["warp"]: row["baseline"] for row in still} == {"forward": "", **systems}
    assert all(row["quality"]["psnr_db"]["mean"] > 48 for row in still)
    (outside,) = (row for row in late if row["warp"] == "cv2.warpFrame")
    assert outside["fill"] == "none" and outside["time_ms"]["warp"]["median"] > 0
    assert outside["lacks"]
    # It moves each pixel to the nearest by its depth, as forward does: only bytes tell them apart.
    forward = next(row for row in late if (row["warp"], row["fill"]) == ("forward", "none"))
    assert outside["quality"]["psnr_db"]["mean"] == pytest.approx(forward["quality"]["psnr_db"]["mean"], abs=0.2)
    page = (tmp_path / "bench.html").read_text(encoding="utf-8")
    assert "CloudXR.js" in page and "OpenCV" in page


@WITHOUT_PAGE
def test_memory_has_seen_the_seconds_before_an_instant(tmp_path):
    """A head that looks around sees again what it saw: memory knows it after the run-in alone."""
    options = attrs.evolve(
        SMALL, warps=("rotation",), fills=("pyramid", "memory+pyramid"), latencies_ms=(400.0,), seconds=None,
        start_s=6.0, guard=1.0, instants=2, rounds=1, out=tmp_path,
    )  # fmt: skip
    alone, after_memory = bench(options).data["rows"]
    assert after_memory["quality"]["flip"]["mean"] < alone["quality"]["flip"]["mean"]


def test_crops_are_of_the_best_of_each_warp_where_it_is_worst_and_where_typical(full):
    """Two instants: the worse of them, and of both the lower one is the median."""
    out, result, _ = full
    for path, latency in zip(sorted((out / "cases").glob("*-crops.npz")), (100.0, 200.0), strict=True):
        worst, typical = unpacked(path.read_bytes())
        assert (worst.which, typical.which) == ("worst", "typical")
        rows = [row for row in result.data["rows"] if row["latency_ms"] in (100.0, 200.0)]
        best = min(rows, key=lambda row: (abs(max(row["at_instants"]["flip"].values()) - worst.flips[0]), latency))
        assert worst.flips[0] == pytest.approx(max(best["at_instants"]["flip"].values()), abs=1e-6)
        assert typical.flips[0] == pytest.approx(min(best["at_instants"]["flip"].values()), abs=1e-6)
        assert sorted(name.split(" + ")[0] for name in worst.names) == sorted(SMALL.warps)
        left, top, side = (round(96 * share) for share in worst.place)  # the truth is small as it is
        assert np.array_equal(worst.truth[top : top + side, left : left + side], worst.shown[0])
        assert worst.shown.shape[0] == 1 + len(SMALL.warps) and worst.shown.shape[1:] == worst.errors.shape[1:] + (3,)
    assert result.report.read_text(encoding="utf-8").count("worst instant") >= 2


@WITHOUT_PAGE
def test_servers_of_other_rates_are_cases_of_their_own_with_the_errors_of_their_replays(tmp_path):
    one = {"warps": ("none",), "fills": ("none",), "latencies_ms": (100.0,)}
    options = attrs.evolve(SMALL, **one, server_rates_hz=(10.0, 25.0, 60.0), out=tmp_path / "bench")
    rows = bench(options).data["rows"]
    assert [row["server_rate_hz"] for row in rows] == [10.0, 25.0, 60.0]
    errors = [row["quality"]["flip"]["mean"] for row in rows]
    assert errors[0] > errors[2], "a frame that stays for 100 ms is older than one that stays for 17"
    same = {name: getattr(SMALL, name) for name in ("predict", "headset", "guard", "samples")}
    network = LinkOptions(server_rate_hz=25.0)
    how = {"warp": "none", "latency_ms": 100.0, "network": network, "metrics_every": 1, **same}
    replayed = run(tmp_path / "replay", **how).rows
    at = rows[1]["at_instants"]
    for number in at["flip"]:
        eyes = [[row["flip"], row["flicker"]] for row in replayed if row["frame"] == int(number)]
        assert [at["flip"][number], at["flicker"][number]] in [pytest.approx(eye, abs=1e-6) for eye in eyes]
