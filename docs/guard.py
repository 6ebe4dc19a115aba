"""Two tables for docs/results-link.md: what a guard band and a second wide view cost and save.

Two recordings move as people do. Two more motions are of one kind each: turning to and fro, and
swaying from side to side.
"""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from hmdwarp.poses import PoseTrack
from hmdwarp.poses.synth import EYE_HEIGHT_M, write_synthetic

LATENCIES = ("200", "400", "800")
GUARDS = ("1", "1.5", "2", "auto")
SIZE = (240, 300)
USUAL = shlex.split("--scene room --warp forward --size 240x300 --start 2 --seconds 3 --metrics-every 15")
# Peaks of a sine: between the median (30 deg/s) and the 95th percentile (113) of recorded heads,
# and half a walking pace.
TURNING_DEG, TURNING_DEG_S = 45.0, 60.0
SIDEWAYS_M, SIDEWAYS_M_S = 0.5, 0.6
SUFFICES = 0.001  # mean share of the picture that is a border hole
BYTES_PER_PIXEL = 12  # colour and inverse depth of one eye

Program = Callable[..., None]


def motion(kind: str, seconds: float = 8.0) -> PoseTrack:
    """Return a sine of `kind`, turning or sideways, at EYE_HEIGHT_M where the recordings begin."""
    t = np.arange(0, round(seconds * 90) + 1) / 90
    place, yaw = np.tile((0.0, EYE_HEIGHT_M, 0.0), (len(t), 1)), np.zeros_like(t)
    if kind == "turning":
        yaw = math.radians(TURNING_DEG) * np.sin(TURNING_DEG_S / TURNING_DEG * t)
    else:
        place[:, 0] = SIDEWAYS_M * np.sin(SIDEWAYS_M_S / SIDEWAYS_M * t)
    turned = Rotation.from_rotvec(yaw[:, None] * (0.0, 1.0, 0.0)).as_quat()
    return PoseTrack(
        np.rint(t * 1e9).astype(np.int64), place, turned, name=kind, origin=f"made up by docs/guard.py: {kind}"
    )


def traces(folder: Path) -> dict[str, str]:
    """Return what replay takes for each motion, by name. Writes the sines into `folder`."""
    paths = {name: name for name in ("look-around", "walk")}
    for kind in ("turning", "sideways"):
        path = folder / f"{kind}.csv"
        with path.open("w", encoding="utf-8") as stream:
            write_synthetic(motion(kind), stream)
        paths[kind] = str(path)
    return paths


def measure(folder: Path, program: Program) -> list[dict]:
    """Return one summary for each trace, latency and choice; `trace` and `choice` say which."""
    rows = []
    for name, trace in traces(folder).items():
        for latency in LATENCIES:
            for choice in (*GUARDS, "wide"):
                out = folder / f"{name}-{latency}-{choice}"
                more = ("--wide",) if choice == "wide" else ("--guard", choice)
                quiet = ("--against", "", "--images", "0", "--quiet", "--out", str(out))
                program("replay", trace, *USUAL, "--latency", latency, *more, *quiet)
                summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
                rows.append({**summary, "trace": name, "choice": choice})
    return rows


def band_table(rows: list[dict]) -> str:
    """Return pixels and bytes against the border before and after the fills, and the error."""
    lines = [
        "| recording | latency ms | guard | pixels | MB a frame | border % | empty after the fill % | PSNR dB |",
        "|" + " --- |" * 8,
    ]
    for row in rows:
        size = row["link"]["frame_bytes"]
        pixels = size / (2 * BYTES_PER_PIXEL * SIZE[0] * SIZE[1])
        guard = {"auto": f"auto: {row['guard']:g}", "wide": "1 and wide"}.get(row["choice"], f"{row['guard']:g}")
        border, empty = 100 * row["quality"]["border_share"]["mean"], 100 * row["filled"]["empty"]
        figures = (
            f"{pixels:.2f}x",
            f"{size / 1e6:.1f}",
            f"{border:.2f}",
            f"{empty:.2f}",
            f"{row['quality']['psnr_db']['mean']:.2f}",
        )
        lines.append(f"| {row['trace']} | {row['latency_ms']:g} | {guard} | {' | '.join(figures)} |")
    return "\n".join(lines)


def finding_table(rows: list[dict]) -> str:
    """Return which guard band suffices for turning and for sideways motion: the thesis' finding."""
    lines = ["| motion | latency ms | border % at 1 | at 1.5 | at 2 | suffices |", "|" + " --- |" * 6]
    for trace in ("turning", "sideways"):
        for latency in LATENCIES:
            shares = {
                row["choice"]: row["quality"]["border_share"]["mean"]
                for row in rows
                if row["trace"] == trace and f"{row['latency_ms']:g}" == latency and row["choice"] in GUARDS[:3]
            }
            enough = next((choice for choice, share in shares.items() if share < SUFFICES), "none of them")
            figures = " | ".join(f"{100 * shares[choice]:.2f}" for choice in GUARDS[:3])
            lines.append(f"| {trace} | {latency} | {figures} | {enough} |")
    return "\n".join(lines)
