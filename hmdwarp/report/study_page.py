"""report.html of a study's analysis: one page with its sentences, charts and tables, that asks the network for nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .bench_page import Cell, Line, PageChart, PageTable
from .page import environment
from .study_charts import forest_chart, place_chart, ratings_chart
from .study_predicted import prediction_of
from .study_tables import comparison_lines, condition_lines, felt_lines
from .study_words import counted, interval, p_text, pair_text, plain, signed

Row = Mapping[str, Any]
_ORIGINS = {"person": "", "pilot": "pilot sessions", "simulated": "simulated participants"}


def render_study_report(data: Row, command: str) -> str:
    """The text of report.html from the content of analysis.json; the same content gives the same text. Everything in it is escaped."""
    return environment().get_template("study.html").render(
        data=data,
        command=command,
        origin=_ORIGINS.get(data["origin"], data["origin"]),
        tiles=_tiles(data),
        scales=[_scale(one) for one in data["scales"]],
        ends=_ends(data["sittings"]),
        cut=data["sittings"]["cut"],
        sickness=[_sickness(one) for one in data["sickness"]],
        questionnaires=_table("Questionnaires, before and after", *felt_lines(data["questionnaires"])) if data["questionnaires"] else None,
        seed=data["seed"],
        resamples=f"{data['resamples']:,}",
    )  # fmt: skip


def _tiles(data: Row) -> list[Row]:
    rows = [row for scale in data["scales"] for row in scale["comparisons"]]
    shown = sum(row["holm"] <= 0.05 for row in rows)
    parts = len(data["scales"][0]["parts"]) if data["scales"] else 0
    texts = [
        (
            "Participants",
            str(data["participants"]),
            f"in {counted(parts, 'part')}, counted in each" if parts > 1 else "who began",
        ),
        (
            "Ratings",
            str(data["ratings"]),
            f"{data['missing']} missing, listed below" if data["missing"] else "none missing",
        ),
        ("Differences shown", f"{shown} of {len(rows)}", "comparisons with p ≤ .05 after Holm in their family"),
    ]
    return [{"label": label, "text": text, "note": note} for label, text, note in texts]


def _scale(scale: Row) -> Row:
    measure, rows = scale["measure"], scale["comparisons"]
    return {
        "title": measure["title"],
        "direction": "low is good" if measure["low_is_good"] else "high is good",
        "range": f"{measure['least']:g} to {measure['most']:g}" if measure["least"] is not None else "range not known",
        "sentences": [row["sentence"] for row in rows],
        "forest": PageChart("", (("", forest_chart(rows, measure["unit"]), _said(rows)),)) if rows else None,
        "comparisons": _table("Paired comparisons", *comparison_lines(rows)) if rows else None,
        "parts": [_part(one, [row for row in rows if row["part"] == one["part"]], measure) for one in scale["parts"]],
        "copied": [row["sentence"] for row in scale["copied"]],
        "claims": [(row["follows"], row["sentence"]) for row in scale["claims"]],
        "why_step": scale["why_step"],
        "missing": _missing(scale["missing"]),
        "missed": len(scale["missing"]),
        "prediction": prediction_of(scale["prediction"], measure),
    }


def _missing(rows: Sequence[Row]) -> list[str]:
    """A line for each person and reason."""
    found: dict[tuple[str, ...], list[str]] = {}
    for row in rows:
        why = "empty in the table" if row["why"].startswith("empty in line ") else row["why"]
        found.setdefault((row["part"], str(row["participant"]), why), []).append(row["condition"])
    return [
        f"{part}{', ' * bool(part)}participant {who}: {'; '.join(names)} ({why})"
        for (part, who, why), names in found.items()
    ]


def _said(rows: Sequence[Row]) -> str:
    return "; ".join(
        f"{row['part']} {row['a']} to {row['b']}: mean {signed(row['mean'])}, {interval(row['low'], row['high'])}".strip()
        for row in rows
        if row["n"]
    )


def _part(part: Row, rows: Sequence[Row], measure: Row) -> Row:
    said = "Ratings by condition: " + ", ".join(
        f"{row['condition']}: median {plain(row['median'])}" for row in part["conditions"]
    )
    chart = PageChart("", (("", ratings_chart(part, rows, measure), said),))
    return {
        "name": part["part"] or "All conditions",
        "participants": counted(part["participants"], "participant"),
        "chart": chart,
        "conditions": _table(
            ", ".join(["Ratings of each condition", *filter(None, [part["part"]])]),
            *condition_lines(part["conditions"]),
        ),
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
    return PageChart(heading, (("", place_chart(part, measure), part["order_sentences"][0]),))


def _without(rows: Sequence[Row]) -> PageTable | None:
    if not rows:
        return None
    heads = (("without them", ""), ("pairs", ""), ("mean", ""), ("p", ""), ("Holm", ""))
    lines = [
        [pair_text(r["a"], r["b"]), str(r["n"]), signed(r["mean"]), p_text(r["p"]), p_text(r["holm"])] for r in rows
    ]
    return _table("The same comparisons without those who missed the reference", heads, lines)


def _table(caption: str, heads: Sequence[tuple[str, str]], lines: Sequence[Sequence[str]], words: int = 1) -> PageTable:
    made = tuple(Line(tuple(Cell(text, number >= words) for number, text in enumerate(texts))) for texts in lines)
    return PageTable(caption, tuple(heads), made)


def _ends(sittings: Row) -> str:
    return ", ".join(f"{number} {status}" for status, number in sittings["counts"].items())


def _sickness(one: Row) -> PageTable:
    heads = (("after trial", ""), ("answers", ""), ("median", ""), ("worst", ""))
    lines = [[str(t["trial"] or "practice"), str(t["n"]), f"{t['median']:g}", f"{t['worst']:g}"] for t in one["trials"]]
    return _table(f"{one['title']}, {one['least']:g} to {one['most']:g}", heads, lines)
