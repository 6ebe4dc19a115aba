"""A network between two ends on this machine: TCP through a relay that delays, stalls, cuts."""

from __future__ import annotations

import asyncio
import random
import socket
import threading
import time
from contextlib import suppress

_Pair = tuple[asyncio.StreamWriter, asyncio.StreamWriter]


class Relay:
    """Pass bytes on to a port, both ways, as its attributes say at the moment. What TCP makes of
    loss and reordering is a delay or, in the end, a cut: both are here."""

    def __init__(self, port: int, seed: int = 1) -> None:
        self.delay_s = self.jitter_s = 0.0
        # Each way; None for no limit.
        self.bytes_s: float | None = None
        self.is_stalled = self.is_down = False
        # Ways that nothing crosses, though all connections stay open: "up" to the port, and "down".
        self.silent: set[str] = set()
        # Whether the next large piece that goes down is the last of its connection, both ways.
        self.freezes_within = False
        # What went by, both ways, where it is a bytearray.
        self.seen: bytearray | None = None
        # How many connections there were.
        self.accepted = 0
        self._port, self._random = port, random.Random(seed)
        # Connections, and the ways that are frozen of each.
        self._frozen: dict[_Pair, set[str]] = {}
        self._loop, self._ended = asyncio.new_event_loop(), False
        listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{listener.getsockname()[1]}"
        self._thread = threading.Thread(target=self._loop.run_until_complete, args=[self._run(listener)], daemon=True)
        self._thread.start()

    async def _run(self, listener: socket.socket) -> None:
        async with await asyncio.start_server(self._accept, sock=listener):
            while not self._ended:
                await asyncio.sleep(0.005)
        while self._frozen:
            self.cut()
            await asyncio.sleep(0.005)

    async def _accept(self, source: asyncio.StreamReader, here: asyncio.StreamWriter) -> None:
        with suppress(OSError):
            if not (self.is_down or self._ended):
                answers, there = await asyncio.open_connection("127.0.0.1", self._port)
                self.accepted += 1
                self._frozen[here, there] = set()
                await asyncio.gather(
                    self._pass("up", source, there, (here, there)), self._pass("down", answers, here, (here, there))
                )
                del self._frozen[here, there]
        here.close()

    async def _pass(self, way: str, source: asyncio.StreamReader, target: asyncio.StreamWriter, pair: _Pair) -> None:
        waiting: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue(64)
        reading = asyncio.create_task(self._read(source, waiting))
        with suppress(OSError):
            while True:
                due, data = await waiting.get()
                while not self._ended and (self._holds(way, pair) or time.monotonic() < due):
                    await asyncio.sleep(0.001)
                if not data:
                    break
                if self.freezes_within and way == "down" and len(data) > 10_000:
                    self._frozen[pair] = {"up", "down"}
                    self.freezes_within, data = False, data[:5000]
                if self.bytes_s:
                    await asyncio.sleep(len(data) / self.bytes_s)
                if self.seen is not None:
                    self.seen += data
                target.write(data)
                await target.drain()
        reading.cancel()
        for end in pair:
            end.close()

    def _holds(self, way: str, pair: _Pair) -> bool:
        return self.is_stalled or way in self.silent | self._frozen[pair]

    async def _read(self, source: asyncio.StreamReader, waiting: asyncio.Queue[tuple[float, bytes]]) -> None:
        due, data = 0.0, b"-"
        while data:
            try:
                data = await source.read(1 << 16)
            except OSError:
                data = b""
            due = max(due, time.monotonic() + self.delay_s + self._random.uniform(0, self.jitter_s))
            await waiting.put((due, data))

    def freeze(self, *ways: str) -> None:
        """Let nothing cross the connections of now any more; they stay open, and new ones work."""
        self._frozen |= {pair: set(ways) for pair in self._frozen}

    def cut(self) -> None:
        """Break every connection there is; new ones pass unless is_down."""
        for end in (end for pair in [*self._frozen] for end in pair):
            self._loop.call_soon_threadsafe(end.close)

    def __enter__(self) -> Relay:
        return self

    def __exit__(self, *_: object) -> None:
        self._ended = True
        self._thread.join()
        self._loop.close()
