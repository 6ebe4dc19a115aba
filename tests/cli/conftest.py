"""Runs the command line.

In this process where that is enough, as a program of its own where signals and streams matter.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import attrs
import pytest
from commands import status_of

PROGRAM = [sys.executable, "-m", "hmdwarp"]
ROOT = Path(__file__).resolve().parents[2]
PROGRESS = re.compile(r"preparing |(refreshes|instants|recordings|studies): ")


def complaints(err: str | bytes) -> list[str]:
    """The lines on stderr but for those that tell how far the command is."""
    text = err.decode() if isinstance(err, bytes) else err
    return [line for line in text.splitlines() if not PROGRESS.match(line)]


@attrs.frozen
class Done:
    """How a command ended."""

    status: int
    out: str
    err: str

    def refused(self, *told: str, status: int = 2) -> None:
        """It ended with that status and one line on stderr that holds each of `told`, and printed
        nothing else.
        """
        assert self.status == status, self
        assert self.out == "", self
        (line,) = complaints(self.err)
        assert line.startswith("hmdwarp: ") and self.err.endswith("\n"), self
        assert "Traceback" not in self.err
        for text in told:
            assert text in self.err, self

    def done(self) -> Done:
        """It ended well and complained about nothing."""
        assert self.status == 0 and not complaints(self.err), self
        return self


@pytest.fixture
def command(capfd) -> Callable[..., Done]:
    """command("replay", "still", ..) in this process, with real file descriptors caught."""

    def call(*arguments: object) -> Done:
        capfd.readouterr()
        return Done(status_of([*map(str, arguments)]), *capfd.readouterr())

    return call


@pytest.fixture
def program() -> Callable[..., Done]:
    """program("replay", .., env={}) as a process of its own."""

    def call(*arguments: object, env: dict[str, str] | None = None, **options: object) -> Done:
        environment = {**os.environ, "PYTHONPATH": str(ROOT), **(env or {})}
        done = subprocess.run(
            [*PROGRAM, *map(str, arguments)], capture_output=True, text=True, env=environment, check=False, **options
        )
        return Done(done.returncode, done.stdout, done.stderr)

    return call


@pytest.fixture
def quick(tmp_path) -> list[str]:
    """Options of a replay that takes well under a second and says nothing."""
    return [
        "--scene", "planes", "--headset", "rift-dk1", "--size", "48x40", "--seconds", "0.1", "--workers", "0",
        "--against", "", "--quiet", "--out", str(tmp_path / "out"),
    ]  # fmt: skip


@pytest.fixture
def kept(tmp_path):
    """An output folder with earlier results.

    Afterwards they must be there as before, and nothing beside them.
    """
    out = tmp_path / "out"
    (out / "images").mkdir(parents=True)
    before = {
        "summary.json": b'{"hmdwarp": "0"}',
        "frames.csv": b"frame\n",
        "report.html": b"<html>",
        "images/frame-000000-left.png": b"png",
        "mine.txt": b"mine",
    }
    for name, data in before.items():
        (out / name).write_bytes(data)
    yield out
    found = {p.relative_to(out).as_posix(): p.read_bytes() for p in out.rglob("*") if p.is_file()}
    assert found == before
    assert sorted(p.name for p in out.iterdir()) == ["frames.csv", "images", "mine.txt", "report.html", "summary.json"]
