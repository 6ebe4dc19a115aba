"""What the page measures: its governor, and `?bench` as `hmdwarp bench merge` reads it."""

from __future__ import annotations

import base64
import json
from pathlib import Path

import needs
import numpy as np
import pytest
from serving import Serving

from hmdwarp.errors import MachineError
from hmdwarp.experiments.bench import MergeOptions, merge
from hmdwarp.pipeline import QualityLevel
from hmdwarp.pipeline.governor import Governor
from hmdwarp.run.browser_display import CHAINS
from hmdwarp.web.door import shaders

from .browser import Browser, page

pytestmark = needs.programs("chromium")

GOVERNED = """
async (levels, budget, times) => {
  const { Governor } = await import("./measure.js"), governor = new Governor(levels, budget);
  return times.map((ms) => [Boolean(governor.measured(ms)), governor.level.name]);
}
"""


def test_the_page_governs_as_a_live_run(tmp_path):
    """The same moves at the same refreshes: calm, a slow spell, noise about the budget, calm."""
    rng, levels = np.random.default_rng(4), {"cheap": 1.0, "middle": 2.5, "best": 4.0}
    slow = np.concatenate([np.ones(100), np.full(60, 2.6), 1 + 0.6 * rng.random(300), np.full(700, 0.9)])
    own = Governor(tuple(QualityLevel(name, "none", ms, 1 / ms) for name, ms in levels.items()), 4.5)
    times, expected = [], []
    for factor in slow:
        times.append(float(factor * levels[own.level.warp]))
        expected.append([own.measured(times[-1]) is not None, own.level.warp])
    with Browser(tmp_path) as driven, page({}) as address:
        driven.open(address)
        driven.until("globalThis.packed")
        known = json.dumps([{"name": name, "ms": ms} for name, ms in levels.items()])
        assert driven.does(f"({GOVERNED})({known}, 4.5, {json.dumps(times)})") == expected
    assert sum(changed for changed, _ in expected) > 2 and {name for _, name in expected} == {*levels}


@pytest.fixture(scope="module")
def benched(tmp_path_factory) -> Path:
    """The folder of a bench of a small window."""
    out = tmp_path_factory.mktemp("served")
    with Serving("--scene", "room", "--web", "127.0.0.1:*", "--out", str(out / "out")) as server:
        with Browser(out / "profile", (400, 300)) as browser:
            browser.open(f"{server.line('for a browser').split()[-1]}&bench&size=96&latency=100")
            browser.until("hmdwarp.session.benched && !hmdwarp.session.isBusy")
        return Path(server.line("a browser's bench").split()[-1])


def _read(folder: Path) -> dict:
    return json.loads((folder / "bench.json").read_text(encoding="utf-8"))


def test_a_bench_of_the_page_is_one_of_ours(benched):
    """Every warp with every fill, timed, and as near to the truth as a late frame of 100 ms is."""
    data = _read(benched)
    rows = {(row["warp"], row["fill"]): row for row in data["rows"]}
    assert list(rows) == [(warp, fill) for warp in CHAINS.values() for fill in ("none", "pyramid")]
    assert all(row["time_ms"]["total"]["median"] > 0 and row["clock"] == data["clock"] for row in rows.values())
    assert {row["trace"] for row in rows.values()} == {"walk"}
    psnr_db = {names: row["quality"]["psnr_db"]["mean"] for names, row in rows.items()}
    assert psnr_db[CHAINS["iterative"], "pyramid"] > max(psnr_db["rotation", "pyramid"], 20)
    assert rows["rotation", "none"]["notes"][0].startswith("Timed by: ")
    assert "mesh:grid=64" in (benched / "bench.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(("host", "levels", "count"), [("another device", 0, 12), ("another device", 40, 0)])
def test_merge_joins_what_two_devices_measured(benched, tmp_path, host, levels, count):
    """Each has its own times beside one quality; a device that shows another picture is found."""
    data = _read(benched)
    for row in data["rows"]:
        row["machine"]["host"] = host
        for at, text in row["blocks"].items():
            blocks = np.frombuffer(base64.b64decode(text), "<u2")
            row["blocks"][at] = base64.b64encode((blocks + np.uint16(256 * levels)).tobytes()).decode()
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "bench.json").write_text(json.dumps(data), encoding="utf-8")
    options = MergeOptions(folders=(benched, tmp_path / "other"), out=tmp_path / "both")
    if levels:
        with pytest.raises(MachineError, match="different pictures"):
            merge(options)
    else:
        assert len(merge(options).data["rows"]) == count


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


def test_what_a_lens_hides_is_not_drawn(tmp_path):
    """A triangle of tangents: its pixels are those of the whole picture, no others are drawn."""
    corners = np.array([(-0.6, -0.5), (0.6, -0.5), (0.1, 0.5)])
    with Browser(tmp_path) as driven, page(shaders()) as address:
        driven.open(address)
        driven.until("globalThis.chain")
        found = [driven.does(f"({MASKED})({json.dumps(mask)})") for mask in (None, corners.ravel().tolist())]
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
