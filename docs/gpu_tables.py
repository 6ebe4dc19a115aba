"""What docs/gpu.md says about one GPU, from gpu.json of `make bench-gpu` there."""

from __future__ import annotations

import re
from typing import Any

import bench_tables
from pages import DOCS, replace

PAGE = DOCS / "gpu.md"

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


def name_of(renderer: str) -> str:
    """Return the GPU's name as a heading: without the bus and the instruction set of the CPU."""
    return re.sub(r"/PCIe.*|/SSE2", "", renderer).strip()


def section(data: Row) -> str:
    """Return the section of one GPU in Markdown, with its heading."""
    renderer = next(one["facts"]["renderer"] for one in data["doctor"] if one["name"] == "OpenGL")
    parts = [f"## {name_of(renderer)}"]
    if data["bench"]:
        rows = [row for each in data["bench"] for row in each["rows"]]
        parts += [
            bench_tables.machine_line(data["bench"][0], defaults=False),
            "Warp and fill together, one eye, median and 95th percentile in ms:",
            times_table(rows),
        ]
        paths = paths_line(rows)
        parts += [paths] if paths else []
    # Files from before there was this part lack it.
    if data.get("chains"):
        copied = data["bench"][0]["copy_gb_s"] if data["bench"] else None
        parts += [
            "Both eyes in one refresh, while copies keep the clock up, in ms:",
            chains_table(data["chains"], copied),
        ]
    if data["bench"]:
        for each in data["bench"]:
            size = "x".join(map(str, each["rows"][0]["size"]))
            parts += [
                f"What each pass must move at {size}, at {each['copy_gb_s']:.1f} GB/s copied, and what it took:",
                bench_tables.traffic_table(each["rows"]),
            ]
    if data["live"]:
        parts += ["`hmdwarp live`, both eyes, in ms:", live_table(data["live"])]
    if data["bench_live"]:
        parts.append(f"`make bench-live`:\n\n```text\n{data['bench_live'].rstrip()}\n```")
    parts += ["Left out:\n\n" + "\n".join(f"- {line}" for line in data["left_out"])] if data["left_out"] else []
    return "\n\n".join(parts) + "\n"


def chains_table(chains: list[Row], copy_gb_s: float | None) -> str:
    """Return median and 95th percentile of whole chains, and how far the warp is from its bound."""
    lines = [
        "| chain | size | warp | fill | all passes | warp over its memory bound |",
        "| --- | --- | ---: | ---: | ---: | ---: |",
    ]
    for row in chains:
        times = row["time_ms"]
        cells = [_cell(times.get(stage)) for stage in ("warp", "fill", "total")]
        bound_ms = row["warp_bytes"] / (copy_gb_s * 1e6) if copy_gb_s else None
        cells.append(f"{times['warp']['median'] / bound_ms:.1f}" if bound_ms else "")
        lines.append(f"| {row['chain']} | {'x'.join(map(str, row['size']))} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def paths_line(rows: list[Row]) -> str:
    """Return the time of `forward`'s 64-bit path beside the portable one; "" without both."""
    told = []
    for size in dict.fromkeys(tuple(row["size"]) for row in rows):
        medians = {
            row["warp"]: row["time_ms"]["warp"]["median"]
            for row in rows
            if tuple(row["size"]) == size and row["fill"] == "none"
        }
        one, two = (medians.get(f"forward:path={path}") for path in ("atomic64", "portable"))
        if one and two:
            told.append(f"{one:.3f} ms against {two:.3f} at {size[0]}x{size[1]} ({one / two:.2f} of it)")
    return (
        f"`forward` in one pass with 64-bit atomics, against two with 32-bit ones: {', '.join(told)}." if told else ""
    )


def live_table(summaries: list[Row]) -> str:
    """Return the median and the 95th percentile of a refresh's parts in live runs."""
    stages = ("render", "warp", "fill", "lens", "total")
    lines = ["| size | chain | " + " | ".join(stages) + " |", "| --- | --- |" + " ---: |" * len(stages)]
    for one in summaries:
        size, chain = "x".join(map(str, one["size"])), f"`{one['warp']}`, `{one['fill']}`, lens `{one['lens']}`"
        cells = " | ".join(_cell(one["live"]["refresh_ms"][stage]) for stage in stages)
        lines.append(f"| {size} | {chain} | {cells} |")
    return "\n".join(lines)


def file_section(data: Row) -> None:
    """Write the section into docs/gpu.md: in place of this GPU's earlier one, else at the end."""
    text = section(data)
    name = text.splitlines()[0].removeprefix("## ")
    marker = f"gpu {name}"
    page = PAGE.read_text(encoding="utf-8")
    if f"<!-- {marker} -->" not in page:
        PAGE.write_text(f"{page.rstrip()}\n\n## {name}\n\n<!-- {marker} -->\n<!-- end -->\n", encoding="utf-8")
    replace(marker, text.partition("\n")[2].lstrip())
