"""report.html of a study's analysis, as data for the page builder."""

from __future__ import annotations

import functools
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from string import Formatter
from typing import Any

import numpy as np

from . import page
from .charts import INK, SERIES, Style, canvas, legend, mark, name_rows, svg_text
from .page import texts
from .run_texts import Heads, Table, counted, interval, p_text, pair_text, plain, signed

Row = Mapping[str, Any]
Lines = tuple[Heads, list[list[str]]]


def _wrapped(name: str) -> str:
    # After a comma first: "forward + interpolate, 200 ms" keeps its 200 ms together. Then at a
    # space, or after the plus of a chain of fills.
    parts = (part.replace("+", "+\0 ").replace("+\0  ", "+ ") for part in name.split(", "))
    lines = (line for part in parts for line in textwrap.wrap(part, _WRAP, break_on_hyphens=False) or [part])
    return "\n".join(line.replace("\0 ", "").replace("\0", "") for line in lines)


def _condition_text(row: Row) -> str:
    """Return a condition's name, marked as the hidden reference unless the name says so."""
    unmarked = not row["reference"] or "reference" in row["condition"].lower()
    return row["condition"] if unmarked else f"{row['condition']} (reference)"


_WRITERS: Mapping[str, Callable[..., str]] = {
    "plain": plain, "signed": signed, "p": p_text, "share": lambda share: f"{100 * share:.1f} %",
}  # fmt: skip


def _cell(template: str, row: Row) -> str:
    """Return a cell of a table; a dash where one of its values is missing."""
    found = ""
    for text, name, given, _ in Formatter().parse(template):
        value, how = row.get(name) if name else "", given or ""
        if value is None:
            return "–"
        writer = how.rstrip("0123456789")
        write = _WRITERS.get(writer)
        found += text + (write(value, *map(int, how[len(writer) :])) if write else format(value, how))
    return found


def best_first(conditions: Iterable[Row]) -> list[Row]:
    return sorted(conditions, key=lambda row: -row["jod"])


def study_lines(table: str, rows: Iterable[Row], **heads: str) -> Lines:
    """Return the heads and cells of a table of an analysis. heads: in place of some."""
    columns, lines = texts("study")["tables"][table], []
    for row in rows:
        more = {"trial": row.get("trial") or "practice"}
        if "baseline" in row:
            more["pair"] = pair_text(row["baseline"], row["condition"])
            more["part_pair"] = ": ".join(filter(None, (row.get("part"), more["pair"])))
            more["pairs"] = "{n} ({better}/{equal}/{worse})".format(**row) if row.get("n") and "better" in row else "0"
        elif "reference" in row:
            more["condition"] = _condition_text(row)
        lines.append([_cell(template, {**row, **more}) for _, _, template in columns])
    return [(heads.get(head, head), unit) for head, unit, _ in columns], lines


def csv_tables(data: Row) -> dict[str, tuple[Sequence[str], list[dict[str, Any]]]]:
    """Return (columns, rows) by file name: every number of the analysis, unrounded."""
    columns_of = texts("study")["csv"]
    rows: dict[str, list[dict[str, Any]]] = {name: [] for name in columns_of}

    def add(name: str, *entries: Row) -> None:
        whole = {key: value for entry in entries for key, value in entry.items()}
        rows[name].append({key: whole.get(key) for key in columns_of[name]})

    for scale in data["scales"]:
        named = {"scale": scale["measure"]["name"]}
        for part in scale["parts"]:
            for row in part["conditions"]:
                own = named | {"part": part["part"]}
                add("conditions.csv", row, own)
                for who, value in row["ratings"].items():
                    add("ratings.csv", row, own, {"participant": who, "value": value})
        for row in scale["comparisons"]:
            add("comparisons.csv", row)
            for who, value in row["differences"].items():
                add("differences.csv", row, named, {"participant": who, "difference": value})
        for row in scale["missing"]:
            add("missing.csv", named, row)
    for part in data["preferences"]:
        for row in part["conditions"]:
            add("jod.csv", part, row)
        for row in part["comparisons"]:
            add("preferences.csv", part, row)
    absent = () if data["preferences"] else ("jod.csv", "preferences.csv")
    return {name: (columns, rows[name]) for name, columns in columns_of.items() if name not in absent}


_WIDTH_IN = 9.6
_BETTER, _WORSE, *_ = SERIES  # their lines differ in dashes too
_MOST_PAIRS = 5  # more would need more columns than fit
_WRAP = 16  # letters of a condition's name in a line
_LINES: dict[int, tuple[str, Any]] = {1: (_BETTER, "solid"), -1: (_WORSE, (0, (4, 2))), 0: (INK, (0, (1, 2)))}
_SHIFT_LABEL = "Hodges-Lehmann shift, exact 95 % or next level"


def _ratings_chart(part: Row, comparisons: Sequence[Row], measure: Row) -> str:
    """Draw every rating of a part, up is better; lines join the compared ratings of one person."""
    by_name = {row["condition"]: row for row in part["conditions"]}
    # The two conditions of a comparison stand side by side, a condition of two comparisons twice.
    # With too many comparisons there are no lines.
    pairs = [*enumerate(comparisons)] if len(comparisons) <= _MOST_PAIRS else []
    names = [name for _, row in pairs for name in (row["baseline"], row["condition"])]
    names += [name for name in by_name if name not in names]
    values = [value for row in part["conditions"] for value in row["ratings"].values()]
    label = f"{measure['title'].lower()} (up is better)"
    with canvas((part["part"], measure["name"], names), (_WIDTH_IN, 3.6), y=label, grid="y") as axes:
        figure: Any = axes.get_figure()
        shifts = {name: _shifts(by_name[name]["ratings"]) for name in names}
        for pair, row in pairs:
            at, ends = 2 * pair, (row["baseline"], row["condition"])
            for who, difference in row["differences"].items():
                x = [at + place + shifts[name][who] for place, name in enumerate(ends)]
                y = [by_name[name]["ratings"][who] for name in ends]
                colour, dash = _LINES[(difference > 0) - (difference < 0)]
                axes.plot(x, y, color=colour, linestyle=dash, linewidth=0.9, alpha=0.6, zorder=1)
        for at, (name, row) in enumerate((name, by_name[name]) for name in names):
            x, y = [at + shifts[name][who] for who in row["ratings"]], [*row["ratings"].values()]
            axes.plot(x, y, "o", markersize=5, color=INK, markerfacecolor="none", zorder=3)
            if row["median"] is not None:
                across: Style = {"linewidth": 2.2, "zorder": 2, "solid_capstyle": "butt"}
                axes.plot([at - 0.3, at + 0.3], [row["median"]] * 2, color=INK, **across)
                axes.plot(at - 0.36, row["mean"], ">", markersize=6, color=INK, zorder=4)
        labels = [f"{_wrapped(_condition_text(row))}\nn = {row['n']}" for row in map(by_name.__getitem__, names)]
        axes.set_xticks(range(len(names)), labels)
        axes.set_xlim(-0.6, len(names) - 0.4)
        axes.set_ylim(_limits(measure, values))
        key = [mark("one person", marker="o", linestyle="none", markerfacecolor="none")]
        key.append(mark("median (▸ mean)", linewidth=2.2))
        if pairs:
            key.append(mark("rated better than the baseline", color=_BETTER, linewidth=1.2))
            key.append(mark("worse", color=_WORSE, linewidth=1.2, linestyle=(0, (4, 2))))
        legend(figure, key, loc="outside upper left", ncols=4)
        return svg_text(figure)


def _forest_chart(rows: Sequence[Row], unit: str) -> str:
    """Draw each comparison's differences, their mean (BCa interval) and Hodges-Lehmann shift."""
    shown = [row for row in rows if row["n"]]
    content = [(row["part"], row["baseline"], row["condition"], row["mean"]) for row in shown]
    label = f"difference in {unit}:  rated worse than the baseline  ←  0  →  better"
    ends = [v for row in shown for v in [*row["differences"].values(), row["low"] or 0.0, row["high"] or 0.0]]
    reach = 1.08 * (max(map(abs, ends), default=0.0) or 1.0)
    with canvas(content, (_WIDTH_IN, 1.1 + 0.52 * max(len(shown), 2)), x=label, grid="x") as axes:
        figure: Any = axes.get_figure()
        axes.axvline(0, color=INK, linewidth=1)
        for y, row in enumerate(shown):
            values = np.array(list(row["differences"].values()))
            dots: Style = {"color": INK, "alpha": 0.45, "markersize": 3.2, "markeredgewidth": 0}
            axes.plot(values, y + 0.23 + 0.1 * (np.arange(len(values)) * 0.618034 % 1), "o", **dots)
            bar: Style = {"solid_capstyle": "butt"}
            if row["low"] is not None:
                axes.plot([row["low"], row["high"]], [y - 0.1] * 2, color=_BETTER, linewidth=2.6, **bar)
            axes.plot(row["mean"], y - 0.1, "o", color=_BETTER, markersize=7)
            if row["shift_low"] is not None:
                axes.plot([row["shift_low"], row["shift_high"]], [y + 0.08] * 2, color=_WORSE, linewidth=1.4, **bar)
            axes.plot(row["shift"], y + 0.08, "D", color=_WORSE, markersize=4.5)
        names = [f"{row['part']}: " * bool(row["part"]) + str(row["condition"]) for row in shown]
        names = [f"{name}\nover {row['baseline']}" for name, row in zip(names, shown, strict=True)]
        name_rows(axes, names, above=0.7)
        axes.set_xlim(-reach, reach)
        key = [
            mark("mean, BCa 95 %", color=_BETTER, marker="o", markersize=7, linewidth=2.6),
            mark(_SHIFT_LABEL, color=_WORSE, marker="D", markersize=4.5, linewidth=1.4),
            mark("one person", alpha=0.45, marker="o", markersize=3.2, linestyle="none"),
        ]
        legend(figure, key, loc="outside upper left", ncols=3)
        return svg_text(figure)


def _score_chart(part: Row) -> str:
    """Draw the scores of conditions from paired comparisons, the best on top."""
    rows = sorted(part["conditions"], key=lambda row: row["jod"])
    zero = "0 is the reference" if any(row["reference"] for row in rows) else "0 is the mean"
    label = f"JOD, with 95 % intervals; 1 more is preferred in 75 % of choices; {zero}"
    content = (part["part"], "scores", [(row["condition"], row["jod"]) for row in rows])
    with canvas(content, (_WIDTH_IN, 0.9 + 0.42 * max(len(rows), 2)), x=label, grid="x") as axes:
        axes.axvline(0, color=INK, linewidth=1)
        for y, row in enumerate(rows):
            if row["low"] is not None:
                axes.plot([row["low"], row["high"]], [y, y], color=_BETTER, linewidth=2.5, solid_capstyle="butt")
            axes.plot(row["jod"], y, "o", color=_BETTER, markersize=8)
        axes.set_yticks(range(len(rows)), [_wrapped(_condition_text(row)) for row in rows])
        axes.set_ylim(-0.6, len(rows) - 0.4)
        return svg_text(axes.get_figure())


def _shifts(ratings: Mapping[str, float]) -> dict[str, float]:
    """Return the sideways shift of each person's point, so that equal ratings lie side by side."""
    groups: dict[float, list[str]] = {}
    for who, value in ratings.items():
        groups.setdefault(value, []).append(who)
    step = min(0.07, 0.5 / max(map(len, groups.values()), default=1))
    return {who: step * (k - (len(people) - 1) / 2) for people in groups.values() for k, who in enumerate(people)}


def _limits(measure: Row, values: Sequence[float]) -> tuple[float, float]:
    """Return the limits of the axis of ratings, the better end on top."""
    ends = [end for end in (measure["least"], measure["most"]) if end is not None] if values else [0.0, 1.0]
    low, high = min([*values, *ends]), max([*values, *ends])
    margin = 0.05 * max(high - low, 1e-9)
    return (high + margin, low - margin) if measure["low_is_good"] else (low - margin, high + margin)


_ALL, _WITHOUT = "All conditions", "The same comparisons without those who missed the reference"
_said = functools.partial(page.Sentences, style="said")
_ORIGINS = {"person": "", "pilot": "pilot sessions", "simulated": "simulated participants"}


def study_page(data: Row, command: str) -> page.Page:
    """Return report.html from the content of analysis.json: the same page for the same content."""
    scales = data["scales"]
    facts = [page.fact("ratings from", data["source"]), page.fact("participants", data["participants"])]
    for scale in scales:
        measure = scale["measure"]
        known = f"{measure['least']:g} to {measure['most']:g}" if measure["least"] is not None else "range unknown"
        facts.append(page.fact(measure["title"], f"{known}, {'low' if measure['low_is_good'] else 'high'} is good"))
    parts = data["preferences"]
    blocks: list[Any] = []
    for part in parts:
        rows, compared = part["conditions"], part["comparisons"]
        blocks += [part["part"] and page.Heading(part["part"]), _said(part["sentences"])]
        if rows:
            scores = ", ".join(f"{row['condition']} {signed(row['jod'])}" for row in rows)
            blocks.append(page.Chart.of("", _score_chart(part), f"Scores in JOD: {scores}"))
            blocks.append(Table.of("Scores", *study_lines("scores", best_first(rows))))
        if compared:
            blocks.append(Table.of("Pairs", *study_lines("preferences", compared)))
        if part["threshold"]:
            blocks.append(page.Text(f"Differences below {part['threshold']:.2f} JOD were mostly called none."))
    note = page.Text(texts("study")["notes"]["pairs"])
    return page.Page(
        kind="study",
        title=f"hmdwarp study: {data['title']}",
        heading=(data["title"], _ORIGINS.get(data["origin"], data["origin"])),
        facts=facts,
        command=command,
        sections=(
            page.notes_section(data["notes"]),
            page.Section("What was preferred", [*blocks, note] if blocks else [], id="pairs"),
            _shown(data),
            page.Section("Every rating", _every_rating(scales), id="conditions"),
            page.Section("Did the order matter?", _order(scales), id="order"),
            _checked(scales),
            _correlations(scales),
            _people(data),
            page.reading_section("study"),
        ),
        made_with=[
            ("hmdwarp", data["hmdwarp"]),
            ("Numbers", "analysis.json and the folder tables hold all of them unrounded"),
        ],
    )


def _titled(scales: Sequence[Row], scale: Row) -> page.Heading | None:
    return page.Heading(scale["measure"]["title"]) if len(scales) > 1 else None


def _shown(data: Row) -> page.Section:
    blocks: list[Any] = []
    for scale in data["scales"]:
        rows = scale["comparisons"]
        blocks += [
            _titled(data["scales"], scale),
            _said([row["sentence"] for row in rows] or ["Nothing was compared."]),
        ]
        if rows:
            words = "; ".join(
                f"{row['part']} {pair_text(row['baseline'], row['condition'])}: "
                f"mean {signed(row['mean'])}, {interval(row['low'], row['high'])}".lstrip()
                for row in rows
                if row["n"]
            )
            blocks.append(page.Chart.of("", _forest_chart(rows, scale["measure"]["unit"]), words))
            blocks.append(Table.of("Paired comparisons", *study_lines("comparisons", rows)))
    note = texts("study")["notes"]["shown"].format(
        compared=data["compared"], resamples=f"{data['resamples']:,}", seed=data["seed"]
    )
    return page.Section("What the ratings show", [*blocks, page.Text(note)] if blocks else [], id="shown")


def _every_rating(scales: Sequence[Row]) -> list[Any]:
    blocks: list[Any] = []
    for scale in scales:
        measure = scale["measure"]
        for part in scale["parts"]:
            rows = [row for row in scale["comparisons"] if row["part"] == part["part"]]
            people, rows_without = counted(part["participants"], "participant"), part.get("without", ())
            medians = ", ".join(f"{row['condition']}: median {plain(row['median'])}" for row in part["conditions"])
            caption = ", ".join(["Ratings of each condition", *filter(None, [part["part"]])])
            blocks += [
                page.Heading(
                    part["part"] or "All conditions", f"{measure['title']}, {people}" if len(scales) > 1 else people
                ),
                page.Chart.of("", _ratings_chart(part, rows, measure), f"Ratings by condition: {medians}"),
                Table.of(caption, *study_lines("conditions", part["conditions"], mean=measure["mean_name"])),
                page.Text(f"{part['friedman_sentence']} {part['reference_sentence']}"),
                rows_without and Table.of(_WITHOUT, *study_lines("without", rows_without)),
            ]
    return blocks


def _order(scales: Sequence[Row]) -> list[Any]:
    blocks: list[Any] = []
    for scale in scales:
        for part in scale["parts"]:
            if len(scale["parts"]) > 1 or len(scales) > 1:
                blocks.append(
                    page.Heading(part["part"] or "All conditions", scale["measure"]["title"] if len(scales) > 1 else "")
                )
            blocks.append(_said(part["order_sentences"]))
    return blocks


def _checked(scales: Sequence[Row]) -> page.Section:
    """Return what published figures are held against."""
    blocks: list[Any] = []
    for scale in scales:
        if claims := scale["claims"]:
            marks = ["yes" if row["follows"] else "no" for row in claims]
            note = texts("study")["notes"]["claims"].format(why_step=scale["why_step"])
            blocks += [
                page.Heading("Published figures"),
                page.Sentences([row["sentence"] for row in claims], marks, "said"),
            ]
            blocks.append(page.Text(note))
    return page.Section("Checked against the data", blocks, id="held")


def _correlations(scales: Sequence[Row]) -> page.Section:
    blocks: list[Any] = []
    for scale in scales:
        if data := scale["prediction"]:
            blocks += [_titled(scales, scale), _said(data["sentences"])]
            if data["measures"]:
                blocks.append(
                    Table.of("What was measured against the ratings", *study_lines("correlations", data["measures"]))
                )
    note = page.Text(texts("study")["notes"]["correlation"])
    return page.Section("What goes with the ratings", [*blocks, note] if blocks else [], id="correlation")


def _people(data: Row) -> page.Section:
    """Return what is missing, and how the sessions ended and went."""
    sessions, notes = data["sittings"], texts("study")["notes"]
    ends = ", ".join(f"{number} {status}" for status, number in sessions["counts"].items())
    blocks: list[Any] = [ends and page.Text(f"Sessions: {ends}.", "")]
    blocks.append(_said([_cut(cut) for cut in sessions["cut"]]) if sessions["cut"] else None)
    for scale in data["scales"]:
        title, count, lines = scale["measure"]["title"], len(scale["missing"]), _missing(scale["missing"])
        fold = page.Fold(title, [_said(lines)], f"{count} missing", is_open=len(lines) < 16)
        blocks.append(fold if count else page.Text(f"{title}: no rating is missing."))
    blocks += [
        Table.of(f"{one['title']}, {one['least']:g} to {one['most']:g}", *study_lines("sickness", one["trials"]))
        for one in data["sickness"]
    ]
    if data["questionnaires"]:
        blocks.append(
            Table.of("Questionnaires, before and after", *study_lines("questionnaires", data["questionnaires"]))
        )
        blocks.append(page.Text(notes["questionnaires"]))
    if data["asked_once"]:
        blocks.append(Table.of("Questionnaires, answered once", *study_lines("asked once", data["asked_once"])))
        blocks.append(page.Text(notes["once"]))
    return page.Section("Missing and unfinished", blocks, id="people")


def _cut(one: Row) -> str:
    part = f" ({one['part']})" if one["part"] else ""
    rated = f"{one['rated']} of {counted(one['of'], 'trial')}"
    why = f": {one['why']}" if one["why"] else ""
    return f"{one['participant']}{part}, session {one['session']}: {one['status']} after {rated}{why}"


def _missing(rows: Sequence[Row]) -> list[str]:
    """Return a line for each person and reason."""
    conditions: dict[tuple[str, ...], list[str]] = {}
    for row in rows:
        why = "empty in the table" if row["why"].startswith("empty in line ") else row["why"]
        conditions.setdefault((row["part"], str(row["participant"]), why), []).append(row["condition"])
    return [
        f"{part}{', ' * bool(part)}participant {who}: {'; '.join(names)} ({why})"
        for (part, who, why), names in conditions.items()
    ]
