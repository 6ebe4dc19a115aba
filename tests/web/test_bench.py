"""What the page measures: its governor, and `?bench`."""

from __future__ import annotations

import base64
import json

import needs
import numpy as np
import pytest
from serving import Serving

from hmdwarp.metrics import db_of
from hmdwarp.pipeline import QualityLevel
from hmdwarp.pipeline.governor import Governor
from hmdwarp.run.browser_log import NAME

from .browser import Browser

CHAINS = ("iterative", "mesh:grid=64", "rotation")  # as the page has them
pytestmark = needs.programs("chromium")

GOVERNED = """
async (levels, budget, times) => {
  const { Governor } = await import("./measure.js"), governor = new Governor(levels, budget);
  return times.map((ms) => [Boolean(governor.measured(ms)), governor.level.name]);
}
"""


def test_the_page_governs_as_a_live_run(browser):
    """The same moves at the same refreshes: calm, slow spells, noise about the budget, calm."""
    rng, levels = np.random.default_rng(4), {"cheap": 1.0, "middle": 2.5, "good": 3.0, "best": 4.0}
    known = json.dumps([{"name": name, "ms": ms} for name, ms in levels.items()])
    seen, changes = set(), 0
    for _ in range(8):
        # The dearer a level, the longer it may be slow: what is tried again fails again.
        spells = [np.full(rng.integers(40, 500), factor) for factor in rng.uniform(0.7, 2.6, 12)]
        slow = np.concatenate([np.ones(100), *spells, 1 + 0.6 * rng.random(300), np.full(700, 0.9)])
        own = Governor(tuple(QualityLevel(name, "none", ms, 1 / ms) for name, ms in levels.items()), 4.5)
        times, expected = [], []
        for factor in slow:
            times.append(float(factor * levels[own.level.warp]))
            expected.append([own.measured(times[-1]) is not None, own.level.warp])
        assert browser.does(f"({GOVERNED})({known}, 4.5, {json.dumps(times)})") == expected
        seen, changes = seen | {name for _, name in expected}, changes + sum(changed for changed, _ in expected)
    assert changes > 20 and seen == {*levels}


def test_a_bench_times_every_chain_and_the_server_keeps_a_line(tmp_path):
    """Every warp with every fill, timed, and as near to the truth as a late frame of 100 ms is."""
    with (
        Serving("--scene", "room", "--web", "127.0.0.1:*", "--out", str(tmp_path / "out")) as server,
        Browser(tmp_path / "profile", (400, 300)) as browser,
    ):
        browser.open(f"{server.line('for a browser').split()[-1]}&bench&size=96&latency=100")
        browser.until("hmdwarp.session.benched && !hmdwarp.session.isBusy")
        found = browser.does("hmdwarp.session.benched")
        browser.does("hmdwarp.session.feed.close()")
        browser.until("hmdwarp.session.feed.socket.readyState === 3")
    lines = [json.loads(line) for line in (tmp_path / "out" / NAME).read_text(encoding="utf-8").splitlines()]
    (line,) = (line for line in lines if "bench" in line)
    assert line["display"] | {"rows": line["bench"]} == found and line["display"]["trace"] == "walk"
    assert not any(line.get("errors") for line in lines)
    rows = {(row["warp"], row["fill"]): row for row in line["bench"]}
    assert list(rows) == [(warp, fill) for warp in CHAINS for fill in ("none", "pyramid")]
    assert all(row["warp_ms"] > 0 and row["total_ms"] > 0 for row in rows.values())
    psnr_db = {names: row["psnr_db"] for names, row in rows.items()}
    assert psnr_db["iterative", "pyramid"] > max(psnr_db["rotation", "pyramid"], 20)


ERRORS = """
async (pixels, truth) => {
  const { psnr } = await import("./bench.js");
  return psnr(new Uint8Array(pixels), new Uint8Array(truth));
}
"""


@pytest.mark.parametrize("off", [0, 1, 60])
def test_the_page_s_psnr_is_that_of_every_run(browser, off):
    """Of colours alone, whatever is in alpha; equal pictures have a finite one, for JSON."""
    truth = np.random.default_rng(off).integers(0, 256 - off, (24, 4), np.uint8)
    pixels = truth + np.array([off, 0, off, 0], np.uint8)
    pixels[:, 3] = 255 - truth[:, 3]
    found = browser.does(f"({ERRORS})({pixels.ravel().tolist()}, {truth.ravel().tolist()})")
    assert found == pytest.approx(db_of(2 / 3 * off**2 / 255**2))


MASKED = """
(mask) => {
  const size = [48, 40], pose = { position: [0, 0, 0], orientation: [0, 0, 0, 1] };
  const shown = { pose, fov: [-0.7, 0.7, -0.6, 0.6], size };
  const colour = new Uint8Array(4 * 48 * 40).fill(200).map((value, k) => (k % 4 === 3 ? 255 : value));
  chain.takeIn(0, { size, colour, depth: { numbers: new Float32Array(48 * 40).fill(0.5) }, view: shown });
  const seen = mask && chain.mask(new Float32Array(mask), new Uint32Array([0, 1, 2])), { target } = chain.scratch(size);
  return ["iterative", "rotation", "mesh:grid=64"].map((name) => {
    chain.draw(target, shown.size, 0);
    chain.gl.clear(chain.gl.COLOR_BUFFER_BIT);
    chain.show(0, { ...shown, mask: seen }, name, target);
    return packed(chain.pixels(target, shown.size));
  });
}
"""


def test_what_a_lens_hides_is_not_drawn(browser):
    """A triangle of tangents: its pixels are those of the whole picture, no others are drawn."""
    corners = np.array([(-0.6, -0.5), (0.6, -0.5), (0.1, 0.5)])
    found = [browser.does(f"({MASKED})({json.dumps(mask)})") for mask in (None, corners.ravel().tolist())]
    whole, seen = (
        [np.frombuffer(base64.b64decode(text), np.uint8).reshape(40, 48, 4)[..., :3] for text in texts]
        for texts in found
    )
    edges = np.tan([0.7, 0.6])
    x = ((np.arange(48) + 0.5) / 24 - 1) * edges[0]
    y = (1 - (np.arange(40) + 0.5) / 20) * edges[1]
    place = np.stack(np.meshgrid(x, y), -1)
    inside = np.ones((40, 48), bool)
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        (along_x, along_y), off = b - a, place - a
        inside &= along_x * off[..., 1] - along_y * off[..., 0] > 0
    for full, part in zip(whole, seen, strict=True):
        assert (full > 150).all() and 0.2 < inside.mean() < 0.4
        np.testing.assert_array_equal(part, np.where(inside[..., None], full, 0))
