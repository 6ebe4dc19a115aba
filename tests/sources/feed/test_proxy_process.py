"""Three processes: a server, `hmdwarp proxy`, and a client that only shows what it gets."""

from contextlib import ExitStack, closing, contextmanager, nullcontext
from unittest.mock import patch

import attrs
import numpy as np
import pytest
from replays import small
from serving import Serving, free_port

from hmdwarp.gpu import download
from hmdwarp.metrics import psnr
from hmdwarp.pipeline.remote import Remote
from hmdwarp.poses import PoseTrack
from hmdwarp.poses.writing import write_native
from hmdwarp.run import set_up_replay
from hmdwarp.scenes import load_scene
from hmdwarp.sources.feed import FeedOptions
from hmdwarp.sources.server import Server

from .test_strategies import patient, unhurried

pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")


def proxy(*options: str) -> Serving:
    """`hmdwarp proxy` in a process of its own, at a port that was free."""
    return Serving(*options, command="proxy")


def test_a_client_without_depth_gets_the_picture_for_its_head_and_its_delay_has_the_warp(gpu, monkeypatch):
    monkeypatch.setattr(Remote, "pace", patient)
    with Serving("--samples", "1") as server, proxy("--connect", server.address) as between:
        options = small(feed=FeedOptions(connect=between.address), warp="none", rate_hz=10.0, seconds=1.0, samples=1)
        shown, took_ms = [], []
        with (
            patch("hmdwarp.run.run.Gpu", lambda: nullcontext(gpu)),
            set_up_replay(options, alone=True) as setup,
        ):
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
def between():
    """The address of a proxy in front of a playroom."""
    with Serving("--scene", "playroom") as server, proxy("--connect", server.address, *AS_IT_IS) as found:
        yield found.address


@contextmanager
def acting(gpu, tmp_path, where: str):
    """A client of a proxy for a playroom whose lamp somebody switches; its head is still."""
    acts, head = tmp_path / "acts.csv", tmp_path / "still.csv"
    acts.write_text(f"time_ns,action,target,x,y,z,dx,dy,dz\n{OFF_MS}000000,switch,lamp,0,0,0,0,0,1\n")
    with head.open("w") as file:
        ends, still = np.array([0, 60_000_000_000]), ([[0.1, 1.6, 0.2]] * 2, [[0.0, 0.0, 0.0, 1.0]] * 2)
        write_native(PoseTrack(ends, *map(np.array, still)), file)
    options = {"scene": "playroom", "warp": "none", "size": (48, 40), "rate_hz": 20.0, "trace": str(head)}
    options |= {"input": str(acts), "start_s": 0.5, "seconds": 60.0, "feed": FeedOptions(connect=where)}
    with (
        patch("hmdwarp.run.run.Gpu", lambda: nullcontext(gpu)),
        set_up_replay(small(**options), alone=True) as setup,
    ):
        yield setup


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
def test_what_people_do_crosses_a_proxy_also_to_one_that_was_started_again(gpu, tmp_path, monkeypatch, again):
    """Every picture is that of the scene here, with the inputs, at the instant that it names."""
    monkeypatch.setattr(Remote, "pace", patient)
    where = {name: f"127.0.0.1:{free_port()}" for name in ("server", "proxy")}
    started = {
        "server": lambda: Serving("--scene", "playroom", "--listen", where["server"]),
        "proxy": lambda: proxy("--connect", where["server"], "--listen", where["proxy"], *AS_IT_IS),
    }
    with ExitStack() as stack:
        running = {name: stack.enter_context(ExitStack()) for name in started}
        for name, start in started.items():
            running[name].enter_context(start())
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
