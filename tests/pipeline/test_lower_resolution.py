"""Frames of lower resolution through the whole loop: every warp takes them, codecs too."""

from __future__ import annotations

import json

import pytest
from replays import contents, each_refresh, run, small, suited

from hmdwarp.errors import InputError
from hmdwarp.link import LinkOptions
from hmdwarp.link.codec import Coding
from hmdwarp.run import LiveOptions, live

NARROW = {"bandwidth": "40", "queue": 60.0}  # Planes at 96x80: frames of 184,320 bytes, at 60 Hz 88 Mbit/s
SLOW = {"response": "sum:render=50"}  # Three periods of 60 Hz: a quarter of the pixels fits, nothing more


def network(overload: str, narrow: dict[str, str], **more: object) -> LinkOptions:
    return LinkOptions.of({"overload": overload, **narrow, **more})


def test_the_resolution_is_lowered_where_frames_were_dropped(tmp_path):
    dropping, lowering = (
        run(tmp_path / name, latency_ms=30.0, network=network(name, NARROW), seconds=1.0).summary["link"]
        for name in ("drop", "resolution")
    )
    assert dropping["frames"]["dropped"] > 10 and "resolution" not in dropping
    assert lowering["frames"]["dropped"] == 0
    told = lowering["resolution"]
    assert sum(told["frames"].values()) == lowering["frames"]["drawn"]
    assert told["frames"]["1"] < 10, "0.42 of the pixels are 37 Mbit/s"
    assert lowering["response_ms"]["queue_ms"] < dropping["response_ms"]["queue_ms"]


def test_without_a_limit_there_is_nothing_to_lower_for(tmp_path):
    with pytest.raises(InputError, match="nothing can be overloaded; give --bandwidth or --response sum"):
        run(tmp_path, network=network("resolution", {}), seconds=0.1)


def test_given_times_are_in_proportion_to_the_pixels(tmp_path):
    slow = {"response": f"{SLOW['response']},decode=20"}
    link = run(tmp_path, latency_ms=30.0, network=network("resolution", slow), seconds=1.0).summary["link"]
    assert link["frames"]["skipped"] <= 6
    parts = link["timeline"][-1]["parts"]
    assert (parts["render"], parts["decode"]) == pytest.approx((50 * 0.5**2, 20 * 0.5**2))


@pytest.mark.parametrize("name", sorted(suited()))
def test_every_warp_takes_frames_of_any_size(tmp_path, name):
    late, whole = both(tmp_path, warp=name, fill="pyramid", guard=1.2)
    assert late["psnr_db"] > min(whole["psnr_db"] - 3, 20), "coarser, and not torn"
    # Points that are scattered one by one cannot cover a picture of more pixels; all others close.
    if not name.startswith("forward"):
        assert late["hole_share"] < whole["hole_share"] + 0.05


@pytest.mark.parametrize("scene", ["cockpit", "greenhouse", "gallery", "workshop", "parade"])
def test_the_layers_of_effects_are_of_the_same_resolution(tmp_path, scene):
    late, whole = both(tmp_path, scene=scene, warp="iterative", fill="pyramid", trace="walk")
    assert late["psnr_db"] > 24, "coarser, and not torn"


def both(folder, **options) -> tuple[dict, dict]:
    """The figures of frames of a quarter of the pixels, and of whole ones."""
    options |= {"latency_ms": 30.0, "metrics_every": 15, "seconds": 0.5}
    late = run(folder / "late", network=network("resolution", SLOW), **options).summary
    whole = run(folder / "whole", **options).summary
    assert late["link"]["resolution"]["frames"]["0.5"] > 10
    return tuple(
        {name: summary["quality"][name]["mean"] for name in ("psnr_db", "hole_share")} for summary in (late, whole)
    )


def test_a_codec_goes_on_at_each_size_after_losses_too(tmp_path):
    link = network("resolution", {"response": "sum:encode=50"}, loss="0.08", loss_burst=1.7, link_seed=2)
    options = {"coding": Coding("h264", 12), "latency_ms": 30.0, "seconds": 1.5, "images": 2}
    told = [run(tmp_path / name, network=link, **options).summary["link"] for name in "ab"]
    assert told[0]["resolution"]["changes"] >= 3 and told[0]["frames"]["lost"] > 0
    assert told[0]["frames"]["shown"] > 20 and told[0]["coded_psnr_db"] > 25
    assert told[0]["frames"] == told[1]["frames"]
    pictures = [
        {name: data for name, data in contents(tmp_path / folder).items() if name.endswith(".png")} for folder in "ab"
    ]
    assert pictures[0] == pictures[1] and pictures[0]


def test_every_texture_comes_back_to_the_server():
    seen = set()

    def look(setup, number, refresh):
        seen.add(refresh.frame.eyes[0].size)
        out = sum(pool.live for pool in setup.server._pools.values())
        assert out <= 2 * (len(setup.channel.link) + 1)

    each_refresh(small(latency_ms=30.0, network=network("resolution", NARROW)), look)
    assert len(seen) > 1


def test_a_live_run_lowers_it_too(tmp_path):
    live(
        LiveOptions(
            scene="planes", source="offscreen", trace="look-around", headset="flat-90", size=(96, 80), pictures=40,
            latency_ms=30.0, network=network("resolution", NARROW), fill="none", lens="none", rate_hz=60.0,
            guard=1.0, out=tmp_path / "live",
        )
    )  # fmt: skip
    link = json.loads((tmp_path / "live" / "summary.json").read_text(encoding="utf-8"))["link"]
    assert link["resolution"]["frames"]["1"] < 15 and link["frames"]["dropped"] == 0
    page = (tmp_path / "live" / "report.html").read_text(encoding="utf-8").replace("<wbr>", "")
    assert "50% of the width and height" in page and "changes of resolution" in page
