"""report.html of a study's analysis, as data for the page builder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..page import (
    Chart,
    Fold,
    Group,
    Heading,
    Page,
    Section,
    Sentences,
    Text,
    Tile,
    fact,
    notes_section,
    reading_section,
    texts,
)
from ..words import Table, counted, interval, p_text, pair_text, plain, signed
from .charts import forest_chart, place_chart, ratings_chart, score_chart
from .results import (
    comparison_lines,
    condition_lines,
    correlation_lines,
    felt_lines,
    once_lines,
    preference_lines,
    score_lines,
)

Row = Mapping[str, Any]
_ORIGINS = {"person": "", "pilot": "pilot sessions", "simulated": "simulated participants"}
_WITHOUT_HEADS = tuple((head, "") for head in ("without them", "pairs", "mean", "p", "Holm"))
_SICKNESS_HEADS = tuple((head, "") for head in ("after trial", "answers", "median", "worst"))


def study_page(data: Row, command: str) -> Page:
    """Return report.html from the content of analysis.json.

    The same content gives the same page. Everything in it is escaped.
    """
    scales = data["scales"]
    facts = [fact("ratings from", data["source"])]
    for scale in scales:
        measure = scale["measure"]
        known = f"{measure['least']:g} to {measure['most']:g}" if measure["least"] is not None else "range unknown"
        facts.append(fact(measure["title"], f"{known}, {'low' if measure['low_is_good'] else 'high'} is good"))
    parts = data["preferences"]
    blocks: list[Any] = []
    for part in parts:
        rows, compared = part["conditions"], part["comparisons"]
        blocks += [part["part"] and Heading(part["part"]), _said(part["sentences"])]
        if rows:
            scores = ", ".join(f"{row['condition']} {signed(row['jod'])}" for row in rows)
            blocks.append(Chart.of("", score_chart(part), f"Scores in JOD: {scores}"))
            blocks.append(Table.of("Scores", *score_lines(rows)))
        if compared:
            blocks.append(Table.of("Pairs", *preference_lines(compared)))
        if part["threshold"]:
            blocks.append(Text(f"Differences below {part['threshold']:.2f} JOD were mostly called none."))
    heading, note = "What was preferred", Text(texts("study")["notes"]["pairs"])
    return Page(
        kind="study",
        title=f"hmdwarp study: {data['title']}",
        heading=(data["title"], _ORIGINS.get(data["origin"], data["origin"])),
        facts=facts,
        command=command,
        sections=(
            Section("", _tiles(data), style="tiles", label="Main figures"),
            notes_section(data["notes"]),
            Section(heading, [*blocks, note] if blocks else [], id="pairs", link=heading),
            _shown(data),
            Section("Every rating", _every_rating(scales), id="conditions", link="Every rating"),
            Section("Did the order matter?", _order(scales), id="order", link="Order"),
            _checked(scales),
            _correlations(scales),
            _people(data),
            reading_section("study"),
        ),
        made_with=[
            ("hmdwarp", data["hmdwarp"]),
            ("Numbers", "analysis.json and the folder tables hold all of them unrounded"),
        ],
    )


def render_study_report(data: Row, command: str) -> str:
    """Return the text of study_page."""
    return study_page(data, command).html()


def _said(sentences: Sequence[str]) -> Sentences:
    return Sentences(sentences, style="said")


def _tiles(data: Row) -> list[Tile]:
    tables = [*data["scales"], *data["preferences"]]
    rows = [row for table in tables for row in table["comparisons"]]
    shown = sum(row["holm"] is not None and row["holm"] <= 0.05 for row in rows)
    parts = len(data["scales"][0]["parts"]) if data["scales"] else len(data["preferences"])
    people = f"in {counted(parts, 'part')}, counted in each" if parts > 1 else "who began"
    missing = f"{data['missing']} missing, listed below" if data["missing"] else "none missing"
    difference = "comparisons with p ≤ .05 after Holm in their family"
    return [
        Tile("Participants", "", str(data["participants"]), people),
        _answers(data["preferences"]) if data["preferences"] else Tile("Ratings", "", str(data["ratings"]), missing),
        Tile("Differences shown", "", f"{shown} of {len(rows)}", difference),
    ]


def _answers(parts: Sequence[Row]) -> Tile:
    missing, ties = (sum(part[key] for part in parts) for key in ("missing", "ties"))
    more = f"{missing} missing" if missing else "none missing"
    return Tile(
        "Pairs compared", "", str(sum(part["answers"] for part in parts)), f"{ties} without a difference, {more}"
    )


def _titled(scales: Sequence[Row], scale: Row) -> Heading | None:
    """Return the title of a scale, where there are several."""
    return Heading(scale["measure"]["title"]) if len(scales) > 1 else None


def _shown(data: Row) -> Section:
    blocks: list[Any] = []
    for scale in data["scales"]:
        rows = scale["comparisons"]
        blocks += [
            _titled(data["scales"], scale),
            _said([row["sentence"] for row in rows] or ["Nothing was compared."]),
        ]
        if rows:
            blocks.append(Chart.of("", forest_chart(rows, scale["measure"]["unit"]), _in_words(rows)))
            blocks.append(Table.of("Paired comparisons", *comparison_lines(rows)))
    note = texts("study")["notes"]["shown"].format(
        compared=data["compared"], resamples=f"{data['resamples']:,}", seed=data["seed"]
    )
    heading = "What the ratings show"
    return Section(heading, [*blocks, Text(note)] if blocks else [], id="shown", link=heading)


def _in_words(rows: Sequence[Row]) -> str:
    return "; ".join(
        f"{row['part']} {pair_text(row['baseline'], row['condition'])}: "
        f"mean {signed(row['mean'])}, {interval(row['low'], row['high'])}".lstrip()
        for row in rows
        if row["n"]
    )


def _every_rating(scales: Sequence[Row]) -> list[Any]:
    blocks: list[Any] = []
    for scale in scales:
        measure = scale["measure"]
        for part in scale["parts"]:
            rows = [row for row in scale["comparisons"] if row["part"] == part["part"]]
            people = counted(part["participants"], "participant")
            medians = ", ".join(f"{row['condition']}: median {plain(row['median'])}" for row in part["conditions"])
            caption = ", ".join(["Ratings of each condition", *filter(None, [part["part"]])])
            blocks += [
                Heading(_part_name(part), f"{measure['title']}, {people}" if len(scales) > 1 else people),
                Chart.of("", ratings_chart(part, rows, measure), f"Ratings by condition: {medians}"),
                Table.of(caption, *condition_lines(part["conditions"], measure["mean_name"])),
                Text(f"{part['friedman_sentence']} {part['reference_sentence']}"),
                _without(part.get("without", ())),
            ]
    return blocks


def _part_name(part: Row) -> str:
    return part["part"] or "All conditions"


def _order(scales: Sequence[Row]) -> list[Any]:
    blocks: list[Any] = []
    for scale in scales:
        for part in scale["parts"]:
            if len(scale["parts"]) > 1 or len(scales) > 1:
                blocks.append(Heading(_part_name(part), scale["measure"]["title"] if len(scales) > 1 else ""))
            blocks.append(_said(part["order_sentences"]))
            if part["places"]:
                heading, words = "Ratings less the person's and the condition's mean", part["order_sentences"][0]
                chart = Chart.of(heading, place_chart(part, scale["measure"]), words, "")
                blocks.append(Group("charts", [chart]))
    return blocks


def _checked(scales: Sequence[Row]) -> Section:
    """Return what was checked: rows that two parts share, and published figures."""
    blocks: list[Any] = []
    for scale in scales:
        copied, claims = scale["copied"], scale["claims"]
        if copied:
            blocks += [Heading("Rows that two parts share"), _said([row["sentence"] for row in copied])]
        if claims:
            marks = ["yes" if row["follows"] else "no" for row in claims]
            note = texts("study")["notes"]["claims"].format(why_step=scale["why_step"])
            blocks += [Heading("Published figures"), Sentences([row["sentence"] for row in claims], marks, "said")]
            blocks.append(Text(note))
    return Section("Checked against the data", blocks, id="held", link="Checked against the data")


def _correlations(scales: Sequence[Row]) -> Section:
    blocks: list[Any] = []
    for scale in scales:
        if data := scale["prediction"]:
            blocks += [_titled(scales, scale), _said(data["sentences"])]
            if data["measures"]:
                blocks.append(Table.of("What was measured against the ratings", *correlation_lines(data["measures"])))
    heading, note = "What goes with the ratings", Text(texts("study")["notes"]["correlation"])
    return Section(heading, [*blocks, note] if blocks else [], id="correlation", link=heading)


def _people(data: Row) -> Section:
    """Return what is missing, and how the sessions ended and went."""
    sessions, notes = data["sittings"], texts("study")["notes"]
    ends = ", ".join(f"{number} {status}" for status, number in sessions["counts"].items())
    blocks: list[Any] = [ends and Text(f"Sessions: {ends}.", "")]
    blocks.append(_said([_cut(cut) for cut in sessions["cut"]]) if sessions["cut"] else None)
    for scale in data["scales"]:
        title, count, lines = scale["measure"]["title"], len(scale["missing"]), _missing(scale["missing"])
        fold = Fold(title, [_said(lines)], f"{count} missing", is_open=len(lines) < 16)
        blocks.append(fold if count else Text(f"{title}: no rating is missing."))
    blocks += [_sickness(score) for score in data["sickness"]]
    if data["questionnaires"]:
        blocks.append(Table.of("Questionnaires, before and after", *felt_lines(data["questionnaires"])))
        blocks.append(Text(notes["questionnaires"]))
    if data["asked_once"]:
        blocks.append(Table.of("Questionnaires, answered once", *once_lines(data["asked_once"])))
        blocks.append(Text(notes["once"]))
    heading = "Missing and unfinished"
    return Section(heading, blocks, id="people", link=heading)


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


def _without(rows: Sequence[Row]) -> Table | None:
    if not rows:
        return None
    lines = [
        [pair_text(r["baseline"], r["condition"]), str(r["n"]), signed(r["mean"]), p_text(r["p"]), p_text(r["holm"])]
        for r in rows
    ]
    return Table.of("The same comparisons without those who missed the reference", _WITHOUT_HEADS, lines)


def _sickness(one: Row) -> Table:
    lines = [[str(t["trial"] or "practice"), str(t["n"]), f"{t['median']:g}", f"{t['worst']:g}"] for t in one["trials"]]
    return Table.of(f"{one['title']}, {one['least']:g} to {one['most']:g}", _SICKNESS_HEADS, lines)
