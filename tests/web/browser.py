"""A headless Chromium that a test drives, by the DevTools protocol."""

from __future__ import annotations

import asyncio
import atexit
import base64
import functools
import itertools
import json
import shutil
import subprocess
import tarfile
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import aiohttp
import needs

import hmdwarp.web

CHROMIUM = needs.program("chromium")
FLAGS = (
    *("--headless=new", "--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-sync"),
    *("--disable-component-update", "--disable-quic", "--hide-scrollbars", "--remote-debugging-port=0"),
    # WebGL 2 on the CPU, by SwiftShader.
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"),
)
MOST_BYTES = 1 << 28
MODULES = Path(hmdwarp.web.__file__).parent / "page"
# What a page of tests has: a chain, and what takes numbers in and out as text.
PACKED = """(numbers) => {
  const all = new Uint8Array(numbers.buffer, numbers.byteOffset, numbers.byteLength);
  let text = "";
  for (let k = 0; k < all.length; k += 8192) text += String.fromCharCode(...all.subarray(k, k + 8192));
  return btoa(text);
}"""
HARNESS = (
    """<!doctype html><meta charset="utf-8"><title>chain</title><link rel="icon" href="data:,">
<canvas id="shown"></canvas>
<script type="module">
import { Chain } from "./chain.js";
import { Panels, VideoEye } from "./coded.js";
import { decode } from "./feed.js";
const shaders = await (await fetch("shaders.json")).json();
Object.assign(globalThis, { Panels, VideoEye, decode });
globalThis.bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
globalThis.packed = """
    + PACKED
    + """;
globalThis.chain = new Chain(document.getElementById("shown"), shaders);
</script>"""
)


@contextmanager
def page(shaders: dict[str, str]) -> Iterator[str]:
    """Serve the page's modules and a page that makes a chain; its address."""

    class Handler(SimpleHTTPRequestHandler):
        def do_GET(self) -> None:
            name = self.path.strip("/")
            made = {"": (HARNESS, "text/html"), "shaders.json": (json.dumps(shaders), "application/json")}
            text, kind = made.get(name) or ((MODULES / name).read_text(encoding="utf-8"), "text/javascript")
            self.send_response(200)
            self.send_header("Content-Type", kind)
            self.end_headers()
            self.wfile.write(text.encode())

        def log_message(self, *_: object) -> None: ...

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}/"
        server.shutdown()


# What the page has told people so far, also what is gone by now.
HEARD = """
globalThis.heard = new Set();
addEventListener("DOMContentLoaded", () => {
  const told = document.getElementById("told");
  if (told) new MutationObserver(() => heard.add(told.textContent)).observe(told, { childList: true });
});
"""


def says(text: str) -> str:
    """Return a condition: the page has told people this, if only for a moment."""
    return f"[...heard].some((line) => line.includes('{text}'))"


class Reloaded(Exception):
    """The page went while it was asked: it loads anew, as after lost graphics."""


class Ended(Exception):
    """Chromium or the page in it is gone, so that nothing it was asked will be answered."""


@functools.cache
def _chromium() -> str:
    """Start one for all pages of this process, which share its compiled shaders; its address."""
    profile = Path(tempfile.mkdtemp())
    command = [CHROMIUM, *FLAGS, f"--user-data-dir={profile}", "about:blank"]
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    atexit.register(lambda: (process.kill(), process.wait(), shutil.rmtree(profile, ignore_errors=True)))
    told = profile / "DevToolsActivePort"  # where it says its address; a pipe would stay open in what it starts
    while len(lines := told.read_text(encoding="utf-8").splitlines() if told.exists() else []) < 2:
        assert process.poll() is None, "Chromium ended before it listened"
        time.sleep(0.02)
    return f"ws://127.0.0.1:{lines[0]}{lines[1]}"


class Browser:
    """One page, with cookies of its own. Use it in a `with`."""

    def __init__(self, size: tuple[int, int] = (960, 600)) -> None:
        self._numbers, self._session = itertools.count(1), ""
        # What the page itself said: errors, warnings, refused loads.
        self.said: list[str] = []
        # Whether its scripts threw something that nobody caught.
        self.has_failed = False
        self._loop = asyncio.new_event_loop()
        self._loop.run_until_complete(self._connect(_chromium()))
        apart = self.send("Target.createBrowserContext", disposeOnDetach=True)
        page = self.send("Target.createTarget", url="about:blank", newWindow=True, **apart)["targetId"]
        self._session = self.send("Target.attachToTarget", targetId=page, flatten=True)["sessionId"]
        self.send_all(*((f"{domain}.enable", {}) for domain in ("Page", "Runtime", "Log", "Inspector")))
        self.send("Page.addScriptToEvaluateOnNewDocument", source=HEARD)
        self.resize(*size)

    async def _connect(self, address: str) -> None:
        self._http = aiohttp.ClientSession()
        self._socket = await self._http.ws_connect(address, max_msg_size=MOST_BYTES)

    async def _send(self, commands: Sequence[tuple[str, dict[str, Any]]]) -> list[Any]:
        numbers, answers = [], {}
        for method, params in commands:
            numbers.append(next(self._numbers))
            which = {"sessionId": self._session} if self._session else {}
            await self._socket.send_json({"id": numbers[-1], "method": method, "params": params, **which})
        while not answers.keys() >= {*numbers}:
            message = await self._socket.receive()
            if message.type is not aiohttp.WSMsgType.TEXT:
                raise Ended("its socket closed")
            told = json.loads(message.data)
            if "id" in told:
                answers[told["id"]] = told
            elif told["method"] in ("Runtime.exceptionThrown", "Log.entryAdded", "Runtime.consoleAPICalled"):
                self.said.append(json.dumps(told["params"]))
                self.has_failed = self.has_failed or told["method"] == "Runtime.exceptionThrown"
            elif told["method"] in ("Inspector.targetCrashed", "Target.detachedFromTarget"):
                raise Ended(told["method"])
        return [answers[number] for number in numbers]

    def send_all(self, *commands: tuple[str, dict[str, Any]]) -> list[Any]:
        """Send commands, none of which waits for the answer to another; return their results."""
        answers = self._loop.run_until_complete(self._send(commands))
        for told in answers:
            if told.get("error", {}).get("message") == "Inspected target navigated or closed":
                raise Reloaded
            assert "error" not in told, told["error"]
        return [told["result"] for told in answers]

    def send(self, method: str, **params: Any) -> Any:
        """Send a command of the protocol; return its result."""
        return self.send_all((method, params))[0]

    def resize(self, width: int, height: int) -> None:
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def open(self, address: str) -> None:
        """Open a page."""
        found = self.send("Page.navigate", url=address)
        assert "errorText" not in found, found["errorText"]

    def does(self, script: str) -> Any:
        """Return what an expression is, awaited, as JSON."""
        found = self.send("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def until(self, condition: str) -> None:
        """Wait until an expression is true; it ends with the browser, and where a script fails."""
        while not self._is(condition):
            assert not self.has_failed, self.said
            time.sleep(0.05)

    def _is(self, condition: str) -> bool:
        with suppress(Reloaded):
            return self.does(f"(() => {{ try {{ return Boolean({condition}); }} catch {{ return false; }} }})()")
        return False

    def picture(self) -> bytes:
        """Return a PNG of the page."""
        return base64.b64decode(self.send("Page.captureScreenshot", format="png")["data"])

    def __enter__(self) -> Browser:
        return self

    def __exit__(self, *_: object) -> None:
        self._loop.run_until_complete(self._http.close())
        self._loop.close()


# Turned by up to 17 degrees and moved by up to 0.2 m, at up to 15 deg/s and 0.2 m/s: in the two
# seconds that a busy machine may take for a frame, much of it stays in view.
HEADSET = """
globalThis.headset = new IWER.XRDevice(IWER.metaQuest3, { stereoEnabled: true, visibilityMask: null });
headset.ipd = 0.068;
headset.installRuntime({ forceInstall: true });
globalThis.moved = (ms) => {
  const t = ms / 1000, yaw = 0.15 * Math.sin(0.9 * t), pitch = 0.06 * Math.sin(1.1 * t);
  headset.position.set(0.2 * Math.sin(0.8 * t), 1.6 + 0.05 * Math.sin(1.3 * t), 0.15 * Math.cos(0.7 * t));
  headset.quaternion.set(Math.sin(pitch) * Math.cos(yaw), Math.sin(yaw) * Math.cos(pitch),
    -Math.sin(yaw) * Math.sin(pitch), Math.cos(yaw) * Math.cos(pitch));
};
setInterval(() => moved(performance.now()), 4);
"""
# Eyes that look past each other by 12 degrees, the right one with another field of view.
CANTED = """
{
  const { getViewerPose } = XRFrame.prototype, turn = [Math.sin(0.052), Math.cos(0.052)];
  const canted = (view, side) => {
    const { position, orientation: { x, y, z, w } } = view.transform, [s, c] = [-side * turn[0], turn[1]];
    const orientation = { x: x * c - z * s, y: y * c + w * s, z: z * c + x * s, w: w * c - y * s };
    const seen = [...view.projectionMatrix], value = { position, orientation };
    if (side > 0) [seen[0], seen[8], seen[9]] = [1.15 * seen[0], 1 / 12, 1 / 13]; // a guard band of whole pixels
    return Object.create(view, { transform: { value }, projectionMatrix: { value: seen } });
  };
  XRFrame.prototype.getViewerPose = function (space) {
    const pose = getViewerPose.call(this, space);
    return pose && { transform: pose.transform, views: pose.views.map((view, k) => canted(view, 2 * k - 1)) };
  };
}
"""


def wear(browser: Browser, script: str = "") -> None:
    """Give the pages opened from now on an emulated headset that moves."""
    with tarfile.open(needs.packed("iwer")) as package:
        runtime = package.extractfile("package/build/iwer.min.js")
        assert runtime is not None
        browser.send("Page.addScriptToEvaluateOnNewDocument", source=runtime.read().decode() + HEADSET + script)
