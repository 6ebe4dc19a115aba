"""A server and its client in two processes, by replay, live and in Python: what crosses the feed is
what would be drawn here."""

import signal
import subprocess
import sys
import tracemalloc
from contextlib import closing

import attrs
import numpy as np
import pytest
import replays
from replays import rows_of
from run.offscreen import OffscreenDisplay, run_on
from serving import Serving

from hmdwarp import feed
from hmdwarp.base import InputError, srgb8_from_linear
from hmdwarp.display import Closed, Command
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import Gpu, download
from hmdwarp.headsets import load_headset
from hmdwarp.link.codec import Coding
from hmdwarp.pipeline.feed_coding import arrays_of
from hmdwarp.pipeline.remote import Remote, RemoteRenderer
from hmdwarp.run import LiveOptions, live, replay
from hmdwarp.run.run_summary import ReplayLog
from hmdwarp.scenes import load_scene
from hmdwarp.sources.feed import FeedOptions
from hmdwarp.sources.feed.caller import Viewer
from hmdwarp.sources.feed.message import DEPTH_CODES, NONE, RAW, RGBA8, Wish
from hmdwarp.sources.server import Renderer, Server

from .exchange import ASK, feeder
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


class Closable(OffscreenDisplay):
    """A display whose user closes it in the middle of a run."""

    def ask_to_close(self) -> None:
        if not any(isinstance(event, Closed) for event in self._events.values()):
            self._events[self._number + 3] = Closed("the window was closed")


def live_of(address: str, **more) -> LiveOptions:
    said = {
        "source": "offscreen",
        "trace": "look-around",
        "connect": address,
        "headset": "rift-dk1",
        "predict": "none",
        "fill": "none",
    }
    return LiveOptions.of({**said, "panel": False, **more})


def test_frames_of_another_process_are_shown_at_the_age_that_was_measured(serving_of, monkeypatch, tmp_path):
    """What is the server's is not changed, and what is the client's is; its scene is here too."""
    changes = {
        3: [Command("latency")],
        4: [Command("scene"), Command("push")],
        5: [Command("guard", 1.75)],
        6: [Command("warp", "none")],
    }
    display = OffscreenDisplay(asked=changes, keeps=True)
    asked = live_of(serving_of("planes"), pictures=12, latency=900.0, out=tmp_path / "out")
    summary = run_on(monkeypatch, display, asked).summary
    assert summary["scene"] == "server"  # whose address stands in link.feed
    assert summary["latency_ms"] not in (0, 900) and "input" not in summary
    feed, live = summary["link"]["feed"], summary["live"]
    assert feed["malformed"] == 0 and not any("other views" in line for line in display.said)
    assert feed["lost"] == sum("no frame for" in line for line in display.said)  # on a machine that stood still
    assert live["refreshes"] == 12 and live["age_ms"]["median"] > 0
    assert [name for change in live["changes"] for name in change["what"]] == ["guard", "warp"]
    # The scene was drawn: nothing else here has any light.
    assert max(picture.std() for picture in display.pictures[-3:]) > 10
    for told in ("the server's scene", "latency and scene are the server's", "does not react to what people do"):
        assert sum(told in line for line in display.said) == 1, told
    display = OffscreenDisplay(keeps=True)
    named = live_of(serving_of("planes"), pictures=6, scene="planes", warp="model")
    summary = run_on(monkeypatch, display, named).summary
    assert any("scene 'planes' on both ends" in line for line in display.said)
    assert summary["scene"] == "planes" and summary["link"]["feed"]["malformed"] == 0
    assert display.pictures[-1].std() > 10


def test_a_warp_whose_layer_the_server_lacks_is_reported_and_can_be_left(monkeypatch):
    changes = {4: [Command("warp", "layered")], 8: [Command("warp", "forward")]}
    display = OffscreenDisplay(asked=changes, keeps=True)
    with feeder() as address:
        summary = run_on(monkeypatch, display, live_of(address, pictures=16, effects="none")).summary
    assert sum("sends no layer 'peeled'" in line for line in display.said) == 1
    assert summary["link"]["feed"]["malformed"] > 0 and display.pictures[-1].std() > 10


def test_the_mismatch_of_a_camera_that_stands_elsewhere_is_reported_once(monkeypatch):
    """0.3 m to the right, turned by 30 degrees, with a field of view of its own."""
    there = Pose((0.3, 0, 0), (0, np.sin(np.pi / 12), 0, np.cos(np.pi / 12)))
    own = Fov(*np.arctan([-0.5, 0.5, -0.5, 0.5]))

    def camera(views: tuple[View, ...]) -> tuple[View, ...]:
        return tuple(attrs.evolve(view, pose=view.pose @ there, fov=own) for view in views)

    display = OffscreenDisplay()
    with feeder(views_of=camera) as address:
        summary = run_on(monkeypatch, display, live_of(address, pictures=6, guard="1")).summary
    assert sum("other views than it is asked for" in line for line in display.said) == 1
    assert summary["link"]["feed"]["draws_others"]


def test_a_lost_server_is_announced_over_the_picture_and_taken_up_again(monkeypatch, tmp_path):
    servers = [Serving()]
    port = servers[0].address.rpartition(":")[2]
    display = Closable()
    before: list[int] = []

    def look(number: int) -> None:
        if number == 5:
            servers[0].process.kill()
        if len(servers) == 1 and any("no frame for" in line for line in display.said):
            before.append(number)
            servers.append(Serving("--listen", f"127.0.0.1:{port}"))
        # Until it is back, and a little longer; the count is a fail-safe.
        if any("come again" in line for line in display.said) or number > 20_000:
            display.ask_to_close()

    try:
        summary = run_on(monkeypatch, display, live_of(servers[0].address, out=tmp_path / "out"), after=look).summary
    finally:
        for server in servers:
            server.__exit__()
    told = f"no frames from {servers[0].address}: the last one stays"
    assert before and told in display.labels and display.labels[-1] == ""
    assert summary["live"]["notices"][told] > 0
    assert summary["link"]["feed"]["lost"] == sum("no frame for" in line for line in display.said) >= 1
    assert summary["link"]["feed"]["away_s"] >= 1.5
    assert len(rows_of(tmp_path / "out")) == 2 * summary["live"]["refreshes"]


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ({"scene": "no such"}, "unknown scene 'no such'"),
        ({"fill": "model"}, "the scene is at the server"),
        ({"response": "sum"}, "the server's times are real"),
        ({"jitter": "uniform:20"}, "--added-latency 0 ms"),
        ({"connect": "nowhere"}, "expected HOST:PORT"),
    ],
)
def test_impossible_options_are_refused_before_a_connection(more, told):
    with pytest.raises(InputError, match=told):
        live(live_of(more.pop("connect", "127.0.0.1:1"), **more))


RENDERED_FOV, RENDERED = Fov.symmetric(1.0, 0.8), (6, 4)
ASKED, CAMERA = View(Pose((0.1, 1.6, 0.2)), RENDERED_FOV), View(Pose((1, 2, 3), (0, 1, 0, 1)), Fov.symmetric(0.9, 0.7))
BYTES = np.random.default_rng(2).integers(0, 256, (4, 6, 3), np.uint8)
DEPTH_M = np.linspace(0.5, 9, 24).reshape(4, 6)
DEPTH_M[0, :3] = np.inf, 0, np.nan


def fetched(render, view: View = ASKED, size=RENDERED):
    with feed.serving(render) as address, closing(Viewer(address)) as viewer:
        return viewer.fetch(view, size, 5_000_000)


def test_a_frame_is_what_render_returns_for_the_view(capfd):
    got = []

    def render(views, time_ns):
        got.append((views, views.size, time_ns))
        return [BYTES], [DEPTH_M]

    frame = fetched(render)
    ((views, *rest),) = got
    assert (*views, *rest) == (ASKED, RENDERED, 5_000_000) and frame.views == (ASKED,)
    assert (frame.colours[0][..., :3] == BYTES).all() and (frame.colours[0][..., 3] == 255).all()
    with np.errstate(divide="ignore"):
        expected = np.where(DEPTH_M > 0, 1 / DEPTH_M, -1).astype(np.float32)
    assert (frame.inverse_depths[0] == expected).all()
    assert "listening at tcp://127.0.0.1:" in capfd.readouterr().err


def test_light_coverage_and_the_view_of_a_camera_come_along():
    light = np.dstack([np.full((4, 6, 3), 1.0), np.eye(4, 6)])
    frame = fetched(lambda views, _: ([light], [np.ones((4, 6))], [CAMERA]))
    assert frame.views == (CAMERA,)
    assert (frame.colours[0] == np.dstack([np.full((4, 6, 3), 255), 255 * np.eye(4, 6)])).all()
    assert (frame.inverse_depths[0] == np.where(np.eye(4, 6) > 0, 1, -1)).all()


@pytest.mark.parametrize(
    "result",
    [([BYTES] * 2, [DEPTH_M]), ([BYTES], [DEPTH_M.T]), ([BYTES[..., :2]], [DEPTH_M]), ([BYTES], [DEPTH_M], [])],
)
def test_other_shapes_end_it_with_what_was_expected(result, monkeypatch):
    monkeypatch.setattr("hmdwarp.sources.feed.caller._ANSWER_NS", 10**8)  # nobody answers any more
    asked = []
    with (
        pytest.raises(InputError, match="render returned .*: expected"),
        feed.serving(lambda views, _: asked.append(views) or result) as address,
        closing(Viewer(address)) as viewer,
    ):
        while not asked:
            viewer.fetch(ASKED, RENDERED, 0)


def test_a_request_beyond_what_a_cpu_draws_is_refused():
    """More than 2^28 bytes, at 13 a pixel."""
    assert fetched(lambda *_: pytest.fail("asked"), size=(8192, 8192)) is None


def test_served_by_a_process_of_its_own_until_it_is_interrupted():
    program = (
        "import hmdwarp, numpy as np\ndef render(views, time_ns):\n    w, h = views.size\n"
        "    return [np.full((h, w, 3), 0.5)], [np.full((h, w), 2.0)]\nhmdwarp.feed.serve(render, '127.0.0.1:*')"
    )
    with subprocess.Popen([sys.executable, "-c", program], stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        with closing(Viewer(process.stderr.readline().split()[2])) as viewer:
            assert (viewer.fetch(ASKED, RENDERED, 0).inverse_depths[0] == 0.5).all()
        process.send_signal(signal.SIGINT)
        assert "Traceback" not in process.stderr.read()
    assert process.returncode == 0
