"""The table of light that moves: late pictures, baked light, and late indirect light alone."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from hmdwarp.experiments.compare import start_bytes

SCENES = ("lantern", "sunroom", "doorway")
LATENCIES = ("200", "400", "800")
WAYS = {
    "`none`": ("--warp", "none", "--fill", "none"),
    "`iterative` + `memory+pyramid`": ("--warp", "iterative", "--fill", "memory+pyramid"),
    "`voxels`": ("--strategy", "voxels"),
    "`voxels:cones=16`": ("--strategy", "voxels:cones=16"),
    "`model`, light baked": ("--strategy", "model"),
    "`irradiance`": ("--strategy", "irradiance"),
    "`photons`": ("--strategy", "photons"),
    "`light`": ("--strategy", "light"),
}
OPTIONS = (
    *("--codec", "h264", "--size", "120x150", "--start", "2", "--seconds", "2", "--rate", "20"),
    *("--metrics-every", "5", "--images", "0", "--against", "", "--quiet"),
)
HEAD = "| scene | latency ms | | PSNR dB | FLIP | flicker | Mbit/s | MB at the start |\n"
HEAD += "| --- | ---: | --- |" + " ---: |" * 5


def table(folder: Path, program: Callable[..., None]) -> str:
    """Run them all and return the table."""
    lines = [HEAD]
    for scene in SCENES:
        for latency in LATENCIES:
            for number, (way, options) in enumerate(WAYS.items()):
                out = folder / f"{scene}-{latency}-{number}"
                chosen = ("--scene", scene, "--latency", latency, *options)
                program("replay", "look-around", *OPTIONS, *chosen, "--out", str(out))
                lines.append(f"| {scene} | {latency} | {way} | {' | '.join(figures(out))} |")
    return "\n".join(lines)


def figures(out: Path) -> list[str]:
    """Return PSNR, FLIP, traffic and what crossed at the start, of a run."""
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    quality, models = summary["quality"], summary.get("client_models", ())
    start = sum(model.get("start_up_bytes", start_bytes({"client_models": [model]})) for model in models)
    return [
        f"{quality['psnr_db']['mean']:.1f}",
        f"{quality['flip']['mean']:.3f}",
        f"{quality['flicker']['mean']:.4f}",
        f"{summary['link']['mbit_s']:.2f}",
        f"{start * 1e-6:.1f}",
    ]
