"""report.html of a study's analysis: one page that loads nothing from the network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..parts import PageChart, PageTable, Tile, environment
from ..words import counted, interval, p_text, pair_text, plain, signed
from .charts import forest_chart, place_chart, ratings_chart, score_chart
from .prediction import prediction_of
from .tables import comparison_lines, condition_lines, felt_lines, once_lines, preference_lines, score_lines

Row = Mapping[str, Any]
_ORIGINS = {"person": "", "pilot": "pilot sessions", "simulated": "simulated participants"}


def render_study_report(data: Row, command: str) -> str:
    """Return the text of report.html from the content of analysis.json.

    The same content gives the same text. Everything in it is escaped.
    """
    return environment().get_template("study.html").render(
        data=data,
        command=command,
        origin=_ORIGINS.get(data["origin"], data["origin"]),
        tiles=_tiles(data),
        scales=[_scale(one) for one in data["scales"]],
        pairs=[_pairs(one) for one in data["preferences"]],
        ends=_ends(data["sittings"]),
        cut=data["sittings"]["cut"],
        sickness=[_sickness(one) for one in data["sickness"]],
        questionnaires=_questionnaires(data["questionnaires"]),
        once=_answered_once(data["asked_once"]),
        seed=data["seed"],
        resamples=f"{data['resamples']:,}",
    )  # fmt: skip


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


def _pairs(part: Row) -> Row:
    rows = part["conditions"]
    scores = ", ".join(f"{row['condition']} {signed(row['jod'])}" for row in rows)
    return {
        "name": part["part"],
        "sentences": part["sentences"],
        "chart": PageChart.of("", score_chart(part), f"Scores in JOD: {scores}") if rows else None,
        "scores": PageTable.of("Scores", *score_lines(rows)) if rows else None,
        "comparisons": PageTable.of("Pairs", *preference_lines(part["comparisons"])) if part["comparisons"] else None,
        "threshold": part["threshold"],
    }


def _scale(scale: Row) -> Row:
    measure, rows = scale["measure"], scale["comparisons"]
    return {
        "title": measure["title"],
        "direction": "low is good" if measure["low_is_good"] else "high is good",
        "range": f"{measure['least']:g} to {measure['most']:g}" if measure["least"] is not None else "range unknown",
        "sentences": [row["sentence"] for row in rows],
        "forest": PageChart.of("", forest_chart(rows, measure["unit"]), _in_words(rows)) if rows else None,
        "comparisons": PageTable.of("Paired comparisons", *comparison_lines(rows)) if rows else None,
        "parts": [_part(one, [row for row in rows if row["part"] == one["part"]], measure) for one in scale["parts"]],
        "copied": [row["sentence"] for row in scale["copied"]],
        "claims": [(row["follows"], row["sentence"]) for row in scale["claims"]],
        "why_step": scale["why_step"],
        "missing": _missing(scale["missing"]),
        "missed": len(scale["missing"]),
        "prediction": prediction_of(scale["prediction"], measure),
    }


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


def _in_words(rows: Sequence[Row]) -> str:
    return "; ".join(
        f"{row['part']} {pair_text(row['baseline'], row['condition'])}: "
        f"mean {signed(row['mean'])}, {interval(row['low'], row['high'])}".lstrip()
        for row in rows
        if row["n"]
    )


def _part(part: Row, rows: Sequence[Row], measure: Row) -> Row:
    medians = ", ".join(f"{row['condition']}: median {plain(row['median'])}" for row in part["conditions"])
    caption = ", ".join(["Ratings of each condition", *filter(None, [part["part"]])])
    return {
        "name": part["part"] or "All conditions",
        "participants": counted(part["participants"], "participant"),
        "chart": PageChart.of("", ratings_chart(part, rows, measure), f"Ratings by condition: {medians}"),
        "conditions": PageTable.of(caption, *condition_lines(part["conditions"], measure["mean_name"])),
        "friedman": part["friedman_sentence"],
        "reference": part["reference_sentence"],
        "without": _without(part.get("without", ())),
        "order": part["order_sentences"],
        "place": _place(part, measure),
    }


def _place(part: Row, measure: Row) -> PageChart | None:
    if not part["places"]:
        return None
    heading = "Ratings less the person's and the condition's mean"
    return PageChart.of(heading, place_chart(part, measure), part["order_sentences"][0])


def _without(rows: Sequence[Row]) -> PageTable | None:
    if not rows:
        return None
    heads = (("without them", ""), ("pairs", ""), ("mean", ""), ("p", ""), ("Holm", ""))
    lines = [
        [pair_text(r["baseline"], r["condition"]), str(r["n"]), signed(r["mean"]), p_text(r["p"]), p_text(r["holm"])]
        for r in rows
    ]
    return PageTable.of("The same comparisons without those who missed the reference", heads, lines)


def _ends(sittings: Row) -> str:
    return ", ".join(f"{number} {status}" for status, number in sittings["counts"].items())


def _sickness(one: Row) -> PageTable:
    heads = (("after trial", ""), ("answers", ""), ("median", ""), ("worst", ""))
    lines = [[str(t["trial"] or "practice"), str(t["n"]), f"{t['median']:g}", f"{t['worst']:g}"] for t in one["trials"]]
    return PageTable.of(f"{one['title']}, {one['least']:g} to {one['most']:g}", heads, lines)


def _questionnaires(rows: Sequence[Row]) -> PageTable | None:
    return PageTable.of("Questionnaires, before and after", *felt_lines(rows)) if rows else None


def _answered_once(rows: Sequence[Row]) -> PageTable | None:
    return PageTable.of("Questionnaires, answered once", *once_lines(rows)) if rows else None
