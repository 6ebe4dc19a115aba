"""thesis.html: the thesis's experiments with their numbers and verdicts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from . import page
from .run_texts import Table, plain

MARKS = {True: " ✓", False: " ✗", None: ""}
# CSS classes of the verdicts.
_CLASSES = {
    "holds": "holds", "holds under conditions": "conditions", "mostly does not hold": "fails", "does not hold": "fails",
    "cannot be told": "unknown",
}  # fmt: skip


def render_thesis_page(data: Mapping[str, Any], pictures: Mapping[str, Sequence[tuple[str, str]]]) -> str:
    """Return the page from results.json. pictures: (caption, data URI or <svg>) by experiment."""
    experiments = data["experiments"]
    facts = [page.fact("pictures", "x".join(map(str, data["size"]))), data["machine"]["gl_renderer"]]
    facts.append(page.fact("run in", page.minutes(data["seconds"])))
    quick = [page.fact("", "quick", ": small pictures, middle speeds only")] if data["quick"] else []
    articles = [_article(experiment, pictures.get(experiment["name"], ())) for experiment in experiments]
    return page.Page(
        kind="thesis",
        title="hmdwarp: the thesis again",
        heading=("The thesis again", f"{len(experiments)} figures, times and claims"),
        facts=[*facts, *quick, ", ".join(f"{count} {name}" for name, count in data["verdicts"].items())],
        command=data.get("command") or "",
        remarks=[f"failed: {failure}" for failure in data["failed"]],
        sections=(
            page.Section("Verdicts", [_verdicts(experiments)], id="verdicts"),
            page.Section("Experiments", articles, id="experiments"),
            page.reading_section("thesis"),
        ),
        made_with=page.machine_pairs(data["hmdwarp"], data["machine"], data["clock"]),
    ).html()


def _verdict(one: Mapping[str, Any]) -> Markup:
    return Markup('<b class="verdict {}">{}</b>{}').format(_CLASSES[one["verdict"]], one["verdict"], weak_text(one))


def weak_text(one: Mapping[str, Any]) -> str:
    """Return what a verdict says of an experiment whose number is a weak stand-in."""
    return ", by a weak stand-in" if one.get("weak") else ""


def is_conditional(one: Mapping[str, Any]) -> bool:
    """Return whether a claim holds at some settings and not at others."""
    return bool(one["holds_at"] and one["fails_at"])


def _verdicts(experiments: Sequence[Mapping[str, Any]]) -> Table:
    claim = Markup('<a href="#{}">{}</a> <span class="unit">{}</span>')
    where = Markup('{}<br><span class="unit">{}</span>')
    lines = []
    for one in experiments:
        verdict = where.format(_verdict(one), one["holds_at"]) if is_conditional(one) else _verdict(one)
        about = claim.format(one["name"], one["claim"], one["source"])
        lines.append((about, one["thesis"], one["ours"] or "–", verdict))
    heads = [(head, "") for head in ("claim", "the thesis", "ours", "verdict")]
    return Table.of("", heads, lines, words=4, style="verdicts", label="Verdicts")


def _article(one: Mapping[str, Any], pictures: Sequence[tuple[str, str]]) -> page.Article:
    pairs = [("The thesis", one["thesis"]), ("Ours", one["ours"] or "not measured"), ("Rule", one["rule"])]
    if is_conditional(one):
        pairs += [("Holds at", one["holds_at"]), ("Does not at", one["fails_at"])]
    pairs += [(term, one[key]) for term, key in (("Cannot be told at", "unknown_at"), ("Note", "note")) if one[key]]
    panels = [page.Picture(caption, uri, caption) for caption, uri in pictures if uri.startswith("data:")]
    blocks = [
        page.Heading(one["claim"]),
        page.Text(f"{one['name']} · {one['source']}"),
        page.Text(_verdict(one), ""),
        page.Terms(pairs),
        panels and page.Group("panels", panels),
        *(page.Chart.of(caption, svg, caption) for caption, svg in pictures if svg.startswith("<svg")),
        page.Fold("Numbers", [_cells_table(one)], str(len(one["cells"]))),
    ]
    return page.Article(blocks, id=one["name"])


def _cells_table(one: Mapping[str, Any]) -> Table:
    """Return an experiment's numbers by setting, each marked by whether the claim holds there."""
    columns = list(dict.fromkeys(cell["column"] for cell in one["cells"]))
    rows = list(dict.fromkeys(cell["row"] for cell in one["cells"]))
    found = {
        (cell["row"], cell["column"]): "–"
        if (value := cell["value"]) is None
        else f"{plain(value * one['scale'], one['digits'])}{MARKS[cell['holds']]}"
        for cell in one["cells"]
    }
    lines = [[row, *(found.get((row, column), "") for column in columns)] for row in rows]
    return Table.of(one["measured"], [("setting", ""), *((column, one["unit"]) for column in columns)], lines)
