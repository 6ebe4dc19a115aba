"""`hmdwarp live --connect`: the live loop with frames from another process."""

import attrs
import numpy as np
import pytest
from replays import rows_of
from run.offscreen import OffscreenDisplay, run_on
from serving import Serving

from hmdwarp.display import Closed, Command
from hmdwarp.errors import InputError
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.pipeline.remote import is_another_view
from hmdwarp.run import LiveOptions, live

from .exchange import feeder

pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")


class Closable(OffscreenDisplay):
    """A display whose user closes it in the middle of a run."""

    def ask_to_close(self) -> None:
        if not any(isinstance(event, Closed) for event in self._events.values()):
            self._events[self._number + 3] = Closed("the window was closed")


def options(address: str, **more) -> LiveOptions:
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
    asked = options(serving_of("planes"), pictures=12, latency=900.0, out=tmp_path / "out")
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
    named = options(serving_of("planes"), pictures=6, scene="planes", warp="model")
    summary = run_on(monkeypatch, display, named).summary
    assert any("scene 'planes' on both ends" in line for line in display.said)
    assert summary["scene"] == "planes" and summary["link"]["feed"]["malformed"] == 0
    assert display.pictures[-1].std() > 10


def test_a_warp_whose_layer_the_server_lacks_is_reported_and_can_be_left(monkeypatch):
    changes = {4: [Command("warp", "layered")], 8: [Command("warp", "forward")]}
    display = OffscreenDisplay(asked=changes, keeps=True)
    with feeder() as address:
        summary = run_on(monkeypatch, display, options(address, pictures=16, effects="none")).summary
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
        summary = run_on(monkeypatch, display, options(address, pictures=6, guard="1")).summary
    assert sum("other views than it is asked for" in line for line in display.said) == 1
    assert summary["link"]["feed"]["draws_others"]


@pytest.mark.parametrize(
    ("moved_m", "turned_deg", "grown", "is_other"),
    [(0, 0, 0, False), (1e-7, 1e-5, 1e-8, False), (0, 0, 0.1, False), (0, 0, -1e-5, True), (1e-4, 0, 0, True)]
    + [(0, 0.01, 0, True)],
)
def test_another_view_is_told_from_rounding_and_from_one_that_shows_more(moved_m, turned_deg, grown, is_other):
    asked = View(Pose((1, 2, 3)), Fov(-0.6, 0.7, -0.5, 0.8))
    for wider in np.eye(4) * (-grown, grown, -grown, grown):
        turn = np.radians(turned_deg) / 2
        pose = asked.pose @ Pose((0, moved_m, 0), (0, np.sin(turn), 0, np.cos(turn)))
        assert is_another_view(asked, View(pose, Fov.from_tangents(asked.fov.tangents + wider))) == is_other


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
        summary = run_on(monkeypatch, display, options(servers[0].address, out=tmp_path / "out"), after=look).summary
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
        live(options(more.pop("connect", "127.0.0.1:1"), **more))
