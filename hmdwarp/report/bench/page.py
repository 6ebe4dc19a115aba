"""bench.html: tables, charts and a choice of method, as data for the page builder."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import attrs
from markupsafe import Markup

from ...metrics import REGIONS, Figure, metrics, metrics_in_order
from ..page import (
    CLOCK_NAMES,
    Chart,
    Choice,
    Fold,
    Page,
    Section,
    Text,
    Tile,
    fact,
    machine_pairs,
    minutes,
    notes_section,
    reading_section,
    texts,
)
from ..run_texts import axes_of_traces
from ..style import markers_of
from ..words import Table, counted, listed, plain
from .charts import (
    pareto_chart,
    pareto_text,
    region_parts,
    regions_chart,
    row_name,
)
from .rows import (
    COLUMNS,
    Case,
    Column,
    Row,
    at,
    cases,
    choice_terms,
    common,
    decision,
    marked_how,
    measure_label,
    table_of,
)

MEASURES = ("flip", "psnr_db")
_REFERENCE = ("forward", "interpolate")  # the pipeline of the thesis that this project began with
_KEYS_OF_A_CHOICE = {"budget_ms", "warp", "fill", "settings", "total_ms", "flip", "psnr_db", "sizes", "cases", "next"}


def bench_page(data: Mapping[str, Any]) -> Page:
    """Return the page from the content of bench.json.

    The same content gives the same page. Sections without data (no regions, no budget)
    are left out.
    """
    rows: list[Row] = list(data["rows"])
    groups = cases(rows)
    title = _title(rows, groups)
    clock_note = (data.get("clocks") or {}).get("note")
    rated = [("JOD", texts("bench")["notes"]["jod"])] if any("jod" in row for row in rows) else []
    explained = [(m.label, m.explanation) for m in metrics_in_order() if m.explanation and m.bench_rank is not None]
    return Page(
        kind="bench",
        title=f"hmdwarp bench: {' '.join(title)}",
        heading=title,
        facts=_facts(rows, groups),
        command=data.get("command") or "",
        sections=(
            _choice(data.get("choice")),
            Section("", _tiles(data, rows), style="tiles", label="What was run"),
            Section("", [clock_note and Text(clock_note)], style="after"),
            notes_section(_notes(data, rows)),
            suite_section(data.get("suite")),
            _tables(rows, groups),
            _fronts(groups, rows),
            _regions(groups),
            reading_section("bench", *explained, *rated),
        ),
        made_with=machine_pairs(data.get("hmdwarp") or "–", data.get("machine") or {}, data.get("clock")),
    )


def suite_section(entry: Mapping[str, Any] | None) -> Section | None:
    """Return the means of a suite over all heads and scenes; None for no suite."""
    if not entry:
        return None
    flip, psnr = (metrics.get(name).figure for name in ("flip", "psnr_db"))
    behind = attrs.evolve(flip, name="behind", label="FLIP behind the best")
    seen = attrs.evolve(psnr, name="where_seen_db", label="PSNR where seen")
    columns = [(flip, "mean"), (flip, "p95"), (behind, "mean"), (psnr, "mean"), (psnr, "p95"), (seen, "mean")]
    lines = [
        (
            f"{row['latency_ms']:g} ms",
            row_name(row),
            *_rank(row["rank"]),
            *(text for figure, which in columns for text in _with_interval(figure, row[figure.name], which)),
        )
        for row in entry["over_all"]
    ]
    heads = [("", ""), ("", ""), ("rank", "95 %"), ("best", "%")]
    for figure, which in columns:
        label = figure.label if which == "mean" else f"{figure.label} {which}"
        heads += [(label, figure.unit), ("95 %", figure.unit)]
    heading = f"Suite {entry['name']} {entry['version']}: over all heads and scenes"
    told = texts("bench")["notes"]
    floors = [
        f"{sequence['name']}: {'unknown' if (floor := sequence['noise_floor_db']) is None else f'{floor:g} dB'}"
        for sequence in entry.get("sequences", ())
    ]
    blocks = [Table.of("", heads, lines, label=heading, words=2), Text(told["suite"]), *_halves(entry["over_all"])]
    return Section(heading, [*blocks, floors and Text(f"{told['floors']} {listed(floors)}.")])


def _halves(rows: Sequence[Mapping[str, Any]]) -> list[Table | Text]:
    """Return the means in the half that parameters are fitted on, and in the one held out."""
    names = {"fit": "fitted on", "held_out": "held out"}
    columns = [Column.of_text("", value=lambda row: f"{row['latency_ms']:g} ms"), Column.of_text("", value=row_name)]
    for figure, (half, name) in itertools.product((metrics.get(name).figure for name in MEASURES), names.items()):
        of_half = attrs.evolve(figure, label=f"{figure.label}, {name}")
        columns.append(Column(of_half, at("halves", half, figure.name)))
    counts = [max((row["halves"][half]["cases"] for row in rows), default=0) for half in names]
    label = "By half: {} cases of scenes and heads that parameters are fitted on, {} of others".format(*counts)
    return [Text(f"{label}."), table_of("", columns, rows, label=label)] if any(counts) else []


def _rank(rank: Mapping[str, Any] | None) -> tuple[str, str]:
    if rank is None:
        return "–", "–"
    return " to ".join(map(str, dict.fromkeys(rank["interval"]))), f"{100 * rank['best']:.0f}"


def _with_interval(figure: Figure, entry: Mapping[str, Any] | None, which: str) -> tuple[str, str]:
    if entry is None:
        return "–", "–"
    interval = entry["interval" if which == "mean" else f"{which}_interval"]
    return figure.text(entry[which]), " to ".join(map(figure.text, interval)) if interval else "–"


def _unique(rows: Iterable[Row], key: str) -> list[Any]:
    return list(dict.fromkeys(row[key] for row in rows))


def _title(rows: Sequence[Row], groups: Sequence[Case]) -> tuple[str, str]:
    warps, fills = len(_unique(rows, "warp")), len(_unique(rows, "fill"))
    methods = counted(warps, "warp") + (f" × {counted(fills, 'fill')}" if fills > 1 else "")
    return methods, f"in {counted(len(groups), 'case')}"


def _facts(rows: Sequence[Row], groups: Sequence[Case]) -> list[str]:
    facts = [
        ("recordings", listed([str(trace) for trace in _unique(rows, "trace")])),
        *((f"axes of {trace}", axes) for trace, axes in axes_of_traces(rows).items()),
        ("latencies", listed([f"{latency:g} ms" for latency in _unique(rows, "latency_ms")])),
        ("fills", listed(_unique(rows, "fill"))),
    ]
    return [fact(label, text) for label, text in facts if text] + [fact("", text) for text in common(rows)]


def _tiles(data: Mapping[str, Any], rows: Sequence[Row]) -> list[Tile]:
    clocks = data.get("clocks") or {}
    gpu, wall = clocks.get("gpu_ms"), clocks.get("wall_ms")
    both = " / ".join("–" if value is None else f"{value:.3g}" for value in (gpu, wall))
    seconds, clock = data.get("seconds"), data.get("clock", "")
    ran = f"run in {minutes(seconds)}" if seconds else "warp, fill, recording, latency"
    return [
        Tile("Combinations", "", str(len(rows)), ran),
        Tile("Clock", "", {"gpu": "GPU", "wall": "wall"}.get(clock, "?"), CLOCK_NAMES.get(clock, "")),
        Tile("One pass, two clocks", "ms", both, "GPU timer / wall clock; where they agree, the timer is real"),
    ]


def _notes(data: Mapping[str, Any], rows: Sequence[Row]) -> list[str]:
    """Return each note once, the bench's first; a row's note with its rows, or their number."""
    rows_of: dict[str, list[str]] = {str(note): [] for note in data.get("notes") or ()}
    for row in rows:
        for note in row.get("notes") or ():
            rows_of.setdefault(str(note), []).append(f"{row_name(row)}, {row['trace']}, {row['latency_ms']:g} ms")
    where = {
        note: "; ".join(names) if len(names) <= 3 else f"{len(names)} combinations" for note, names in rows_of.items()
    }
    return [f"{note} ({names})" if names else note for note, names in where.items()]


def _choice(choice: Mapping[str, Any] | None) -> Section | None:
    """Return the box with the method that was chosen within the budget, and the next step up."""
    if not choice:
        return None
    settings = choice.get("settings")
    settings = dict(settings) if isinstance(settings, Mapping) else {"settings": settings} if settings else {}
    settings |= {key: value for key, value in choice.items() if key not in _KEYS_OF_A_CHOICE and value is not None}
    figures = Markup("<b>{:.2f} ms</b>, {} ({})").format(choice["total_ms"], _figures(choice), choice_terms(choice))
    step, more = choice.get("next"), "Nothing measured is more accurate at any time."
    if step:
        named = Markup("The next step up: <b>{} + {}</b>, {:.2f} ms, {} ({}).")
        parts = []
        if choice.get("flip") and step.get("flip") is not None:
            parts.append(
                f"{100 * (1 - step['flip'] / choice['flip']):+.0f} % of the FLIP error removed".replace("+", "")
            )
        if choice.get("psnr_db") is not None and step.get("psnr_db") is not None:
            parts.append(f"{step['psnr_db'] - choice['psnr_db']:+.2f} dB")
        parts.append(f"{step['total_ms'] - choice['total_ms']:+.2f} ms")
        more = named.format(step["warp"], step["fill"], step["total_ms"], _figures(step), ", ".join(parts))
    blocks = [
        Text(f"{choice['warp']} + {choice['fill']}", "name"),
        settings and Text(", ".join(f"{name} {value}" for name, value in settings.items()), ""),
        Text(figures, ""),
        Text(more, ""),
    ]
    heading = f"The most accurate within {choice['budget_ms']:g} ms per eye on this machine"
    return Section(heading, blocks, style="answer")


def _figures(entry: Mapping[str, Any]) -> str:
    flip, psnr = (metrics.get(name).short_figure.text(entry.get(name)) for name in ("flip", "psnr_db"))
    return f"FLIP {flip}, PSNR {psnr} dB"


def _tables(rows: Sequence[Row], groups: Sequence[Case]) -> Section:
    note = texts("bench")["notes"]["table"].format(sure=marked_how(rows, mark="★ and bold"))
    folds = [
        Fold(group.label, [_decision(group)], f"{len(group.rows)} methods", is_open=number == 0)
        for number, group in enumerate(groups)
    ]
    return Section("The table to decide from", [_winners(groups), Text(note), *folds], id="table", link="Table")


def _decision(case: Case) -> Table:
    columns = [COLUMNS[name] for name in decision(case.rows)]
    return table_of(f"{case.label}, least FLIP first", columns, case.ordered(), marked=case.held(), has_marks=True)


def _winners(groups: Sequence[Case]) -> Table:
    """Return each case's most accurate row and its most accurate within the thesis's time."""
    lines: list[list[str]] = []
    has_limit = False
    for group in groups:
        measured = [
            row for row in group.ordered() if not row.get("lacks") and row["quality"]["flip"]["mean"] is not None
        ]
        limit = next((_total(row) for row in measured if (row["warp"], row["fill"]) == _REFERENCE), None)
        within = [
            row for row in measured if limit is not None and (total := _total(row)) is not None and total <= limit
        ]
        has_limit |= limit is not None
        lines.append([group.label, *_first(measured), *_first(within), plain(limit)])
    figures = (("time", "ms"), ("FLIP", ""))
    heads = [("case", ""), ("most accurate", ""), *figures]
    heads += [("best no slower than forward + interpolate", ""), *figures, ("that takes", "ms")] if has_limit else []
    return Table.of("The most accurate of each case", heads, [line[: len(heads)] for line in lines], words=(0, 1, 4))


def _total(row: Row) -> float | None:
    total: float | None = row["time_ms"]["total"]["median"]
    return total


def _first(rows: Sequence[Row]) -> list[str]:
    if not rows:
        return ["–", "–", "–"]
    return [row_name(rows[0]), COLUMNS["total_ms"].text(rows[0]), COLUMNS["flip"].text(rows[0])]


def _fronts(groups: Sequence[Case], rows: Sequence[Row]) -> Section:
    markers = markers_of(row["fill"] for row in rows)
    known = [name for name in MEASURES if any(row["quality"][name]["mean"] is not None for row in rows)] or MEASURES
    charts = [
        Chart(
            group.label,
            tuple((name, pareto_chart(group, name, markers=markers), pareto_text(group, name)) for name in known),
        )
        for group in groups
    ]
    choice = [_measures("time", known)] if len(known) > 1 else []
    return Section("Error against time", [*choice, *charts], id="time", link="Error against time")


def _measures(section: str, names: Sequence[str] = MEASURES) -> Choice:
    return Choice(f"measure-{section}", [(name, measure_label(name).partition(",")[0]) for name in names])


def _regions(groups: Sequence[Case]) -> Section:
    folds: list[Fold] = []
    for group in groups:
        if any(region_parts(row) for row in group.rows):
            words = f"Error by region, {group.label}: see the table below"
            blocks = [Chart.of("", regions_chart(group), words), Fold("As a table", [_regions_table(group)])]
            folds.append(Fold(group.label, blocks, is_open=not folds))
    notes = texts("bench")["notes"]
    heading, note = "Where the error lies", Text(f"{notes['regions']} {notes['regions_chart']}")
    return Section(heading, [note, *folds] if folds else [], id="regions", link=heading)


def _regions_table(case: Case) -> Table:
    names = [f"{region}_{figure}" for region in REGIONS for figure in ("share", "flip", "psnr_db")]
    columns = [COLUMNS[name] for name in ("warp", "fill", *names)]
    return table_of(f"Error by region, {case.label}", columns, filter(region_parts, case.ordered()))
