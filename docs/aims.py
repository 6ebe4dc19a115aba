"""The project's aims for the bench and whether they were met: a table for docs/results-warps.md."""

from __future__ import annotations

from collections.abc import Iterable

from hmdwarp.report.bench import cases

THESIS = ("forward", "interpolate")
LATENCY_MS = 200


def _figures(row: dict) -> tuple[float, float, float]:
    """Return (ms, PSNR, FLIP)."""
    return row["time_ms"]["total"]["median"], row["quality"]["psnr_db"]["mean"], row["quality"]["flip"]["mean"]


def _name(row: dict) -> str:
    return f"`{row['warp']}`" + (f" + `{row['fill']}`" if row["fill"] != "none" else "")


def _of(rows: Iterable[dict], warp: str, fill: str) -> dict | None:
    return next((row for row in rows if (row["warp"], row["fill"]) == (warp, fill)), None)


def _lines_of_case(trace: str, rows: list[dict]) -> list[str]:
    thesis, none, rotation = _of(rows, *THESIS), _of(rows, "none", "none"), _of(rows, "rotation", "none")
    best = min(rows, key=lambda row: _figures(row)[2])
    ms, psnr, flip = _figures(thesis)
    affordable = min((row for row in rows if _figures(row)[0] <= ms), key=lambda row: _figures(row)[2])
    gain, share = _figures(affordable)[1] - psnr, _figures(affordable)[2] / flip
    lines = [
        _line(
            trace,
            f"best within the time of `forward` + `interpolate`: PSNR + 3 dB ({_name(affordable)})",
            f"{gain:+.2f} dB",
            gain >= 3,
        ),
        _line(trace, f"the same: half its FLIP ({_name(affordable)})", f"{share:.2f} of it", share <= 0.5),
    ]
    enough = [row for row in rows if _figures(row)[1] >= psnr + 3]
    if gain < 3 and enough:
        near = min(enough, key=lambda row: _figures(row)[0])
        near_ms, near_psnr, near_flip = _figures(near)
        result = f"{near_ms / ms:.2f}x the time, {near_psnr - psnr:+.2f} dB, {near_flip / flip:.2f} of the FLIP"
        lines.append(f"| {trace} | how near: the quickest with 3 dB more ({_name(near)}) | {result} | |")
    for other, limit in ((none, 0.25), (rotation, 0.5)):
        share = _figures(best)[2] / _figures(other)[2]
        aim = f"best of all: {limit:g} of the FLIP of {_name(other)} ({_name(best)})"
        lines.append(_line(trace, aim, f"{share:.2f} of it", share <= limit))
    mesh, adaptive = _of(rows, "mesh", "none"), _of(rows, "mesh_adaptive", "none")
    faster, lost = _figures(mesh)[0] / _figures(adaptive)[0], _figures(mesh)[1] - _figures(adaptive)[1]
    aim = "`mesh_adaptive` 5x faster than `mesh` at 0.3 dB or less"
    lines.append(_line(trace, aim, f"{faster:.1f}x at {lost:.2f} dB", faster >= 5 and lost <= 0.3))
    return lines


def _line(trace: str, aim: str, result: str, met: bool) -> str:
    return f"| {trace} | {aim} | {result} | {'met' if met else 'not met'} |"


def table(data: dict) -> str:
    """Return one line for each aim and recording."""
    lines = ["| recording | aim | result | |", "| --- | --- | --- | --- |"]
    for case in cases(row for row in data["rows"] if row["latency_ms"] == LATENCY_MS):
        lines += _lines_of_case(case.rows[0]["trace"], list(case.rows))
    for row in data["fused"]:
        lines.append(
            _line(
                "", f"`{row['warp']}` fused with the lens: 1.3x faster", f"{row['speedup']:.2f}x", row["speedup"] >= 1.3
            )
        )
    return "\n".join(lines)
