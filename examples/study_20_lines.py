# Shows: a rating study in 20 lines, rehearsed by two simulated participants and analysed.
# Writes: study.toml, data, analysis/report.html

import subprocess
import sys
from pathlib import Path

STUDY = """
schema = 1
name = "study"
title = "Does a warp help at half a second?"
common = {scene = "planes", headset = "rift-dk1", size = "96x80", guard = 1.5, predict = "cautious"}
trial = {seconds = 0.3, scales = ["grade"]}
[[condition]]
name = "late"
latency = 500
warp = "none"
[[condition]]
name = "warped"
latency = 500
warp = "forward"
[[condition]]
name = "reference"
latency = 0
warp = "none"
reference = true
"""


def hmdwarp(*words: str) -> None:
    """Run a command, as in a terminal."""
    subprocess.run([sys.executable, "-m", "hmdwarp", "study", *words], check=True)


out = Path(sys.argv[1] if len(sys.argv) > 1 else "out/study_20_lines")
out.mkdir(parents=True, exist_ok=True)
(study := out / "study.toml").write_text(STUDY)
for person in ("P01", "P02"):  # with people: without the last three options, in the headset or a window
    display = ("--source", "offscreen", "--trace", "walk", "--simulate", "quick")
    hmdwarp("run", str(study), "--participant", person, "--store", str(out / "data"), *display)
hmdwarp("analyse", str(study), "--store", str(out / "data"), "--simulated", "--out", str(out / "analysis"))
