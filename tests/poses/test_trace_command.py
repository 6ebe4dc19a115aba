"""`hmdwarp trace`: what it prints and writes, and what it never does."""

from __future__ import annotations

import json
import os

import pytest
from typer.testing import CliRunner

from hmdwarp.base import HmdwarpError, resources
from hmdwarp.cli.trace import app
from hmdwarp.poses import load_trace

from .traces import WRITERS, head, rows, same_motion, write

TRACK = head(200)


def run(*arguments: object) -> str:
    """Standard output of the command; its error if it raised one."""
    result = CliRunner().invoke(app, [str(a) for a in arguments], catch_exceptions=True, env={"COLUMNS": "140"})
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert result.exit_code == 0, result.output
    return result.stdout


def refused(*arguments: object, status: int = 2) -> str:
    """The one line of a refusal that ends the command line with that status."""
    with pytest.raises(HmdwarpError) as error:
        run(*arguments)
    assert error.value.exit_status == status
    return str(error.value)


def test_info_of_a_shipped_recording():
    text = run("info", "look-around")
    wanted = ["90.00 Hz", "30.000 s", "gaps      none", "29.2", "116.5", "200.3", "no defects found"]
    wanted += ["trace synth look-around", *(f"{latency} ms" for latency in (20, 50, 100, 200, 400, 600, 800))]
    assert [word for word in wanted if word not in text] == []


def test_info_tells_every_defect_and_segment(tmp_path):
    table = rows(TRACK)
    path = write(
        tmp_path / "two.csv",
        [*table[:60], *table[:30], *([repr(float(r[0]) + 2), *r[1:]] for r in table[30:]), ["9", "9"]],
    )
    text = run("info", path)
    loaded = load_trace(path)
    assert {d.kind for d in loaded.defects} == {"last-row-cut", "clock-restart", "unit-guessed", "gap"}
    for defect in loaded.defects:
        assert str(defect) in text
    assert "4 defects found" in text
    assert "2 in the file" in text and "in the file" not in run("info", "look-around")
    assert "1 longer than 100 ms, the longest 2.017 s from 0.483 s" in text
    assert "60.00 Hz" in run("info", path, "--segment", 1)


def test_info_for_programs_has_the_same_figures_and_no_nan(tmp_path):
    data = json.loads(run("info", "look-around", "--json"))
    keys = (
        "trace format origin axes columns clock clock_starts_s samples repeated_share duration_s rate_hz mean_rate_hz"
    )
    keys += " gaps jumps gaze angular_speed_deg_s linear_speed_m_s errors_deg segments assumptions defects"
    assert list(data) == keys.split()
    assert data["samples"] == 2701 and data["rate_hz"] == pytest.approx(90) and data["gaps"] == data["defects"] == []
    assert [f"{data['angular_speed_deg_s'][name]:.1f}" for name in ("p50", "p95", "p99")] == ["29.2", "116.5", "200.3"]
    assert [row["latency_ms"] for row in data["errors_deg"]] == [20, 50, 100, 200, 400, 600, 800]
    table = rows(TRACK)
    two = write(tmp_path / "two.csv", [*table[:60], *table[:30], ["9", "9"]])
    data = json.loads(run("info", two, "--json"))
    assert [segment["taken"] for segment in data["segments"]].count(True) == 1 and len(data["segments"]) == 2
    assert {defect["kind"] for defect in data["defects"]} == {defect.kind for defect in load_trace(two).defects}
    assert "trace too short" in run("info", write(tmp_path / "s.csv", rows(head(10))))
    short = json.loads(run("info", tmp_path / "s.csv", "--json"))
    assert list(short["errors_deg"][-1]) == ["latency_ms", "count", "none", "constant_velocity", "cautious"]
    figures = ("mean", "p50", "p95", "p99")
    assert short["errors_deg"][-1]["none"] == dict.fromkeys(figures)


@pytest.mark.parametrize("to", WRITERS)
def test_convert_writes_a_clean_trace(tmp_path, to):
    table = [[*r[:4], *("-" + f if i % 2 else f for f in r[4:])] for i, r in enumerate(rows(TRACK))]
    table = [[f.removeprefix("--") for f in r] for r in table]
    path = write(tmp_path / "in.csv", table)
    out = tmp_path / "out.txt"
    run("convert", path, out, "--to", to)
    back = load_trace(out)
    assert back.format == to
    assert same_motion(back.track, TRACK)
    assert back.defects == []
    assert sorted(p.name for p in tmp_path.iterdir()) == ["in.csv", "out.txt"]


def test_convert_takes_the_overrides(tmp_path):
    path = write(tmp_path / "in.txt", [r[1:] for r in rows(TRACK, "wxyz")], header="x,y,z,q0,q1,q2,q3")
    out = tmp_path / "out.csv"
    words = "--trace-rate 60 --quat-order wxyz --scale 2 --up 0,1,0 --format named --segment 1"
    run("convert", path, out, *words.split())
    assert same_motion(load_trace(out).track, TRACK.evolve(position_m=2 * TRACK.position_m))
    text = out.read_text()
    assert "--trace-rate" in text.split("time_ns")[0]  # what was done is told in the file too


def test_synth_writes_the_shipped_bytes_and_takes_its_options(tmp_path):
    out = tmp_path / "out.csv"
    run("synth", "walk", "--out", out)
    assert out.read_bytes() == (resources.folder("recordings") / "walk.csv").read_bytes()
    run("synth", "walk", "--out", out, "--seed", 5, "--seconds", 2, "--rate", 50, "--force")
    loaded = load_trace(out)
    assert (len(loaded.track), round(loaded.track.rate_hz)) == (101, 50)
    assert "--seed 5 --seconds 2 --rate 50" in loaded.track.origin
    run("synth", "sideways", "--out", out, "--speed", 1, "--amplitude", 0.4, "--seconds", 2, "--force")
    assert load_trace(out).track.position_m[:, 0].max() == pytest.approx(0.4, abs=1e-3)
    assert "synth sideways --speed 1 --amplitude 0.4 --seconds 2 --rate 90'" in load_trace(out).track.origin


def test_the_input_is_never_overwritten(tmp_path):
    path = write(tmp_path / "in.csv", rows(TRACK))
    before = path.read_bytes()
    link, hard = tmp_path / "link.csv", tmp_path / "hard.csv"
    link.symlink_to(path)
    os.link(path, hard)
    for out in (path, link, hard):
        for force in ((), ("--force",)):
            assert "is the input itself" in refused("convert", path, out, *force)
    assert path.read_bytes() == before
