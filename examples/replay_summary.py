# Shows: a recorded head, replayed with frames that arrive 200 ms late, and what the summary says.
# Writes: summary.json, frames.csv, report.html, images

import sys
from pathlib import Path

import hmdwarp

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out/replay_summary")

options = hmdwarp.RunOptions(
    trace="look-around",  # a shipped recording, or the path of a file
    scene="room",
    latency_ms=200,
    headset="rift-dk1",  # by default today's: quest-3
    size=(96, 120),  # pixels of one eye; without it, those of the headset
    seconds=0.4,  # without it, all of the recording
    out=out,
)
result = hmdwarp.replay(options)

quality, time_ms = result.summary["quality"], result.summary["time_ms"]
print(f"error:  FLIP {quality['flip']['mean']:.3f}, PSNR {quality['psnr_db']['mean']:.1f} dB")
print(f"        without a warp: FLIP {result.against[0]['quality']['flip']['mean']:.3f}")
print(f"holes:  {quality['hole_share']['mean']:.1%} of the pixels, before the fill")
print(f"time:   {time_ms['total']['median']:.2f} ms an eye")
print(f"report: {result.report}")
