"""A picture that is as old as the parts of its way say, in a replay and live."""

from __future__ import annotations

import json

import numpy as np
import pytest
from replays import rows_of, run, small

from hmdwarp.errors import InputError
from hmdwarp.link import LinkOptions, ResponseTime, StageTimes, TransitStats, response_figures
from hmdwarp.link.codec import Coding
from hmdwarp.run import LiveOptions, live

GIVEN = "sum:render=8,encode=5,decode=4"
PERIOD_MS = 1000 / 60


def network(response: str = GIVEN, **more: object) -> LinkOptions:
    return LinkOptions.of({"response": response, **more})


def ages_ms(folder) -> list[float]:
    return [float(row["age_ms"]) for row in rows_of(folder) if row["eye"] == "0"]


def test_the_response_time_is_the_whole_way_of_a_frame():
    """Work at both ends is measured; the rest of the way is the link's, each part once."""
    way = dict.fromkeys(("queue_ns", "transfer_ns", "delay_ns", "hold_ns"), 0)
    for name in way:
        transit = TransitStats(3, 0, **way | {name: 7_000_000})
        time = ResponseTime.of(transit, render_ms=1.0, encode_ms=2.0, decode_ms=3.0, warp_ms=4.0)
        assert time.total_ms == transit.ready_ns / 1e6 + 10.0 == 17.0


def test_figures_of_response_times_are_means_of_the_parts_and_ends_of_the_sums():
    times = [ResponseTime(render_ms=1.0, warp_ms=float(number)) for number in range(101)]
    found = response_figures(times)
    assert {name: found[f"{name}_ms"] for name in ("render", "warp", "total", "median", "p95")} == pytest.approx(
        {"render": 1.0, "warp": 50.0, "total": 51.0, "median": 51.0, "p95": 96.0}
    )
    assert response_figures([]) is None


def test_the_texts_of_the_option():
    assert network("fixed").response is None and network("").response is None
    assert network("sum").response == StageTimes(None, None, None)
    assert network(GIVEN).response == StageTimes(8.0, 5.0, 4.0)
    assert network(" sum : decode = measured , render=8").response == StageTimes(8.0, 0.0, None)
    assert not network("sum").is_plain
    assert network(GIVEN).longest_ns(7) == network(GIVEN).typical_ns(7) == 17_000_007


@pytest.mark.parametrize(
    "text", ["summ", "sum:", "fixed:3", "sum:render", "sum:render=x", "sum:warp=3", "sum:render=1,render=2"]
)
def test_other_texts_are_refused_with_what_is_expected(text):
    with pytest.raises(InputError, match="expected fixed, sum, or sum:render=8"):
        network(text)


@pytest.mark.parametrize("value", ["-1", "nan", "1e9"])
def test_times_that_cannot_be_are_refused(value):
    with pytest.raises(InputError, match="render=.*: expected 0 to 60000 ms"):
        network(f"sum:render={value}")


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


def test_given_times_are_the_same_twice_over_any_network(tmp_path):
    options = {
        "network": network(jitter="uniform:20", bandwidth="60", link_seed=3, server_rate=25.0),
        "latency_ms": 30.0,
    }
    told = [run(tmp_path / name, **options).summary["link"] for name in "ab"]
    for summary in told:
        for name in ("warp_ms", "total_ms", "median_ms", "p95_ms"):
            del summary["response_ms"][name]
    assert told[0] == told[1]
    assert told[0]["response_ms"]["transfer_ms"] > 0
    assert ages_ms(tmp_path / "a") == ages_ms(tmp_path / "b")


@pytest.mark.parametrize("stage", ["render", "encode", "decode"])
def test_the_slowest_stage_sets_the_pace(tmp_path, stage):
    """40 ms of work: a frame at every third refresh of 60 Hz, whichever stage it is."""
    frames = run(tmp_path, latency_ms=20.0, network=network(f"sum:{stage}=40")).summary["link"]["frames"]
    drawn = np.diff(sorted({int(row["drawn_ns"]) for row in rows_of(tmp_path)})) * 1e-6
    assert drawn == pytest.approx([3 * PERIOD_MS] * len(drawn), abs=2e-6)
    assert frames["skipped"] == pytest.approx(2 * frames["drawn"], abs=2)
    assert min(ages_ms(tmp_path)) == pytest.approx(4 * PERIOD_MS, abs=2e-6)


def test_stages_work_on_different_frames_at_once(tmp_path):
    """15 ms each, 45 of work for a frame: one comes at every refresh of 16.7 ms all the same."""
    frames = run(tmp_path, latency_ms=20.0, network=network("sum:render=15,encode=15,decode=15")).summary["link"]
    assert frames["frames"]["skipped"] == 0 and frames["frames"]["shown"] == 30


def test_the_time_line_adds_up(tmp_path):
    options = {"network": network(bandwidth="60", jitter="uniform:5"), "latency_ms": 30.0}
    line = run(tmp_path, page=True, **options).summary["link"]["timeline"]
    assert len(line) == 12
    for frame in line:
        arrived = frame["drawn"] + sum(frame["parts"].values())
        assert arrived <= frame["shown"] + 1e-6 < arrived + PERIOD_MS + 1e-3
        assert frame["until"] >= frame["shown"]
    page = (tmp_path / "report.html").read_text(encoding="utf-8").replace("<wbr>", "")
    for label in ("part by part", "size / bandwidth", "round trip", "wait for the refresh", "on the screen"):
        assert label in page


def test_measured_times_make_the_picture_as_old_as_they_were(tmp_path):
    told = run(tmp_path, latency_ms=0.0, network=network("sum"), coding=Coding("h264"), seconds=1.0).summary
    parts = told["link"]["response_ms"]
    assert min(parts[name] for name in ("render_ms", "encode_ms", "decode_ms")) > 0
    for frame in told["link"]["timeline"]:
        assert frame["parts"]["render"] > 0 and frame["parts"]["decode"] > 0
        assert frame["drawn"] + sum(frame["parts"].values()) <= frame["shown"] + 1e-6


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


def test_the_options_of_a_run_take_it():
    assert small(network=network()).notes
    assert not small().notes
