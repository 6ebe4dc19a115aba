"""Warps in Python: what their arrays hold, what they may return, and what is timed."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp import Fov, Pose, View
from hmdwarp.base import InputError, linear_from_srgb
from hmdwarp.client import Compensator, PassInputs, build_plan
from hmdwarp.client.warp_kinds import ArrayWarp
from hmdwarp.client.warps import warps
from hmdwarp.frames import EyeImage
from hmdwarp.gpu import COLOUR, SCALAR, allocate, download, upload

SIZE, FOV = (7, 5), Fov.symmetric(1.0, 0.8)
RENDERED, SHOWN = View(Pose(), FOV), View(Pose((0.1, 0, 0)), FOV)
RNG = np.random.default_rng(3)
COLOURS = np.dstack([RNG.random((5, 7, 3)), np.ones((5, 7))]).astype(np.float16)
INVERSE = np.linspace(0.1, 2, 35, dtype=np.float32).reshape(5, 7)
COLOURS[1, 2], INVERSE[0, 0], INVERSE[4, 6] = 0, 0, -1  # never drawn; infinitely far; no depth


class Given(ArrayWarp):
    """Returns what a test sets, and keeps what it got."""

    name, summary, source, exact_when, gets_wrong = "given", "", "", "", ""
    returns = None

    def warp(self, *got):
        type(self).got = got
        return got[0], got[1] > 0 if self.returns is None else self.returns


@pytest.fixture
def shown(gpu, monkeypatch):
    """Return the shown colour with coverage and the stages of one eye, for a fill."""
    list(warps)  # all are loaded before the copy, or they would be forgotten with it
    monkeypatch.setattr(warps, "_entries", dict(warps._entries))
    warps.register(Given)
    pair = [allocate(gpu.gl, SIZE, kind) for kind in (COLOUR, SCALAR)]
    for texture, picture in zip(pair, (COLOURS, INVERSE), strict=True):
        upload(texture, picture)

    def run(fill: str = "none") -> tuple[np.ndarray, list[str]]:
        made = Compensator(gpu, build_plan((), "given", fill, "none", client_geometry=False), None, SIZE, SIZE)
        gpu.timer.collect()
        result = made.run(PassInputs(EyeImage(RENDERED, *pair), SHOWN))
        found = download(result.warped.texture).astype(np.float64), [name for name, _ in gpu.timer.collect()]
        made.close()
        return found

    return run


def test_it_gets_arrays_of_its_own_top_row_first(shown):
    shown()
    colour, depth_m, rendered, now = Given.got
    assert (rendered, now) == (RENDERED, SHOWN)
    for array in (colour, depth_m):
        assert array.dtype == np.float32 and array.flags.writeable and array.flags.c_contiguous
    assert (colour == COLOURS[..., :3]).all()
    with np.errstate(divide="ignore"):
        expected = np.where((INVERSE < 0) | (COLOURS[..., 3] == 0), np.nan, 1 / INVERSE)
    assert np.array_equal(depth_m, expected, equal_nan=True) and np.isinf(depth_m[0, 0])


def test_what_is_returned_is_shown_and_holes_are_black(shown):
    """The identity is exact: light goes through half floats alone. NaN is no light."""
    found, _ = shown()
    covered = (INVERSE >= 0) & (COLOURS[..., 3] > 0)
    assert (found == np.where(covered[..., None], COLOURS, 0)).all()


@pytest.mark.parametrize("coverage", [np.ones((5, 7)), np.full((5, 7), 0.3), np.ones((5, 7), bool)])
def test_bytes_are_srgb_and_what_is_not_finite_is_a_hole(shown, monkeypatch, coverage):
    encoded = RNG.integers(0, 256, (5, 7, 3), np.uint8)
    monkeypatch.setattr(Given, "warp", lambda *_: (encoded, coverage))
    # A half float keeps 11 bits: half of the last one is 2^-12 of the value.
    assert shown()[0][..., :3] == pytest.approx(linear_from_srgb(encoded), rel=2**-11, abs=2**-24)
    light = np.ones((5, 7, 3))
    light[2, 3, 1] = np.nan
    monkeypatch.setattr(Given, "warp", lambda *_: (light, coverage))
    found, _ = shown()
    assert (found[2, 3] == 0).all() and (found[..., 3] == 1).sum() == 34


def test_its_time_is_that_of_its_call_also_where_a_fill_runs_it_again(shown):
    """Pyramid reads the depth of what is shown, which the warp carries along."""
    assert shown()[1] == ["warp"]
    assert shown("pyramid")[1].count("warp") == 1


@pytest.mark.parametrize("result", [(np.ones((5, 7)), np.ones((5, 7))), (np.ones((5, 7, 3)), np.ones(5))])
def test_arrays_of_other_shapes_are_refused_by_name(shown, monkeypatch, result):
    monkeypatch.setattr(Given, "warp", lambda *_: result)
    with pytest.raises(InputError, match=r"warp 'given' returned .*expected \(5, 7, 3\) and \(5, 7\)"):
        shown()
