"""bench.html: tables, charts and a choice of method, as data for the page builder."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import attrs

from ...metrics import PRIMARY, error_and_time, metrics, metrics_in_order
from .. import charts, page
from ..charts import Drawn, Look, Spot
from ..page import texts
from ..run_texts import Table, axes_of_traces, counted, listed
from . import rows as bench_rows
from .crops import Crops, crops_chart
from .rows import Case, Column, Row, at, common, measure_label, row_name, table_of


def looks_of(rows: Iterable[Row]) -> dict[str, Look]:
    """Return a look for each warp, which the charts of a page share."""
    return {warp: Look.of(number) for number, warp in enumerate(dict.fromkeys(row["warp"] for row in rows))}


def pareto_chart(case: Case, measure: str = PRIMARY, *, looks: Mapping[str, Look] | None = None) -> Drawn:
    """Draw one case as an <svg> element: mean error against median total time per eye.

    Colour and shape of a point say which warp it is. The best of each warp and the front have a
    number, which the legend explains. Rows without a measurement are left out. looks: of the warps,
    where several charts share them.
    """
    looks, front = looks or looks_of(case.ordered(measure)), set(map(id, case.front(measure)))
    rows = [row for row in case.ordered(measure) if None not in error_and_time(row, measure)]
    firsts = {row["warp"]: id(row) for row in reversed(rows)}
    spots, names = list[Spot](), dict[int, str]()
    for row in rows:
        entry, number = row["quality"][measure], None
        if id(row) in front or firsts[row["warp"]] == id(row):
            number = len(names) + 1
            names[number] = row_name(row) + (f" ({row['baseline']})" if row.get("baseline") else "")
        error = (entry["mean"], *(entry.get("interval") or [entry["mean"]] * 2))
        spots.append(Spot(_total_ms(row), error, looks[row["warp"]], id(row) in front, number))
    content = (case.label, measure, [(row_name(row), *error_and_time(row, measure)) for row in case.rows])
    higher, time = metrics.get(measure).higher_is_better, "time per eye, all stages, in ms"
    return charts.spots_chart(content, spots, names, x=time, y=measure_label(measure), higher=higher)


def pareto_text(case: Case, measure: str = PRIMARY) -> str:
    """Return the chart in words, for readers who cannot see it."""
    front = sorted(case.front(measure), key=_total_ms)
    names = [f"{row['warp']} with fill {row['fill']} ({_total_ms(row):.1f} ms)" for row in front]
    methods = ", ".join(names) or ("nothing was measured" if case.usable else "the bench's client can run none")
    return f"Error against time, {case.label}, {measure_label(measure)}. Pareto front, from quick to slow: {methods}."


def _total_ms(row: Row) -> float:
    return float(row["time_ms"]["total"]["median"])


MEASURES = ("flip", "psnr_db")


def bench_page(data: Mapping[str, Any], crops: Sequence[Sequence[Crops]] = ()) -> page.Page:
    """Return the page from the content of bench.json. crops: of the first cases."""
    rows: list[Row] = list(data["rows"])
    groups = bench_rows.cases(rows)
    warps, fills = len(_unique(rows, "warp")), len(_unique(rows, "fill"))
    methods = counted(warps, "warp") + (f" × {counted(fills, 'fill')}" if fills > 1 else "")
    title = methods, f"in {counted(len(groups), 'case')}"
    clock_note = (data.get("clocks") or {}).get("note")
    rated = [("JOD", texts("bench")["notes"]["jod"])] if any("jod" in row for row in rows) else []
    explained = [(m.label, m.explanation) for m in metrics_in_order() if m.explanation and m.bench_rank is not None]
    rows_of: dict[str, list[str]] = {str(note): [] for note in data.get("notes") or ()}
    for row in rows:
        for note in row.get("notes") or ():
            rows_of.setdefault(str(note), []).append(f"{row_name(row)}, {row['trace']}, {row['latency_ms']:g} ms")
    where = {
        note: "; ".join(names) if len(names) <= 3 else f"{len(names)} combinations" for note, names in rows_of.items()
    }
    told = texts("bench")["notes"]["crops"]
    cut = [
        page.Chart.of(group.label, crops_chart(both), f"{group.label}. {told}")
        for group, both in zip(groups, crops, strict=False)
        if both
    ]
    facts = [
        ("recordings", listed([str(trace) for trace in _unique(rows, "trace")])),
        *((f"axes of {trace}", axes) for trace, axes in axes_of_traces(rows).items()),
        ("latencies", listed([f"{latency:g} ms" for latency in _unique(rows, "latency_ms")])),
        ("fills", listed(_unique(rows, "fill"))),
        *(("", text) for text in common(rows)),
    ]
    return page.Page(
        kind="bench",
        title=f"hmdwarp bench: {' '.join(title)}",
        heading=title,
        facts=[page.fact(label, text) for label, text in facts if text],
        shared=common(rows),
        command=data.get("command") or "",
        sections=(
            page.Section("", [clock_note and page.Text(clock_note)], style="after"),
            page.notes_section([f"{note} ({names})" if names else note for note, names in where.items()]),
            suite_section(data.get("suite")),
            _tables(rows, groups),
            page.Section("Crops and error maps", cut and [page.Text(told), *cut], id="crops"),
            _fronts(groups, rows),
            page.reading_section("bench", *explained, *rated),
        ),
        made_with=[
            *page.machine_pairs(data.get("hmdwarp") or "–", data.get("machine") or {}, data.get("clock")),
            *([("Run in", page.minutes(data["seconds"]))] if data.get("seconds") else []),
        ],
    )


def suite_section(entry: Mapping[str, Any] | None) -> page.Section | None:
    """Return the means of a suite over all heads and scenes; None for no suite."""
    if not entry:
        return None
    flip, psnr = (metrics.get(name).figure for name in MEASURES)
    columns = {"flip": (flip, ""), "behind": (flip, " behind the best"), "held_out": (flip, " behind, held out")}
    columns |= {"psnr_db": (psnr, ""), "where_seen_db": (psnr, " where seen")}
    heads, lines = [("", ""), ("", ""), ("rank", "95 %"), ("best", "%")], []
    for name, (figure, what) in columns.items():
        heads += [(figure.label + what, figure.unit), ("95 %", figure.unit)]
        heads += [(f"{figure.label} p95", figure.unit)] * (name in MEASURES)
    for row in entry["over_all"]:
        line, rank = [f"{row['latency_ms']:g} ms", row_name(row), "–", "–"], row["rank"]
        if rank is not None:
            line[2:] = " to ".join(map(str, dict.fromkeys(rank["interval"]))), f"{100 * rank['best']:.0f}"
        for name, (figure, _) in columns.items():
            found = (row["halves"][name].get("behind") if name in row["halves"] else row[name]) or {}
            line += [figure.text(found.get("mean")), " to ".join(map(figure.text, found.get("interval") or ())) or "–"]
            line += [figure.text(found.get("p95"))] * (name in MEASURES)
        lines.append(line)
    heading = f"Suite {entry['name']} {entry['version']}: over all heads and scenes"
    told = texts("bench")["notes"]
    floors = [
        f"{sequence['name']}: {'unknown' if (floor := sequence['noise_floor_db']) is None else f'{floor:g} dB'}"
        for sequence in entry.get("sequences", ())
    ]
    blocks = [Table.of("", heads, lines, label=heading, words=2), page.Text(told["suite"]), *_halves(entry["over_all"])]
    return page.Section(heading, [*blocks, floors and page.Text(f"{told['floors']} {listed(floors)}.")])


def _halves(rows: Sequence[Mapping[str, Any]]) -> list[Table | page.Text]:
    """Return the means in the half that parameters are fitted on, and in the one held out."""
    names = {"fit": "fitted on", "held_out": "held out"}
    columns = [Column.of_text("", value=lambda row: f"{row['latency_ms']:g} ms"), Column.of_text("", value=row_name)]
    for figure, (half, name) in itertools.product((metrics.get(name).figure for name in MEASURES), names.items()):
        of_half = attrs.evolve(figure, label=f"{figure.label}, {name}")
        columns.append(Column(of_half, at("halves", half, figure.name)))
    counts = [max((row["halves"][half]["cases"] for row in rows), default=0) for half in names]
    label = "By half: {} cases of scenes and heads that parameters are fitted on, {} of others".format(*counts)
    return [page.Text(f"{label}."), table_of("", columns, rows, label=label)] if any(counts) else []


def _unique(rows: Iterable[Row], key: str) -> list[Any]:
    return list(dict.fromkeys(row[key] for row in rows))


def _tables(rows: Sequence[Row], groups: Sequence[Case]) -> page.Section:
    note = texts("bench")["notes"]["table"].format(sure=bench_rows.marked_how(rows, mark="★"))
    winners = [bench_rows.verdict_text(group.verdict()) for group in groups if group.rows]
    columns = bench_rows.decision(rows)
    folds: list[page.Fold] = []
    for group in groups:
        table = table_of(f"{group.label}, least FLIP first", columns, group.ordered(), case=group, has_marks=True)
        folds.append(page.Fold(group.label, [table], f"{len(group.rows)} methods", is_open=not folds))
    blocks = [page.Sentences(winners), page.Text(f"Rule: {bench_rows.RULE}."), page.Text(note), *folds]
    return page.Section("Summary: best method per case", blocks, id="table")


def _fronts(groups: Sequence[Case], rows: Sequence[Row]) -> page.Section:
    looks = looks_of(row for group in groups for row in group.ordered())
    known = [name for name in MEASURES if any(row["quality"][name]["mean"] is not None for row in rows)] or MEASURES
    charts = [
        page.Chart(
            group.label,
            tuple((name, pareto_chart(group, name, looks=looks), pareto_text(group, name)) for name in known),
        )
        for group in groups
    ]
    measures = [(name, measure_label(name).partition(",")[0]) for name in known]
    choice = [page.Choice("measure-time", measures)] if len(known) > 1 else []
    return page.Section("Error against time", [*choice, *charts], id="time")
