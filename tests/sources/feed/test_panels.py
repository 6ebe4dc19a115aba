"""Panels between processes: pictures cross once; what is none is refused."""

from __future__ import annotations

import contextlib
import re
import struct

import numpy as np
import pytest
from client_scene import ClientScene
from replays import small
from serving import Serving

from hmdwarp.client.effects.text import KeptPanels
from hmdwarp.errors import InputError
from hmdwarp.frames import Frame, Needs
from hmdwarp.frames.layers.panels import PanelDelivery, Panels, things_of
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.pipeline.feed_layers import made, needs_of_client, parts_of, wanted_of
from hmdwarp.scenes import Panel, Scene, load_scene
from hmdwarp.sources.feed import FeedOptions
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


def answered(server, time_ns, arrived=True):
    """The eyes that a client makes of a frame, and the bytes of its panels."""
    wanted = wanted_of(NEEDS, VIEWS, SIZE)
    needs = needs_of_client(wanted)
    frame = server.draw_guarded(VIEWS, time_ns, SIZE, needs, wanted.fovs, SIZE)
    parts = parts_of(frame, needs, packs=False)
    (content,) = parts[0]["panels"]
    assert parts[1] == {}, "both eyes share it"
    assert Panels.misfit([content], None) == ""
    eyes = made(server, frame.eyes, parts, wanted)
    server.heard(frame, arrived, time_ns + 1)
    return Frame(tuple(eyes), time_ns), content.ravel()


def test_pictures_come_once_and_again_only_where_they_were_lost(gpu, server):
    client = ClientScene(gpu, server.scene)
    kept = client.store(KeptPanels, PanelDelivery())
    held, sizes = [], []
    for index, (time_ns, arrived) in enumerate(((0, False), (0, True), (0, True), (SECOND, True), (2 * SECOND, True))):
        frame, content = answered(server, time_ns + index, arrived)
        sizes.append(len(content))
        if arrived:
            client.receive(frame)
        held.append(kept.held[0].texture if kept.held else None)
    # The first page stays until the other has come, and is still there when it is shown again.
    assert held[0] is None and held[1] is not None
    assert held[1] is held[2] is held[4]
    assert held[3] not in (None, held[1])
    assert min(sizes[0], sizes[1], sizes[3]) > 30 * 40 * 3 > 12 == sizes[2] == sizes[4]
    assert kept.held[0].panel.occluded
    client.close()


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
        (_change(THING, struct.pack("<d", float("nan"))), "cannot be read"),
        (_change(THING + 7 * 8, struct.pack("<d", -1.0)), "a panel is -1 x"),
        (_change(PLACE + 4 + 14, b"JUNK"), "cannot be read"),
        (_change(PLACE + 4 + 14 + 60, bytes(400)), "cannot be read"),
    ],
)
def test_what_is_no_panel_is_refused_in_one_line(gpu, server, change, message):
    """Also by the client's store, which alone sees pictures that come in several frames."""
    _, content = answered(server, 0)
    wrong = Panels.misfit([change(content)[None]], None)
    assert "\n" not in wrong
    assert re.search(message, wrong), wrong
    client = ClientScene(gpu, server.scene)
    with contextlib.suppress(InputError):
        client.store(KeptPanels, PanelDelivery()).receive(change(content))
    client.close()


def test_a_page_crosses_a_network_once_and_stays_sharp(tmp_path, monkeypatch):
    pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")
    from .test_serve import pictures

    asked = {
        "scene": "reading",
        "rate_hz": 10.0,
        "trace": "still",
        "seconds": 1.5,
        "effects": "panels,no-occluded_panels",
    }
    with Serving("--scene", "reading") as serving:
        options = small(tmp_path / "out", feed=FeedOptions(connect=serving.address), **asked)
        shown, summary = pictures(monkeypatch, options)
    assert summary["effects"] == ["panels"]
    page, _ = (panel.pictures[0] for panel in load_scene("reading").panels)
    sent = summary["link"]["layers_mbit_s"]["panels"] * 1e6 / 8 * 1.5
    once = sum(map(len, things_of(load_scene("reading").panels)))
    assert 0 < sent < once  # of two pages and two labels the first
    last = shown[max(shown)][1][0][..., :3]
    assert (last > 0.7).all(axis=2).mean() > 0.02  # paper: nothing else of the scene is so bright
    assert page.image.min() < 50
