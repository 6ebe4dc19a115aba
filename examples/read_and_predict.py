# Shows: a head trace read from a file, and how far its head is predicted wrongly, by how far ahead.
# Writes: prediction.csv

import csv
import sys
from pathlib import Path

import numpy as np

import hmdwarp
from hmdwarp.poses import predict

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out/read_and_predict")
out.mkdir(parents=True, exist_ok=True)

loaded = hmdwarp.load_trace("look-around")  # or a path: the format is found by looking at the file
track = loaded.track
print(f"{loaded.format}: {len(track)} poses in {track.duration_ns * 1e-9:.1f} s at {track.rate_hz:.0f} Hz")

with (out / "prediction.csv").open("w", newline="") as file:
    table = csv.writer(file)
    table.writerow(["ahead_ms", "method", "median_error_deg"])
    for ahead_ms in (20, 50, 100):
        for method in ("none", "constant_velocity", "cautious"):
            errors_deg = []
            for now_ns in range(track.start_ns, track.end_ns - 100_000_000, 50_000_000):
                then_ns = now_ns + ahead_ms * 1_000_000
                predicted = predict(track, now_ns, then_ns, method).pose  # looks at nothing after now_ns
                turn = predicted.rotation.inv() * track.at(then_ns).pose.rotation
                errors_deg.append(np.rad2deg(turn.magnitude()))
            table.writerow([ahead_ms, method, round(float(np.median(errors_deg)), 3)])
print((out / "prediction.csv").read_text())
