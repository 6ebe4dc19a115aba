"""Warp auto on the command line: what it wants beside it, and what plan tells of it."""

from __future__ import annotations

import json

from bench_files import a_bench


def test_warp_auto_needs_a_budget_and_plan_explains_it(command, tmp_path):
    path = a_bench(tmp_path / "b.json")
    command("replay", "walk", "--warp", "auto").refused("--budget MS")
    command("replay", "walk", "--budget", "3").refused("only --warp auto keeps to a budget")
    command("replay", "walk", "--warp", "auto", "--budget", "3", "--fill", "none").refused("chooses the fill too")
    command("plan", "--warp", "auto").refused("--budget MS")
    usual = (
        "plan", "--scene", "planes", "--headset", "flat-90", "--size", "96x80", "--guard", "1",
        "--warp", "auto", "--budget",
    )  # fmt: skip
    told = " ".join(command(*usual, "5000", "--bench", str(path)).done().out.split())
    assert "rotation 3000.00 ms per eye, mean FLIP 0.2000; it would begin here" in told
    data = json.loads(command(*usual, "5000", "--bench", str(path), "--json").done().out)
    assert data["levels"][data["begins_with"]] | {"psnr_db": 0} == {
        **{"warp": "rotation", "fill": "none", "total_ms": 3000.0, "flip": 0.2, "psnr_db": 0}
    }
    elsewhere = (*usual, "5000", "--bench", str(path), "--latency", "300")
    (note,) = json.loads(command(*elsewhere, "--json").done().out)["notes"]
    assert "(this run: 300.0 ms)" in note and f"note: {note}" in " ".join(command(*elsewhere).done().out.split())
    tries = json.loads(command(*usual, "5000", "--json").done().out)["tries"]
    assert {"warp": "forward", "fill": "interpolate"} in tries
    # Frames carry what the best of them reads.
    assert "rendered.colour 0.1 MB, rendered.inverse_depth 0.1 MB" in told
    assert "forward + interpolate" in " ".join(command(*usual, "5000").done().out.split())
