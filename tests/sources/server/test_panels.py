"""Panels of a scene: each picture crosses once; a client shows what the server draws."""

from __future__ import annotations

import struct
from contextlib import suppress

import attrs
import numpy as np
import pytest
from client_scene import ClientScene
from worlds import read

from hmdwarp.base import InputError
from hmdwarp.client import PassInputs, ShownPicture
from hmdwarp.client.effects import Tools
from hmdwarp.client.effects.text import KeptPanels, PanelsPass
from hmdwarp.frames import Needs
from hmdwarp.frames.layers import layers
from hmdwarp.frames.layers.panels import PanelDelivery, Panels
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import Canvas
from hmdwarp.pipeline.feed_coding import made, needs_of_client, parts_of, wanted_of
from hmdwarp.scenes import Panel, Scene, load_scene

VIEW = View(Pose((0.0, 1.6, 0.0)), Fov(-0.5, 0.5, -0.45, 0.45), Pose((-0.03, 0.0, 0.0)))
SIZE = (96, 80)
SECOND = 1_000_000_000


def needs(budget=20_000):
    return Needs(panels=frozenset({PanelDelivery(budget)}))


def bytes_of(frame):
    (update,) = frame.eyes[0]["panels"].values()
    return len(update.content)


@pytest.fixture
def scene():
    """Two panels, one of which turns over each second; noise does not pack."""
    pages = [np.random.default_rng(seed).integers(0, 256, (30, 40, 3), dtype=np.uint8) for seed in range(3)]
    still = Panel(pages[2], Pose((0.2, 1.6, -1.0)), (0.3, 0.2), occluded=True)
    return Scene("pages", "", (), panels=[Panel(pages[:2], Pose((-0.2, 1.6, -1.0)), (0.3, 0.2)), still])


def frames(server, times, budget=20_000):
    for time_ns in times:
        frame = server.draw_frame([VIEW], time_ns, SIZE, needs=needs(budget))
        yield frame
        server.recycle(frame)


def test_each_picture_crosses_once_and_when_it_changes(serve, scene):
    server = serve(scene)
    # Second 0, 0.5, 1.0 (the other page), 1.5, 2.0 (the first again, which the client has), 2.5
    sent = [bytes_of(frame) for frame in frames(server, range(0, 3 * SECOND, SECOND // 2))]
    head = 8 + 2 + 2 * 2  # the instant, how many panels, a number each
    page = 30 * 40 * 3  # noise: a PNG is about as large
    assert sent[0] > 2 * page
    assert sent[1] == sent[3] == sent[4] == sent[5] == head
    assert page < sent[2] < 1.1 * page


def test_what_was_lost_is_sent_again_and_the_page_before_stays_until_then(gpu, serve, scene):
    server, client = serve(scene), ClientScene(gpu, scene)
    kept = client.store(KeptPanels, PanelDelivery())
    shown = []
    for time_ns, arrives in ((0, True), (SECOND, False), (SECOND + 1, True), (SECOND + 9, True)):
        frame = server.draw_frame([VIEW], time_ns, SIZE, needs=needs())
        server.heard(frame, arrives, time_ns + 5)
        if arrives:
            client.receive(frame)
        shown.append(kept.held[0].texture)
        server.recycle(frame)
    assert shown[0] is shown[1] is shown[2]  # the loss is not known yet
    assert shown[3] is not shown[0]
    client.close()


def test_a_frame_that_comes_late_does_not_turn_the_page_back(gpu, serve, scene):
    server, client = serve(scene), ClientScene(gpu, scene)
    kept = client.store(KeptPanels, PanelDelivery())
    first, second = (server.draw_frame([VIEW], at, SIZE, needs=needs()) for at in (0, SECOND))
    for frame in (first, second):
        client.receive(frame)
    page = kept.held[0].texture
    client.receive(first)
    assert kept.held[0].texture is page
    client.close()


@pytest.mark.parametrize("pose", [VIEW.pose, Pose((0.1, 1.5, 0.1), (0.0, 0.0499792, 0.0, 0.9987503))])
def test_what_a_client_shows_is_what_the_server_draws(gpu, serve, pose):
    """The library's scene: the frame lacks the panels, and the pass lays them over it."""
    scene, size = load_scene("reading"), (192, 160)
    server, client = serve(scene), ClientScene(gpu, scene)
    view = attrs.evolve(VIEW, pose=pose)
    whole = read(server.draw(view, size).colour)
    rendered = None
    for _ in range(40):
        frame = server.draw_frame([view], 0, size, needs=needs())
        client.receive(frame)
        rendered = frame.eyes[0]
        if not server.has_more(0):
            break
    canvas, into = Canvas(gpu.gl, size), Canvas(gpu.gl, size)
    canvas.texture.write(rendered.colour.read())
    bare = read(canvas.texture)
    parts = frozenset({"panels", "occluded_panels"})
    made = PanelsPass(gpu, parts, size, size, Tools(carry=None, pictures=0, geometry=client))
    made.run(PassInputs(rendered, view), ShownPicture(canvas, rendered.inverse_depth), into)
    gpu.gl.memory_barrier()
    error, apart = (np.abs(read(into.texture) - picture).max(axis=-1) for picture in (whole, bare))
    # A renderer has its own filter, without the footprint's shape, and no half pixels at borders.
    assert (apart > 0.05).mean() > 0.15
    assert (error > 0.1).mean() < 0.03
    assert error[apart > 0.05].mean() < 0.04
    client.close()


def test_drawn_into_a_frame_a_panel_in_the_world_has_its_depth(serve):
    scene = load_scene("reading")
    for panel, place, expected in zip(scene.panels, ((0, 1.6, -1.6), (0, 0, -1.6)), (1 / 1.6, 0.0), strict=True):
        server = serve(Scene("panel", "", (), panels=[attrs.evolve(panel, pose=Pose(place))]))
        drawn = server.draw(VIEW, SIZE)
        assert read(drawn.colour)[40, 48, :3].min() > 0
        assert read(drawn.inverse_depth)[40, 48, 0] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("layer", ["wide", "views"])
def test_no_other_picture_of_a_frame_shows_what_the_client_lays_over(serve, layer):
    scene = load_scene("reading")
    amount = layers.get(layer).something
    found = []
    for one in (scene, attrs.evolve(scene, panels=())):
        server = serve(one)
        eye = server.draw_frame([VIEW], 0, SIZE, needs=needs() | Needs(**{layer: amount})).eyes[0]
        pictures = eye[layer] if isinstance(eye[layer], tuple) else (eye[layer],)
        found.append([read(picture.colour) for picture in pictures])
    assert all(np.array_equal(*both) for both in zip(*found, strict=True))


def changed(at, to):
    return lambda content: np.concatenate([content[:at], np.frombuffer(to, np.uint8), content[at + len(to) :]])


PLACE = 8 + 2 + 2 + 14  # after how many panels there are, and the head of the first
PICTURE = PLACE + 9 * 8 + 4 + 14


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda content: content[:5], "cannot be read"),
        (lambda content: content[:-700], "cannot be read"),
        (changed(8, struct.pack("<H", 9)), "cannot be read"),
        (changed(10, struct.pack("<H", 7)), "panels that show pictures"),
        (changed(PLACE, struct.pack("<d", float("nan"))), "cannot be read"),
        (changed(PLACE + 7 * 8, struct.pack("<d", -1.0)), "a panel is -1 x"),
        (changed(PICTURE, b"JUNK"), "cannot be read"),
        (changed(PICTURE + 60, bytes(400)), "cannot be read"),
    ],
)
def test_what_is_no_panel_is_refused_in_one_line(gpu, serve, scene, change, message):
    """Of what crosses the feed, once for both eyes. Also by the client's store, which alone sees
    pictures that come in several frames."""
    server, wanted = serve(attrs.evolve(scene, panels=scene.panels[:1])), wanted_of(needs(), [VIEW, VIEW], SIZE)
    frame = server.draw_guarded([VIEW, VIEW], 0, SIZE, needs(), wanted.fovs, SIZE)
    parts = parts_of(frame, needs_of_client(wanted), packs=False)
    (content,) = parts[0]["panels"]
    assert Panels.misfit([content], None) == "" and parts[1] == {}
    assert made(server, frame.eyes, parts, wanted)[0]["panels"].keys() == frame.eyes[0]["panels"].keys()
    wrong = Panels.misfit([change(content.ravel())[None]], None)
    assert "\n" not in wrong and message in wrong
    client = ClientScene(gpu, server.scene)
    with suppress(InputError):
        client.store(KeptPanels, PanelDelivery()).receive(change(content.ravel()))
    client.close()
