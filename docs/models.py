"""The table of what it takes and brings that the client has the scene itself."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path

LATENCIES = ("200", "400", "800")
RATE_HZ, SECONDS = 20, 6
# A budget of 60 kB a frame is 9.6 Mbit/s at this rate.
WAYS = {
    "`iterative` + `memory+pyramid`": ("--warp", "iterative", "--fill", "memory+pyramid"),
    "`model`": ("--strategy", "model"),
    "`model:share=0.2`": ("--strategy", "model:share=0.2"),
    "`model:share=0.05`": ("--strategy", "model:share=0.05"),
    "`model:share=0.05,texture=0.25`": ("--strategy", "model:share=0.05,texture=0.25"),
    "`model:arrives=progressive,budget=60000`": ("--strategy", "model:arrives=progressive,budget=60000"),
}
OPTIONS = (
    *("--scene", "room", "--codec", "h264", "--size", "240x300", "--start", "2", "--seconds", str(SECONDS)),
    *("--rate", str(RATE_HZ), "--metrics-every", "5", "--images", "0", "--against", "", "--quiet"),
)
HEAD = (
    "| latency ms | | MB before the first whole picture | MB in all | Mbit/s | PSNR dB | FLIP | FLIP, first second "
    "| FLIP, last second |\n|" + " ---: | --- |" + " ---: |" * 7
)


def table(folder: Path, program: Callable[..., None]) -> str:
    """Run them all and return the table."""
    lines = [HEAD]
    for latency in LATENCIES:
        for number, (way, options) in enumerate(WAYS.items()):
            out = folder / f"{latency}-{number}"
            program("replay", "look-around", *OPTIONS, "--latency", latency, *options, "--out", str(out))
            lines.append(f"| {latency} | {way} | {' | '.join(_figures(out))} |")
    return "\n".join(lines)


def _figures(out: Path) -> list[str]:
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    with (out / "frames.csv").open(encoding="utf-8") as file:
        measured = [(int(row["frame"]), float(row["flip"])) for row in csv.DictReader(file) if row["flip"]]
    first, last = (
        [flip for frame, flip in measured if low <= frame < low + RATE_HZ] for low in (0, (SECONDS - 1) * RATE_HZ)
    )
    link, quality = summary["link"], summary["quality"]
    model = next(iter(summary.get("client_models", ())), None)
    before = model["first_picture_bytes"] if model else link["frame_bytes"]
    sent = link["frame_bytes"] * link["frames"]["drawn"] + (model["start_up_bytes"] if model else 0)
    return [
        f"{before * 1e-6:.2f}",
        f"{sent * 1e-6:.1f}",
        f"{link['mbit_s']:.1f}",
        f"{quality['psnr_db']['mean']:.1f}",
        f"{quality['flip']['mean']:.3f}",
        *(f"{sum(values) / len(values):.3f}" for values in (first, last)),
    ]
