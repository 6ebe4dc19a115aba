"""A network between two ends on this machine: TCP through a relay that delays, stalls, cuts."""

from __future__ import annotations

import contextlib
import queue
import random
import socket
import threading
import time


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
        self._frozen: dict[tuple[socket.socket, socket.socket], set[str]] = {}
        # What went by, both ways, where it is a bytearray.
        self.seen: bytearray | None = None
        # How many connections there were.
        self.accepted = 0
        self._port, self._random, self._ended = port, random.Random(seed), False
        # Which ways each connection still has.
        self._ways: dict[tuple[socket.socket, socket.socket], int] = {}
        self._lock = threading.Lock()
        self._threads: list[threading.Thread] = []
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self._listener.getsockname()[1]}"
        self._start(self._accept)

    def _start(self, run, *given) -> None:
        thread = threading.Thread(target=run, args=given, daemon=True)
        self._threads.append(thread)
        thread.start()

    def _accept(self) -> None:
        while not self._ended:
            try:
                here, _ = self._listener.accept()
            except OSError:
                return
            there = None if self.is_down or self._ended else self._connected()
            if there is None:
                here.close()
                continue
            with self._lock:
                self._ways[here, there] = 2
            self.accepted += 1
            for way, source, target in (("up", here, there), ("down", there, here)):
                waiting: queue.Queue[tuple[float, bytes]] = queue.Queue(64)
                self._start(self._read, source, waiting)
                self._start(self._write, way, target, source, waiting, (here, there))

    def _connected(self) -> socket.socket | None:
        try:
            return socket.create_connection(("127.0.0.1", self._port))
        except OSError:
            return None

    def _read(self, source: socket.socket, waiting: queue.Queue) -> None:
        due = 0.0
        while True:
            try:
                data = source.recv(1 << 16)
            except OSError:
                data = b""
            due = max(due, time.monotonic() + self.delay_s + self._random.uniform(0, self.jitter_s))
            waiting.put((due, data))
            if not data:
                return

    def freeze(self, *ways: str) -> None:
        """Let nothing cross the connections of now any more; they stay open, and new ones work."""
        with self._lock:
            self._frozen |= dict.fromkeys(self._ways, set(ways))

    def _holds(self, way: str, connection) -> bool:
        return self.is_stalled or way in self.silent or way in self._frozen.get(connection, ())

    def _write(self, way: str, target: socket.socket, source: socket.socket, waiting: queue.Queue, connection) -> None:
        is_open = True
        while True:
            due, data = waiting.get()
            while is_open and not self._ended and (self._holds(way, connection) or time.monotonic() < due):
                time.sleep(0.001)
            if not data:
                break
            if self.freezes_within and way == "down" and len(data) > 10_000:
                self._frozen[connection] = {"up", "down"}
                self.freezes_within, data = False, data[:5000]
            if self.bytes_s:
                time.sleep(len(data) / self.bytes_s)
            if self.seen is not None:
                self.seen += data
            try:
                target.sendall(data)
            except OSError:  # go on taking, so that the other end is not held up
                is_open = False
                _hang_up(source)
        _hang_up(target)
        with self._lock:
            self._ways[connection] -= 1
            if self._ways[connection]:
                return
            del self._ways[connection]
        for end in connection:
            end.close()

    def cut(self) -> None:
        """Break every connection there is; new ones pass unless is_down."""
        with self._lock:
            for connection in self._ways:
                for end in connection:
                    _hang_up(end)

    def __enter__(self) -> Relay:
        return self

    def __exit__(self, *_: object) -> None:
        self._ended = True
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self.cut()
        for thread in self._threads:
            thread.join()


def _hang_up(one: socket.socket) -> None:
    with contextlib.suppress(OSError):
        one.shutdown(socket.SHUT_RDWR)
