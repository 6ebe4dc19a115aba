"""The command line of the bench and of warp auto, which chooses by it."""

from __future__ import annotations

import json
import shlex
from itertools import product

from bench_files import a_bench

QUICK = (
    "--scene", "planes", "--headset", "rift-dk1", "--size", "48x40", "--seconds", "0.3", "--instants", "1",
    "--rounds", "1", "--workers", "0", "--guard", "1.1",
)  # fmt: skip


def test_lists_by_repetition_and_by_commas(command, tmp_path):
    several = [
        "--warp", "rotation,forward", "--warp", "none", "--latency", "100", "--latency", "0",
        "--size", "48x40,32x24",
    ]  # fmt: skip
    other = ["--fill", "none", "--out", tmp_path]
    done = command("bench", "walk", *QUICK, *several, *other).done()
    data = json.loads((tmp_path / "bench.json").read_text(encoding="utf-8"))
    found = {(r["latency_ms"], tuple(r["size"]), r["warp"], r["fill"]) for r in data["rows"]}
    assert found == {*product((100.0, 0.0), ((48, 40), (32, 24)), ("rotation", "forward", "none"), ("none",))}
    assert data["command"].startswith("hmdwarp bench walk --scene planes")
    assert "Timed by " in done.out and done.out.rstrip().endswith("bench.html")


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


SMALL = ("--scene", "planes", "--headset", "flat-90", "--size", "96x80", "--seconds", "0.1")


def test_choose_prints_a_command_line_that_runs_and_why(command, tmp_path):
    path = a_bench(tmp_path / "b.json")
    typed = ("walk", *SMALL, "--budget", "5000", "--bench", f"{path}", "--out", f"{tmp_path / 'out'}")
    line, why, following, *_ = command("choose", *typed).done().out.splitlines()
    assert "rotation: 3000.00 of 5000 ms for one eye, mean FLIP 0.2000." in why
    assert following.startswith("The next better is ")
    data = json.loads(command("choose", *typed, "--json").done().out)
    chosen = ("rotation", "none", 3000.0, 0.2)
    assert tuple(data[key] for key in ("warp", "fill", "total_ms", "flip")) == chosen
    assert data["command"] == line and data["levels"][-1]["warp"] == "forward"
    assert f"--guard {data['guard']}" in line and data["guard"] >= 1

    program, *words = shlex.split(line)
    assert program == "hmdwarp"
    told = command(*words).done().out
    made = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert (made["warp"], made["fill"], made["guard"]) == ("rotation", "none", data["guard"])
    assert "auto" not in made and "rotation" in told


def test_a_replay_by_warp_auto_is_the_replay_that_choose_names(command, tmp_path):
    path, out = a_bench(tmp_path / "b.json"), tmp_path / "out"
    typed = ("walk", *SMALL, "--budget", "5000", "--bench", f"{path}", "--out", f"{out}", "--warp", "auto")
    done = command("replay", *typed).done()
    assert "hmdwarp replay walk" in done.out and "--warp rotation --fill none" in done.out
    assert json.loads((out / "summary.json").read_text(encoding="utf-8"))["warp"] == "rotation"
    assert "--warp rotation --fill none" in (out / "report.html").read_text(encoding="utf-8").replace("<wbr>", "")
