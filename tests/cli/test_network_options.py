"""What is said about network, codec, effects and fills.

Refused in one line where it cannot be meant, and nothing written then.
"""

from __future__ import annotations

import json

SMALL = (
    "replay", "look-around", "--scene", "planes", "--headset", "flat-90", "--size", "64x48",
    "--rate", "30", "--seconds", "0.3",
)  # fmt: skip
QUICK = (*SMALL, "--metrics-every", "9", "--images", "0", "--against", "", "--quiet", "--workers", "0")


def test_a_delay_trace_that_cannot_be_meant_names_file_and_line(command, tmp_path):
    path = tmp_path / "delays.csv"
    path.write_text("12\nx\n", encoding="utf-8")
    command(*QUICK, "--out", tmp_path / "out", "--delay-trace", path).refused("delays.csv", "line 2", "'x'")


def test_a_delay_trace_is_followed(command, tmp_path):
    """Delays of 40 ms: at 30 Hz a frame is seen two refreshes after it was drawn."""
    path = tmp_path / "delays.csv"
    path.write_text("# recorded on a table\ndelay_ms\n40\n40\n", encoding="utf-8")
    command(*QUICK, "--out", tmp_path / "out", "--delay-trace", path).done()
    rows = (tmp_path / "out" / "frames.csv").read_text(encoding="utf-8").splitlines()
    column = rows[0].split(",").index("age_ms")
    assert {round(float(row.split(",")[column]), 1) for row in rows[1:]} == {66.7}


def test_effects_of_the_link_are_printed_where_there_are_any(command, tmp_path):
    options = ("--codec", "h264", "--loss", "0.2", "--link-seed", "2", "--latency", "50")
    told = [part for part in QUICK if part != "--quiet"]
    out = command(*told, "--seconds", "1", "--out", tmp_path / "out", *options).done().out
    assert "lost on the network" in out and "Mbit/s" in out and "latency plus this machine's stages" in out
    link = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))["link"]
    assert link["frames"]["lost"] > 0 and link["codec"] == "h264"
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8").replace("<wbr>", "")
    assert "Frames in transit" in page and "Response time" in page
