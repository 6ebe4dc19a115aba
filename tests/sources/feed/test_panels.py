"""Panels between processes: pictures cross once; what is none is refused."""

from __future__ import annotations

import contextlib
import re
import struct

import numpy as np
import pytest
from client_scene import ClientScene

from hmdwarp.client.effects.text import KeptPanels
from hmdwarp.errors import InputError
from hmdwarp.frames import Needs
from hmdwarp.frames.layers.panels import PanelDelivery, Panels
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.pipeline.feed_coding import made, needs_of_client, parts_of, wanted_of
from hmdwarp.scenes import Panel, Scene
from hmdwarp.sources.server import Server

VIEWS = [View(Pose((x, 1.6, 0.0)), Fov.symmetric(1.0, 0.8)) for x in (-0.03, 0.03)]
SIZE = (24, 20)
NEEDS = Needs(panels=frozenset({PanelDelivery()}))


@pytest.fixture
def server(gpu):
    pages = [np.random.default_rng(seed).integers(0, 256, (30, 40, 4), dtype=np.uint8) for seed in range(2)]
    scene = Scene("pages", "", (), panels=[Panel(pages, Pose((-0.2, 1.6, -1.0)), (0.3, 0.2), occluded=True)])
    one = Server(gpu, scene)
    yield one
    one.close()


def sent(server) -> np.ndarray:
    """The bytes of a frame's panels."""
    wanted = wanted_of(NEEDS, VIEWS, SIZE)
    needs = needs_of_client(wanted)
    frame = server.draw_guarded(VIEWS, 0, SIZE, needs, wanted.fovs, SIZE)
    parts = parts_of(frame, needs, packs=False)
    (content,) = parts[0]["panels"]
    assert parts[1] == {}, "both eyes share it"
    assert Panels.misfit([content], None) == ""
    assert made(server, frame.eyes, parts, wanted)[0]["panels"].keys() == frame.eyes[0]["panels"].keys()
    return content.ravel()


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
    content = sent(server)
    wrong = Panels.misfit([change(content)[None]], None)
    assert "\n" not in wrong
    assert re.search(message, wrong), wrong
    client = ClientScene(gpu, server.scene)
    with contextlib.suppress(InputError):
        client.store(KeptPanels, PanelDelivery()).receive(change(content))
    client.close()
