"""A server and its client in two processes: what crosses the feed is what would be drawn here."""

import time
import tracemalloc
from contextlib import closing, nullcontext
from types import SimpleNamespace

import attrs
import numpy as np
import pytest
import replays
from replays import rows_of
from serving import Serving

from hmdwarp.colour import srgb8_from_linear
from hmdwarp.errors import InputError
from hmdwarp.frames import Needs
from hmdwarp.frames.layers import layers
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import Gpu, download
from hmdwarp.headsets import load_headset
from hmdwarp.link import LinkOptions
from hmdwarp.link.codec import Coding
from hmdwarp.pipeline.feed_coding import arrays_of
from hmdwarp.pipeline.remote import Remote, ViewsApart
from hmdwarp.pipeline.remote_source import RemoteFrames, RemoteRenderer
from hmdwarp.poses import Origin, PoseSample
from hmdwarp.run import replay
from hmdwarp.run.frame_rows import ReplayLog
from hmdwarp.scenes import InputEvent, load_scene
from hmdwarp.sources.feed import FeedOptions, caller
from hmdwarp.sources.feed import listener as listening
from hmdwarp.sources.feed.caller import Caller
from hmdwarp.sources.feed.listener import Listener
from hmdwarp.sources.feed.message import DEPTH_CODES, NONE, RAW, RGBA8, Fate, Wish, encode
from hmdwarp.sources.feed.message import Session as Told
from hmdwarp.sources.feed.viewer import Viewer
from hmdwarp.sources.server import Renderer, Server

from .exchange import WHENEVER_MS, answered, exchanged, feeder
from .messages import ASK, FRAME
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
    """Run a replay; return age and both eyes' pictures, in linear light, by the instant shown.

    A busy machine makes some frames late, and none is passed over.
    """
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


@pytest.mark.parametrize(
    ("fill", "coding"),
    [
        ("none", Coding()),
        ("memory+pyramid", Coding()),
        ("none", Coding("h264", depth="exact")),
        ("none", Coding("hevc", 30, depth="exact")),
    ],
)
def test_shown_pictures_equal_an_offline_replay_of_the_same_ages_bit_for_bit(
    serving, tmp_path, monkeypatch, fill, coding
):
    same_as_offline(
        serving, tmp_path, monkeypatch, {"warp": "iterative", "fill": fill, "guard": 1.25, "coding": coding}
    )


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


@pytest.mark.parametrize("coding", [Coding(), Coding("h264", depth="exact")], ids=["raw", "h264"])
def test_deforming_meshes_go_on_as_offline_bit_for_bit(parade, tmp_path, monkeypatch, coding):
    """The plan reads velocity, which comes beside the picture, packed where that is coded."""
    asked = {"scene": "parade", "guard": 1.25, "coding": coding, "effects": "soft_motion"}
    if coding == Coding():
        summary = same_as_offline(parade, tmp_path, monkeypatch, asked)
    else:
        _, summary = pictures(monkeypatch, small(tmp_path / "out", feed=FeedOptions(connect=parade.address), **asked))
    assert summary["effects"] == ["soft_motion"]
    layers = summary["link"]["layers_mbit_s"]
    if coding == Coding():
        assert layers["velocity"] == layers["colour"]  # 8 bytes a pixel, either of them
    else:
        # Of both eyes ten times a second; most of it is still, and packs well.
        assert 0 < layers["velocity"] < 8 * 10 * 2 * 8 * 120 * 100 / 1e6 / 4


def same_as_offline(serving, tmp_path, monkeypatch, asked) -> dict:
    coding, asked = asked["coding"], {"start_s": 2.0, **asked}  # offline it begins as long before as any delay
    # A machine that was held up shows hardly a frame or an older one, or begins to draw at another
    # refresh than offline, which a video depends on; the fact is about other runs.
    for _ in range(20):
        here = small(tmp_path / "online", feed=FeedOptions(connect=serving.address), force=True, **asked)
        online, summary = pictures(monkeypatch, here)
        if not summary["link"]["feed"]["unanswered"]:
            network = LinkOptions.of({"delay_trace": tmp_path / "online" / "delays.csv"})
            offline, there = pictures(monkeypatch, small(tmp_path / "offline", network=network, force=True, **asked))
            as_many = coding == Coding() or arrived(summary) == arrived(there)
            if as_many and summary["link"]["frames"]["shown"] > 1 and ages(online).items() <= ages(offline).items():
                break
    assert not summary["link"]["feed"]["unanswered"], summary["link"]
    assert summary["link"]["frames"]["shown"] > 1, summary["link"]
    assert summary["link"]["codec"] == coding.codec and summary["link"]["feed"]["undecodable"] == 0
    assert ages(online).items() <= ages(offline).items()
    for shown, (_, eyes) in online.items():
        for ours, theirs in zip(eyes, offline[shown][1], strict=True):
            np.testing.assert_array_equal(ours, theirs)
    return summary


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
            before = tracemalloc_peak(lambda: renderer.take_in(arrays_of(frame, 0, size), target))  # noqa: B023
            assert before < size[0] * size[1]


def tracemalloc_peak(run) -> int:
    tracemalloc.start()
    run()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


@pytest.mark.parametrize("knows", [True, False])
def test_a_replay_in_half_says_how_frames_came(serving, tmp_path, monkeypatch, knows):
    """A server that does not know the form sends what it has."""
    with feeder() if not knows else nullcontext(serving.address) as address:
        scene = "planes" if knows else "server"
        asked = small(tmp_path / "out", scene=scene, feed=FeedOptions(connect=address, raw="half"))
        _, summary = pictures(monkeypatch, asked)
    expected = {"colour": "srgb8", "depth": "uint16"} if knows else {"colour": "float16", "depth": "float32"}
    told = summary["link"]["feed"]["raw"]
    error = told.pop("depth_error")
    assert told == expected and (0 < error < 1e-4 if knows else error == 0)
    with pytest.raises(InputError, match="--raw half beside --codec h264"):
        replay(attrs.evolve(asked, coding=Coding("h264")))
    with pytest.raises(InputError, match="--raw half: it is for --connect"):
        FeedOptions(raw="half")


def ages(shown) -> dict[int, int]:
    return {instant_ns: age_ns for instant_ns, (age_ns, _) in shown.items()}


def arrived(summary) -> int:
    frames = summary["link"]["frames"]
    return frames["drawn"] - frames["under_way"]


@pytest.mark.parametrize("coding", [Coding(), Coding("h264")], ids=["raw", "h264"])
def test_depth_that_no_pass_reads_does_not_cross(serving, tmp_path, monkeypatch, coding):
    """A warp that is compared gets it still."""
    # With its depth the warp leaves hardly a hole for a head at rest, however old a frame is.
    options = {"warp": "none", "against": "forward", "coding": coding, "trace": "still"}
    feed = FeedOptions(connect=serving.address)
    there, summary = pictures(monkeypatch, small(tmp_path / "out", feed=feed, **options))
    here, alone = pictures(monkeypatch, small(tmp_path / "here", latency_ms=summary["latency_ms"], **options))
    assert [*summary["link"]["layers_mbit_s"]] == [*alone["link"]["layers_mbit_s"]] == ["colour"]
    # What the feed's video lacks is the coverage.
    assert summary["link"]["frame_bytes"] == pytest.approx(
        alone["link"]["frame_bytes"], rel=0 if coding == Coding() else 0.1
    )
    assert all((eye[..., 3] == 1).all() for _, eyes in there.values() for eye in eyes)
    for one in (summary, alone):
        (against,) = one["against"]
        assert against["quality"]["hole_share"]["mean"] < 0.2


def test_a_server_that_leaves_out_what_is_read_is_refused_in_a_line(tmp_path):
    with (
        feeder(as_sent=lambda frame: attrs.evolve(frame, inverse_depths=(b"",) * 2, depth=NONE)) as address,
        pytest.raises(InputError, match="the server sends no inverse_depth"),
    ):
        replay(small(tmp_path / "out", feed=FeedOptions(connect=address), scene="server"))


def test_a_fovea_at_a_server_that_takes_none_is_refused_in_a_line(tmp_path):
    known = {"scene": "server", "fovea_deg": 30.0}
    with feeder() as address, pytest.raises(InputError, match="that server sends whole frames alone; leave it out"):
        replay(small(tmp_path / "out", feed=FeedOptions(connect=address), **known))


def test_the_latency_is_measured_and_the_clocks_are_compared(serving, tmp_path, monkeypatch):
    _, summary = pictures(
        monkeypatch, small(tmp_path / "out", feed=FeedOptions(connect=serving.address), latency_ms=900.0)
    )
    feed = summary["link"]["feed"]
    assert summary["latency_ms"] not in (0, 900)
    # One machine, one clock.
    clock = feed["clock"]
    assert abs(clock["offset_ms"]) <= clock["shortest_round_trip_ms"] / 2
    assert feed["malformed"] == 0 and clock["jumps"] == 0


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


def test_motion_vectors_of_a_renderer_move_what_it_drew(tmp_path, monkeypatch):
    """The stripe goes to the right at 2 m/s, so each frame is older than where it is shown."""

    def vectors_of(ask):
        left, right, *_ = ask.views[0].fov.tangents
        found = np.zeros((ask.size[1], ask.size[0], 4), np.float16)
        # In a hundredth of a second 0.02 m at 2 m: a tangent of 0.01, of a picture from -1 to 1.
        found[:, 2 * ask.size[0] // 5 : 3 * ask.size[0] // 5, 0] = 2 * 0.01 / (right - left)
        of_eyes = []
        for view in ask.views:
            poses = [
                number
                for pose in (view.pose, view.head_from_eye)
                for number in (*pose.position_m, *pose.orientation_xyzw)
            ]
            angles = (view.fov.left, view.fov.right, view.fov.down, view.fov.up)
            of_eyes.append({"velocity": [found, np.array([[1, 1, 1, 0, 0, 0, 0.1, np.inf, 0.01, *poses, *angles]])]})
        return of_eyes

    def red(found) -> float:
        """Where the stripe's middle is in the last picture, in pixels."""
        _, (picture, _) = found[max(found)]
        return float(np.flatnonzero((picture[40, :, 0] > 0.9) & (picture[40, :, 1] < 0.1)).mean())

    trace = tmp_path / "still.csv"
    rows = "".join(f"{n * 100_000_000},0,1.6,0,0,0,0,1\n" for n in range(20))
    trace.write_text("# origin: at rest\ntime_ns,x_m,y_m,z_m,qx,qy,qz,qw\n" + rows)
    asked = {"trace": str(trace), "scene": "server", "warp": "forward", "fill": "pyramid"}
    with feeder(vectors_of) as address:
        feed = FeedOptions(connect=address)
        moved, summary = pictures(monkeypatch, small(tmp_path / "moved", feed=feed, effects="soft_motion", **asked))
        stayed, _ = pictures(monkeypatch, small(tmp_path / "stayed", feed=feed, **asked))
    assert summary["link"]["layers_mbit_s"]["velocity"] > 0 and summary["effects"] == ["soft_motion"]
    moved = dict([min(moved.items(), key=lambda one: one[1][0])])  # not one that a busy machine made old
    age_s = moved[max(moved)][0] * 1e-9
    # A swing is extrapolated a little less far than its speed would take it, see SWING_S.
    tangent = 1.0 * age_s * (1 - age_s)
    pixels = tangent * 96 / 2
    assert pixels > 2 and abs(red(moved) - red(stayed) - pixels) <= 1


def test_a_server_without_a_layer_that_is_read_is_refused_in_a_line(tmp_path):
    with feeder() as address:
        asked = {"scene": "server", "feed": FeedOptions(connect=address), "effects": "soft_motion"}
        with pytest.raises(InputError, match="sends no layer 'velocity': use --effects none"):
            replay(small(tmp_path / "out", **asked))


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


def next_asked(listener):
    """Return the next request; the limit is a fail-safe."""
    for _ in range(600):
        asked = listener.next(200)
        if asked is not None:
            return asked
    raise AssertionError("no request came")


def test_a_frame_that_missed_its_refresh_is_counted_as_later_than_it():
    """A refresh was shown without it, so an offline replay of its delay must not show it there."""
    listener = Listener("127.0.0.1:*")
    remote = Remote(FeedOptions(connect=listener.address), holds=False)
    eyes, head = load_headset("flat-90"), PoseSample(0, Pose(), Origin.MEASURED)
    found, asked = [], None
    while asked is None:  # until the connection is there
        remote.ask(head, eyes.views(head.pose), 1.0, (4, 3), 0)
        asked = listener.next(200)
    assert remote.arrived(5_000_000_000) == []
    listener.answer(asked, attrs.evolve(FRAME, number=asked.ask.number, sent_ns=FRAME.received_ns))
    while not found:
        found = remote.arrived(6_000_000_000)
    assert found[0].took_ns > 5_000_000_000
    remote.close()
    listener.close()


def test_views_apart_keep_the_largest_difference_of_each_kind():
    right = np.arctan(1.0)
    asked, apart = View(Pose(), Fov(-right, right, -right, right)), ViewsApart()
    apart.take(asked, asked)
    assert not apart
    # Three quarters of the width and of the height; the next one is wider, and elsewhere.
    apart.take(asked, View(Pose(), Fov(-right, np.arctan(0.5), -np.arctan(0.5), right)))
    apart.take(asked, View(Pose((0, 0.3, 0.4)), Fov(-1.2, right, -right, 1.2)))
    assert apart and apart.field_share == pytest.approx(0.5625)
    assert (apart.moved_m, apart.turned_deg) == (pytest.approx(0.5), 0.0)


def test_a_request_that_comes_again_is_left_out():
    lines = []
    with closing(Listener("127.0.0.1:*", say=lines.append)) as listener, closing(Caller(listener.address)) as caller:
        exchanged(caller, listener)
        for number in (10**9, 10**9, 10**9 - 1, 10**9 + 1):
            caller.ask(attrs.evolve(ASK, number=number, token=bytes(32)))
        # They come in order, so all before the last one have been read by then.
        while next_asked(listener).ask.number <= 10**9:
            pass
    assert [line.partition("request ")[2] for line in lines if "left out" in line] == [
        f"{number} after {10**9}" for number in (10**9, 10**9 - 1)
    ]


def test_a_frame_that_was_not_requested_is_left_out():
    with closing(Listener("127.0.0.1:*")) as listener, closing(Caller(listener.address)) as caller:
        exchanged(caller, listener)
        caller.ask(attrs.evolve(ASK, number=10**9, token=bytes(32)))
        while (asked := next_asked(listener)).ask.number < 10**9:
            pass
        caller.take()
        for number in (10**9 + 1, 10**9):
            while not listener.answer(asked, attrs.evolve(FRAME, number=number)):
                listener.next(1)  # on a busy machine the frames before are still under way
        found = []
        while not any(arrival.frame.number == 10**9 for arrival in found):
            found += caller.take()
        assert max(arrival.frame.number for arrival in found) == 10**9 and caller.malformed == 1


class Session:
    """A client's session and the server's end of it: what one asks, and answers by hand."""

    def __init__(self) -> None:
        self.listener, self._asked = Listener("127.0.0.1:*"), 0
        self.remote = Remote(FeedOptions(connect=self.listener.address), holds=False)
        self.eyes, self.head = load_headset("flat-90"), PoseSample(0, Pose(), Origin.MEASURED)

    def ask(self, now_ns, needs=None):
        self.remote.ask(self.head, self.eyes.views(self.head.pose), 1.0, (4, 3), now_ns, needs)
        self._asked += 1

    def asked(self, now_ns, needs=None):
        """Ask; return the request as it arrived, once the ones before it have."""
        self.ask(now_ns, needs)
        while (found := next_asked(self.listener)).ask.number < self._asked:
            pass
        return found

    def answer(self, asked, **says):
        says = {"takes_inputs": True, "takes_session": True, **says}
        self.listener.answer(asked, attrs.evolve(FRAME, number=asked.ask.number, **says))
        while not (found := self.remote.arrived(0)):
            pass
        return found[-1].pending

    def begin(self) -> None:
        """Answer one request, so that the client knows what it may tell."""
        found = None
        while found is None:  # until the connection is there
            self.ask(0)
            found = self.listener.next(200)
        self.answer(found)

    def close(self) -> None:
        self.remote.close()
        self.listener.close()


def test_what_people_did_is_told_until_the_server_has_it():
    events = [InputEvent(at, "push", "ball") for at in (100, 200, 300)]
    with closing(Session()) as session:
        session.begin()
        session.remote.act(events)
        told = [session.asked(at) for at in (199, 200, 250, 300)]
        # With that of the very instant; what was not answered is told again.
        assert [list(one.ask.inputs) for one in told] == [events[:1], events[:2], events[:2], events]
        session.answer(told[2])
        last = session.asked(400)
        assert list(last.ask.inputs) == events[2:]
        session.answer(last)
        after = session.asked(500)
        assert after.ask.inputs == ()
        session.answer(after, began=7)  # another server in its place, which knows nothing
        assert list(session.asked(600).ask.inputs) == events


def test_inputs_to_a_scene_that_does_not_react_are_said_and_frames_go_on(serving):
    """Once a session, by the server, whose frames say that it takes none; and by the client."""
    events, said = tuple(InputEvent(at, "push", "ball") for at in (1, 2)), []
    with closing(Caller(serving.address)) as client:
        found = []
        number = 1
        while len(found) < 2:
            client.ask(attrs.evolve(ASK, number=number, token=bytes(32), inputs=events, session=Told(1)))
            client.wait_until(time.monotonic_ns() + 200_000_000)
            found, number = found + client.take(), number + 1
    assert not any(arrival.frame.takes_inputs for arrival in found)
    assert "its inputs are left out: planes does not react" in serving.line("inputs are left out")
    with closing(Session()) as session:
        session.remote._say = said.append
        session.begin()
        session.remote.act(events)
        session.answer(session.asked(5), takes_inputs=False)
        session.answer(session.asked(6), takes_inputs=False)
    assert sum("does not react any more" in line for line in said) == 1


def test_a_fate_is_told_from_when_it_is_heard_until_a_request_that_told_it_is_answered():
    needs = Needs(irradiance=layers.get("irradiance").something)

    def told(asked):
        return asked.ask.session.fates

    with closing(Session()) as session:
        session.begin()
        of = session.answer(session.asked(500, needs))
        fate = Fate(of.number, True, 1000)
        session.remote.tell(of, arrived=True, heard_ns=1000)
        before, first, second = (session.asked(at, needs) for at in (999, 1000, 1001))
        assert [told(one) for one in (before, first, second)] == [(), (fate,), (fate,)]
        session.answer(before)  # it was not in there
        third = session.asked(1100, needs)
        assert told(third) == (fate,)
        session.answer(second)
        # The first will have no answer: its frame is lost, which is known at once.
        lost = Fate(first.ask.number, False, 1000)
        assert told(session.asked(1200, needs)) == (lost,)


def test_the_log_counts_requests_that_were_replaced_before_they_were_drawn():
    said, drawn, count = [], 0, 50
    with closing(Listener("127.0.0.1:*", say=said.append)) as listener, zmq.Context() as context:
        socket = context.socket(zmq.DEALER)
        socket.connect(listener.address)
        for number in range(1, count + 1):
            socket.send(encode(attrs.evolve(ASK, number=number, token=bytes(32))))
        newest = 0
        while newest < count:
            newest, drawn = next_asked(listener).ask.number, drawn + 1
        socket.close(0)
        while not any("superseded" in line for line in said):
            listener.next(20)
    assert f"{count - drawn} requests superseded" in " ".join(said)


@pytest.mark.parametrize("room", [1, 3])
def test_frames_that_were_taken_no_longer_count_as_held(monkeypatch, room):
    """Two frames that fit are both there, however many were taken before."""
    with closing(Listener("127.0.0.1:*")) as listener, closing(Caller(listener.address)) as client:
        exchanged(client, listener)
        monkeypatch.setattr(caller, "_MOST_HELD", room * FRAME.bytes)
        for first in range(1_000_000, 1_000_010, 2):
            for number in (first, first + 1):
                client.ask(attrs.evolve(ASK, number=number, token=bytes(32)))
                while not answered(listener):
                    pass
            while client._newest < first + 1:  # both have come
                client.wait_until(time.monotonic_ns() + 1_000_000)
            there = [arrival.frame.number for arrival in client.take()]
            assert there[-2 if room == 3 else -1 :] == [first, first + 1][-2 if room == 3 else -1 :]
            assert (first in there) == (room == 3)


def test_clients_share_the_time_of_a_server_so_that_cheap_requests_have_more_turns(monkeypatch):
    """By a clock of its own: a frame takes 10 ms, or 60."""
    clock = [0]
    monkeypatch.setattr(listening, "time", SimpleNamespace(monotonic_ns=lambda: clock[0]))
    with closing(Listener("127.0.0.1:*")) as listener, zmq.Context() as context:
        sockets = [context.socket(zmq.DEALER) for _ in range(5)]
        for socket in sockets:
            socket.setsockopt(zmq.LINGER, 0)
            socket.connect(listener.address)
        number, turns, silent = dict.fromkeys(range(5), 0), [], None

        def ask(which):
            number[which] += 1
            # Each has a size of its own, by which it is known here.
            request = attrs.evolve(ASK, number=number[which], size=(4 + which, 3), received=0, token=bytes(32))
            sockets[which].send(encode(request))

        def turn():
            which = next_asked(listener).ask.size[0] - 4
            clock[0] += 10_000_000 if which == 4 else 60_000_000
            turns.append(which)
            if which != silent:
                ask(which)
                assert listener._socket.poll(WHENEVER_MS)  # it is there in time

        for which in number:
            ask(which)
        while {*turns} != {*number}:  # until the connection of each is there
            turn()
        turns.clear()
        for _ in range(24):
            turn()
        # Six for one of each other in turn: 14 or 15 of 24; of five if turns only went round.
        assert 12 <= turns.count(4) <= 16 and {*turns} == {*number}
        silent = 0
        for _ in range(48):
            turn()
        silent = None
        ask(0)
        while turns[-1] != 0:
            turn()
        for _ in range(10):
            turn()
        assert turns[-10:].count(0) <= 2  # silence has saved it no turns
        for socket in sockets:
            socket.close()
