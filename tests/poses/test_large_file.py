"""A file of very many rows is read in bounded memory.

By default 400,000 rows; HMDWARP_LARGE_ROWS=10000000 runs the large one (its file takes 1.1 GB in
the temporary folder; `-s` prints the figures).
"""

from __future__ import annotations

import json
import os
import subprocess
import sys

import numpy as np
import pytest

ROWS = int(os.environ.get("HMDWARP_LARGE_ROWS", "400000"))

MEASURE = """
import json, re, sys, time
from pathlib import Path
from hmdwarp.poses import load_trace
import hmdwarp.poses.reading.cleaning, hmdwarp.poses.reading.text_table, hmdwarp.poses.writing
def peak():  # ru_maxrss would count what the parent held when it forked
    return int(re.search(r"VmHWM:\\s+(\\d+)", Path("/proc/self/status").read_text())[1])
before = peak()
start = time.perf_counter()
loaded = load_trace(Path(sys.argv[1]))
seconds = time.perf_counter() - start
used = peak() - before
kinds = [d.kind for d in loaded.defects]
found = {"rows": len(loaded.track), "last": loaded.track.end_ns, "kinds": kinds}
print(json.dumps({**found, "bytes": used * 1024, "s": seconds}))
"""


def large_file(path, count: int) -> None:
    """A native file of a head that turns about, each row with its own digits."""
    with path.open("w") as stream:
        stream.write("time_ns,x_m,y_m,z_m,qx,qy,qz,qw\n")
        for start in range(0, count, 100_000):
            i = np.arange(start, min(start + 100_000, count))
            q = np.stack([0.1 * np.sin(i * 2e-3), np.sin(i * 1e-4), 0.05 * np.sin(i * 3e-3)], axis=1) * 0.9
            q = np.concatenate([q, np.sqrt(1 - (q**2).sum(axis=1))[:, None]], axis=1)
            table = np.concatenate([np.sin(i[:, None] * [1e-3, 2e-3, 3e-3]), q], axis=1).tolist()
            line = "{},{:.6f},{:.6f},{:.6f},{:.9f},{:.9f},{:.9f},{:.9f}\n".format
            stream.writelines(line(t, *r) for t, r in zip((i * 1_000_000).tolist(), table, strict=True))


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="peak memory is read from /proc")
def test_memory_is_bounded_by_the_rows(tmp_path):
    path = tmp_path / "large.csv"
    large_file(path, ROWS)
    out = subprocess.run([sys.executable, "-c", MEASURE, str(path)], capture_output=True, text=True, check=True).stdout
    found = json.loads(out)
    print(found, f"{path.stat().st_size / 1e9:.2f} GB of text")
    assert found["rows"] == ROWS
    assert found["last"] == (ROWS - 1) * 1_000_000
    assert found["kinds"] == []
    # A row is 68 bytes when done (time, line, position, quaternion); its largest column is copied
    # twice while cleaning, and one chunk of text with its numbers takes some 30 MB: 200 bytes a row
    # and 60 MB keep 10^7 rows below 2.1 GB.
    assert found["bytes"] < 200 * ROWS + 60e6


def test_chunks_meet_without_a_seam(tmp_path, monkeypatch):
    """The same file in chunks of any size, down to a few rows, is the same track."""
    from hmdwarp.poses import load_trace
    from hmdwarp.poses.reading import text_table

    path = tmp_path / "seams.csv"
    large_file(path, 500)
    text = path.read_text()
    path.write_text(text.replace("\n", "\n# a remark\n", 40).rstrip("\n"))
    whole = load_trace(path)
    for size in (97, 1000, 4096):
        monkeypatch.setattr(text_table, "CHUNK_BYTES", size)
        parts = load_trace(path)
        assert np.array_equal(parts.track.time_ns, whole.track.time_ns)
        assert np.array_equal(parts.track.orientation_xyzw, whole.track.orientation_xyzw)
        assert parts.defects == whole.defects
