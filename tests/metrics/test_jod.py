"""JOD by ColorVideoVDP: its scale, what it rates, and what a run without the package says."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from ratings import crashing_torch, quiet, with_cvvdp, without_cvvdp  # noqa: F401  (a fixture)
from replays import run

import hmdwarp.headsets
from hmdwarp.base import MachineError
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.metrics import Clips, Compared, ShownOn, preferring

VIEW = View(Pose(), Fov.symmetric(np.deg2rad(90), np.deg2rad(90)))


def test_one_jod_is_three_of_four_people():
    assert preferring(9.0, 8.0) == pytest.approx(0.75)
    assert preferring(8.0, 8.0) == 0.5
    assert preferring(8.0, 9.5) == pytest.approx(1 - preferring(9.5, 8.0))


@without_cvvdp
def test_without_the_package_a_run_says_how_to_get_it(tmp_path):
    with pytest.raises(MachineError, match=r"needs cvvdp.*pip install '\.\[jod\]'"):
        run(tmp_path / "out", jod_s=0.2)
    assert not [*tmp_path.iterdir()]


def test_a_run_imports_it_only_where_asked_to_and_goes_on_after_a_crash(tmp_path, crashing_torch):  # noqa: F811
    there = {name for name in ("pycvvdp", "torch") if name in sys.modules}
    assert "jod" not in run(tmp_path / "plain").summary
    assert {name for name in ("pycvvdp", "torch") if name in sys.modules} == there
    result = run(tmp_path / "out", jod_s=0.1, seconds=0.2, against="none")
    assert "jod" not in result.summary and result.summary["jod_failure"] == crashing_torch
    assert result.summary["notes"].count(crashing_torch) == 1


def rated(shown: list[np.ndarray], truth: np.ndarray, second_s: float, pixels_per_degree: float) -> Clips:
    """Of several pictures in the place of each true one."""
    clips = Clips(second_s, ShownOn(60, pixels_per_degree))
    for which, pictures in enumerate(shown):
        for number, (picture, right) in enumerate(zip(pictures, truth, strict=True)):
            clips.add(number, 0, which, Compared(picture, right, VIEW))
    clips.finish()
    return clips


@with_cvvdp
@quiet
def test_the_truth_has_ten_and_more_error_has_less():
    rng = np.random.default_rng(0)
    truth = rng.integers(60, 180, (6, 64, 64, 3)).astype(np.uint8)
    shown = [(truth + rng.integers(-most, most + 1, truth.shape)).astype(np.uint8) for most in (0, 6, 30)]
    clips = rated(shown, truth, 0.1, 8.0)
    entries = [clips.entry(which) for which in range(3)]
    assert entries[0]["mean"] == 10
    assert 10 > entries[1]["mean"] > entries[2]["mean"]
    for entry in entries:
        assert entry["truth_preferred"] == pytest.approx(preferring(10, entry["mean"]))


@with_cvvdp
@quiet
def test_error_finer_than_people_see_counts_less():
    """A chequered error has its power at half the pixels per degree: here 4 and 30 cycles.

    Contrast sensitivity at 30 is below a tenth of that at 4 (Barten 1999).
    """
    truth = np.full((4, 64, 64, 3), 120, np.uint8)
    shown = truth + (np.indices((64, 64)).sum(axis=0) % 2 * 6).astype(np.uint8)[None, :, :, None]
    coarse, fine = (rated([shown], truth, 1, pixels_per_degree).entry(0)["mean"] for pixels_per_degree in (8.0, 60.0))
    assert coarse < fine


@with_cvvdp
@quiet
def test_a_replay_rates_every_refresh_and_its_comparison_twice_the_same(tmp_path):
    headset = tmp_path / "bright.toml"
    flat = (Path(hmdwarp.headsets.__file__).parent / "flat-90.toml").read_text()
    headset.write_text(flat.replace("refresh_hz", "peak_cd_m2 = 80\nblack_cd_m2 = 0.2\nrefresh_hz"))
    options = {"jod_s": 0.1, "seconds": 0.2, "against": "none", "fill": "interpolate", "headset": str(headset)}
    first, second = (run(tmp_path / name, **options).summary["jod"] for name in ("a", "b"))
    assert first == second
    assert len(first["clips"]) == 2
    assert {"peak_cd_m2": 80, "black_cd_m2": 0.2, "rate_hz": 60}.items() <= first["display"].items()
    assert first["mean"] > first["against"][0]["mean"]
    notes = json.loads((tmp_path / "a" / "summary.json").read_text())["notes"]
    assert any(f"like the truth, none {first['against'][0]['mean']:.2f}. " in note for note in notes)
