"""The experimenter's console in a browser: the same screen, for who knows its address."""

from __future__ import annotations

import ast
import asyncio
import base64
import contextlib
import io
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import AsyncIterator, Iterator, Mapping
from pathlib import Path

import needs
import numpy as np
import pytest
from PIL import Image

pytest.importorskip("textual_serve", reason="textual-serve is not installed: pip install '.[study]'")
pytest.importorskip("aiohttp", reason="textual-serve brings aiohttp")

import aiohttp

from hmdwarp.errors import MachineError
from hmdwarp.study.console.terminal_console import make_console

from .played import HEADING
from .terminals import PLAYED, ROOT


class Played:
    """played.py with its console in a browser."""

    def __init__(self, log: Path, folder: str) -> None:
        self.log, self.folder = log, Path(folder)
        environment = {
            **os.environ,
            "TMPDIR": folder,
            "PYTHONPATH": f"{ROOT}{os.pathsep}{os.environ.get('PYTHONPATH', '')}",
        }
        self.program = subprocess.Popen(
            [sys.executable, PLAYED, str(log), "--console", "browser", "--seconds", "600"],
            stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, stdin=subprocess.DEVNULL, text=True, env=environment,
        )  # fmt: skip
        self.said = self.program.stderr.readline()
        self.address = self.said.split()[2]

    def show(self, state: str) -> None:
        new = self.log.with_suffix(".new")
        new.write_text(state, encoding="utf-8")
        new.replace(self.log.with_suffix(".state"))

    def asked(self) -> list[tuple[str, object]]:
        return [ast.literal_eval(line) for line in self.log.read_text(encoding="utf-8").splitlines()]


@contextlib.contextmanager
def playing(log: Path) -> Iterator[Played]:
    # Not in tmp_path: the path of a socket must be short.
    with tempfile.TemporaryDirectory() as folder:
        played = Played(log, folder)
        try:
            yield played
        finally:
            played.program.kill()
            played.program.stderr.read()  # which the server holds open as long as it lives
            played.program.wait()
            played.program.stderr.close()


class Page:
    """What a page is for the server: a WebSocket. Waits for words on the screen, and types."""

    def __init__(self, socket) -> None:
        self._socket, self._seen = socket, b""

    async def until(self, words: str) -> None:
        """Wait until these were drawn since the last call."""
        while words.encode() not in self._seen:
            message = await self._socket.receive()
            assert message.type == aiohttp.WSMsgType.BINARY, (message, self._seen)
            self._seen += message.data
        self._seen = b""

    async def type(self, keys: str) -> None:
        for key in keys:
            await self._socket.send_json(["stdin", key])

    async def closed(self) -> None:
        """Wait until the server closes it."""
        while (await self._socket.receive()).type == aiohttp.WSMsgType.BINARY:
            pass


@contextlib.asynccontextmanager
async def page_of(address: str) -> AsyncIterator[Page]:
    async with aiohttp.ClientSession() as client, client.ws_connect(f"{address}ws?width=80&height=24") as socket:
        yield Page(socket)


def test_a_page_shows_the_session_and_sends_its_commands(tmp_path):
    async def visit(played: Played) -> None:
        async with page_of(played.address) as page:
            await page.until("participant P07")
            played.show("asking")
            await page.until("How good was the picture?")
            await page.type("3.5\r\r")
            await page.until("asked for: answer")
        # A later page gets the state and the journal, and takes the place of another.
        async with page_of(played.address) as first:
            await first.until("asked for: answer")
            async with page_of(played.address) as second:
                await second.until("asked for: answer")
                await first.closed()
                await second.type("sy")
                await second.closed()

    with playing(tmp_path / "log") as played:
        asyncio.run(visit(played))
        assert played.program.wait() == 0
        assert played.asked() == [("answer", 3.5), ("stop", None)]


async def answers(requests: list[tuple[str, dict[str, str]]]) -> list[tuple[int, Mapping[str, str]]]:
    """Status and headers of each."""
    found = []
    async with aiohttp.ClientSession() as client:
        for url, headers in requests:
            async with client.get(url, headers=headers) as answer:
                found.append((answer.status, answer.headers))
    return found


async def statuses(urls: list[str]) -> list[int]:
    return [status for status, _ in await answers([(url, {}) for url in urls])]


def test_no_process_names_the_token_nor_does_a_log_file(tmp_path):
    with playing(tmp_path / "log") as played:
        token = played.address.rsplit("/", 2)[1].encode()
        assert asyncio.run(statuses([played.address])) == [200], "the server runs"
        for process in Path("/proc").glob("[0-9]*"):
            for name in ("cmdline", "environ", "comm"):
                with contextlib.suppress(OSError):
                    assert token not in (process / name).read_bytes()
    log = tmp_path / "stderr"
    code = f"""
import os, sys; os.dup2(os.open({str(log)!r}, os.O_WRONLY | os.O_CREAT), 2)
from hmdwarp.study.console.terminal_console import make_console
with make_console("browser", "x") as console:
    from urllib.request import url2pathname
    page = open(2, closefd=False) and open({str(log)!r}).read().split()[2].removeprefix("file://")
    print(console.address, os.stat(os.path.dirname(page)).st_mode & 0o777, console.address in open(page).read())
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    address, mode, there = done.stdout.split()
    assert address not in log.read_text() and address.rsplit("/", 2)[1] not in log.read_text()
    assert (int(mode), there) == (0o700, "True")


def test_pages_of_other_origins_and_other_names_of_this_machine_are_refused(tmp_path):
    with playing(tmp_path / "log") as played:
        own = played.address.split("/")[2]
        port, page, ws = own.rsplit(":", 1)[1], played.address, f"{played.address}ws?width=80&height=24"
        upgrade = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13",
                   "Sec-WebSocket-Key": base64.b64encode(bytes(16)).decode()}  # fmt: skip
        foreign = ["http://evil.example", "null", "http://127.0.0.1", f"https://{own}", f"http://127.0.0.2:{port}",
                   f"http://{own}.evil.example", f"http://evil.example:{port}"]  # fmt: skip
        names = ["evil.example", f"evil.example:{port}", "127.0.0.1", f"127.0.0.1:{port}0", f"[::1]:{port}"]
        refused = [(url, {"Origin": origin, **upgrade}) for url in (page, ws) for origin in foreign]
        refused += [(url, {"Host": name, **upgrade}) for url in (page, ws, f"http://{own}/wrong/") for name in names]
        found = asyncio.run(answers(refused))
        assert {status for status, _ in found} == {403}
        taken = [(page, {}), (page, {"Origin": f"http://{own}"}), (page, {"Host": f"localhost:{port}"})]
        found = asyncio.run(answers([*taken, (f"{page}static/js/textual.js", {}), (f"http://{own}/wrong/", {})]))
        assert [status for status, _ in found] == [200, 200, 200, 200, 404]
        for _, headers in found:
            policy = headers["Content-Security-Policy"].split("; ")
            assert {"default-src 'none'", "frame-ancestors 'none'"} <= {*policy}
            assert not [rule for rule in policy if rule.startswith("script-src") and "unsafe" in rule]
            assert headers["X-Frame-Options"] == "DENY" and headers["Cache-Control"] == "no-store"


def test_sizes_and_messages_that_no_browser_sends_end_nothing(tmp_path):
    async def visit(played: Played) -> None:
        async with aiohttp.ClientSession() as client:
            for text in ("{", "[]", "{}", '["stdin", 5]', '["resize", {}]', '["resize", {"width": "x", "height": 1}]'):
                async with client.ws_connect(f"{played.address}ws", origin=played.address.rsplit("/", 2)[0]) as socket:
                    await socket.send_str(text)
                    await Page(socket).closed()
            huge = "9" * 12
            async with client.ws_connect(f"{played.address}ws?width={huge}&height=-{huge}") as socket:
                for size in ({"width": 1e300, "height": 10**12}, {"width": -5, "height": 0}):
                    await socket.send_json(["resize", size])
                await socket.receive()
                async with client.ws_connect(f"{played.address}ws?width=80&height=24") as another:
                    await Page(another).until("participant P07")
                    biggest = max(_peak_mib(process) for process in _descendants(played.program.pid))
                    await Page(another).type("sy")
                    await Page(another).closed()
        assert biggest < 300

    with playing(tmp_path / "log") as played:
        asyncio.run(visit(played))
        assert played.program.wait() == 0 and played.asked() == [("stop", None)]
        assert played.program.stderr.read() == ""


def _descendants(pid: int) -> list[int]:
    children = [int(line) for line in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    return [*children, *(grandchild for child in children for grandchild in _descendants(child))]


def _peak_mib(pid: int) -> float:
    # One that has just ended and was not waited for yet has no memory.
    try:
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    except (FileNotFoundError, ProcessLookupError):
        return 0
    return next((int(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM")), 0)


def test_only_this_machine_and_only_the_whole_address_gets_in(tmp_path):

    with playing(tmp_path / "log") as played:
        assert played.address.startswith("http://127.0.0.1:")
        root, token = played.address[:-1].rsplit("/", 1)
        assert len(token) >= 32
        wrong = token[:-1] + ("A" if token[-1] != "A" else "B")
        inside = ["", "ws", "static/js/textual.js"]
        refused = [
            f"{root}/{page}" for page in ("", "ws", "static/js/textual.js", *(f"{wrong}/{path}" for path in inside))
        ]
        assert set(asyncio.run(statuses(refused))) == {404}
        assert asyncio.run(statuses([f"{played.address}{path}" for path in ("", "static/js/textual.js")])) == [200, 200]
        port = int(root.rsplit(":", 1)[1])
        listening = [line.split()[1] for line in Path("/proc/net/tcp").read_text().splitlines()[1:] if " 0A " in line]
        assert [line for line in listening if line.endswith(f":{port:04X}")] == [f"0100007F:{port:04X}"]


def test_the_server_and_the_page_end_with_a_session_that_is_killed(tmp_path):
    async def visit(played: Played) -> None:
        async with page_of(played.address) as page:
            await page.until("participant P07")
            played.program.send_signal(signal.SIGKILL)
            await page.closed()

    with playing(tmp_path / "log") as played:
        asyncio.run(visit(played))
        # The server holds stderr open as long as it lives.
        assert played.program.stderr.read() == ""
        assert not list(played.folder.iterdir())


def test_a_server_that_dies_leaves_the_session_a_console_of_lines(capfd):
    with make_console("browser", HEADING) as console:
        console.server.kill()
        console.server.wait()
        console.tell(console._state)
        console.say("it goes on")
    assert "console: it goes on" in capfd.readouterr().err


def test_without_textual_serve_one_line_says_how(monkeypatch):
    monkeypatch.setitem(sys.modules, "textual_serve", None)
    with pytest.raises(MachineError, match=r"textual-serve, which is not installed: pip install '\.\[study\]'"):
        make_console("browser", "")


class Chromium:
    """A page in Chromium, by its DevTools protocol."""

    def __init__(self, socket) -> None:
        self._socket, self._number = socket, 0

    async def do(self, method: str, **parameters: object) -> dict:
        self._number += 1
        await self._socket.send_json({"id": self._number, "method": method, "params": parameters})
        while (answer := await self._socket.receive_json()).get("id") != self._number:
            pass
        assert "error" not in answer, answer
        return answer["result"]

    async def value(self, expression: str) -> object:
        return (await self.do("Runtime.evaluate", expression=expression, returnByValue=True))["result"].get("value")

    async def picture(self) -> np.ndarray:
        shot = await self.do("Page.captureScreenshot")
        return np.asarray(Image.open(io.BytesIO(base64.b64decode(shot["data"]))).convert("RGB"))


@contextlib.asynccontextmanager
async def chromium(profile: Path, address: str) -> AsyncIterator[Chromium]:
    flags = ["--headless", "--no-sandbox", "--disable-gpu", "--window-size=1000,700", "--remote-debugging-port=0"]
    command = [needs.program("chromium"), *flags, f"--user-data-dir={profile}", address]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    try:
        line = next(line for line in process.stderr if "DevTools listening" in line)
        listing = f"http://{line.split('//')[1].split('/')[0]}/json/list"
        async with aiohttp.ClientSession() as client:
            urls: list[str] = []
            while not urls:  # it listens before it has a page
                async with client.get(listing) as answer:
                    pages = json.loads(await answer.text())
                urls = [page["webSocketDebuggerUrl"] for page in pages if page["type"] == "page"]
            async with client.ws_connect(urls[0], max_msg_size=0) as socket:
                yield Chromium(socket)
    finally:
        process.kill()
        process.wait()
        process.stderr.close()


@needs.programs("chromium")
@pytest.mark.slow(15)
def test_in_chromium_it_is_drawn_and_takes_keys(tmp_path):
    async def visit(played: Played) -> None:
        async with chromium(tmp_path / "profile", played.address) as browser:
            while not await browser.value("document.body.className.includes('-first-byte')"):
                await asyncio.sleep(0.05)
            outside = "performance.getEntriesByType('resource').map(e => e.name).filter(n => !n.startsWith(location))"
            assert await browser.value(outside) == []
            before = await browser.picture()
            played.show("asking")
            while True:  # until the question is drawn
                picture = await browser.picture()
                if (picture != before).any(axis=2).mean() > 0.01:
                    break
                await asyncio.sleep(0.05)
            if "CONSOLE_SHOT" in os.environ:
                Image.fromarray(picture).save(os.environ["CONSOLE_SHOT"])
            for key in ("r", "p"):
                await browser.do("Input.dispatchKeyEvent", type="keyDown", key=key, text=key)
            while len(played.asked()) < 2:
                await asyncio.sleep(0.05)

    with playing(tmp_path / "log") as played:
        played.log.touch()
        asyncio.run(visit(played))
        assert [name for name, _ in played.asked()] == ["again", "pause"]
