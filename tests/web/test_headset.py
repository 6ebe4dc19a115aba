"""The page in a headset: WebXR by an emulated one, over a network that delays, stalls and cuts."""

from __future__ import annotations

import json

import needs
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from serving import Serving
from sources.feed.relay import Relay

from hmdwarp.run.browser_log import NAME

from .browser import Browser, says, wear
from .looks import CLOCK, Own, enter_vr_at_once, looks, pictures_of

pytestmark = [needs.programs("chromium"), needs.from_npm("iwer")]

# As WebXR tells what a lens hides: what is left is a rhombus, of tangents.
HIDES = """
(async () => {
  const { views } = await hmdwarp.session.look(), indices = new Uint32Array([0, 1, 2, 0, 2, 3]);
  views.forEach(({ fov }, index) => {
    const [left, right, down, up] = fov.map(Math.tan), x = (left + right) / 2, y = (down + up) / 2;
    const vertices = new Float32Array([left, y, x, up, right, y, x, down]);
    hmdwarp.session.xr.dispatchEvent(Object.assign(new Event("visibilitymaskchange"), { index, vertices, indices }));
  });
})()
"""
# What is held of what was made since.
BUFFERS = """{
  const gl = hmdwarp.chain.gl, { createBuffer } = gl;
  globalThis.buffers = [];
  gl.createBuffer = () => (buffers.push(createBuffer.call(gl)), buffers.at(-1));
}"""
HELD = "buffers.filter((buffer) => hmdwarp.chain.gl.isBuffer(buffer)).length"
TOLD = "document.getElementById('told').textContent"
HAND = "headset.controllers.right"
ENTER = "document.getElementById('enter').click()"
BOTH = "hmdwarp.session.xr && hmdwarp.session.shown.eyes.length === 2"


@pytest.fixture
def worn():
    """A function that opens a page and enters VR, in a headset of 2 x 120 x 130 pixels."""
    opened = []

    def enter(address: str) -> Browser:
        opened.append(browser := Browser((240, 130)))
        wear(browser)
        browser.open(address)
        browser.until("hmdwarp.session.shown && !document.getElementById('enter').hidden")
        browser.does(ENTER)
        browser.until(BOTH)
        return browser

    yield enter
    for browser in opened:
        browser.__exit__()


def through(relay: Relay, address: str) -> str:
    """Return the page's address by way of a relay."""
    return f"http://{relay.address}/?{address.partition('/?')[2]}"


def port_of(address: str) -> int:
    return int(address.partition("/?")[0].rpartition(":")[2])


def test_fifty_refreshes_are_our_own_warp_at_their_ages(worn, gpu):
    """As tests/web/test_page.py has it for one refresh of a window, by the same bound.

    With a panel in the world and one on the head.
    """
    with (
        Serving("--scene", "reading", "--samples", "4", "--web", "127.0.0.1:*") as server,
        Relay(port_of(address := server.line("for a browser").split()[-1])) as relay,
        Own(gpu, 4, "reading") as own,
    ):
        relay.delay_s, relay.jitter_s = 0.04, 0.03
        browser = worn(through(relay, address) + "&raw&latency=100&warp=iterative&size=128")
        browser.until("hmdwarp.session.panels.laid.length === 2")

        def then(count: int) -> list:
            """What so many refreshes show, once there is a newer frame."""
            browser.does("globalThis.before = hmdwarp.session.shown.number")
            browser.until("hmdwarp.session.shown.number > before")
            return browser.does(looks(count))

        shown = then(12) + then(12)
        relay.is_stalled = True  # as a loss stops TCP
        shown += browser.does(looks(6))
        relay.is_stalled = False
        relay.cut()
        shown += then(20)
        assert len({look["age"] for look in shown}) > 25 and min(look["age"] for look in shown) >= 100
        assert len({look["time"] for look in shown}) > 3
        known = []
        for look in shown:
            left, right = (view["pose"]["position"] for view in look["views"])
            assert abs(np.linalg.norm(np.subtract(left, right)) - 0.068) < 1e-6
            for eye, picture in enumerate(pictures_of(look)):
                here = own.warped(look, eye)
                seen = here.coverage > 0
                off = np.abs(picture.astype(int) - here.colour).max(axis=-1)
                assert np.mean(seen & (off > 2)) <= 0.01, look["age"]
                known.append(seen.mean())
        assert np.mean(known) > 0.5 and len(known) == 100
        browser.does(BUFFERS)
        for _ in range(20):
            browser.does(HIDES)
        (look,) = browser.does(looks(1))
        for eye, picture in enumerate(pictures_of(look)):  # an outline through the middles of its sides
            inside = np.abs(np.linspace(-1, 1, 130))[:, None] + np.abs(np.linspace(-1, 1, 120)) < 0.95
            off = np.abs(picture.astype(int) - own.warped(look, eye).colour).max(axis=-1)
            assert not picture[:20, :20].any() and not picture[-20:, -20:].any()
            assert np.mean(inside & (own.warped(look, eye).coverage > 0) & (off > 2)) <= 0.01
        assert browser.does(HELD) == 4  # places and indices of each eye
        browser.does("hmdwarp.session.xr.end()")
        browser.until(f"{HELD} === 0")


CHAINS = ("iterative", "mesh:grid=64", "rotation")  # as the page has them


def test_a_bench_times_every_chain_and_in_a_headset_its_own_views(tmp_path):
    """Every warp with every fill, in a window as near to the truth as frames 100 ms late are; the
    server keeps a line of each bench.
    """
    benched = "hmdwarp.session.benched"
    options = ("--scene", "room", "--web", "127.0.0.1:*", "--out", str(tmp_path / "out"))
    with Serving(*options) as server, Browser((240, 130)) as browser:
        wear(browser)
        browser.open(server.line("for a browser").split()[-1] + "&raw&size=96&bench&latency=100")
        browser.until(f"{benched} && !hmdwarp.session.isBusy")
        browser.does(ENTER)
        browser.until(f"{benched}.width === 120 && !hmdwarp.session.isBusy")
        found = browser.does(benched)
        assert "EXT_disjoint_timer_query_webgl2" in found["how"]
        assert browser.does(f"{TOLD}").startswith(f"Measured by {found['how']}")
        browser.does("hmdwarp.session.feed.close()")
        browser.until("hmdwarp.session.feed.socket.readyState === 3")
    lines = [json.loads(line) for line in (tmp_path / "out" / NAME).read_text(encoding="utf-8").splitlines()]
    assert not any(line.get("errors") for line in lines)
    window, headset = (line for line in lines if "bench" in line)
    assert headset["display"] | {"rows": headset["bench"]} == found and headset["display"]["trace"] == "walk"
    assert (found["width"], found["height"]) == (120, 130) and window["display"]["width"] != 120
    for line in (window, headset):
        rows = {(row["warp"], row["fill"]): row for row in line["bench"]}
        assert list(rows) == [(warp, fill) for warp in CHAINS for fill in ("none", "pyramid")]
        assert all(row["warp_ms"] > 0 and row["total_ms"] > 0 for row in rows.values())
        psnr_db = {names: row["psnr_db"] for names, row in rows.items()}
        assert psnr_db["iterative", "pyramid"] > max(psnr_db["rotation", "pyramid"], 20)


GOES_ON = f"!{TOLD} && hmdwarp.session.shown.number > before"


def test_what_stops_it_is_told_in_the_view_and_taken_up_again(worn):
    with (
        Serving("--scene", "room", "--web", "127.0.0.1:*") as server,
        Relay(port_of(address := server.line("for a browser").split()[-1])) as relay,
    ):
        browser = worn(through(relay, address) + "&raw&size=128")

        def goes_on_after(text: str, mend) -> None:
            browser.until(f"{says(text)} && hmdwarp.chain.told.text.includes('{text}')")
            mend()
            browser.does("globalThis.before = hmdwarp.session.shown.number")
            browser.until(GOES_ON)

        for shown in ("true", "false"):  # a trigger that is held shows the figures, and hides them
            browser.does(f"{HAND}.updateButtonValue('trigger', 1)")
            browser.until(f"Boolean(hmdwarp.session.tells) === {shown}")
            browser.does(f"{HAND}.updateButtonValue('trigger', 0), globalThis.before = hmdwarp.figures.all")
            browser.until("hmdwarp.figures.all > before + 1")  # a refresh has seen that it is let go
            if shown == "true":
                browser.until("hmdwarp.chain.told.text.includes('round trip')")
        browser.does("headset.updateVisibilityState('visible-blurred')")
        goes_on_after("something in front", lambda: browser.does("headset.updateVisibilityState('visible')"))
        relay.is_down = True
        relay.cut()
        goes_on_after("Connection lost", lambda: setattr(relay, "is_down", False))
        browser.does("hmdwarp.session.xr.end()")
        browser.until(says("VR has ended"))
        browser.until("hmdwarp.session.shown.eyes.length === 1")
        browser.does(ENTER)
        browser.until(BOTH)


def test_a_server_started_anew_with_another_secret(worn):
    """The page says what to open; with the same secret it goes on, as test_page.py has it."""
    with Serving("--web", "127.0.0.1:*") as server:
        address = server.line("for a browser").split()[-1]
        browser = worn(address + "&raw&size=128")
    browser.until(says("Connection lost"))
    with Serving("--web", f"127.0.0.1:{port_of(address)}"):
        browser.until(says("does not accept this browser any more"))


def test_controllers_push_switch_and_grab():
    """What the hand's ray means, or a key, by the light of what is drawn for a still head."""
    with Serving("--scene", "playroom", "--web", "127.0.0.1:*") as server, Browser((160, 80)) as browser:
        browser.send("Page.addScriptToEvaluateOnNewDocument", source=CLOCK)
        wear(browser, "globalThis.moved = () => headset.position.set(0, 1.6, 0);")
        browser.open(server.line("for a browser").split()[-1] + "&raw&size=64&latency=0&rate=120")
        connected = "hmdwarp.session.feed.socket.readyState === 1"
        browser.until(connected)

        def light_after(*does: str) -> int:
            """Return the sum of a frame's levels, once all that is done has been answered."""
            steps = " ".join(f"{one}; await stepped(3);" for one in does)
            sums = "hmdwarp.session.shown.eyes[0].colour.reduce((sum, level) => sum + level)"
            return browser.does(f"(async () => {{ {steps} return {sums}; }})()")

        def pointing(x: float, y: float, z: float) -> str:
            """Return what lets the hand stand at the head, and point along a direction."""
            way = Rotation.align_vectors([[x, y, z]], [[0, 0, -1]])[0].as_quat().tolist()
            return f"{HAND}.position.set(0, 1.6, 0), {HAND}.quaternion.set(...{way})"

        trigger, squeeze = (
            [f"{HAND}.updateButtonValue('{name}', {k})" for k in (1, 0)] for name in ("trigger", "squeeze")
        )
        lit = light_after("0")
        key = "dispatchEvent(new KeyboardEvent('keydown', { code: 'KeyL' }))"
        assert light_after(key) < 0.9 * lit == 0.9 * light_after(key)
        enter_vr_at_once(browser)
        lit = light_after(pointing(0.75, -0.35, -3.6))  # at the lamp's switch
        dark = light_after(*trigger)
        assert dark < 0.9 * lit
        browser.does("hmdwarp.session.feed.socket.close()")
        browser.until(connected)
        assert light_after("0") == dark, "all is told again"
        assert light_after(*trigger) == lit
        taken = light_after(pointing(0.45, -1.46, -1.9), squeeze[0])  # at the ball
        assert taken == lit != light_after(pointing(0.1, -0.3, -1.0))
        light_after(*trigger, squeeze[1])  # which throws it, so that nothing is held then
        found = browser.does("(({ known, acted }) => [known, acted.map(({ action }) => action)])(hmdwarp.session.feed)")
        known, acted = found
        assert known == len(acted) and acted[:4] == [2, 2, 1, 1] and {*acted[4:-2]} == {3} and acted[-2:] == [1, 4]
