"""Real frames with depth: how they are found, fetched and measured; they are never part of this."""

from __future__ import annotations

import hashlib
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "docs"))
import real_frames  # noqa: E402

from hmdwarp import warp_image  # noqa: E402
from hmdwarp.metrics import psnr  # noqa: E402

DEVELOPMENT = ROOT.parent / "shared" / "rgbd"
FOLDER = real_frames.folder_of() or real_frames.folder_of(str(DEVELOPMENT))


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
