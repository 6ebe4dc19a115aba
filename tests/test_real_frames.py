"""Real frames with depth: how they are found, fetched and measured; they are never part of this."""

from __future__ import annotations

import hashlib
import http.server
import sys
import threading
from pathlib import Path

import attrs
import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "docs"))
import real_frames  # noqa: E402

from hmdwarp import warp_image  # noqa: E402
from hmdwarp.metrics import psnr  # noqa: E402

DEVELOPMENT = ROOT.parent / "shared" / "rgbd"
FOLDER = real_frames.folder_of() or real_frames.folder_of(str(DEVELOPMENT))


def write_set(folder: Path, frames: real_frames.RealFrames) -> None:
    """Five pictures of a wall with depth, in a set's layout; the camera goes sideways."""
    rng = np.random.default_rng(0)
    wall = np.asarray(Image.fromarray(rng.integers(0, 256, (8, 12, 3), dtype=np.uint8)).resize((96, 64)))
    poses = []
    for number in range(1, 6):
        depth = np.full((48, 64), 2 * round(1 / frames.options.depth_scale), np.uint16)
        depth[6 + 2 * number : 26 + 2 * number, 20:40] = 0
        for name, picture in (("color", wall[:48, number : number + 64]), ("depth", depth)):
            path = folder / name / f"{number}.{'png' if name == 'color' else frames.depths}"
            path.parent.mkdir(parents=True, exist_ok=True)
            Image.fromarray(picture).save(path)
        poses.append(" ".join(map(str, (0.02 * number, 0, 0, *Rotation.identity().as_quat()))))
    (folder / "pose.txt").write_text("\n".join(poses), encoding="utf-8")


@pytest.fixture
def sets(tmp_path, monkeypatch):
    """Small sets of our own in the place of the real ones, in tmp_path / "there"."""
    made = []
    for frames in real_frames.SETS:
        folder = tmp_path / "there" / frames.name
        write_set(folder, frames)
        made.append(attrs.evolve(frames, rim=4, digest=real_frames.digest_of(folder, frames)))
    monkeypatch.setattr(real_frames, "SETS", tuple(made))
    return tmp_path / "there"


def test_frames_are_fetched_once_and_checked(sets, tmp_path, monkeypatch):
    """From a server of our own; a damaged file is told, and nothing is fetched twice."""
    asked = []

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked.append(self.path)
            place = {frames.place: frames.name for frames in real_frames.SETS}
            name = next(self.path[len(p) + 2 :] for p in place if self.path.startswith(f"/{p}/"))
            content = (sets / next(n for p, n in place.items() if self.path.startswith(f"/{p}/")) / name).read_bytes()
            self.send_response(200)
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, *_: object) -> None:
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    monkeypatch.setattr(real_frames, "SOURCE", f"http://127.0.0.1:{server.server_port}")
    here = tmp_path / "here"
    real_frames.fetch(here)
    assert len(asked) == 22 and real_frames.folder_of(str(here)) == here
    real_frames.fetch(here)
    assert len(asked) == 22
    (here / "icl" / "color" / "3.png").write_bytes(b"not a picture")
    with pytest.raises(SystemExit, match="not the files of commit"):
        real_frames.fetch(here)
    server.shutdown()
    server.server_close()


@pytest.mark.skipif(FOLDER is None, reason=real_frames.why_absent())
@pytest.mark.parametrize(("name", "gain_db"), [("camera", 2.0), ("icl", -0.05)])
def test_repairs_gain_on_real_frames_and_cost_nothing_where_depth_is_exact(name, gain_db):
    """Measured: 2.5 dB from frame 4 to 5 of the camera, 0.00 dB on the ray-traced ones."""
    frames = next(frames for frames in real_frames.SETS if frames.name == name)
    assert FOLDER is not None and real_frames.digest_of(FOLDER / name, frames) == frames.digest
    sequence = real_frames.sequences.open(FOLDER / name, frames.options)
    late, now = sequence.frames[3], sequence.frames[4]
    inside = (slice(frames.rim, -frames.rim or None),) * 2
    colour = real_frames.without_rim(late.colour, frames.rim)
    none, both = (
        psnr(warp_image(colour, late.depth_m, late.view, now.view, repair=repair).colour[inside], now.colour[inside])
        for repair in ("none", "edges+complete")
    )
    assert both > none + gain_db


def test_no_real_frame_is_part_of_this():
    """By its content: no file of the repository is one of theirs."""
    if FOLDER is None:
        pytest.skip(real_frames.why_absent())
    theirs = {
        hashlib.sha256((FOLDER / frames.name / name).read_bytes()).digest()
        for frames in real_frames.SETS
        for name in frames.files()
    }
    ours = [path for path in ROOT.rglob("*") if path.suffix in (".png", ".pgm", ".txt") and path.is_file()]
    assert not [path for path in ours if hashlib.sha256(path.read_bytes()).digest() in theirs]
