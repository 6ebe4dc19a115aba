"""A bench of recorded frames: what runs, what is left out, what is refused."""

from __future__ import annotations

import pytest
from recorded_folders import taken, write_npz

from hmdwarp.base import InputError, PlanError
from hmdwarp.experiments.bench import BenchOptions, bench
from hmdwarp.experiments.bench.cases import combinations_of
from hmdwarp.image import usable_warps
from hmdwarp.pipeline.recorded_source import RecordingSource
from hmdwarp.sources import sequences


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("bench") / "slide"
    path.mkdir()
    write_npz(path, taken(8))
    return path


def options(folder, out, **said) -> BenchOptions:
    usual = {"latency": ["100"], "fill": ["none"], "instants": 1, "rounds": 1, "workers": 0}
    return BenchOptions.of({**usual, "frames": folder, "out": out / "out", **said})


def test_all_warps_that_colour_and_depth_are_enough_for(folder, tmp_path):
    chosen = combinations_of(options(folder, tmp_path), RecordingSource(sequences.open(folder)).scene)
    warps = {combination.warp.partition(":")[0] for combination in chosen}
    assert set(usable_warps()) <= warps
    assert not warps & {"backward", "layered", "environment", "points", "model"}
    assert not any(combination.plan.needs.others.other_eye for combination in chosen)


def test_a_bench_measures_one_eye_at_recorded_instants(folder, tmp_path):
    rows = bench(options(folder, tmp_path, warp=["iterative", "rotation"])).data["rows"]
    assert [row["warp"] for row in rows] == ["iterative", "rotation"]
    assert {(row["scene"], row["trace"], tuple(row["size"])) for row in rows} == {("slide", "slide", (36, 24))}
    assert all(row["quality"]["psnr_db"]["mean"] > 10 for row in rows)


def test_a_guard_band_is_cut_off_what_is_shown(folder, tmp_path):
    (row,) = bench(options(folder, tmp_path, warp=["iterative"], guard="1.5")).data["rows"]
    assert tuple(row["size"]) == (24, 16) and row["guard"] == 1.5


def test_warps_and_options_beyond_a_recording_are_refused(folder, tmp_path):
    with pytest.raises(PlanError, match="layer 'peeled'"):
        bench(options(folder, tmp_path, warp=["layered"]))
    said_of = {"--scene": {"scene": ["room"]}, "TRACE": {"traces": ["walk"]}}
    for flag, said in {**said_of, "--strategy": {"strategy": ["points"]}}.items():
        with pytest.raises(InputError, match=f"^{flag} with --frames"):
            options(folder, tmp_path, **said)
