"""Frames on their way through the loop.

What the client warps is what has arrived, and every frame is accounted for.
"""

from __future__ import annotations

import gc

import attrs
import numpy as np
import pytest
from replays import contents, run, small

from hmdwarp.colour import picture_from_linear
from hmdwarp.errors import InputError, UnknownNameError
from hmdwarp.frames.layers import VIDEO
from hmdwarp.gpu import download
from hmdwarp.link import LinkOptions, ResponseTime
from hmdwarp.link.codec import Coding
from hmdwarp.link.codec.stream import VideoDecoder, VideoEncoder
from hmdwarp.run import set_up_replay

NETWORKS = {
    "plain": {}, "jitter": {"jitter": "uniform:30"}, "normal": {"jitter": "normal:15"},
    "bursts": {"loss": "0.3", "loss_burst": 2.0, "link_seed": 3}, "narrow": {"bandwidth": "3", "queue": 60.0},
    "all": {"jitter": "uniform:40", "loss": "0.1", "bandwidth": "20", "link_seed": 1},
}  # fmt: skip


@pytest.mark.parametrize("codec", ["none", "h264"])
@pytest.mark.parametrize("network", NETWORKS)
def test_every_frame_is_accounted_for(tmp_path, network, codec):
    told = run(
        tmp_path, network=LinkOptions.of(NETWORKS[network]), coding=Coding(codec), latency_ms=60.0, seconds=1.0
    ).summary
    frames = told["link"]["frames"]
    assert frames["drawn"] == frames["dropped"] + frames["sent"]
    assert frames["sent"] == sum(
        frames[name] for name in ("lost", "undecodable", "late", "superseded", "shown", "under_way")
    )
    assert frames["drawn"] >= 60 and frames["shown"] > 0
    assert (frames["lost"] > 0) == (network in ("bursts", "all"))
    assert (told["link"]["response_ms"]["transfer_ms"] > 0) == (network in ("narrow", "all"))
    parts = {name: told["link"]["response_ms"][name] for name in ResponseTime().parts()}
    assert parts["round_trip_ms"] > 0 and parts["render_ms"] > 0 and parts["warp_ms"] > 0
    assert told["link"]["response_ms"]["total_ms"] == pytest.approx(sum(parts.values()))


def test_a_run_that_has_ended_keeps_no_codec(tmp_path):
    """Each holds MBs: a sweep would grow by them until garbage happens to be collected."""
    gc.collect()
    gc.disable()
    try:
        run(tmp_path, coding=Coding("h264"), seconds=0.2)
        left = [value for value in gc.get_objects() if isinstance(value, VideoEncoder | VideoDecoder)]
    finally:
        gc.enable()
    assert left == []


def test_a_codec_costs_bytes_and_quality_and_both_are_told(tmp_path):
    told = {
        name: run(tmp_path / name, coding=Coding(name, crf), latency_ms=50.0, size=(160, 120)).summary
        for name, crf in (("none", None), ("h264", 18))
    }
    layers = {"colour": 2 * 160 * 120 * 8 * 8 * 60 / 1e6, "inverse_depth": 2 * 160 * 120 * 4 * 8 * 60 / 1e6}
    assert told["none"]["link"] | {"frames": 0, "response_ms": 0, "timeline": 0} == {
        "frames": 0,
        "response": "fixed",
        "response_ms": 0,
        "timeline": 0,
        "layers_mbit_s": pytest.approx(layers),
        "mbit_s": pytest.approx(sum(layers.values())),
        "frame_bytes": 2 * 160 * 120 * 12,
        "up_mbit_s": pytest.approx(468 * 8 * 60 / 1e6),  # 180 bytes and 144 for each eye, docs/feed.md
        "codec": "none",
    }
    coded = told["h264"]["link"]
    assert coded["layers_mbit_s"].keys() == layers.keys()
    assert sum(coded["layers_mbit_s"].values()) == pytest.approx(coded["mbit_s"])
    assert coded["mbit_s"] < told["none"]["link"]["mbit_s"] / 5
    assert coded["encode_ms"] > 0 and coded["decode_ms"] > 0 and 25 < coded["coded_psnr_db"] < 60
    assert told["h264"]["quality"]["flip"]["mean"] > told["none"]["quality"]["flip"]["mean"]


READ = {
    "rotation": ({"warp": "rotation"}, {"colour"}),
    "forward": ({"warp": "forward"}, {"colour", "inverse_depth"}),
    "environment": ({"warp": "environment"}, {"cube"}),
    "layered": ({"warp": "layered"}, {"colour", "inverse_depth", "peeled"}),
    "wide": ({"warp": "rotation", "fill": "wide"}, {"colour", "wide"}),
    "mirrors": ({"warp": "iterative", "scene": "gallery"}, {"colour", "inverse_depth", "reflection"}),
    "glass": ({"warp": "iterative", "scene": "greenhouse"}, {"colour", "inverse_depth", "transparent"}),
    "HUD": ({"warp": "iterative", "scene": "cockpit"}, {"colour", "inverse_depth", "overlay"}),
    "bodies": ({"warp": "iterative", "scene": "workshop"}, {"colour", "inverse_depth", "ids"}),
    "soft": ({"warp": "iterative", "scene": "parade"}, {"colour", "inverse_depth", "velocity"}),
}


@pytest.mark.parametrize("kind", READ)
def test_every_layer_is_coded_and_shows_nearly_what_the_server_drew(gpu, kind):
    """The same plan on the frame as it arrived and as it is drawn again.

    A layer whose coverage or holes were off would show elsewhere.
    """
    options, names = READ[kind]
    with set_up_replay(small(coding=Coding("h264"), latency_ms=50.0, **options)) as setup:
        for number, instant_ns in setup.schedule.numbered():
            setup.loop.draw(instant_ns)
            if number >= 0 and (refresh := setup.loop.show(instant_ns)) is not None:
                break
        shown = [download(eye.shown.texture) for eye in refresh.eyes]
        views = [eye.view for eye in refresh.frame.eyes]
        again = setup.server.draw_frame(views, refresh.frame.drawn_ns, setup.sizes.shown, needs=setup.plans[0].needs)
        for inputs, eye, after in zip(refresh.inputs, again.eyes, shown, strict=True):
            before = download(setup.loop.compensator.run(attrs.evolve(inputs, rendered=eye)).shown.texture)
            assert ((before[..., 3] > 0) != (after[..., 3] > 0)).mean() < 0.01
            wrong = picture_from_linear(before).astype(float) - picture_from_linear(after)
            assert wrong.any(), "what has arrived was never coded"
            assert -10 * np.log10(np.mean(wrong**2) / 255**2) > 27
        told = setup.channel.summary(60.0)
        assert told["layers_mbit_s"].keys() == names
        assert sum(told["layers_mbit_s"].values()) == pytest.approx(told["mbit_s"])
        assert told["mbit_s"] * 1e6 / 60 / 8 == pytest.approx(told["frame_bytes"])


def test_after_lost_frames_no_layer_shows_anything_broken():
    """Each of the shown frames looks as the server draws it again, in every layer."""
    network, lowest = LinkOptions.of({"loss": "0.23", "loss_burst": 2.0, "link_seed": 3}), []
    asked = small(warp="layered", fill="wide", coding=Coding("h264"), latency_ms=50.0, network=network)
    with set_up_replay(asked) as setup:
        needs, drawn = setup.requested.needs, set()
        for number, instant_ns in setup.schedule.numbered():
            setup.loop.draw(instant_ns)
            refresh = setup.loop.show(instant_ns) if number >= 0 else None
            if refresh is None or refresh.frame.drawn_ns in drawn:
                continue
            drawn.add(refresh.frame.drawn_ns)
            views = [eye.view for eye in refresh.frame.eyes]
            again = setup.server.draw_frame(views, refresh.frame.drawn_ns, setup.sizes.shown, 1.0, needs)
            for (layer, before), (_, after) in zip(again.contents(), refresh.frame.contents(), strict=True):
                for (old, coding), (new, _) in zip(layer.coded(before), layer.coded(after), strict=True):
                    if coding == VIDEO:
                        wrong = picture_from_linear(download(old)).astype(float) - picture_from_linear(download(new))
                        lowest.append(-10 * np.log10(np.mean(wrong**2) / 255**2))
            setup.server.recycle(again)
        tally = setup.channel.link.tally
    assert tally.lost > 0 and tally.undecodable > 0 and len(drawn) > 5
    assert min(lowest) > 27, "broken chains lie far below"


def test_a_plan_that_is_compared_with_gets_decoded_layers_and_costs_the_client_nothing(tmp_path, gpu):
    alone, compared = (
        run(tmp_path / f"against-{warp}", gpu=gpu, coding=Coding("h264"), warp="environment", against=warp, seconds=0.1)
        for warp in ("", "none")
    )
    assert alone.summary["link"]["layers_mbit_s"] == compared.summary["link"]["layers_mbit_s"]
    assert alone.summary["link"]["layers_mbit_s"].keys() == {"cube"}
    plain = run(tmp_path / "plain", gpu=gpu, warp="environment", against="none", seconds=0.1)
    losses = [result.against[0]["quality"]["psnr_db"]["mean"] for result in (plain, compared)]
    assert losses[0] != losses[1], "the late picture was never coded"


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"network": LinkOptions.of({"loss": "1"})}, InputError, "no frame has arrived in time to be shown .*lost"),
        ({"coding": Coding("h265")}, UnknownNameError, "h264"),
    ],
)
def test_a_run_without_a_frame_to_show_is_refused_in_one_line(tmp_path, options, error, message):
    with pytest.raises(error, match=message):
        run(tmp_path, **options)
    assert contents(tmp_path) == {}
