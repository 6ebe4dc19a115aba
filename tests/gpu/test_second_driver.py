"""A second OpenGL driver beside llvmpipe: Zink over lavapipe, which runs on Vulkan.

Another compiler and another API below the same shaders, in processes of its own, because a driver
is chosen before the first context. It has timer queries, which llvmpipe lacks.
"""

from __future__ import annotations

import functools
import os
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import driver_pictures
import needs
import numpy as np
import pytest

TESTS = Path(__file__).resolve().parents[1]
# Uniforms compiled into the shaders, as Zink does over a CPU alone, take stale values in Mesa 22.3:
# the third picture of a memory fill, meshes of blocks of 4.
ZINK = {"LIBGL_ALWAYS_SOFTWARE": "1", "GALLIUM_DRIVER": "zink", "ZINK_INLINE_UNIFORMS": "0"}
ZINK |= {"LP_NUM_THREADS": "2"}  # with none (conftest.py) its timers at times do not agree with the wall
NAME = "Zink over lavapipe"
RENDERER = "from hmdwarp.gpu import Gpu; print(Gpu().renderer)"
# The timers, blocks of 4 of meshes, the hard cases, and a replay. That warps and fills equal
# their twins follows: they make llvmpipe's pictures.
SELECTED = (
    "tests/gpu/test_timers.py", "tests/gpu/test_programs.py", "tests/client/test_forward.py",
    "tests/client/test_mesh_adaptive.py", "tests/hard_cases/test_hard_cases.py", "tests/test_golden.py",
)  # fmt: skip
# Of the hard cases each warp with its defaults.
FEWER = "(not test_hard_cases.py or not :) and (not test_looks_as_before or iterative)"
# Fills that sum many terms, which another compiler may round otherwise. Each of the levels of a
# pyramid, halves of the picture down to one texel and up again, stores means as half floats: one
# that falls to the other side of a rounding is off by a unit, 2^-10 of it, and a mean of such
# values by no more. Inverse depth is stored at least as finely.
ROUNDED = ("pyramid",)
STORES = 2 * int(np.ceil(np.log2(max(driver_pictures.SIZE))))
HALF_UNIT = 2.0**-10
# All else is the same, but for the inverse depth that a warp computes: at most this many float32
# operations, each of which another order or a fused product moves by half a unit.
OPERATIONS = 32
DEPTH_OFF = OPERATIONS * 2.0**-24


def most_off(fill: str) -> tuple[float, float, float, float, float]:
    """Of colour, coverage and inverse depth, as a share of the largest in the picture."""
    rounded = STORES * HALF_UNIT if fill in ROUNDED else 0.0
    return (rounded, rounded, rounded, 0.0, max(rounded, DEPTH_OFF))


def on_zink(*command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *command], cwd=TESTS.parent, env={**os.environ, **ZINK},
        capture_output=True, text=True, errors="replace", check=False,
    )  # fmt: skip


@functools.cache
def lacking() -> str | None:
    """Why this machine has no Zink over a CPU's Vulkan, as the reason to skip; None if it has."""
    done = on_zink("-c", RENDERER)
    renderer = done.stdout.strip().lower()
    if done.returncode == 0 and "zink" in renderer and "llvmpipe" in renderer:
        return None
    return needs.missing("lavapipe", needs.APT + needs.TOOLS["packages"]["lavapipe"])


@pytest.fixture(autouse=True)
def zink() -> None:
    reason = lacking()
    if reason:
        pytest.skip(reason)


def said(done: subprocess.CompletedProcess[str]) -> str:
    """The end of what it said, for a failure."""
    return f"status {done.returncode}\n{done.stdout[-4000:]}\n{done.stderr[-2000:]}"


@pytest.mark.slow(30)
def test_pairs_of_warp_and_fill_make_the_same_picture(gpu, tmp_path, record_property):
    """Bit for bit; rounded sums within the bound."""
    if not gpu.renderer.startswith("llvmpipe"):
        pytest.skip(f"the pictures are compared with llvmpipe's; this is {gpu.renderer}")
    done = on_zink("tests/driver_pictures.py", str(tmp_path / "zink.npz"))
    assert done.returncode == 0, f"{NAME} crashed or failed on the last pair named: {said(done)}"
    _, _, clock, *_ = done.stdout.splitlines()
    assert clock == "gpu", "its timer queries are right, but were not used"
    theirs, ours = dict(np.load(tmp_path / "zink.npz")), driver_pictures.all_of(gpu)
    assert set(theirs) == set(ours)
    same = 0
    for name, picture in theirs.items():
        wanted = ours[name]
        off, largest = (np.abs(array).max(axis=(0, 1)) for array in (picture - wanted, wanted))
        assert (off <= most_off(name.rpartition(" + ")[2]) * largest).all(), f"{name} differs by {off}"
        same += not off.any()
    record_property(
        needs.TOLD,
        f"{NAME}: {len(theirs)} pairs of warp and fill, {same} as on llvmpipe bit for bit, the others by roundings",
    )


@pytest.mark.slow(60)
def test_the_selected_tests_pass_there(tmp_path, record_property):
    results = tmp_path / "results.xml"
    options = ("-q", "-p", "no:cacheprovider", "-p", "no:xdist", f"--junitxml={results}", "-k", FEWER)
    done = on_zink("-m", "pytest", *options, *SELECTED)
    assert done.returncode == 0, said(done)
    cases = list(ElementTree.parse(results).iter("testcase"))
    reasons = (found.get("message", "") for case in cases for found in case.iter("skipped"))
    skipped = Counter(re.sub(r"'[^']+'", "..", reason) for reason in reasons)
    why = "; ".join(f"{count} as {reason}" for reason, count in sorted(skipped.items()))
    record_property(needs.TOLD, f"{NAME}: {len(cases) - skipped.total()} tests passed, left out there: {why or 'none'}")
