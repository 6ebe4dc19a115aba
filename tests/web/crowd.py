"""Those who crowd both doors: connections that never finish, and pages, for tests and soaks."""

from __future__ import annotations

import asyncio
import os
import random
import time
from contextlib import AsyncExitStack, suppress
from pathlib import Path
from urllib.parse import urlsplit

import aiohttp
from serving import Serving

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.sources.feed.message import RGBA8, Ask, Wish, decode, encode

EYES = (View(Pose((0, 1.6, 0)), Fov.symmetric(1.57, 1.4)),)


def ask(number: int = 1, size=(64, 48)) -> bytes:
    return encode(Ask(number, 0, 0, 0, 0, size, Pose((0, 1.6, 0)), EYES, wish=Wish(RGBA8)))


def held_by(process: int) -> tuple[int, int]:
    """MiB in memory, and open descriptors."""
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") >> 20, len(list(Path(f"/proc/{process}/fd").iterdir()))


class Crowd:
    """At the door of a server; the honest one comes from an address of its own, 127.0.0.2."""

    def __init__(self, serving: Serving, cookie: str, seed: int = 1) -> None:
        self.door, self._cookie, self._random = urlsplit(serving.door), cookie, random.Random(seed)
        self._ports = self.door.port, urlsplit(serving.address).port
        self.longest_s, self.frames = 0.0, 0

    def _session(self, stack: AsyncExitStack, host: str) -> aiohttp.ClientSession:
        connector = aiohttp.TCPConnector(local_addr=(host, 0))
        return aiohttp.ClientSession(connector=connector, headers={"Cookie": self._cookie})

    async def honest(self, until_s: float) -> None:
        """Open the page anew, load a file and see five frames, again and again."""
        feed = f"ws://{self.door.netloc}/feed"
        while time.monotonic() < until_s:
            async with AsyncExitStack() as stack:
                session = await stack.enter_async_context(self._session(stack, "127.0.0.2"))
                begun_s = time.monotonic()
                async with session.get(f"http://{self.door.netloc}/main.js") as file:
                    assert file.status == 200 and await file.read()
                socket = await stack.enter_async_context(session.ws_connect(feed, max_msg_size=1 << 28))
                for number in range(1, 6):
                    await socket.send_bytes(ask(number))
                    assert decode((await socket.receive()).data).number == number
                    self.frames, now_s = self.frames + 1, time.monotonic()
                    self.longest_s, begun_s = max(self.longest_s, now_s - begun_s), now_s

    async def slow(self, until_s: float, at: int) -> None:
        """Begin a request at a door and never end it; anew where that is cut."""
        while time.monotonic() < until_s:
            with suppress(OSError):
                _, writer = await asyncio.open_connection(self.door.hostname, self._ports[at])
                for letter in (b"GET / HTTP/1.1\r\nHost: ", b"\xff" + bytes(8) + b"\x7f\x03")[at] + b"x" * 1000:
                    writer.write(bytes([letter]))
                    await writer.drain()
                    await asyncio.sleep(self._random.random())
                    if time.monotonic() > until_s or writer.is_closing():
                        break
                writer.transport.abort()

    async def page(self, until_s: float) -> None:
        """Send what no page sends, and requests whose frames are not read."""
        while time.monotonic() < until_s:
            with suppress(OSError, aiohttp.ClientError):
                async with AsyncExitStack() as stack:
                    session = await stack.enter_async_context(self._session(stack, "127.0.0.1"))
                    socket = await stack.enter_async_context(session.ws_connect(f"ws://{self.door.netloc}/feed"))
                    for number in range(1, self._random.randrange(2, 30)):
                        data = bytearray(ask(number, (512, 384)))
                        if self._random.random() < 0.3:
                            data[self._random.randrange(len(data))] = self._random.randrange(256)
                        await socket.send_bytes(bytes(data))
                        await asyncio.sleep(0.02)
                    if self._random.random() < 0.5:
                        await socket.send_str("[" * self._random.randrange(1, 60_000))

    async def all(self, seconds: float, slow: int, pages: int) -> None:
        """Run all of them for some seconds."""
        until_s = time.monotonic() + seconds
        crowd = [asyncio.ensure_future(self.slow(until_s, number % 2)) for number in range(slow)]
        crowd += [asyncio.ensure_future(self.page(until_s)) for _ in range(pages)]
        await self.honest(until_s)
        await asyncio.gather(*crowd)
