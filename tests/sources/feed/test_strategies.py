"""Every strategy as two processes: `hmdwarp serve` draws, and a client here shows. Each is compared
with a replay whose frames are as old: the same instants, and the delays that were measured. Without
a codec the pictures are equal to the last bit, and so are the bytes by layer."""

from __future__ import annotations

import itertools
import time
from contextlib import ExitStack, closing

import attrs
import numpy as np
import pytest
from eyes import with_eyes
from replays import CHEAPER, of_strategy, scene_for, set_up, small
from serving import Serving, free_port

from hmdwarp.client.strategies import strategies
from hmdwarp.gpu import download
from hmdwarp.metrics import psnr
from hmdwarp.pipeline.remote import Remote
from hmdwarp.poses import PoseTrack, synthesise, write_synthetic
from hmdwarp.poses.formats import write_native
from hmdwarp.scenes import load_scene
from hmdwarp.sources.feed import FeedOptions
from hmdwarp.sources.feed.caller import Caller
from hmdwarp.sources.server import Server

pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")

RATE_HZ = 20.0
# A proxy is a process of its own, below.
NAMES = [name for name in strategies.names() if name != "proxy"]
TRIED = {
    **{name: CHEAPER.get(name, name) for name in NAMES},
    "difference": "difference:share=1,texture=0.25",
    "irradiance": "irradiance:updates=5",
    "in pieces": "model:arrives=progressive,budget=4000",
    "points": "points:budget=6000,room=4096,spacing=2",
}


def ready(gpu, strategy: str, network=None, **more):
    """Set a run of a strategy up."""
    return set_up(gpu, of_strategy(strategy, network or {}, **{"rate_hz": RATE_HZ} | more))


def patient(remote: Remote, now_ns: int) -> None:
    """Ask only when what was asked last is answered, so that a busy machine skips nothing. Answers
    to what was asked before the session, while the latency was measured, are none."""
    caller, newest, until_ns = remote._caller, max(remote._pending, default=0), time.monotonic_ns() + 600_000_000_000
    while newest and newest not in {*caller._unchanged, *(each.frame.number for each in list(caller._arrived))}:
        assert time.monotonic_ns() < until_ns, "no answer"
        time.sleep(0.001)


def flown(setup, instants) -> tuple[dict, dict]:
    """Return what was shown at each instant, frame by frame, and the summary of the link."""
    found = {}
    for number, instant_ns in instants:
        setup.loop.draw(instant_ns)
        refresh = setup.loop.show(instant_ns)
        if refresh is not None and number >= 0:
            drawn = refresh.frame.drawn_ns, *(eye.view.gaze for eye in refresh.frame.eyes)
            found[instant_ns] = drawn, [download(eye.shown.texture) for eye in refresh.eyes]
    return found, setup.channel.summary(RATE_HZ)


def compared(gpu, address: str, strategy: str, scene: str, network=None, *, monkeypatch, feed=None, equal=1.0, **more):
    """Run a strategy over the feed, and again here at the same ages; return both summaries. equal:
    the share of numbers, at least, that is the same to the last bit."""
    with monkeypatch.context() as patched:
        patched.setattr(Remote, "pace", patient)
        options = {"feed": FeedOptions(connect=address, **feed or {}), "network": network}
        with ready(gpu, strategy, scene=scene, **options, **more) as setup:
            instants, age_ns = list(setup.schedule.numbered()), setup.requested.age_ns
            there, _ = flown(setup, instants)
            patient(setup.source.remote, 0)
            setup.channel.newest(instants[-1][1])  # the last frame is counted as well
            told = setup.channel.summary(RATE_HZ)
            delays, latency_ms = [delay for _, delay in setup.source.remote.delays_ns], setup.options.latency_ms
    assert told["feed"]["malformed"] == told["feed"]["undecodable"] == 0, told
    with ready(gpu, strategy, scene=scene, latency_ms=latency_ms, network=network, **more) as setup:
        setup.requested.age_ns = age_ns
        setup.channel.link.delay_by(iter(delays))
        here, alone = flown(setup, instants)
    assert len(there) >= 3 and there.keys() == here.keys()
    for instant_ns, (drawn, eyes) in there.items():
        assert drawn == here[instant_ns][0]
        for ours, theirs in zip(eyes, here[instant_ns][1], strict=True):
            if equal < 1:
                assert np.mean(ours == theirs) >= equal
                continue
            np.testing.assert_array_equal(ours, theirs, err_msg=f"{strategy} at {instant_ns}")
    return told, alone


@pytest.fixture
def looking_around(tmp_path) -> str:
    """Return a recording with made-up eyes, which leap and pursue within its first two seconds."""
    with (tmp_path / "looking.csv").open("w", encoding="utf-8") as file:
        write_synthetic(with_eyes(synthesise("look-around", seconds=2)), file)
    return str(tmp_path / "looking.csv")


def test_coded_frames_with_their_gaze_are_their_replay_bit_for_bit(gpu, serving_of, monkeypatch, looking_around):
    network = {"codec": "h264", "depth_code": "exact"}
    how = {"warp": "iterative", "trace": looking_around}
    told, _ = compared(gpu, serving_of("planes"), "", "planes", network, monkeypatch=monkeypatch, **how)
    assert told["codec"] == "h264"


@pytest.mark.parametrize("fill", ["none", "memory+pyramid"])  # read on its grid, and expanded first
def test_foveated_frames_are_their_replay_bit_for_bit(gpu, serving_of, monkeypatch, looking_around, fill):
    warp = "rotation" if fill == "none" else "iterative"
    how = {"trace": looking_around, "fovea_deg": 30.0, "warp": warp, "fill": fill}
    told, alone = compared(gpu, serving_of("planes"), "", "planes", monkeypatch=monkeypatch, **how)
    pictures = told["layers_mbit_s"]["colour"] + told["layers_mbit_s"].get("inverse_depth", 0)
    # The same numbers cross under other names, and a row of seven for each eye.
    foveated = alone["layers_mbit_s"]
    assert pictures == pytest.approx(foveated["foveated"] + foveated.get("foveated_depth", 0), rel=0.02)


# Half of the delays are beyond the time between two frames, so frames overtake each other; of seed
# 4 a fifth is lost, and a bottleneck drops more of those that carry pictures.
EMULATED = {"jitter": "uniform:90", "loss": "0.2", "bandwidth": "12", "queue": 20.0, "link_seed": 4}


@pytest.mark.parametrize("name", TRIED)
def test_it_is_its_replay_bit_for_bit_and_nothing_else_crosses(gpu, serving_of, monkeypatch, name):
    """Over an emulated network behind the real one, with loss and reorder: what was lost comes
    again, and what is late overwrites nothing newer."""
    scene = scene_for(TRIED[name])
    feed = {"added_latency_ms": 100.0}
    told, alone = compared(gpu, serving_of(scene), TRIED[name], scene, EMULATED, monkeypatch=monkeypatch, feed=feed)
    for fate in ("drawn", "lost", "dropped", "shown", "late", "superseded", "unchanged"):
        assert told["frames"][fate] == alone["frames"][fate], fate
    if name != "views":  # which sends few
        assert told["frames"]["lost"] + told["frames"]["dropped"] > 0
    crossed, counted = ({k: v for k, v in one["layers_mbit_s"].items() if v} for one in (told, alone))
    assert crossed.keys() == counted.keys()
    # Beside its pictures a layer may have numbers: of bodies, mirrors and views.
    assert crossed == pytest.approx(counted, rel=0.02)


def unhurried(remote: Remote, now_ns: int) -> None:
    """Ask ten times a second, whether or not there is an answer."""
    remote._caller.wait_until(time.monotonic_ns() + 100_000_000)


def test_a_frame_of_a_video_enters_the_link_with_its_instant_its_bytes_and_whether_it_stands_alone(
    gpu, serving_of, monkeypatch
):
    """After a loss a frame is asked for that does."""
    monkeypatch.setattr(Remote, "pace", patient)
    feed = FeedOptions(connect=serving_of("planes"), added_latency_ms=50.0)
    network = {"codec": "h264", "loss": "0.3", "link_seed": 4}
    with ready(gpu, "imposter", scene="planes", feed=feed, network=network, seconds=1.0) as setup:
        remote, link, came, sent = setup.source.remote, setup.channel.link, [], []
        arrived, send = remote.arrived, link.send

        def arriving(now_ns):
            came.extend(found := arrived(now_ns))
            return found

        def sending(frame, now_ns, size_bytes, key):
            sent.append((now_ns, size_bytes, key))
            return send(frame, now_ns, size_bytes, key)

        monkeypatch.setattr(remote, "arrived", arriving)
        monkeypatch.setattr(link, "send", sending)
        _, told = flown(setup, setup.schedule.numbered())
    frames = [(one.drawn_ns, one.message) for one in came]
    assert sent == [(at_ns, sum(map(len, frame.colours)), frame.begins) for at_ns, frame in frames]
    assert {key for *_, key in sent[1:]} == {True, False} and told["frames"]["lost"] > 0


@pytest.mark.parametrize("name", ["in pieces", "photons"])
def test_a_server_that_was_started_again_begins_anew_and_so_does_the_client(gpu, monkeypatch, name):
    """From its first frame on all is as for a client that comes then: nothing of before is left."""
    scene, where = scene_for(TRIED[name]), f"127.0.0.1:{free_port()}"
    command = ("--scene", scene, "--listen", where)
    monkeypatch.setattr(Remote, "pace", patient)
    with ExitStack() as stack:
        with Serving(*command):
            feed = FeedOptions(connect=where)
            setup = stack.enter_context(ready(gpu, TRIED[name], scene=scene, seconds=600.0, feed=feed))
            remote, numbered = setup.source.remote, setup.schedule.numbered()
            _, instant_ns = flown(setup, itertools.islice(numbered, 12)), next(numbered)[1]
            patient(remote, 0)
            setup.channel.newest(instant_ns)
        with Serving(*command) as again:
            monkeypatch.setattr(Remote, "pace", unhurried)
            before = len(remote.delays_ns)
            while len(remote.delays_ns) == before:
                assert again.process.poll() is None
                flown(setup, itertools.islice(numbered, 1))
            first_ns = remote.delays_ns[before][0]
            monkeypatch.setattr(Remote, "pace", patient)
            instants, latency_ms = list(itertools.islice(numbered, 12)), setup.options.latency_ms
            there, _ = flown(setup, instants)
            patient(remote, 0)
            setup.channel.newest(instants[-1][1])
            delays = dict(remote.delays_ns)
    with ready(gpu, TRIED[name], scene=scene, seconds=600.0, latency_ms=latency_ms) as setup:
        drawn = [ns for ns in sorted(delays) if ns >= first_ns]
        setup.channel.link.delay_by(iter([delays[ns] for ns in drawn]))
        here, _ = flown(setup, [(0, ns) for ns in drawn])
    again = {ns: eyes for ns, ((drawn_ns, *_), eyes) in there.items() if drawn_ns >= first_ns}
    assert len(again) > 3 and again.keys() <= here.keys()
    for instant_ns, eyes in again.items():
        for ours, theirs in zip(eyes, here[instant_ns][1], strict=True):
            np.testing.assert_array_equal(ours, theirs)


def test_frames_that_are_of_no_use_are_told_and_what_they_brought_comes_again(gpu, serving_of, monkeypatch):
    """In the end the picture is that of the whole scene, as for a client that lost nothing."""
    monkeypatch.setattr(Remote, "pace", patient)
    take, count, found = Caller.take, itertools.count(), []

    def spoilt(caller) -> list:
        """Return what has arrived, of every third frame another size than was asked for."""
        return [
            attrs.evolve(one, frame=attrs.evolve(one.frame, coded_size=(2, 2))) if next(count) % 3 == 2 else one
            for one in take(caller)
        ]

    for loses in (False, True):
        if loses:
            monkeypatch.setattr(Caller, "take", spoilt)
        feed = FeedOptions(connect=serving_of("planes"))
        with ready(gpu, "model:arrives=progressive", seconds=4.0, feed=feed) as setup:
            shown, told = flown(setup, setup.schedule.numbered())
            assert (told["feed"]["malformed"] > 5) == loses
            (weight,) = setup.geometry.weights()
            assert weight["arrived"] == weight["things"]
            found.append(shown[max(shown)][1])
    here, there = found
    for ours, theirs in zip(here, there, strict=True):
        np.testing.assert_array_equal(ours, theirs)


ACTED = {"input": "seed:2", "start_s": 0.5}


def test_what_people_do_crosses_and_each_client_has_a_world_of_its_own(gpu, serving_of, monkeypatch):
    """Another client of the same server acts otherwise, in between and at the same instants."""
    address = serving_of("playroom")
    with ready(gpu, "imposter", scene="playroom", feed=FeedOptions(connect=address), input="seed:9") as other:
        other.loop.draw(other.schedule.first_ns)
        with monkeypatch.context() as patched:
            original, others = Remote.ask, other.source.remote

            def beside(remote, head, views, guard, size, now_ns, needs=None):
                if remote is not others:
                    other.loop.draw(now_ns)
                    patient(others, now_ns)
                original(remote, head, views, guard, size, now_ns, needs)

            patched.setattr(Remote, "ask", beside)
            told, _ = compared(gpu, address, "imposter", "playroom", monkeypatch=monkeypatch, **ACTED)
    assert told["frames"]["shown"] > 0


def proxy(*options: str) -> Serving:
    """`hmdwarp proxy` in a process of its own, at a port that was free."""
    return Serving(*options, command="proxy")


def test_a_client_without_depth_gets_the_picture_for_its_head_and_its_delay_has_the_warp(gpu, monkeypatch):
    monkeypatch.setattr(Remote, "pace", patient)
    with Serving("--samples", "1") as server, proxy("--connect", server.address) as between:
        options = small(feed=FeedOptions(connect=between.address), warp="none", rate_hz=10.0, seconds=1.0, samples=1)
        shown, took_ms = [], []
        with set_up(gpu, options) as setup:
            for _, instant_ns in setup.schedule.numbered():
                setup.loop.draw(instant_ns)
                if (refresh := setup.loop.show(instant_ns)) is not None:
                    eye = refresh.frame.eyes[0]
                    shown.append((eye.view, refresh.frame.drawn_ns, download(eye.colour)[..., :3]))
                    took_ms.append((refresh.response.render_ms, refresh.transit.ready_ns - refresh.transit.sent_ns))
            told, latency_ms = setup.channel.summary(10.0), setup.options.latency_ms
        # What was measured and what ran are two sessions of the client, and one of the proxy.
        assert sum("connected:" in line for line in list(server.lines.queue)) == 1
    assert [*told["layers_mbit_s"]] == ["colour"] and told["feed"]["malformed"] == 0
    # Warping is the proxy's drawing, and part of what was measured.
    assert all(0 < render_ms <= ready_ns / 1e6 for render_ms, ready_ns in took_ms) and latency_ms > 0
    view, drawn_ns, last = shown[-1]
    with closing(Server(gpu, load_scene("planes"))) as server:
        truth = download(server.draw(view, last.shape[1::-1], time_ns=drawn_ns).colour)[..., :3]
    # Resampled and coded, but in its place: nearer to the truth than that is, moved by a pixel.
    last, truth = (np.clip(one, 0, 1).astype(np.float64) for one in (last, truth))
    assert psnr(last, truth) > psnr(np.roll(truth, 1, axis=1), truth)


OFF_MS = 600  # the lamp goes off
AS_IT_IS = ("--codec", "none", "--warp", "none", "--fill", "none", "--proxy-guard", "1")


@pytest.fixture(scope="module")
def between(serving_of):
    """The address of a proxy in front of a playroom."""
    with proxy("--connect", serving_of("playroom"), *AS_IT_IS) as found:
        yield found.address


def acting(gpu, tmp_path, where: str):
    """A client of a proxy for a playroom whose lamp somebody switches; its head is still."""
    acts, head = tmp_path / "acts.csv", tmp_path / "still.csv"
    acts.write_text(f"time_ns,action,target,x,y,z,dx,dy,dz\n{OFF_MS}000000,switch,lamp,0,0,0,0,0,1\n")
    with head.open("w") as file:
        ends, still = np.array([0, 60_000_000_000]), ([[0.1, 1.6, 0.2]] * 2, [[0.0, 0.0, 0.0, 1.0]] * 2)
        write_native(PoseTrack(ends, *map(np.array, still)), file)
    options = {"scene": "playroom", "warp": "none", "size": (48, 40), "rate_hz": 20.0, "trace": str(head)}
    options |= {"input": str(acts), "start_s": 0.5, "seconds": 60.0, "feed": FeedOptions(connect=where)}
    return set_up(gpu, small(**options))


def shown_until(setup, numbered, last_ms: float, since_ns: int = 0) -> dict[int, np.ndarray]:
    """Return what is shown until an instant of the scene is, by its instant: as here, bit for bit.
    since_ns: when the oldest of these pictures was asked for."""
    found: dict[int, np.ndarray] = {}
    while max(found, default=-1) < last_ms * 1_000_000:
        _, instant_ns = next(numbered)
        setup.loop.draw(instant_ns)
        if (refresh := setup.loop.show(instant_ns)) is not None and refresh.frame.drawn_ns >= since_ns:
            at_ns = refresh.frame.shows_ns
            assert at_ns <= refresh.frame.drawn_ns
            found[at_ns], truth = pictures(setup, refresh.frame)
            np.testing.assert_array_equal(found[at_ns], truth, err_msg=str(at_ns))
    return found


def pictures(setup, frame) -> tuple[np.ndarray, np.ndarray]:
    """Return the left eye's colour, and as the scene here has it at the instant that it shows."""
    eye = frame.eyes[0]
    truth = setup.server.draw(eye.view, eye.size, time_ns=frame.shows_ns)
    return download(eye.colour), download(truth.colour)


@pytest.mark.parametrize("again", ["server", "proxy"])
def test_what_people_do_crosses_a_proxy_also_to_one_that_was_started_again(
    gpu, tmp_path, monkeypatch, serving_of, again
):
    """Every picture is that of the scene here, with the inputs, at the instant that it names."""
    monkeypatch.setattr(Remote, "pace", patient)
    where = {name: f"127.0.0.1:{free_port()}" for name in ("server", "proxy")}
    if again == "proxy":
        where["server"] = serving_of("playroom")
    started = {
        "server": lambda: Serving("--scene", "playroom", "--listen", where["server"]),
        "proxy": lambda: proxy("--connect", where["server"], "--listen", where["proxy"], *AS_IT_IS),
    }
    with ExitStack() as stack:
        running = {name: stack.enter_context(ExitStack()) for name in started}
        for name in sorted({"proxy", again}, reverse=True):
            running[name].enter_context(started[name]())
        setup = stack.enter_context(acting(gpu, tmp_path, where["proxy"]))
        numbered = setup.schedule.numbered()
        lit, dark = (shown_until(setup, numbered, at_ms) for at_ms in (0, OFF_MS))
        assert dark[max(dark)].mean() < lit[max(lit)].mean()
        began, remote = setup.source.remote._began, setup.source.remote
        running[again].close()
        running[again].enter_context(started[again]())
        monkeypatch.setattr(Remote, "pace", unhurried)
        known, told_ns = again != "proxy", 0
        while not known:  # what another one shows first knows of nothing
            _, instant_ns = next(numbered)
            setup.loop.draw(instant_ns)
            told_ns = instant_ns if remote._began == began else told_ns
            frame = setup.loop.show(instant_ns).frame
            known = frame.drawn_ns > told_ns and np.array_equal(*pictures(setup, frame))
        shown_until(setup, numbered, max(dark) / 1_000_000 + 1)


def test_what_the_server_refuses_the_proxy_refuses(gpu, tmp_path, between):
    with acting(gpu, tmp_path, between) as setup:
        remote, said = setup.source.remote, []
        remote._acted[:] = [attrs.evolve(remote._acted[0], target="window")]
        remote._say, numbered = said.append, setup.schedule.numbered()
        while not any("thing that reacts 'window'" in line for line in said):
            _, instant_ns = next(numbered)
            setup.loop.draw(instant_ns)
            setup.loop.show(instant_ns)
        assert all("refused" in line for line in said)
