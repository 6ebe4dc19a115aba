"""The two tables of README.md: rows selected from the tables of docs/, never typed in."""

from __future__ import annotations

import textwrap

from pages import rows_of, text_of

RECORDINGS = ("look-around", "walk")
FIGURES = ("ms", "PSNR dB", "FLIP")
THESIS = ("forward", "interpolate")  # stays in the table although others beat it
UNCORRECTED = "none"
LEAST = "rotation"  # what is worse in both recordings is left out, unless it is a baseline
DEFAULT_FIGURES = ("PSNR dB", "FLIP", "empty %")

Row = dict[str, str]
Pair = tuple[str, str]


WARPS_INTRO = """\
200 ms late, guard band 1.5, 1280x800 an eye, {machine}; each warp with the fill of the
lowest FLIP, and the thesis's. Bold: none is both quicker and more accurate."""
DEFAULTS_INTRO = """\
From the thesis's method to the default, one change after the other: 200 ms late, 480x600 an eye."""


def tables() -> str:
    """Return both tables, each with a line that says what it shows."""
    machine = text_of("machine").split(";")[1].strip()
    warps = textwrap.fill(WARPS_INTRO.format(machine=machine), 100, break_on_hyphens=False)
    return "\n\n".join((DEFAULTS_INTRO, defaults_table(), warps, warps_table()))


def warps_table() -> str:
    """Return each warp of a front and each baseline, with the fill of its lowest FLIP."""
    cases = [{_pair(row): row for row in rows_of(f"bench {recording} 200")} for recording in RECORDINGS]

    def total(pair: Pair, figure: str) -> float:
        return sum(float(rows[pair][figure]) for rows in cases)

    def flip(pair: Pair) -> float:
        return total(pair, "FLIP")

    best: dict[str, Pair] = {}
    for pair in sorted(set.intersection(*map(set, cases)), key=lambda pair: (flip(pair), total(pair, "time ms"))):
        best.setdefault(pair[0], pair)
    fronts = {warp for rows in cases for (warp, _), row in rows.items() if _is_front(row)}
    chosen = {
        pair
        for warp, pair in best.items()
        if warp == UNCORRECTED or "(" in warp or (warp in fronts and flip(pair) <= flip(best[LEAST]))
    }
    # Settings that lose accuracy for time are a matter of the full tables.
    chosen -= {
        pair
        for pair in chosen
        if ":" in pair[0] and "(" not in pair[0] and flip(pair) > flip(best[pair[0].partition(":")[0]])
    }
    lines = [_head("warp", "fill", *(f"{recording}: {name}" for recording in RECORDINGS for name in FIGURES))]
    for pair in sorted(chosen | {THESIS}, key=lambda pair: (flip(pair), pair)):
        spec, space, system = pair[0].partition(" (")
        cells = [f"`{spec}`{space}{system}", f"`{pair[1]}`"]
        for rows in cases:
            mark = "**" if _is_front(rows[pair]) else ""
            cells += [rows[pair]["time ms"], rows[pair]["PSNR dB"], f"{mark}{rows[pair]['FLIP']}{mark}"]
        lines.append(_line(cells))
    return "\n".join(lines)


def defaults_table() -> str:
    """Return what each step from the thesis's method to the default gains, of docs/results.md."""
    shown = ("pixels drawn", "ms an eye", *(f"{one}: {what}" for one in RECORDINGS for what in DEFAULT_FIGURES))
    lines = [_head("fill", *shown).replace("| fill |", "| |", 1)]
    lines += [_line([row[""], *(row[name] for name in shown)]) for row in rows_of("defaults")]
    return "\n".join(lines)


def _pair(row: Row) -> Pair:
    """Return warp, with its system if it is a baseline, and fill."""
    return row["warp"].replace("*", "").replace("`", ""), row["fill"].strip("`")


def _is_front(row: Row) -> bool:
    return row["warp"].startswith("**")


def _head(*columns: str) -> str:
    texts = [column in ("warp", "fill") for column in columns]
    return f"{_line(columns)}\n|{'|'.join(' --- ' if text else ' ---: ' for text in texts)}|"


def _line(cells: object) -> str:
    return "| " + " | ".join(cells) + " |"  # type: ignore[arg-type]
