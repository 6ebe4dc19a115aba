"""The two tables of README.md: rows selected from the tables of docs/, never typed in."""

from __future__ import annotations

import textwrap

from pages import rows_of, text_of

RECORDINGS = ("look-around", "walk")
FIGURES = ("ms", "PSNR dB", "FLIP")
BASELINE = "forward"  # the thesis' warp stays in the table although others beat it
CHAINS = (
    ("forward", "interpolate"),
    ("forward", "pyramid"),
    ("forward", "memory+pyramid"),
    ("forward", "relight"),
    ("mesh", "relight"),
)

Row = dict[str, str]


WARPS_INTRO = """\
200 ms late, guard band 1.5, 1280x800 an eye, {machine}; the better of no fill and
`interpolate`. Bold: no other method is both quicker and more accurate."""
FILLS_INTRO = """\
400 ms late, guard band 1.5, 480x600 an eye, the time of the fill alone; `interpolate` leaves holes."""


def tables() -> str:
    """Return both tables, each with a line that says what it shows."""
    machine = text_of("machine").split(";")[1].strip()
    warps = textwrap.fill(WARPS_INTRO.format(machine=machine), 100, break_on_hyphens=False)
    return "\n\n".join((warps, warps_table(), FILLS_INTRO, fills_table()))


def warps_table() -> str:
    """Return one row for each warp on the Pareto front of a recording: its lowest FLIP."""
    best = {recording: _best_rows(rows_of(f"bench {recording} 200")) for recording in RECORDINGS}
    fronts = {name for rows in best.values() for name, row in rows.items() if _is_front(row)} | {BASELINE}
    names = sorted(fronts, key=lambda name: (sum(float(rows[name]["FLIP"]) for rows in best.values()), name))
    lines = [_head("warp", *(f"{recording}: {name}" for recording in RECORDINGS for name in FIGURES))]
    for name in names:
        cells = [f"`{name}`"]
        for recording in RECORDINGS:
            row = best[recording][name]
            mark = "**" if _is_front(row) else ""
            cells += [row["time ms"], row["PSNR dB"], f"{mark}{row['FLIP']}{mark}"]
        lines.append(_line(cells))
    return "\n".join(lines)


def fills_table() -> str:
    """Return the rows of CHAINS at 400 ms, both recordings side by side."""
    rows = {(row["recording"], row["warp"].strip("`"), row["fill"].strip("`")): row for row in rows_of("fills")}
    columns = ("fill ms an eye", "PSNR dB", "FLIP")
    lines = [_head("warp", "fill", *(f"{recording}: {name}" for recording in RECORDINGS for name in FIGURES))]
    for warp, fill in CHAINS:
        figures = [rows[recording, warp, fill][name] for recording in RECORDINGS for name in columns]
        lines.append(_line([f"`{warp}`", f"`{fill}`", *figures]))
    return "\n".join(lines)


def _best_rows(rows: list[Row]) -> dict[str, Row]:
    """Return the row of each warp with the lowest FLIP, the quicker one of equals."""
    best: dict[str, Row] = {}
    for row in sorted(rows, key=lambda row: (float(row["FLIP"]), float(row["time ms"]))):
        best.setdefault(row["warp"].strip("*`"), row)
    return best


def _is_front(row: Row) -> bool:
    return row["warp"].startswith("**")


def _head(*columns: str) -> str:
    texts = [column in ("warp", "fill") for column in columns]
    return f"{_line(columns)}\n|{'|'.join(' --- ' if text else ' ---: ' for text in texts)}|"


def _line(cells: object) -> str:
    return "| " + " | ".join(cells) + " |"  # type: ignore[arg-type]
