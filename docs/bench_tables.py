"""Tables for docs/results-warps.md that only the documentation needs, from bench.json."""

from __future__ import annotations

import textwrap
from typing import Any

Row = dict[str, Any]

# Columns of the displacement table: (kind of axis, step in metres or degrees).
STEPS = (("xyz", 0.1), ("xyz", 0.2), ("xyz", 0.3), ("turn", 10), ("turn", 20), ("turn", 30))


def machine_line(data: Row, *, defaults: bool = True) -> str:
    """Return what was measured with, on which machine; defaults: how long those take, if used."""
    clock = "GPU timers" if data["clock"] == "gpu" else "wall clock after every pass"
    parts = (
        f"hmdwarp {data['hmdwarp']}",
        f"{data['machine']['gl_renderer']}, {data['machine']['cpu_count']} cores",
        data["machine"]["gl_version"],
        clock,
        f"{data['copy_gb_s']:.1f} GB/s copied",
        *([f"the bench with its defaults took {data['seconds'] / 60:.1f} minutes"] if defaults else []),
    )
    return textwrap.fill("; ".join(parts) + ".", 100, break_on_hyphens=False)


def displacement_table(grid: list[Row]) -> str:
    """Return FLIP of each warp by head displacement: the mean over directions and axes."""
    heads = [f"{step * 100:.0f} cm" if kind == "xyz" else f"{step} degrees" for kind, step in STEPS]
    lines = ["| warp | " + " | ".join(heads) + " |", "|" + " --- |" * (len(STEPS) + 1)]
    for warp in dict.fromkeys(row["warp"] for row in grid):
        means = [_mean_flip([row for row in grid if row["warp"] == warp], kind, step) for kind, step in STEPS]
        lines.append(f"| `{warp}` | " + " | ".join(f"{mean:.3f}" for mean in means) + " |")
    return "\n".join(lines)


def _mean_flip(rows: list[Row], kind: str, step: float) -> float:
    flips = [
        row["flip"]
        for row in rows
        if (row["axis"] in "xyz") == (kind == "xyz") and abs(abs(row["offset"]) - step) < 1e-6
    ]
    return sum(flips) / len(flips)


def fused_table(rows: list[Row]) -> str:
    """Return the comparison of one resample for warp and lens with two."""
    lines = [
        "| warp | one resample ms | two ms | faster | PSNR dB one / two | FLIP one / two | sharpness one / two |",
        "|" + " --- |" * 7,
    ]
    digits = {"psnr_db": 2, "flip": 3, "sharpness": 2}
    for row in rows:
        pairs = [f"{row[k]['fused']:.{d}f} / {row[k]['separate']:.{d}f}" for k, d in digits.items()]
        times = f"{row['fused_ms']:.1f} | {row['separate_ms']:.1f} | {row['speedup']:.2f}x"
        lines.append(f"| `{row['warp']}` | {times} | {' | '.join(pairs)} |")
    return "\n".join(lines)


def traffic_table(rows: list[Row]) -> str:
    """Return the memory traffic of each pass, its least time, and how far above it the pass ran.

    A pass that occurs in several rows is taken from the first.
    """
    lines = ["| pass | MB | bound ms | measured ms | times the bound |", "|" + " --- |" * 5]
    seen = set()
    for row in rows:
        for one in row["passes"]:
            kind = one["name"]
            name = row["warp"] if kind == "warp" else f"{kind} {row.get(kind, '')}".strip()
            if name not in seen:
                seen.add(name)
                figures = (f"{one['bytes'] / 1e6:.1f}", f"{one['bound_ms']:.2f}", f"{one['median_ms']:.2f}")
                lines.append(f"| `{name}` | {' | '.join(figures)} | {one['times_bound']:.1f} |")
    return "\n".join(lines)
