"""Analysis of the ratings of a study: tests, intervals and plots."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import typer

from ...errors import InputError
from ...options import Declared, Number, PaperOptions, force_field, group, option, out_field
from .._options import JSON, QUIET, Said, command_line, print_results, takes
from ._options import pilot_field, simulated_field, store_field

if TYPE_CHECKING:
    from rich.table import Table


_SIGN = "positive: rated better than the baseline, the one after 'over'"
_Texts = list[str] | None
_SOURCE = "Tables with one row per rating (.csv, .tsv), or a study's .toml file, or the name of a shipped study."


@attrs.frozen
class AnalyseOptions(Declared):
    """An analysis. Errors: InputError for pilots mixed with simulated sessions."""

    sources: tuple[str, ...] = option(
        attrs.NOTHING, _SOURCE, kind=list, positional=True, metavar="FILE|STUDY", names_files=True
    )
    out: Path = out_field(attrs.NOTHING, "Folder for report.html, analysis.json and tables/*.csv.")
    force: bool = force_field()
    paper: PaperOptions = group(PaperOptions)
    store: Path | None = store_field()
    scale: str = option("", "Scale of a table that does not name it: grade, acr, ..")
    low_is_good: bool | None = option(None, "Direction of ratings where a table has none.", off="--high-is-good")
    columns: str = option("", "Columns of a table by their roles, where they have other names.", metavar="ROLE=NAME,..")
    missing: str = option("", "Ratings of a table that stand for a missing one, such as 99.", metavar="CODE,..")
    family: _Texts = option(
        None,
        "Compare these pairs instead of the planned ones, as one family; may be repeated.",
        kind=list,
        metavar="BASELINE:BETTER;..",
    )
    claims: Path | None = option(None, "A .toml file of published figures to compare with the ratings.")
    pilot: bool = pilot_field()
    simulated: bool = simulated_field()
    seed: int = option(0, "Random seed, where resamples are drawn: not for ratings in steps.", valid=Number())
    resamples: int = option(
        20_000, "Number of resamples, where they are drawn.", valid=Number(least=100, most=10_000_000)
    )

    def __attrs_post_init__(self) -> None:
        if self.pilot and self.simulated:
            raise InputError("--pilot and --simulated: they are never mixed; analyse one after the other")


@takes(AnalyseOptions, JSON, QUIET)
def analyse(said: Said) -> None:
    """Analyse ratings: exact tests, intervals, order effects; writes tables, plots and one page.

    Only sessions with people count; --pilot and --simulated analyse the others by themselves. The
    name of a shipped study without sessions stands for the ratings published with it ('thesis').
    """
    from ...study.analysis.findings import Resampling, claims_for
    from ...study.analysis.full_analysis import analyse as run
    from ...study.analysis.full_analysis import analysis_folder, write_analysis
    from ...study.analysis.long_table import SourceOptions, ratings_from_all

    options = AnalyseOptions.of(said)
    origin = "pilot" if options.pilot else "simulated" if options.simulated else ""
    missing = tuple(filter(None, map(str.strip, options.missing.split(","))))
    text = options.columns
    pairs = [pair.partition("=") for pair in filter(None, text.split(","))]
    if not all(role and name for role, _, name in pairs):
        raise InputError(f"--columns '{text}': expected ROLE=NAME,.., like participant=who,rating=mos")
    columns = SourceOptions(
        {role.strip(): name.strip() for role, _, name in pairs}, options.scale, options.low_is_good, origin, missing
    )
    with analysis_folder(options.out, force=options.force) as out:
        ratings = ratings_from_all(options.sources, options.store, columns)
        published, note = claims_for(options.claims, ratings, columns)
        ratings = attrs.evolve(ratings, notes=(*ratings.notes, *([note] if note else [])))
        resampling = Resampling(options.seed, options.resamples)
        data = run(ratings, resampling, options.family or (), published)
        page = write_analysis(out, data, command_line(), options.paper)
    print_results(said, data, lambda: _print(data), page)


def _print(data: dict[str, Any]) -> None:
    from ...report import counted
    from ...report.study import best_first, study_lines
    from .._show import console, paragraph

    screen = console()
    paragraph(typer.style(data["title"], bold=True))
    compared, missing = (sum(part[key] for part in data["preferences"]) for key in ("answers", "missing"))
    given = counted(compared, "comparison") if data["preferences"] else counted(data["ratings"], "rating")
    people = counted(data["participants"], "participant")
    paragraph(f"{people}, {given}, {data['missing'] + missing} missing; from {data['source']}.")
    for note in data["notes"]:
        paragraph(f"note: {note}")
    for part in data["preferences"]:
        typer.echo()
        title = f"{part['part'] or 'Scores'}: JOD, {counted(part['people'], 'person')}"
        screen.print(lines_as_table(title, *study_lines("scores", best_first(part["conditions"]))))
        for sentence in part["sentences"]:
            paragraph(sentence)
    for scale in data["scales"]:
        for part in scale["parts"]:
            typer.echo()
            measure, people = scale["measure"], counted(part["participants"], "participant")
            title = f"{part['part'] or 'Conditions'}: {measure['title']}, {people}"
            lines = study_lines("conditions", part["conditions"], mean=measure["mean_name"])
            screen.print(lines_as_table(title, *lines))
            paragraph(part["friedman_sentence"])
            paragraph(part["reference_sentence"])
            for sentence in part["order_sentences"]:
                paragraph(sentence)
        for part in dict.fromkeys(row["part"] for row in scale["comparisons"]):
            typer.echo()
            rows = [row for row in scale["comparisons"] if row["part"] == part]
            title = f"{part}: {_SIGN}" if part else _SIGN.capitalize()
            screen.print(lines_as_table(title, *study_lines("comparisons in 80 columns", rows)))
        for row in scale["comparisons"]:
            typer.echo()
            paragraph(row["sentence"])
        for finding in [*scale["copied"], *scale["claims"]]:
            typer.echo()
            paragraph(finding["sentence"])
        for sentence in (scale["prediction"] or {}).get("sentences", ()):
            typer.echo()
            paragraph(sentence)
    typer.echo()
    drawn = f"{data['resamples']} drawn with seed {data['seed']}"
    paragraph(f"{data['compared']} BCa intervals: all resamples for ratings in steps, otherwise {drawn}.")
    ends = ", ".join(f"{number} {status}" for status, number in data["sittings"]["counts"].items())
    if ends:
        paragraph(f"Sessions: {ends}.")


def lines_as_table(title: str, heads: Any, lines: list[list[str]]) -> Table:
    """Return a table for the terminal; heads: (label, unit) of each column.

    Heads of numbers are broken into lines where the table would be wider than the terminal: it
    would take that from the names of the rows.
    """
    from ...report import terminal_table
    from .._show import console

    names = [" ".join(head).strip() for head in heads]
    cells = [max(map(len, column)) for column in zip(*lines, strict=True)] or [0] * len(names)
    widths = [max(len(name), cell) + 1 for name, cell in zip(names, cells, strict=True)]
    if sum(widths) > console().width:
        folded = zip(names[1:], cells[1:], strict=True)
        names[1:] = [textwrap.fill(name, max(cell, 1), break_long_words=False) for name, cell in folded]
    return terminal_table(names, lines, title=title, title_style="bold")
