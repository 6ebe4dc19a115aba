"""The table of what deforms: as it was, moved by its velocity, and drawn by the client."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import light

RECORDINGS = ("look-around", "walk")
WAYS = {"stands still": "none", "`soft_motion`": "auto", "`soft_bodies`": "soft_bodies"}
OPTIONS = (
    *("--scene", "parade", "--warp", "iterative", "--fill", "memory+pyramid", "--codec", "h264", "--crf", "16"),
    *("--size", "240x200", "--start", "2", "--seconds", "1", "--rate", "20", "--metrics-every", "4"),
    *("--images", "0", "--against", "", "--quiet"),
)
HEAD = "| recording | latency ms | what deforms | PSNR dB | FLIP | Mbit/s | MB at the start |\n"
HEAD += "| --- | ---: | --- |" + " ---: |" * 4


def table(folder: Path, program: Callable[..., None]) -> str:
    """Run them all and return the table."""
    lines = [HEAD]
    for recording in RECORDINGS:
        for latency in light.LATENCIES:
            for number, (way, effects) in enumerate(WAYS.items()):
                out = folder / f"{recording}-{latency}-{number}"
                chosen = ("--latency", latency, "--effects", effects, "--out", str(out))
                program("replay", recording, *OPTIONS, *chosen)
                lines.append(f"| {recording} | {latency} | {way} | {' | '.join(light.figures(out))} |")
    return "\n".join(lines)
