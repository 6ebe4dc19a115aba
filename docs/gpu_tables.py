"""What docs/gpu.md says about one GPU, from gpu.json of `make bench-gpu` there."""

from __future__ import annotations

import re
import textwrap
from typing import Any

from pages import DOCS, markdown, replace

PAGE = DOCS / "gpu.md"

Row = dict[str, Any]


def machine_line(data: Row, *, defaults: bool = True) -> str:
    """Return what was measured with, on which machine; defaults: how long those take, if used."""
    clock = "GPU timers" if data["clock"] == "gpu" else "wall clock after every pass"
    parts = (
        f"hmdwarp {data['hmdwarp']}",
        f"{data['machine']['gl_renderer']}, {data['machine']['cpu_count']} cores",
        data["machine"]["gl_version"],
        clock,
        *([f"the bench with its defaults took {data['seconds'] / 60:.1f} minutes"] if defaults else []),
    )
    return textwrap.fill("; ".join(parts) + ".", 100, break_on_hyphens=False)


def times_table(rows: list[Row], trace: str = "look-around") -> str:
    """Return what warp and fill take for one eye, for warps of every size, the quickest first.

    rows: of bench.json, at one latency. Median and 95th percentile in ms.
    """
    here = [row for row in rows if row["trace"] == trace]
    sizes = sorted({tuple(row["size"]) for row in here})
    times = {(row["warp"], row["fill"], tuple(row["size"])): row["time_ms"]["total"] for row in here}
    fills = list(dict.fromkeys(row["fill"] for row in here))
    warps = {row["warp"] for row in here if all((row["warp"], fills[0], size) in times for size in sizes)}
    warps = sorted(warps, key=lambda warp: times[warp, fills[0], sizes[0]]["median"])
    heads = ["warp", *(f"{fill}, {size[0]}x{size[1]}" for size in sizes for fill in fills)]
    cells = [[_cell(times.get((warp, fill, size))) for size in sizes for fill in fills] for warp in warps]
    return markdown(heads, [[f"`{warp}`", *line] for warp, line in zip(warps, cells, strict=True)])


def _cell(time: Row | None) -> str:
    return "" if time is None else f"{time['median']:.2f} ({time['p95']:.2f})"


def name_of(renderer: str) -> str:
    """Return the GPU's name as a heading: without the bus and the instruction set of the CPU."""
    return re.sub(r"/PCIe.*|/SSE2", "", renderer).strip()


def section(data: Row) -> str:
    """Return the section of one GPU in Markdown, with its heading."""
    renderer = next(each["facts"]["renderer"] for each in data["doctor"] if each["name"] == "OpenGL")
    parts = [f"## {name_of(renderer)}"]
    if data["bench"]:
        rows = [row for each in data["bench"] for row in each["rows"]]
        parts += [
            machine_line(data["bench"][0], defaults=False),
            "Warp and fill together, one eye, median and 95th percentile in ms:",
            times_table(rows),
        ]
    # Files from before there was this part lack it.
    if data.get("chains"):
        parts += ["Both eyes in one refresh, while copies keep the clock up, in ms:", chains_table(data["chains"])]
    if data["live"]:
        parts += ["`hmdwarp live`, both eyes, in ms:", live_table(data["live"])]
    if data.get("arrays"):
        parts.append(f"Calls with arrays:\n\n```text\n{data['arrays'].rstrip()}\n```")
    if data["bench_live"]:
        parts.append(f"`make bench-live`:\n\n```text\n{data['bench_live'].rstrip()}\n```")
    parts += ["Left out:\n\n" + "\n".join(f"- {line}" for line in data["left_out"])] if data["left_out"] else []
    return "\n\n".join(parts) + "\n"


def chains_table(chains: list[Row]) -> str:
    """Return median and 95th percentile of whole chains."""
    lines = []
    for row in chains:
        cells = [_cell(row["time_ms"].get(stage)) for stage in ("warp", "fill", "total")]
        lines.append([row["chain"], "x".join(map(str, row["size"])), *cells])
    return markdown(("chain", "size", "warp", "fill", "all passes"), lines, texts=2)


def live_table(summaries: list[Row]) -> str:
    """Return the median and the 95th percentile of a refresh's parts in live runs."""
    stages, lines = ("render", "warp", "fill", "lens", "total"), []
    for each in summaries:
        chain = f"`{each['warp']}`, `{each['fill']}`, lens `{each['lens']}`"
        lines.append(["x".join(map(str, each["size"])), chain, *(_cell(each["live"]["refresh_ms"][s]) for s in stages)])
    return markdown(("size", "chain", *stages), lines, texts=2)


def file_section(data: Row) -> None:
    """Write the section into docs/gpu.md: in place of this GPU's earlier one, else at the end."""
    text = section(data)
    name = text.splitlines()[0].removeprefix("## ")
    marker = f"gpu {name}"
    page = PAGE.read_text(encoding="utf-8")
    if f"<!-- {marker} -->" not in page:
        PAGE.write_text(f"{page.rstrip()}\n\n## {name}\n\n<!-- {marker} -->\n<!-- end -->\n", encoding="utf-8")
    replace(marker, text.partition("\n")[2].lstrip())
