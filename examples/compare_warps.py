# Shows: three warps over the same recorded head, and their errors over time in one plot.
# Writes: errors.png, rotation, planar, forward (a replay's folder each)

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import hmdwarp

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out/compare_warps")

run = {
    "trace": "walk",
    "start_s": 4,
    "seconds": 0.4,
    "headset": "rift-dk1",
    "size": (96, 120),
    "images": 0,
    "against": "",
}
run["workers"] = 0  # so few pictures are measured sooner here than in processes of their own

figure, axes = plt.subplots(figsize=(8, 4), layout="constrained")
for warp in ("rotation", "planar", "forward"):
    options = hmdwarp.RunOptions(warp=warp, latency_ms=200, metrics_every=4, out=out / warp, **run)
    rows = [row for row in hmdwarp.replay(options).rows if row["eye"] == 0 and row["flip"] is not None]
    axes.plot([row["time_s"] for row in rows], [row["flip"] for row in rows], marker=".", label=warp)

axes.set(xlabel="time in s", ylabel="error (FLIP), left eye", ylim=(0, None))
axes.legend()
figure.savefig(out / "errors.png", dpi=120)
