"""A picture that is as old as the parts of its way say, in a replay and live."""

from __future__ import annotations

import json

import numpy as np
import pytest
from replays import rows_of, run

from hmdwarp.link import LinkOptions
from hmdwarp.link.codec import Coding
from hmdwarp.run import LiveOptions, live

GIVEN = "sum:render=8,encode=5,decode=4"
PERIOD_MS = 1000 / 60


def network(response: str = GIVEN, **more: object) -> LinkOptions:
    return LinkOptions.of({"response": response, **more})


def ages_ms(folder) -> list[float]:
    return [float(row["age_ms"]) for row in rows_of(folder) if row["eye"] == "0"]


@pytest.mark.parametrize("codec", ["none", "h264"])
def test_a_picture_is_as_old_as_its_parts_and_the_next_refresh(tmp_path, codec):
    """40 ms of network and 17 of work: 57, so at the fourth refresh, 66.7 ms old."""
    told = run(tmp_path, latency_ms=40.0, network=network(), coding=Coding(codec)).summary
    assert ages_ms(tmp_path) == pytest.approx([4 * PERIOD_MS] * 30, abs=2e-6)
    parts = told["link"]["response_ms"]
    given = {"render_ms": 8, "encode_ms": 5, "queue_ms": 0, "transfer_ms": 0, "round_trip_ms": 40, "decode_ms": 4}
    assert {name: parts[name] for name in given} == pytest.approx(given)
    assert told["link"]["stages_ms"] == {"render": 8.0, "encode": 5.0, "decode": 4.0}
    assert any("the network's alone" in note for note in told["notes"])


def test_a_live_run_is_as_old(tmp_path):
    """The display without a screen has 60 refreshes a second, as this replay."""
    live(
        LiveOptions(
            scene="planes", source="offscreen", trace="look-around", headset="flat-90", size=(96, 80), pictures=40,
            latency_ms=40.0, network=network(server_rate=30.0), fill="none", lens="none", rate_hz=60.0,
            out=tmp_path / "live",
        )
    )  # fmt: skip
    run(tmp_path / "replay", latency_ms=40.0, network=network(server_rate=30.0))
    ages = {round(age / PERIOD_MS, 2) for age in ages_ms(tmp_path / "live")}
    assert len(ages) == 2, "each frame stays for two refreshes"
    assert np.ptp(list(ages)) == pytest.approx(1.0, abs=0.01)
    told = json.loads((tmp_path / "live" / "summary.json").read_text(encoding="utf-8"))["link"]
    assert told["frames"]["shown"] == 20 and told["response_ms"]["encode_ms"] == pytest.approx(5.0)
    assert min(ages_ms(tmp_path / "live")) >= 57 and len(told["timeline"]) == 12


@pytest.mark.parametrize(
    ("stages", "refreshes"),
    [*((f"{stage}=40", 3) for stage in ("render", "encode", "decode")), ("render=15,encode=15,decode=15", 1)],
)
def test_the_slowest_stage_sets_the_pace(tmp_path, stages, refreshes):
    """40 ms of work: a frame at every third refresh of 60 Hz, whichever stage it is. They work on
    different frames at once: with 15 ms each one comes at every refresh all the same."""
    frames = run(tmp_path, latency_ms=20.0, network=network(f"sum:{stages}")).summary["link"]["frames"]
    drawn = np.diff(sorted({int(row["drawn_ns"]) for row in rows_of(tmp_path)})) * 1e-6
    assert drawn == pytest.approx([refreshes * PERIOD_MS] * len(drawn), abs=2e-6)
    assert frames["skipped"] == pytest.approx((refreshes - 1) * frames["drawn"], abs=2)
    assert min(ages_ms(tmp_path)) == pytest.approx(4 * PERIOD_MS, abs=2e-6)


@pytest.mark.parametrize("measured", [False, True], ids=["given", "measured"])
def test_the_time_line_adds_up(tmp_path, measured):
    how = {"network": network("sum"), "coding": Coding("h264"), "latency_ms": 0.0, "seconds": 1.0}
    given = {"network": network(bandwidth="60", jitter="uniform:5"), "latency_ms": 30.0}
    link = run(tmp_path, page=True, **(how if measured else given)).summary["link"]
    assert len(link["timeline"]) == 12
    assert min(link["response_ms"][f"{stage}_ms"] for stage in ("render", "encode", "decode")) > 0
    for frame in link["timeline"]:
        arrived = frame["drawn"] + sum(frame["parts"].values())
        assert frame["parts"]["render"] > 0 and frame["parts"]["decode"] > 0
        assert arrived <= frame["shown"] + 1e-6 and frame["until"] >= frame["shown"]
        assert measured or frame["shown"] < arrived + PERIOD_MS + 1e-3
    page = (tmp_path / "report.html").read_text(encoding="utf-8").replace("<wbr>", "")
    for label in ("part by part", "size / bandwidth", "round trip", "wait for the refresh", "on the screen"):
        assert measured or label in page
