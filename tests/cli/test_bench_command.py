"""The command line of the bench: lists, refusals in one line, and what it ends with."""

from __future__ import annotations

import json

import pytest

from .conftest import complaints

QUICK = (
    "--scene", "planes", "--headset", "rift-dk1", "--size", "48x40", "--seconds", "0.3", "--instants", "1",
    "--rounds", "1", "--workers", "0", "--guard", "1.1",
)  # fmt: skip


@pytest.fixture(autouse=True)
def small_copies(monkeypatch):
    """The copy that both clocks time is of 1 MiB."""
    monkeypatch.setattr("hmdwarp.gpu.timers._CHECK_BYTES", 1 << 20)


def test_lists_by_repetition_and_by_commas(command, tmp_path):
    several = [
        "--warp", "rotation,forward", "--warp", "none", "--latency", "100", "--latency", "0",
        "--size", "48x40,32x24",
    ]  # fmt: skip
    other = ["--trace", "walk", "--fill", "none", "--budget", "10000", "--out", tmp_path]
    done = command("bench", "look-around", *QUICK, *several, *other).done()
    data = json.loads((tmp_path / "bench.json").read_text(encoding="utf-8"))
    found = {(r["trace"], r["latency_ms"], tuple(r["size"]), r["warp"], r["fill"]) for r in data["rows"]}
    wanted = {
        (trace, latency, size, warp, "none")
        for trace in ("look-around", "walk")
        for latency in (100.0, 0.0)
        for size in ((48, 40), (32, 24))
        for warp in ("rotation", "forward", "none")
    }
    assert found == wanted
    assert data["command"].startswith("hmdwarp bench look-around --scene planes")
    assert "Within 10000 ms per eye the most accurate is" in " ".join(done.out.split())
    assert "Timed by " in done.out and done.out.rstrip().endswith("bench.html")


def test_a_budget_nothing_fits_into_is_refused_after_the_results(command, tmp_path):
    done = command(
        "bench", "walk", *QUICK, "--warp", "none", "--latency", "0", "--budget", "0.000001", "--out", tmp_path
    )
    (told,) = complaints(done.err)
    assert done.status == 2 and "nothing is that fast" in told
    assert "bench.html" in done.out and (tmp_path / "bench.json").exists()


def test_recordings_that_no_table_could_tell_apart(command, tmp_path):
    text = "t,x,y,z,qx,qy,qz,qw\n" + "".join(f"{k / 60},0,1.6,0,0,0,0,1\n" for k in range(60))
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "head.csv").write_text(text, encoding="utf-8")
    files = [str(tmp_path / folder / "head.csv") for folder in ("a", "b")]
    command("bench", *files, *QUICK, "--out", tmp_path / "out").refused(*files, "both called 'head'")


def test_a_list_may_be_longer_than_the_name_of_a_file(command, tmp_path):
    latencies = ",".join(str(20 + 4 * k) for k in range(100))
    command("bench", "walk", *QUICK, "--latency", f"{latencies},soon", "--out", tmp_path / "out").refused("'soon'")
