"""Recorded frames, and replays of them."""

from __future__ import annotations

from pathlib import Path

import pytest
from recorded_folders import taken, write_npz
from replays import replayed

from hmdwarp.run import ReplayResult

from .recorded import COUNT, SIZE, options


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Twelve frames at 30 Hz; from one to the next the camera moves 2 cm and turns 1 degree."""
    path = tmp_path_factory.mktemp("recorded") / "walk-past"
    path.mkdir()
    write_npz(path, taken(COUNT, SIZE))
    return path


@pytest.fixture
def run(folder, tmp_path, gpu):
    """run(folder=..., page=False, **said): a replay into tmp_path / "out"."""

    def call(folder: Path = folder, page: bool = False, **said: object) -> ReplayResult:
        return replayed(options(folder, tmp_path / "out", force=True, **said), page, gpu)

    return call
