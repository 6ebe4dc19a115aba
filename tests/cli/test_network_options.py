"""What is said about network, codec, effects and fills.

Refused in one line where it cannot be meant, and nothing written then.
"""

from __future__ import annotations

import json

import pytest

SMALL = (
    "replay", "look-around", "--scene", "planes", "--headset", "flat-90", "--size", "64x48",
    "--rate", "30", "--seconds", "0.3",
)  # fmt: skip
QUICK = (*SMALL, "--metrics-every", "9", "--images", "0", "--against", "", "--quiet", "--workers", "0")


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--jitter", "unifrm:3"), "did you mean 'uniform'?"),
        (("--jitter", "uniform:300"), "before they were sent"), (("--loss", "p=0.1,r=0.5"), "--loss-burst"),
        (("--loss-burst", "2"), "without --loss"), (("--bandwidth", "abc"), "expected Mbit/s"),
        (("--delay-trace", "nowhere.csv"), "nowhere.csv: no such file"), (("--link-seed", "-1"), "seed -1"),
        (("--codec", "h265"), "unknown codec 'h265': did you mean"),
        (("--codec", "h264", "--crf", "99"), "expected 0 (best) to 51"),
        (("--codec", "h264", "--crf", "20", "--bitrate", "3"), "not both"), (("--crf", "20"), "without a codec"),
        (("--bitrate", "5"), "without a codec"), (("--depth-code", "exact"), "without a codec"),
        (("--codec", "h264", "--depth-code", "lossy"), "expected exact, sixteenth, video or video8"),
        (("--effects", "overlai"), "did you mean 'overlay'?"),
        (("--effects", "overlay,no-overlay"), "both forced and forbidden"),
        (("--mirrors", "scren"), "did you mean 'screen'?"), (("--fill", "none+interpolate"), "means nothing"),
        (("--fill", "interpolate+interpolate"), "the same fill twice"),
        (("--fill", "interpolate+"), "unknown fill ''"),
    ],
)  # fmt: skip
def test_impossible_values_are_refused_in_one_line(command, tmp_path, options, told):
    command(*QUICK, "--out", tmp_path / "out", *options).refused(told)
    assert not (tmp_path / "out").exists()


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
