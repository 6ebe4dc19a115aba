"""Frames of lower resolution through the whole loop: every warp takes them, codecs too."""

from __future__ import annotations

import pytest
from replays import contents, each_refresh, run, small, suited

from hmdwarp.errors import InputError
from hmdwarp.link import LinkOptions
from hmdwarp.link.codec import Coding

NARROW = {"bandwidth": "40", "queue": 60.0}  # Planes at 96x80: frames of 184,320 bytes, at 60 Hz 88 Mbit/s
HAVE_EFFECTS = ("cockpit", "greenhouse", "gallery", "workshop", "parade")
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


EFFECTS = {scene: {"scene": scene, "warp": "iterative", "trace": "walk"} for scene in HAVE_EFFECTS}


@pytest.mark.parametrize("which", [*sorted(suited()), *EFFECTS])
def test_every_warp_takes_frames_of_any_size_and_so_do_layers_of_effects(tmp_path, which):
    """Frames of a quarter of the pixels are coarser than whole ones, and not torn."""
    options = EFFECTS.get(which, {"warp": which, "guard": 1.2})
    options |= {"fill": "pyramid", "latency_ms": 30.0, "metrics_every": 15, "seconds": 0.5}
    late = run(tmp_path / "late", network=network("resolution", SLOW), **options).summary
    assert late["link"]["resolution"]["frames"]["0.5"] > 10
    found = late["quality"]
    if which in EFFECTS:
        assert found["psnr_db"]["mean"] > 24
        return
    whole = run(tmp_path / "whole", **options).summary["quality"]
    assert found["psnr_db"]["mean"] > min(whole["psnr_db"]["mean"] - 3, 20)
    # Points that are scattered one by one cannot cover a picture of more pixels; all others close.
    if not which.startswith("forward"):
        assert found["hole_share"]["mean"] < whole["hole_share"]["mean"] + 0.05
