"""A server and its client in two processes: what crosses the feed is what would be drawn here."""

import math
import tracemalloc
from contextlib import closing, nullcontext

import attrs
import numpy as np
import pytest
import replays
from replays import rows_of
from serving import Serving

from hmdwarp.colour import srgb8_from_linear
from hmdwarp.errors import InputError
from hmdwarp.geometry import Pose
from hmdwarp.gpu import Gpu, download
from hmdwarp.headsets import load_headset
from hmdwarp.link import LinkOptions
from hmdwarp.link.codec import Coding
from hmdwarp.pipeline.feed_coding import arrays_of
from hmdwarp.pipeline.remote import Remote, RemoteFrames, RemoteRenderer
from hmdwarp.run import replay
from hmdwarp.run.run_summary import ReplayLog
from hmdwarp.scenes import load_scene
from hmdwarp.sources.feed import FeedOptions
from hmdwarp.sources.feed.caller import Viewer
from hmdwarp.sources.feed.message import DEPTH_CODES, NONE, RAW, RGBA8, Wish
from hmdwarp.sources.server import Renderer, Server

from .exchange import feeder
from .messages import ASK
from .test_strategies import patient

zmq = pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")


@pytest.fixture(scope="module")
def serving():
    with Serving() as one:
        yield one


@pytest.fixture(scope="module")
def parade():
    """A scene with things that deform."""
    with Serving("--scene", "parade") as one:
        yield one


def small(out, **options):
    """Options of a run of few refreshes, long enough to show a frame that came a second late."""
    return replays.small(out, **{"rate_hz": 10.0, "seconds": 1.0, **options})


def pictures(monkeypatch, options) -> dict[int, tuple[int, list]]:
    """Run a replay; return age and both eyes' pictures, in linear light, by the instant shown. A
    busy machine makes some frames late, and none is passed over."""
    found = {}
    add = ReplayLog.add

    def look(log, refresh, **more):
        found[refresh.shown_ns] = refresh.age_ns, [download(eye.shown.texture) for eye in refresh.eyes]
        add(log, refresh, **more)

    with monkeypatch.context() as patched:
        patched.setattr(Remote, "pace", patient)
        patched.setattr(ReplayLog, "add", look)
        patched.setattr("hmdwarp.run.run_summary.render_report", lambda *_, **__: "no page")
        done = replay(options)
    return found, done.summary


def test_what_the_lens_hides_is_not_drawn_elsewhere_either(serving, tmp_path, monkeypatch):
    drawn = []
    made = RemoteFrames.made

    def looked_at(frames, pending, arrival):
        frame = made(frames, pending, arrival)
        drawn.append([(eye.view, download(eye.colour)[..., 3] > 0) for eye in frame.eyes])
        return frame

    monkeypatch.setattr(RemoteFrames, "made", looked_at)
    options = small(tmp_path, feed=FeedOptions(connect=serving.address), headset="index", guard=1.25)
    _, summary = pictures(monkeypatch, options)
    assert summary["hidden"]["share"] == pytest.approx(0.25, abs=0.02) and len(drawn) > 1
    for view, covered in drawn[-1]:
        seen = view.seen(covered.shape[::-1])
        assert seen.mean() < 0.9 and covered[seen].all() and covered.mean() < seen.mean() + 0.04


def ages(shown) -> dict[int, int]:
    return {instant_ns: age_ns for instant_ns, (age_ns, _) in shown.items()}


def test_what_a_server_says_that_drawing_took_is_a_part_of_the_measured_delay(tmp_path, monkeypatch):
    """It says a minute, which is all of the delay, and nothing is left for the way."""
    with feeder(as_sent=lambda frame: attrs.evolve(frame, render_ns=60_000_000_000)) as address:
        feed = FeedOptions(connect=address)
        options = small(tmp_path / "out", feed=feed, scene="server", warp="none", fill="none")
        _, summary = pictures(monkeypatch, options)
    shown = summary["link"]["timeline"]
    assert shown and all(one["parts"]["network"] == 0 < one["parts"]["render"] for one in shown)
    # Rounding of the two instants.
    assert all(one["drawn"] + sum(one["parts"].values()) <= one["shown"] + 1e-6 for one in shown)


def test_the_truth_that_the_server_draws_is_the_one_drawn_here(parade):
    """Of the instant, in a scene that moves."""
    headset, scene, size = load_headset("flat-90"), load_scene("parade"), (96, 80)
    view = headset.views(scene.viewpoint)[0]
    with Gpu() as gpu, closing(RemoteRenderer(gpu, scene, FeedOptions(connect=parade.address))) as there:
        seen = set()
        with closing(Server(gpu, scene)) as here:
            for time_ns in (0, 700_000_000):
                ours, theirs = here.draw(view, size, time_ns=time_ns), there.draw(view, size, time_ns=time_ns)
                for name in ("colour", "inverse_depth"):
                    np.testing.assert_array_equal(download(getattr(theirs, name)), download(getattr(ours, name)))
                seen.add(download(theirs.inverse_depth).tobytes())
        assert len(seen) == 2
        assert (
            there.truth_facts([], 0, 1.0, own_head=True)[1] == "The truth is what the server drew for the shown views."
        )


def test_a_server_that_draws_no_truth_is_replayed_without_figures(tmp_path, monkeypatch):
    with feeder() as address:
        _, summary = pictures(monkeypatch, small(tmp_path / "out", scene="server", feed=FeedOptions(connect=address)))
    assert summary["measured"]["psnr_db"] == 0 and summary["quality"]["psnr_db"]["mean"] is None
    # Of both eyes at every fifth refresh, where one was there by then.
    count = sum(int(row["frame"]) % 5 == 0 for row in rows_of(tmp_path / "out"))
    assert f"It drew none for {count} pictures, which were not measured." in summary["notes"][-1]


def test_a_wrong_token_is_refused_and_the_right_one_let_in(tmp_path, monkeypatch):
    right, wrong = tmp_path / "right", tmp_path / "wrong"
    right.write_text("open sesame\n")
    wrong.write_text("open barley\n")
    with Serving("--token-file", str(right)) as one:
        with pytest.raises(InputError, match="token"):
            replay(small(tmp_path / "out", feed=FeedOptions(connect=one.address, token_file=wrong)))
        shown, _ = pictures(
            monkeypatch, small(tmp_path / "out", feed=FeedOptions(connect=one.address, token_file=right))
        )
        assert shown


CODINGS = {"raw": Coding(), "h264": Coding("h264", depth="exact"), "hevc": Coding("hevc", 30, depth="exact")}


@pytest.mark.parametrize("codec", CODINGS)
def test_shown_pictures_equal_an_offline_replay_of_the_same_ages_bit_for_bit(serving, tmp_path, monkeypatch, codec):
    """A fill that remembers would need all of them to be there: see test_strategies.py."""
    coding = CODINGS[codec]
    # Offline it begins as long before as any delay.
    asked = {"warp": "iterative", "fill": "none", "guard": 1.25, "coding": coding, "start_s": 2.0, "force": True}

    def arrived(summary) -> int:
        frames = summary["link"]["frames"]
        return frames["drawn"] - frames["under_way"]

    # A machine that was held up shows hardly a frame or an older one, or begins to draw at another
    # refresh than offline, which a video depends on; the fact is about other runs.
    for _ in range(20):
        here = small(tmp_path / "online", feed=FeedOptions(connect=serving.address), **asked)
        online, summary = pictures(monkeypatch, here)
        link = summary["link"]
        if not link["feed"]["unanswered"]:
            network = LinkOptions.of({"delay_trace": tmp_path / "online" / "delays.csv"})
            offline, there = pictures(monkeypatch, small(tmp_path / "offline", network=network, **asked))
            as_many = codec == "raw" or arrived(summary) == arrived(there)
            if as_many and link["frames"]["shown"] > 1 and ages(online).items() <= ages(offline).items():
                break
    assert not link["feed"]["unanswered"] and link["frames"]["shown"] > 1, link
    assert link["codec"] == coding.codec and link["feed"]["undecodable"] == link["feed"]["malformed"] == 0
    assert ages(online).items() <= ages(offline).items()
    for shown, (_, eyes) in online.items():
        for ours, theirs in zip(eyes, offline[shown][1], strict=True):
            np.testing.assert_array_equal(ours, theirs)
    # The latency is measured. One machine has one clock.
    clock = link["feed"]["clock"]
    assert summary["latency_ms"] not in (0, 200) and clock["jumps"] == 0
    assert abs(clock["offset_ms"]) <= clock["shortest_round_trip_ms"] / 2


def test_velocity_of_deforming_meshes_comes_packed_beside_a_video(parade, tmp_path, monkeypatch):
    """Of both eyes ten times a second; most of it is still, and packs well."""
    asked = {"scene": "parade", "guard": 1.25, "coding": CODINGS["h264"], "effects": "soft_motion"}
    _, summary = pictures(monkeypatch, small(tmp_path / "out", feed=FeedOptions(connect=parade.address), **asked))
    assert summary["effects"] == ["soft_motion"]
    assert 0 < summary["link"]["layers_mbit_s"]["velocity"] < 8 * 10 * 2 * 8 * 120 * 100 / 1e6 / 4


def test_half_of_the_bytes_are_the_same_picture_in_srgb_and_depth_within_half_a_step(serving, gpu):
    """Over the feed, and as the GPU takes it over."""
    view, size = attrs.evolve(ASK.views[0], pose=Pose((0, 1.6, 0))), (161, 143)
    found = {}
    for name, wish in (*RAW.items(), ("as before", Wish(200, 200))):
        with closing(Viewer(serving.address, wish=wish)) as viewer:
            found[name] = viewer.fetch(view, size, 0)
    full, half, odd = found.values()
    assert (odd.colour, odd.depth) == (full.colour, full.depth)  # whatever is not known is answered as drawn
    assert half.bytes == full.bytes / 2 + 4 and (half.colour, half.depth) == (RGBA8, DEPTH_CODES)
    np.testing.assert_array_equal(half.colours[0][..., :3], srgb8_from_linear(full.colours[0][..., :3]))
    np.testing.assert_array_equal(half.colours[0][..., 3] > 0, full.colours[0][..., 3] > 0)
    exact, got, step = full.inverse_depths[0], half.inverse_depth(0), half.inverse_depths[0].step
    assert step == pytest.approx(exact.max() / 65534, rel=1e-6) and ((exact == 0) == (got == 0)).all()
    assert np.abs(got - exact)[exact > step].max() <= 0.55 * step and ((exact < 0) == (got < 0)).all()
    with closing(Renderer(gpu, load_scene("planes"))) as renderer:
        for frame in (full, half):
            target = renderer.acquire(size)
            renderer.take_in(arrays_of(frame, 0, size), target)
            np.testing.assert_array_equal(download(target.colour), frame.light(0))
            np.testing.assert_array_equal(download(target.inverse_depth), frame.inverse_depth(0))
            tracemalloc.start()
            renderer.take_in(arrays_of(frame, 0, size), target)
            assert tracemalloc.get_traced_memory()[1] < size[0] * size[1]
            tracemalloc.stop()


@pytest.mark.parametrize("knows", [True, False])
def test_a_replay_in_half_weighs_half(serving, tmp_path, monkeypatch, knows):
    """A server that does not know the form sends what it has."""
    with feeder() if not knows else nullcontext(serving.address) as address:
        scene = "planes" if knows else "server"
        asked = small(tmp_path / "out", scene=scene, feed=FeedOptions(connect=address, raw="half"))
        _, summary = pictures(monkeypatch, asked)
    full = 2 * 12 * math.prod(asked.size)
    assert summary["link"]["frame_bytes"] == pytest.approx(full / 2 if knows else full, rel=0.01)


@pytest.mark.parametrize("coding", [Coding(), Coding("h264")], ids=["raw", "h264"])
def test_depth_that_no_pass_reads_does_not_cross(serving, tmp_path, monkeypatch, coding):
    """A warp that is compared gets it still: it leaves hardly a hole for a head at rest."""
    options = {"warp": "none", "against": "forward", "coding": coding, "trace": "still"}
    there, summary = pictures(monkeypatch, small(tmp_path, feed=FeedOptions(connect=serving.address), **options))
    assert [*summary["link"]["layers_mbit_s"]] == ["colour"]
    assert all((eye[..., 3] == 1).all() for _, eyes in there.values() for eye in eyes)
    (against,) = summary["against"]
    assert against["quality"]["hole_share"]["mean"] < 0.2


NO_DEPTH = {"as_sent": lambda frame: attrs.evolve(frame, inverse_depths=(b"",) * 2, depth=NONE)}


@pytest.mark.parametrize(
    ("sends", "asked", "message"),
    [
        (NO_DEPTH, {}, "the server sends no inverse_depth"),
        ({}, {"fovea_deg": 30.0}, "that server sends whole frames alone; leave it out"),
        ({}, {"effects": "soft_motion"}, "sends no layer 'velocity': use --effects none"),
        ({}, {"coding": Coding("h264"), "raw": "half"}, "--raw half beside --codec h264"),
    ],
)
def test_a_server_without_what_is_asked_for_is_refused_in_a_line(tmp_path, sends, asked, message):
    raw = {"raw": asked.pop("raw")} if "raw" in asked else {}
    with feeder(**sends) as address, pytest.raises(InputError, match=message):
        replay(small(tmp_path / "out", feed=FeedOptions(connect=address, **raw), scene="server", **asked))
    with pytest.raises(InputError, match="--raw half: it is for --connect"):
        FeedOptions(raw="half")
