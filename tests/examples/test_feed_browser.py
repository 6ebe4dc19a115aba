"""examples/feed_browser: a page that shows a session with a feed, in Chromium."""

from __future__ import annotations

import io
import json
import re
import subprocess
import sys
import urllib.request
from pathlib import Path

import needs
import numpy as np
import pytest
from PIL import Image
from serving import Serving

pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")

SCRIPT = Path(__file__).resolve().parents[2] / "examples" / "feed_browser" / "show.py"


@pytest.fixture(scope="module")
def page():
    """The address of the page, with a renderer behind it, each in a process of its own."""
    with Serving("--scene", "planes") as server:
        show = [sys.executable, str(SCRIPT), server.address.removeprefix("tcp://"), "0"]
        with subprocess.Popen(show, stdout=subprocess.PIPE, text=True) as session:
            assert session.stdout is not None
            yield session.stdout.readline().split()[1]
            session.terminate()


def test_pictures_and_figures_come(page):
    with urllib.request.urlopen(f"{page}figures") as told:
        figures = json.loads(told.readline().removeprefix(b"data: "))
    assert figures["frames"] >= 1 and 0 < figures["latency_ms"] <= figures["age_ms"]
    with urllib.request.urlopen(f"{page}shown.mjpeg") as stream:
        length = next(int(line.split()[1]) for line in stream if line.startswith(b"Content-Length"))
        stream.readline()
        picture = np.asarray(Image.open(io.BytesIO(stream.read(length))))
    assert picture.shape == (360, 480, 3) and picture.std() > 10


@needs.programs("chromium")
def test_a_browser_shows_them(page, tmp_path):
    with urllib.request.urlopen(f"{page}figures") as told:
        told.readline()  # the session is under way
    shot = tmp_path / "page.png"
    # The page never ends loading, as its pictures do not: Chromium is told when to look. A slow
    # machine gets more time.
    for wait_ms in (3000, 10_000, 60_000):
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--window-size=1000,1000", f"--timeout={wait_ms}"]
        command = [needs.program("chromium"), *options, f"--user-data-dir={tmp_path / 'profile'}"]
        dom = subprocess.run([*command, "--dump-dom", page], capture_output=True, text=True, check=True).stdout
        subprocess.run([*command, f"--screenshot={shot}", page], capture_output=True, check=True)
        frames = re.search(r'id="frames">(\d+)<', dom)
        shown = np.asarray(Image.open(shot).convert("RGB"))[100:700, 50:900]
        if frames is not None and int(frames[1]) > 0 and shown.std() > 10:
            return
    raise AssertionError(dom)
