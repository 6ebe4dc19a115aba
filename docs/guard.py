"""Two tables for docs/results-link.md: what a guard band and a second wide view cost and save.

The first is of two recordings that move as people do. The second repeats the thesis's experiment:
reference pictures of 1280x800, 1600x900 and 1920x1080 pixels for an output of 1280x800, and a head
that moves in one way only, at a known speed. The thesis gives no speed, so several are tried.
"""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Callable
from pathlib import Path

LATENCIES = ("200", "400", "600", "800")
# The thesis's larger pictures, in pixels of its output of 1280x800.
OUTPUT = (1280, 800)
PICTURES = ((1600, 900), (1920, 1080))
PER_AXIS = tuple(f"{w / OUTPUT[0]:g}x{h / OUTPUT[1]:g}" for w, h in PICTURES)
GUARDS = ("1", *PER_AXIS, "1.5", "2", "auto")
SIZE = (240, 300)
USUAL = shlex.split(
    "--scene room --warp forward --fill interpolate --predict none --size 240x300 --start 2 --seconds 3"
    " --metrics-every 15"
)
BYTES_PER_PIXEL = 12  # colour and inverse depth of one eye

# The thesis's output at a quarter of its size, and each of its pictures beside one factor for both
# axes that makes as many pixels.
SMALL = 4
AS_MANY = tuple(f"{math.sqrt(w * h / (OUTPUT[0] * OUTPUT[1])):.3f}" for w, h in PICTURES)
# Heads turn with 30 degrees a second in the median and 113 at the 95th percentile; 1 m/s is a slow
# walk. The amplitudes give the head its full speed for longer than the latency.
SPEEDS = {"sideways": ("0.25", "0.5", "1"), "rotate": ("30", "60", "113")}
AMPLITUDES = {"sideways": "1.2", "rotate": "180"}
UNITS = {"sideways": "m/s", "rotate": "deg/s"}
STEADILY = "--scene room --warp forward --fill none --headset flat-90 --start 0.8 --seconds 9 --instants 16 --rounds 1"
SUFFICES = 0.001  # mean share of the picture that is a border hole

Program = Callable[..., None]


def measure(folder: Path, program: Program) -> list[dict]:
    """Return one summary for each recording, latency and choice; `choice` says which."""
    rows = []
    for name in ("look-around", "walk"):
        for latency in LATENCIES:
            for choice in (*GUARDS, "wide"):
                out = folder / f"{name}-{latency}-{choice}"
                more = ("--wide",) if choice == "wide" else ("--guard", choice)
                quiet = ("--against", "", "--images", "0", "--quiet", "--out", str(out))
                program("replay", name, *USUAL, "--latency", latency, *more, *quiet)
                summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
                rows.append({**summary, "choice": choice})
    return rows


def measure_thesis(folder: Path, program: Program) -> list[dict]:
    """Return the rows of benches over motions, speeds and latencies; `choice` says which guard."""
    traces = []
    for kind, speeds in SPEEDS.items():
        for speed in speeds:
            traces.append(str(folder / f"{kind}-{speed}.csv"))
            about = ("--speed", speed, "--amplitude", AMPLITUDES[kind], "--seconds", "10")
            program("trace", "synth", kind, *about, "--out", traces[-1])
    sizes = [tuple(side // SMALL for side in size) for size in (OUTPUT, *PICTURES)]
    size, *pictures = (f"{width}x{height}" for width, height in sizes)
    choices = [("1", ("--guard", "1"))]
    for (width, height), picture, factor in zip(PICTURES, pictures, AS_MANY, strict=True):
        choices += [(f"{width}x{height}", ("--rendered-size", picture)), (factor, ("--guard", factor))]
    at = ("--latency", ",".join(LATENCIES), "--size", size, "--no-grid", "--no-fused", "--quiet")
    rows = []
    for choice, guard in choices:
        out = folder / f"thesis-{choice}"
        program("bench", *traces, *shlex.split(STEADILY), *at, *guard, "--out", str(out))
        found = json.loads((out / "bench.json").read_text(encoding="utf-8"))["rows"]
        rows += [{**row, "choice": choice} for row in found]
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
        guard = {"auto": f"auto: {row['guard']}", "wide": "1 and wide"}.get(row["choice"], row["choice"])
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
    """Return which of the thesis's pictures suffices for which motion, speed and latency."""
    shares = {
        (row["trace"], f"{row['latency_ms']:g}", row["choice"]): row["quality"]["border_share"]["mean"] for row in rows
    }
    pictures = [f"{width}x{height}" for width, height in PICTURES]
    choices = ["1"]
    for picture, factor in zip(pictures, AS_MANY, strict=True):
        choices += [picture, factor]
    heads = ["1280x800", *choices[1:]]
    lines = [
        f"| motion | latency ms | border % at {' | at '.join(heads)} | suffices |",
        "|" + " --- |" * (len(heads) + 3),
    ]
    for kind, speeds in SPEEDS.items():
        for speed in speeds:
            for latency in LATENCIES:
                found = {choice: shares[f"{kind}-{speed}", latency, choice] for choice in choices}
                enough = next((picture for picture in pictures if found[picture] < SUFFICES), "neither")
                figures = " | ".join(f"{100 * found[choice]:.2f}" for choice in choices)
                lines.append(f"| {kind} {speed} {UNITS[kind]} | {latency} | {figures} | {enough} |")
    return "\n".join(lines)
