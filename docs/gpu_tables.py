"""The table of times on a GPU in docs/results.md, from bench.json of runs there."""

from __future__ import annotations

from typing import Any

Row = dict[str, Any]


def times_table(rows: list[Row], trace: str = "look-around") -> str:
    """Return what warp and fill take together for one eye at each size, the quickest warp first.

    rows: of bench.json, at one latency. Median and 95th percentile in ms.
    """
    here = [row for row in rows if row["trace"] == trace]
    sizes = sorted({tuple(row["size"]) for row in here})
    times = {(row["warp"], row["fill"], tuple(row["size"])): row["time_ms"]["total"] for row in here}
    fills = list(dict.fromkeys(row["fill"] for row in here))
    warps = sorted({row["warp"] for row in here}, key=lambda warp: times[warp, fills[0], sizes[0]]["median"])
    heads = ["warp", *(f"{fill}, {size[0]}x{size[1]}" for size in sizes for fill in fills)]
    lines = ["| " + " | ".join(heads) + " |", "| --- |" + " ---: |" * (len(heads) - 1)]
    for warp in warps:
        found = [times.get((warp, fill, size)) for size in sizes for fill in fills]
        lines.append(f"| `{warp}` | " + " | ".join(_cell(each) for each in found) + " |")
    return "\n".join(lines)


def _cell(time: Row | None) -> str:
    return "" if time is None else f"{time['median']:.2f} ({time['p95']:.2f})"
