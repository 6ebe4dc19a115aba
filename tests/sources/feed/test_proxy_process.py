"""Three processes: a server, `hmdwarp proxy`, and a client that only shows what it gets."""

import subprocess
import sys
from contextlib import closing, nullcontext
from unittest.mock import patch

import numpy as np
import pytest
from replays import small
from serving import Serving

from hmdwarp.gpu import download
from hmdwarp.metrics import psnr_db
from hmdwarp.pipeline.remote import Remote
from hmdwarp.run import set_up_replay
from hmdwarp.scenes import load_scene
from hmdwarp.sources.feed.options import FeedOptions
from hmdwarp.sources.server import Server

from .test_strategies import patient

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
            patch("hmdwarp.run.replay_setup.Gpu", lambda: nullcontext(gpu)),
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
        assert sum("here" in line for line in list(server.lines.queue)) == 1
    assert [*told["layers_mbit_s"]] == ["colour"] and told["feed"]["malformed"] == 0
    # Warping is the proxy's drawing, and part of what was measured.
    assert all(0 < render_ms <= ready_ns / 1e6 for render_ms, ready_ns in took_ms) and latency_ms > 0
    view, drawn_ns, last = shown[-1]
    with closing(Server(gpu, load_scene("planes"))) as server:
        truth = download(server.draw(view, last.shape[1::-1], time_ns=drawn_ns).colour)[..., :3]
    # Resampled and coded, but in its place: nearer to the truth than that is, moved by a pixel.
    last, truth = (np.clip(one, 0, 1).astype(np.float64) for one in (last, truth))
    assert psnr_db(last, truth) > psnr_db(np.roll(truth, 1, axis=1), truth)


def test_a_proxy_without_a_server_is_refused_in_a_line():
    done = subprocess.run(
        [sys.executable, "-m", "hmdwarp", "proxy", "--listen", "127.0.0.1:*"],
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 2 and "name the one to warp for by --connect" in done.stderr
