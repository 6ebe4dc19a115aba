"""The copy that passes are held against really copies, and the clocks are told apart."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.gpu import Copier, check_clocks, copy_bandwidth, last_cache_bytes, suitable_bytes
from hmdwarp.gpu import memory_bandwidth as bandwidth

SMALL = 1 << 20


@pytest.mark.parametrize("size", [16, 16 * 8192, 16 * 8192 * 8 + 16, 16 * 70001])
@pytest.mark.parametrize("way", ["shader", "driver"])
def test_every_block_is_copied(gpu, way, size):
    """Also where the last row of the dispatch is not full."""
    with Copier(gpu, size) as copier:
        content = np.random.default_rng(1).integers(0, 256, size, dtype=np.uint8).tobytes()
        copier._buffers[0].write(content)
        copier._buffers[1].write(bytes(size))
        copier.ways[way]()
        gpu.gl.finish()
        assert copier._buffers[1].read() == content


def test_bandwidth_is_that_of_a_copy(gpu):
    found = copy_bandwidth(gpu, rounds=2, size_bytes=SMALL)
    assert found.buffer_bytes == SMALL
    assert found.copied in ("shader", "driver")
    # Between a floppy disk and a hundred of the fastest GPUs.
    assert 1e6 < found.bytes_per_s < 1e15


def test_the_best_copy_counts(gpu, monkeypatch):
    """Times are made up: one to warm up, then the best of each way.

    2 x 1 MiB in half a millisecond.
    """
    made_up = iter([99.0, 99.0, 3.0, 4.0, 2.0, 0.5, 9.0, 9.0])
    monkeypatch.setattr(bandwidth, "both_clocks", lambda gl, run: (value := next(made_up), value))
    found = copy_bandwidth(gpu, rounds=3, size_bytes=SMALL)
    assert found.copied == "driver"
    assert found.bytes_per_s == pytest.approx(2 * SMALL / 0.5e-3)


def test_clocks(gpu):
    found = check_clocks(gpu, rounds=2, size_bytes=SMALL)
    assert found.clock == gpu.timer.clock
    assert found.wall_ms > 0
    if found.clock == "wall":
        assert found.gpu_ms is None and "GPU timers are unusable" in found.note
    else:
        assert 0 < found.gpu_ms <= found.wall_ms * 1.5


def test_real_timers_are_compared_with_the_wall(gpu, monkeypatch):
    monkeypatch.setattr(gpu.timer, "clock", "gpu")
    times = iter([(3.0, 2.5), (2.2, 2.0), (2.4, 1.9)])
    monkeypatch.setattr(bandwidth, "both_clocks", lambda gl, run: next(times))
    found = check_clocks(gpu, rounds=3, size_bytes=SMALL)
    assert (found.clock, found.wall_ms, found.gpu_ms) == ("gpu", 2.2, 1.9)
    assert "+15.8%" in found.note


def test_buffers_are_larger_than_the_caches(gpu, tmp_path, monkeypatch):
    for name, text in (("index0", "48K\n"), ("index3", "32M\n"), ("index4", "what?\n"), ("index5", "")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "size").write_text(text, encoding="ascii")
    assert last_cache_bytes(tmp_path) == 32 << 20
    assert last_cache_bytes(tmp_path / "nowhere") == 0
    if gpu.is_software:
        for cache, wanted in ((0, 64 << 20), (32 << 20, 128 << 20), (1 << 30, 512 << 20)):
            monkeypatch.setattr(bandwidth, "last_cache_bytes", lambda cache=cache: cache)
            assert suitable_bytes(gpu) == wanted
