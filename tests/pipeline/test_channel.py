"""Frames on their way through the loop: how each layer is coded, and that all are accounted for."""

from __future__ import annotations

import gc
import json
import math
from itertools import product

import numpy as np
import pytest
from replays import rows_of, run, small

from hmdwarp.base import picture_from_linear, srgb_from_linear
from hmdwarp.frames import Frame, Needs
from hmdwarp.frames.layers import BRIGHT_VIDEO, DEPTH, PACKED, VECTORS, VIDEO, layers
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import download, upload
from hmdwarp.link import LinkOptions
from hmdwarp.link.codec import DEPTH_CODES, DEPTH_VIDEOS, Coding
from hmdwarp.link.codec.stream import VideoDecoder, VideoEncoder
from hmdwarp.pipeline import Coder, Reads
from hmdwarp.run import LiveOptions, live, set_up_replay
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

pytest.importorskip("av")


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
            for (layer, before), (_, after) in zip(
                again.eyes[0].contents(), refresh.frame.eyes[0].contents(), strict=True
            ):
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


SIZE = (128, 96)
VIEWS = [View(Pose((x, 1.6, 1.0)), Fov.symmetric(1.0, 0.8)) for x in (-0.03, 0.03)]
# Everything that a server can draw beside the picture.
EVERYTHING = Needs(**{layer.name: layer.something for layer in layers if layer.drawn_by})
DRAWN = [layer.name for layer in layers if layer.formats]
DEEP = [name for name in DRAWN if DEPTH in layers.get(name).coded_as()]


def reads_of(*names: str) -> Reads:
    needs = Needs(**{name: EVERYTHING[name] for name in names if name in EVERYTHING})
    return Reads(frozenset(layers.get(name).readable() for name in names), needs)


@pytest.fixture
def server(gpu):
    made = Server(gpu, load_scene("planes"))
    yield made
    made.close()


def blocks(rng: np.random.Generator, values: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Flat squares of 32 pixels, (h, w, channels), each of one of the rows of `values`."""
    width, height = size
    chosen = values[rng.integers(0, len(values), (-(-height // 32), -(-width // 32)))]
    return chosen.repeat(32, 0).repeat(32, 1)[:height, :width]


def content(rng: np.random.Generator, coding: str, size: tuple[int, int], like: np.ndarray) -> np.ndarray:
    """What a texture of that coding may hold: at its extremes, with holes and edges."""
    height, width = size[::-1]
    holes = rng.random((height, width)) < 0.2
    if coding in (VIDEO, BRIGHT_VIDEO):
        out = np.ones((height, width, 4), np.float16)
        out[..., :3] = blocks(rng, rng.random((40, 3)) * (8 if coding == BRIGHT_VIDEO else 1), size)
        out[holes] = 0
        return out
    if coding == DEPTH:
        return np.where(holes, -1, rng.choice([0, 0.1, 3, 40], (height, width)) * rng.random((height, width))).astype(
            np.float32
        )
    if coding == VECTORS:
        out = rng.normal(size=(height, width, 4)).astype(np.float16)
        out[..., 3] = ~holes
        out[holes] = 0
        return out
    return rng.integers(0, 65536, like.shape).astype(like.dtype)


def check(coding: str, before: np.ndarray, after: np.ndarray, depth_error: float) -> None:
    assert after.shape == before.shape
    if coding == PACKED:
        assert (after == before).all()
    elif coding == DEPTH:
        assert ((after == -1) == (before == -1)).all() and ((after == 0) == (before == 0)).all()
        assert np.abs(after - before).max() <= depth_error
    elif coding == VECTORS:
        assert (after[..., 3] == before[..., 3]).all() and (after[before[..., 3] == 0] == 0).all()
        # Half a step, and the half float that the texture rounds it to.
        assert (np.abs(after.astype(float) - before) <= 2.0**-11 + np.abs(before) * 2.0**-11).all()
    else:
        assert (after[..., 3] == before[..., 3]).all() and (after[before[..., 3] == 0] == 0).all()
        # 3.2 of 255 levels at crf 1, see tests/link/codec/test_coder.py; where light reaches 8, 191
        # levels are for what is below 1 and 64 for the four stops above.
        most = before[..., :3].max()
        one = 255 if most <= 1 else 191
        middle = np.zeros(before.shape[:2], bool)
        middle[16::32, 16::32] = True
        covered = middle & (before[..., 3] == 1)
        assert covered.sum() > middle.sum() / 3
        old, new = (picture[covered][:, :3].astype(float) for picture in (before, after))
        levels = [one * srgb_from_linear(np.minimum(x, 1)) + 16 * np.log2(np.maximum(x, 1)) for x in (old, new)]
        assert np.abs(levels[0] - levels[1]).max() <= 3.2


@pytest.mark.parametrize(("name", "depth"), [*((name, "exact") for name in DRAWN), *product(DEEP, DEPTH_CODES[1:])])
def test_arrived_layers_are_within_the_bound_of_their_coding(server, name, depth):
    """Everything that passes read is overwritten before it is decoded: nothing slips by. A video
    bounds no pixel of noise; that what is no depth stays so is checked all the same."""
    layer, reads, rng = layers.get(name), reads_of(name), np.random.default_rng(7)
    coder = Coder(Coding("h264", crf=1, depth=depth), 60, 0.2)
    for number in range(3):
        frame = server.draw_frame(VIEWS, number, SIZE, needs=reads.needs)
        parts = [part for _, each, data in reads.contents(frame) for part in each.coded(data)]
        assert len(parts) % len(layer.formats) == 0 and parts
        before = []
        for texture, coding in parts:
            before.append(content(rng, coding, texture.size, download(texture)))
            upload(texture, before[-1])
        coded = coder.encode(frame, reads, wants_key=False)
        errors = frame.eyes[0].depth_error, coded.frame.eyes[0].depth_error  # half a step of the exact code, or more
        assert errors[0] == 0 and errors[1] >= 2.0**-11 and (errors[1] == 2.0**-11) == (depth == "exact")
        assert {key[1] for key in coded.packets} == {name} and len(coded.packets) == len(parts)
        videos = {VIDEO, BRIGHT_VIDEO, *([DEPTH] if depth in DEPTH_VIDEOS else [])}
        assert coded.is_key == (number == 0) or not videos & set(layer.coded_as())
        for texture, _ in parts:
            upload(texture, np.full_like(download(texture), 3))
        assert coder.receive(coded)
        for (texture, coding), drawn in zip(parts, before, strict=True):
            check(
                coding, drawn, download(texture), math.inf if depth in DEPTH_VIDEOS else coded.frame.eyes[0].depth_error
            )
        server.recycle(frame)


def test_a_frame_is_undecodable_until_each_of_its_streams_has_its_key_frame(server):
    reads = reads_of("colour", "cube", "inverse_depth")
    coder = Coder(Coding("h264"), 60, 0.2)
    frames = [server.draw_frame(VIEWS, number, SIZE, needs=reads.needs) for number in range(4)]
    coded = [coder.encode(frame, reads, wants_key=number == 3) for number, frame in enumerate(frames)]
    assert [frame.is_key for frame in coded] == [True, False, False, True]
    assert coder.receive(coded[0])
    assert not coder.receive(coded[2]), "the one before it never came"
    assert coder.receive(coded[3])
    for frame in frames:
        server.recycle(frame)


def test_a_bit_rate_is_that_of_an_eye_however_many_videos_it_has(server):
    """Noise, which costs as much as it is given; the first frame costs more."""
    rng, totals = np.random.default_rng(1), []
    for names in (("colour",), ("colour", "cube"), ("colour", "peeled")):
        reads, coder, sizes = reads_of(*names), Coder(Coding("h264", bitrate_mbit=3.0), 60, 0.2), []
        for number in range(16):
            frame = server.draw_frame(VIEWS[:1], number, SIZE, needs=reads.needs)
            for _, layer, data in reads.contents(frame):
                for texture, coding in layer.coded(data):
                    if coding == VIDEO:
                        upload(texture, rng.random((*texture.size[::-1], 3)).astype(np.float16))
            coded = coder.encode(frame, reads, wants_key=False)
            videos = [len(packet.data) for (_, _, part), packet in coded.packets.items() if part % 2 == 0]
            sizes.append(sum(videos))
            server.recycle(frame)
        totals.append(np.mean(sizes[6:]) * 8 * 60 / 1e6)
    assert totals == pytest.approx([3.0] * 3, rel=0.3)


# --- the sum of a response's parts ---

PERIOD_MS = 1000 / 60


def ages_ms(folder) -> list[float]:
    return [float(row["age_ms"]) for row in rows_of(folder) if row["eye"] == "0"]


@pytest.fixture
def stages(monkeypatch):
    """Let stages take so many ms, whatever they take here."""

    def take(render: float = 0, encode: float = 0, decode: float = 0) -> None:
        coded, received = Coder.encode, Coder.receive

        def encoded(coder, frame, *reads, **how):
            found = coded(coder, frame, *reads, **how)
            frame.timings_ms["encode"] = encode
            return found

        def decoded(coder, frame):
            is_whole = received(coder, frame)
            frame.frame.timings_ms["decode"] = decode
            return is_whole

        monkeypatch.setattr(Frame, "render_ms", render)
        monkeypatch.setattr(Coder, "encode", encoded)
        monkeypatch.setattr(Coder, "receive", decoded)

    return take


SUM = {"network": LinkOptions(response="sum"), "coding": Coding("h264")}


def test_a_picture_is_as_old_as_its_parts_and_the_next_refresh(tmp_path, stages):
    """40 ms of network and 17 of work: 57, so at the fourth refresh, 66.7 ms old."""
    stages(8, 5, 4)
    told = run(tmp_path, latency_ms=40.0, **SUM).summary
    ages = ages_ms(tmp_path)
    assert len(ages) >= 29 and ages == pytest.approx([4 * PERIOD_MS] * len(ages), abs=2e-6)
    parts = told["link"]["response_ms"]
    taken = {"render_ms": 8, "encode_ms": 5, "queue_ms": 0, "transfer_ms": 0, "round_trip_ms": 40, "decode_ms": 4}
    assert {name: parts[name] for name in taken} == pytest.approx(taken)
    assert any("the network's alone" in note for note in told["notes"])


def test_a_live_run_is_as_old(tmp_path, stages):
    """The display without a screen has 60 refreshes a second, as this replay."""
    stages(8, 5, 4)
    network = LinkOptions(response="sum", server_rate_hz=30.0)
    live(
        LiveOptions(
            scene="planes", source="offscreen", trace="look-around", headset="flat-90", size=(96, 80), pictures=40,
            latency_ms=40.0, network=network, coding=Coding("h264"), fill="none", lens="none", rate_hz=60.0,
            out=tmp_path / "live",
        )
    )  # fmt: skip
    run(tmp_path / "replay", latency_ms=40.0, network=network, coding=Coding("h264"))
    ages = {round(age / PERIOD_MS, 2) for age in ages_ms(tmp_path / "live")}
    assert len(ages) == 2, "each frame stays for two refreshes"
    assert np.ptp(list(ages)) == pytest.approx(1.0, abs=0.01)
    told = json.loads((tmp_path / "live" / "summary.json").read_text(encoding="utf-8"))["link"]
    assert told["frames"]["shown"] == 20 and told["response_ms"]["encode_ms"] == pytest.approx(5.0)
    assert min(ages_ms(tmp_path / "live")) >= 57 and len(told["timeline"]) == 12


@pytest.mark.parametrize(
    ("taken", "refreshes"),
    [
        *(({stage: 40.0}, 3) for stage in ("render", "encode", "decode")),
        ({"render": 15.0, "encode": 15.0, "decode": 15.0}, 1),
    ],
)
def test_the_slowest_stage_sets_the_pace(tmp_path, stages, taken, refreshes):
    """40 ms of work: a frame at every third refresh of 60 Hz, whichever stage it is. They work on
    different frames at once: with 15 ms each one comes at every refresh all the same."""
    stages(**taken)
    frames = run(tmp_path, latency_ms=20.0, seconds=1.0, **SUM).summary["link"]["frames"]
    drawn = np.diff(sorted({int(row["drawn_ns"]) for row in rows_of(tmp_path)}))[4:] * 1e-6
    assert drawn == pytest.approx([refreshes * PERIOD_MS] * len(drawn), abs=2e-6)
    assert frames["skipped"] == pytest.approx((refreshes - 1) * frames["drawn"], abs=8)
    assert min(ages_ms(tmp_path)) == pytest.approx(4 * PERIOD_MS, abs=2e-6)


def test_the_time_line_adds_up(tmp_path):
    network = LinkOptions.of({"response": "sum", "bandwidth": "60", "jitter": "uniform:5"})
    options = {"network": network, "coding": Coding("h264"), "latency_ms": 30.0, "seconds": 1.0}
    link = run(tmp_path, page=True, **options).summary["link"]
    assert len(link["timeline"]) == 12
    assert min(link["response_ms"][f"{stage}_ms"] for stage in ("render", "encode", "decode")) > 0
    for frame in link["timeline"]:
        arrived = frame["drawn"] + sum(frame["parts"].values())
        assert frame["parts"]["render"] > 0 and frame["parts"]["decode"] > 0
        assert arrived <= frame["shown"] + 1e-6 and frame["until"] >= frame["shown"]
    page = (tmp_path / "report.html").read_text(encoding="utf-8").replace("<wbr>", "")
    for label in ("part by part", "size / bandwidth", "round trip", "wait for the refresh", "on the screen"):
        assert label in page
