"""Replays of recorded frames with gaps in their depth, repaired before the warp."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from recorded_folders import taken, write_npz

from hmdwarp.pipeline import PipelineOptions
from hmdwarp.pipeline.recorded_source import RecordingSource
from hmdwarp.run import RunOptions, replay
from hmdwarp.sources import sequences
from hmdwarp.sources.repairs import parse_repairs

SIZE = (60, 40)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Eight frames of a wall; the camera saw no depth in a quarter of it."""
    path = tmp_path_factory.mktemp("recorded") / "gaps"
    path.mkdir()
    frames = taken(8, SIZE)
    for frame in frames:
        frame.depth_m[10:30, 15:45] = 0
    write_npz(path, frames)
    return path


def options(folder: Path, out: Path, **said: object) -> RunOptions:
    usual = {"latency": 67.0, "warp": "iterative", "fill": "none", "against": "", "metrics_every": 2, "images": 0}
    return RunOptions.of({**usual, "workers": 0, "frames": folder, "out": out, "force": True, **said})


def test_late_frames_are_repaired_and_the_truth_is_not(folder, tmp_path):
    found = {repair: replay(options(folder, tmp_path / repair, repair=repair)) for repair in ("none", "edges+complete")}
    holes, psnr = (
        {repair: run.summary["quality"][name]["mean"] for repair, run in found.items()}
        for name in ("hole_share", "psnr_db")
    )
    # The gap is a quarter of the picture; repaired, what is left is what the camera has turned to.
    assert holes["none"] > 0.25 and holes["edges+complete"] < 0.1
    assert psnr["edges+complete"] > psnr["none"] + 3
    page = (tmp_path / "edges+complete" / "report.html").read_text(encoding="utf-8").replace("<wbr>", "")
    assert "The depth of late frames is mended by edges+complete" in page
    assert "mended" not in (tmp_path / "none" / "report.html").read_text(encoding="utf-8")


def test_the_server_gives_repaired_frames_and_truth_as_it_was_recorded(folder, gpu):
    from hmdwarp.gpu import download

    sequence = sequences.open(folder).repaired(parse_repairs("complete"))
    server = RecordingSource(sequence).renderer(gpu, PipelineOptions())
    late = server.draw_frame([sequence.frames[0].view], 10**9, SIZE).eyes[0]
    inverse, colour = download(late.inverse_depth), download(late.colour)
    truth = server.draw(late.view, SIZE, time_ns=10**9)
    assert (inverse > 0).all() and (download(truth.inverse_depth)[10:30, 15:45] == -1).all()
    assert np.array_equal(download(truth.colour), colour)  # a repair changes no colour
    server.close()
