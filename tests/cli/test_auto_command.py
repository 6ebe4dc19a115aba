"""Warp auto on the command line: what it needs, what `choose` prints, the replay that follows."""

from __future__ import annotations

import json
import shlex

from bench_files import a_bench

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
