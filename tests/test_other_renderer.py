"""Frames of another renderer: by their truth, conventions and warps hold outside this program."""

from __future__ import annotations

import importlib.util

import mitsuba_frames
import pytest
from needs import missing

from hmdwarp.check import check, read_stated
from hmdwarp.run import RunOptions, measured
from hmdwarp.sources.sequences import SequenceOptions

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("mitsuba") is None, reason=missing("Mitsuba", "pip install mitsuba")
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("mitsuba") / "railing"
    path.mkdir()
    mitsuba_frames.draw(path)
    return path


def test_every_convention_that_one_eye_tells_is_as_stated(folder):
    answer = check(read_stated([folder], SequenceOptions()))
    assert answer.headline.startswith("right")
    untold = {finding.name for finding in answer.findings if not finding.told}
    assert untold == {"eyes"} and all(finding.as_stated for finding in answer.findings)


def test_a_warp_by_depth_beats_one_by_rotation_and_that_beats_none(folder):
    """By 1 dB at least: the noise of one render, 64 samples, is the same for all."""
    usual = {"frames": folder, "latency": 100.0, "guard": "1.25", "fill": "pyramid", "metrics_every": 1, "workers": 0}
    found = {
        warp: measured(RunOptions.of({**usual, "warp": warp, "against": ""})).summary["quality"]["psnr_db"]["mean"]
        for warp in ("none", "rotation", "iterative")
    }
    assert found["none"] + 1 < found["rotation"] < found["iterative"] - 1
