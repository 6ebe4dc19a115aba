"""A file of very many rows is read in bounded memory.

By default 25,000 rows; HMDWARP_LARGE_ROWS=10000000 runs the large one (its file takes 1.1 GB in
the temporary folder).
"""

from __future__ import annotations

import os
import tracemalloc

import numpy as np
import pytest

from hmdwarp.poses import load_trace

ROWS = int(os.environ.get("HMDWARP_LARGE_ROWS", "25000"))


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
def test_memory_is_bounded_by_the_rows(tmp_path):
    large_file(tmp_path / "large.csv", ROWS)
    tracemalloc.start()
    loaded = load_trace(tmp_path / "large.csv")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert (len(loaded.track), loaded.track.end_ns, loaded.defects) == (ROWS, (ROWS - 1) * 1_000_000, [])
    # A row is 68 bytes when done (time, line, position, quaternion); its largest column is copied
    # twice while cleaning: 200 bytes a row and 60 MB keep 10^7 rows below 2.1 GB (25,000: 6 MB).
    assert peak < 200 * ROWS + min(200 * ROWS, 60e6)
