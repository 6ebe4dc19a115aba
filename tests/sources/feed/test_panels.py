"""Panels between processes: pictures cross when asked for, once; what is none is refused."""

from __future__ import annotations

import re
import struct

import numpy as np
import pytest
from client_scene import ClientScene
from replays import small
from serving import Serving

from hmdwarp.client.effect_passes.panels_pass import KeptPanels
from hmdwarp.frames import EyeImage, Needs
from hmdwarp.frames.layers import bytes_of_part, part_of_bytes
from hmdwarp.frames.layers.panels import PICTURES, SHOWING, PanelDelivery, PanelRequests, Panels, things_of
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import COLOUR, allocate
from hmdwarp.pipeline.feed_layers import made, needs_of_client, parts_of, wanted_of
from hmdwarp.scenes import Panel, Scene, load_scene
from hmdwarp.sources.feed.options import FeedOptions
from hmdwarp.sources.server import Server

VIEWS = [View(Pose((x, 1.6, 0.0)), Fov.symmetric(1.0, 0.8)) for x in (-0.03, 0.03)]
SIZE, SECOND = (24, 20), 1_000_000_000
NEEDS = Needs(panels=frozenset({PanelDelivery()}))


@pytest.fixture
def server(gpu):
    pages = [np.random.default_rng(seed).integers(0, 256, (30, 40, 4), dtype=np.uint8) for seed in range(2)]
    scene = Scene("pages", "", (), panels=[Panel(pages, Pose((-0.2, 1.6, -1.0)), (0.3, 0.2), occluded=True)])
    one = Server(gpu, scene)
    yield one
    one.close()


def answered(server, number, time_ns):
    """The parts of both eyes that a server sends to a request."""
    wanted = wanted_of(NEEDS, VIEWS, SIZE, {"panels": number})
    needs = needs_of_client(wanted)
    frame = server.draw_guarded(VIEWS, time_ns, SIZE, needs, wanted.fovs, SIZE)
    parts = [parts_of(eye, needs, packs=False, is_first=eye is frame.eyes[0]) for eye in frame.eyes]
    server.recycle(frame)
    assert [Panels.misfit(of_eye["panels"], None) for of_eye in parts] == ["", ""]
    return wanted, parts


def test_pictures_are_asked_for_until_they_have_come_and_when_another_is_shown(gpu, server):
    client, requests = ClientScene(gpu, server.scene), PanelRequests()
    kept = client.store(KeptPanels, PanelDelivery())
    asked, held = [], []
    # Request 1 has no answer; 2 is sent while it is on its way.
    for number, time_ns, pending in (
        (1, 0, {1}),
        (2, 0, {1, 2}),
        (3, 0, {3}),
        (4, 0, {4}),
        (5, SECOND, {5}),
        (6, SECOND, {6}),
        (7, 2 * SECOND, {7}),
    ):
        asked.append(requests.number(number, pending - {number}))
        if number == 1:
            continue
        wanted, parts = answered(server, asked[-1], time_ns)
        requests.take(parts[0]["panels"][0])
        data = made(server, parts[0], wanted)
        empty = allocate(gpu.gl, (1, 1), COLOUR)
        client.receive(type("Arrived", (), {"drawn_ns": time_ns, "eyes": [EyeImage(VIEWS[0], empty, empty, data)]}))
        held.append(kept.held[0].texture if kept.held else None)
    assert asked == [PICTURES, SHOWING, PICTURES, SHOWING, SHOWING, PICTURES, SHOWING]
    # The first page stays until the other has come, and is still there when it is shown again.
    assert held[0] is None and held[1] is not None
    assert held[1] is held[2] is held[3]
    assert held[4] not in (None, held[1])
    assert held[5] is held[1]
    assert kept.held[0].panel.occluded
    client.close()


def test_both_eyes_share_the_bytes(server):
    _, parts = answered(server, PICTURES, 0)
    assert parts[0]["panels"][0].nbytes > 30 * 40 * 4
    assert len(bytes_of_part(parts[1]["panels"][0])) == 0


@pytest.mark.parametrize("count", [0, 1, 2, 7, 8191, 8192, 20_001])
def test_bytes_come_back_from_a_picture_of_numbers(count):
    content = np.random.default_rng(count).integers(0, 256, count, dtype=np.uint8)
    part = part_of_bytes(content)
    assert max(part.shape) <= 8192
    assert np.array_equal(bytes_of_part(part), content)


def _change(at, to):
    def changed(content):
        content = content.copy()
        content[at : at + len(to)] = list(to)
        return content

    return changed


HEAD = 8 + 2 + 2  # before the first thing
THING = HEAD + 14
PLACE = THING + 9 * 8


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda content: content[:5], "cannot be read"),
        (lambda content: content[:-700], "cannot be read"),
        (_change(8, struct.pack("<H", 9)), "cannot be read"),
        (_change(10, struct.pack("<H", 7)), "panels that show pictures"),
        (_change(HEAD + 8, struct.pack("<I", 2)), "a part of a picture"),
        (_change(THING, struct.pack("<d", float("nan"))), "cannot be read"),
        (_change(THING + 7 * 8, struct.pack("<d", -1.0)), "a panel is -1 x"),
        (_change(PLACE + 4 + 14, b"JUNK"), "cannot be read"),
        (_change(PLACE + 4 + 14 + 60, bytes(400)), "cannot be read"),
    ],
)
def test_what_is_no_panel_is_refused_in_one_line(server, change, message):
    _, parts = answered(server, PICTURES, 0)
    content = bytes_of_part(parts[0]["panels"][0])
    wrong = Panels.misfit([part_of_bytes(change(content))], None)
    assert "\n" not in wrong
    assert re.search(message, wrong), wrong


def test_another_number_of_parts_or_kind_is_refused():
    assert "expected one" in Panels.misfit([], None)
    assert "expected a picture of u16" in Panels.misfit([np.zeros((2, 2), np.float32)], None)
    with pytest.raises(Exception, match="there is no 3 of layer 'panels'"):
        needs_of_client(wanted_of(NEEDS, VIEWS, SIZE, {"panels": 3}))


def test_a_page_crosses_a_network_once_and_stays_sharp(tmp_path, monkeypatch):
    pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")
    from .test_serve import pictures

    asked = {
        "scene": "reading",
        "rate_hz": 10.0,
        "trace": "still",
        "seconds": 0.6,
        "effects": "panels,no-occluded_panels",
    }
    with Serving("--scene", "reading") as serving:
        options = small(tmp_path / "out", feed=FeedOptions(connect=serving.address), **asked)
        shown, summary = pictures(monkeypatch, options)
    assert summary["effects"] == ["panels"]
    page, _ = (panel.pictures[0] for panel in load_scene("reading").panels)
    sent = summary["link"]["layers_mbit_s"]["panels"] * 1e6 / 8 * 0.6
    once = sum(map(len, things_of(load_scene("reading").panels)))
    assert 0 < sent < once  # of two pages and two labels the first
    last = shown[max(shown)][1][0][..., :3]
    assert (last > 0.7).all(axis=2).mean() > 0.02  # paper: nothing else of the scene is so bright
    assert page.image.min() < 50
