"""hmdwarp study analyse: tests, intervals and plots of the ratings."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ._options import PilotOption, QuietOption, SimulatedOption, StoreOption

if TYPE_CHECKING:
    from rich.table import Table

_Texts = list[str] | None
_SOURCE = "A table with one row per rating (.csv, .tsv), a study's .toml file, or the name of a shipped study."
_FAMILY = "Compare these pairs instead of the planned ones, as one family; may be repeated."


def analyse(
    source: Annotated[str, typer.Argument(metavar="FILE|STUDY", help=_SOURCE)],
    out: Annotated[Path, typer.Option("--out", help="Folder for report.html, analysis.json and tables/*.csv.")],
    store: StoreOption = None,
    scale: Annotated[
        str,
        typer.Option("--scale", help="Scale of a table that does not name it: grade, acr, ..", show_default=False),
    ] = "",
    low_is_good: Annotated[
        bool | None,
        typer.Option(
            "--low-is-good/--high-is-good",
            help="Direction of a table's ratings, if it does not give it.",
            show_default=False,
        ),
    ] = None,
    column: Annotated[
        _Texts,
        typer.Option(
            "--column",
            metavar="ROLE=NAME",
            help="Column for a role: rating=mos, participant=who; may be repeated.",
            show_default=False,
        ),
    ] = None,
    family: Annotated[_Texts, typer.Option("--family", metavar="A:B;C:D", help=_FAMILY, show_default=False)] = None,
    claims: Annotated[
        Path | None,
        typer.Option(
            "--claims", help="A .toml file of published figures to compare with the ratings.", show_default=False
        ),
    ] = None,
    pilot: PilotOption = False,
    simulated: SimulatedOption = False,
    seed: Annotated[
        int, typer.Option("--seed", min=0, help="Random seed, where resamples are drawn: not for ratings in steps.")
    ] = 0,
    resamples: Annotated[
        int, typer.Option("--resamples", min=100, max=10_000_000, help="Number of resamples, where they are drawn.")
    ] = 20_000,
    quiet: QuietOption = False,
) -> None:
    """Analyse ratings: exact tests, intervals, order effects; writes tables, plots and one page.

    Only sessions with people count; --pilot and --simulated analyse the others by themselves. The
    name of a shipped study without sessions stands for the ratings published with it ('thesis').
    """
    import attrs

    from ...errors import InputError
    from ...study.analysis import Resampling, SourceOptions, claims_for, ratings_from, write_analysis
    from ...study.analysis import analyse as run

    if pilot and simulated:
        raise InputError("--pilot and --simulated: they are never mixed; analyse one after the other")
    origin = "pilot" if pilot else "simulated" if simulated else ""
    options = SourceOptions(_columns(column), scale, low_is_good, origin)
    ratings = ratings_from(source, store, options)
    published, note = claims_for(claims, ratings, options)
    ratings = attrs.evolve(ratings, notes=(*ratings.notes, *([note] if note else [])))
    data = run(ratings, Resampling(seed, resamples), family or (), published)
    page = write_analysis(out, data, shlex.join(["hmdwarp", *sys.argv[1:]]))
    if not quiet:
        _print(data)
        typer.echo(f"report: {page}")


def _columns(texts: _Texts) -> dict[str, str]:
    from ...errors import InputError

    pairs = [text.partition("=") for text in texts or ()]
    for text, (role, _, name) in zip(texts or (), pairs, strict=True):
        if not role or not name:
            raise InputError(f"--column '{text}': wanted ROLE=NAME, like rating=mos")
    return {role.strip(): name.strip() for role, _, name in pairs}


def _print(data: dict[str, Any]) -> None:
    from ...report import counted
    from .._show import console, paragraph

    screen = console()
    paragraph(typer.style(data["title"], bold=True))
    counts = f"{counted(data['participants'], 'participant')}, {counted(data['ratings'], 'rating')}"
    paragraph(f"{counts}, {data['missing']} missing; from {data['source']}.")
    for note in data["notes"]:
        paragraph(f"note: {note}")
    for scale in data["scales"]:
        for part in scale["parts"]:
            typer.echo()
            screen.print(_conditions(part, scale["measure"]))
            paragraph(part["friedman_sentence"])
            paragraph(part["reference_sentence"])
            for sentence in part["order_sentences"]:
                paragraph(sentence)
        _print_comparisons(screen, scale)
        for one in [*scale["copied"], *scale["claims"]]:
            typer.echo()
            paragraph(one["sentence"])
        for sentence in (scale["prediction"] or {}).get("sentences", ()):
            typer.echo()
            paragraph(sentence)
    typer.echo()
    drawn = f"{data['resamples']} drawn with seed {data['seed']}"
    paragraph(f"{data['compared']} BCa intervals: all resamples for ratings in steps, otherwise {drawn}.")
    ends = ", ".join(f"{number} {status}" for status, number in data["sittings"]["counts"].items())
    if ends:
        paragraph(f"Sessions: {ends}.")


def _print_comparisons(screen: Any, scale: dict[str, Any]) -> None:
    from .._show import paragraph

    if not scale["comparisons"]:
        return
    for part in dict.fromkeys(row["part"] for row in scale["comparisons"]):
        typer.echo()
        screen.print(_comparisons(part, [row for row in scale["comparisons"] if row["part"] == part]))
    for row in scale["comparisons"]:
        typer.echo()
        paragraph(row["sentence"])


def _conditions(part: dict[str, Any], measure: dict[str, Any]) -> Table:
    from ...report import counted
    from ...report.study import condition_lines

    heads, lines = condition_lines(part["conditions"])
    return _table(
        f"{part['part'] or 'Conditions'}: {measure['title']}, {counted(part['participants'], 'participant')}",
        heads,
        lines,
    )


def _comparisons(part: str, rows: list[dict[str, Any]]) -> Table:
    """Return the table of comparisons in 80 columns; the page has the rest."""
    from ...report import interval, p_text, pair_text, plain, signed
    from ...report.study import pairs_text

    heads = [(name, "") for name in ("compared", "pairs +/0/-", "mean", "BCa 95 %", "p", "Holm", "all", "r")]
    lines = [
        [
            pair_text(row["a"], row["b"]),
            pairs_text(row),
            signed(row["mean"], 3) if row["n"] else "–",
            interval(row["low"], row["high"]),
            *(p_text(row[name]) for name in ("p", "holm", "holm_all")),
            plain(row["rank_biserial"]),
        ]
        for row in rows
    ]
    return _table(
        f"{part}: positive means the second was rated better" if part else "Positive: the second was rated better",
        heads,
        lines,
    )


def _table(title: str, heads: Any, lines: list[list[str]]) -> Table:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(
        title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0)
    )
    for number, (name, unit) in enumerate(heads):
        table.add_column(f"{name} {unit}".strip(), justify="right" if number else "left", no_wrap=number > 0)
    for line in lines:
        table.add_row(*map(Text, line))
    return table
