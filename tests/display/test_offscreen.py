"""The display nobody looks at, by the command.

The same every time, its own time, and words for what it needs.
"""

from __future__ import annotations

import csv
import json

import pytest

from hmdwarp.base import InputError, TraceError
from hmdwarp.run import LiveOptions, live

ASKED = {
    "source": "offscreen",
    "scene": "planes",
    "headset": "rift-dk1",
    "size": (48, 60),
    "rate_hz": 50.0,
    "latency_ms": 60.0,
}


def test_two_runs_are_equal_and_as_long_as_asked_for_by_the_display_s_own_clock(tmp_path):
    heads = []
    for name in ("a", "b"):
        result = live(
            LiveOptions(**ASKED, trace="walk", seconds=0.5, record=tmp_path / f"{name}.csv", out=tmp_path / name)
        )
        heads.append((tmp_path / f"{name}.csv").read_text(encoding="utf-8").split("time_ns,")[1])
        # 25 refreshes of 20 ms from the first picture, which the 26th then ends.
        assert result.summary["frames"] == 26
        rows = list(csv.DictReader((tmp_path / name / "frames.csv").read_text(encoding="utf-8").splitlines()))
        # Asked for at a tick and seen two refreshes later, 60 ms under way: no refresh falls
        # between 60 and 80 ms.
        assert {round(float(row["age_ms"]), 3) for row in rows} <= {60.0, 80.0, 100.0}
        summary = json.loads((tmp_path / name / "summary.json").read_text(encoding="utf-8"))
        assert summary["live"]["source"] == "offscreen"
        assert summary["trace"] == name
    assert heads[0] == heads[1]


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"source": "offscreen"}, InputError, "--trace"),
        ({"source": "auto", "trace": "walk"}, InputError, "head of its own"),
        ({"source": "openxr", "trace": "walk"}, InputError, "head of its own"),
        ({**ASKED, "trace": "missing.csv"}, TraceError, "missing.csv"),  # before anything is opened
    ],
)
def test_whose_head_it_follows_must_be_clear(options, error, words):
    with pytest.raises(error, match=words):
        live(LiveOptions(**options))
