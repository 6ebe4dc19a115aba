"""`hmdwarp serve` in a process of its own, for tests."""

from __future__ import annotations

import os
import queue
import socket
import subprocess
import sys
import threading


def free_port() -> int:
    """Return a port of the loopback that nothing listens at."""
    with socket.create_server(("127.0.0.1", 0)) as one:
        return int(one.getsockname()[1])


class Serving:
    """`hmdwarp serve` in a process of its own, at a port that was free: planes, one sample."""

    def __init__(self, *options: str, inside: tuple[str, ...] = (), command: str = "serve") -> None:
        where = () if "--listen" in options else ("--listen", "127.0.0.1:*")
        scene = () if {"--scene", "--frames"} & {*options} or command != "serve" else ("--scene", "planes")
        if command == "serve" and not {"--samples", "--frames"} & {*options}:
            scene += ("--samples", "1")
        arguments = [*inside, sys.executable, "-m", "hmdwarp", command, *scene, *where, *options]
        self.process = subprocess.Popen(
            arguments, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True, env=os.environ
        )
        self.lines: queue.Queue[str | None] = queue.Queue()  # None once it has ended
        self._said: list[str] = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self.address = self.line("listening at").split()[2].rstrip(":")

    def _read(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self._said.append(line)
            self.lines.put(line)
        self.lines.put(None)

    def line(self, start: str) -> str:
        """Wait for a line of the log, as long as the server lives; the limit is a fail-safe."""
        while (line := self.lines.get(timeout=300)) is not None:
            if start in line:
                return line
        raise AssertionError(f"the server ended and never said '{start}': {''.join(self._said[-20:])}")

    def __enter__(self) -> Serving:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        self.process.wait()
        self._reader.join()
        assert self.process.stderr is not None
        self.process.stderr.close()
