"""A server and its client in two processes: what crosses the feed is what would be drawn here."""

import tracemalloc
from contextlib import closing

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
from hmdwarp.link.codec import Coding
from hmdwarp.pipeline.feed_coding import arrays_of
from hmdwarp.pipeline.remote import Remote, RemoteRenderer
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


def test_the_truth_that_the_server_draws_is_the_one_drawn_here(serving_of):
    """Of the instant, in a scene that moves."""
    headset, scene, size = load_headset("flat-90"), load_scene("parade"), (96, 80)
    view = headset.views(scene.viewpoint)[0]
    with Gpu() as gpu, closing(RemoteRenderer(gpu, scene, FeedOptions(connect=serving_of("parade")))) as there:
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


def test_half_of_the_bytes_are_the_same_picture_in_srgb_and_depth_within_half_a_step(serving_of, gpu):
    """Over the feed, and as the GPU takes it over."""
    view, size = attrs.evolve(ASK.views[0], pose=Pose((0, 1.6, 0))), (161, 143)
    found = {}
    for name, wish in (*RAW.items(), ("as before", Wish(200, 200))):
        with closing(Viewer(serving_of("planes"), wish=wish)) as viewer:
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


@pytest.mark.parametrize("coding", [Coding(), Coding("h264")], ids=["raw", "h264"])
def test_depth_that_no_pass_reads_does_not_cross(serving_of, tmp_path, monkeypatch, coding):
    """A warp that is compared gets it still: it leaves hardly a hole for a head at rest."""
    options = {"warp": "none", "against": "forward", "coding": coding, "trace": "still"}
    there, summary = pictures(monkeypatch, small(tmp_path, feed=FeedOptions(connect=serving_of("planes")), **options))
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
