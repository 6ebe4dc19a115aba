"""hmdwarp study: rating sessions from the plan to the paper."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import attrs
import typer

from ..base import Declared, InputError, Number, PaperOptions, force_field, group, option, out_field, same_as
from ..study import MeasureOptions, store
from ..study import design as designs
from ..study.session.session_options import SessionOptions
from ._options import JSON, QUIET, Group, Said, as_json, command_line, print_results, takes
from ._signals import INTERRUPTED, Ended

app = typer.Typer(cls=Group, help="Rating studies: plan, run, export, analyse.", no_args_is_help=True)
_STUDY = "The study's .toml file, or the name of a shipped study, such as thesis."
_SOURCE = "Tables with one row per rating (.csv, .tsv), or a study's .toml file, or the name of a shipped study."
_SIGN = "positive: rated better than the baseline, the one after 'over'"
_Texts = list[str] | None


def _study_field() -> Any:
    return option(attrs.NOTHING, _STUDY, positional=True, metavar="STUDY", names_files=True)


@attrs.frozen
class _DataOptions(Declared):
    """Whose data of a study."""

    store: Path | None = option(None, "Folder of the study's data; by default STUDY-data beside its file.", kind=Path)
    pilot: bool = same_as(attrs.fields(MeasureOptions).pilot)
    simulated: bool = option(False, "Simulated sessions instead of those of participants.")


_STORE, _PILOT, _SIMULATED = (getattr(attrs.fields(_DataOptions), name) for name in ("store", "pilot", "simulated"))


def _origin_of(pilot: bool, simulated: bool) -> str:
    """Return whose sessions the options choose. Errors: InputError for both."""
    from ..study.store import PERSON, PILOT, SIMULATED

    if pilot and simulated:
        raise InputError("--pilot and --simulated: their data lie apart and are never mixed: one after the other")
    return PILOT if pilot else SIMULATED if simulated else PERSON


@attrs.frozen
class _InitOptions(Declared):
    """A new plan."""

    name: str = option(attrs.NOTHING, "Name of the study; the file is NAME.toml.", positional=True, metavar="NAME")
    force: bool = force_field()


@app.command()
@takes(_InitOptions)
def init(said: Said) -> None:
    """Write NAME.toml, a commented plan that can be run as it is."""
    from ..study.design import write_new_plan

    options = _InitOptions.of(said)
    path = write_new_plan(options.name, Path(), force=options.force)
    typer.echo(f"written: {path}; change it, then: hmdwarp study plan {path}")


@attrs.frozen
class _PlanOptions(Declared):
    """What to print of a plan."""

    study: str = _study_field()
    json: bool = option(False, "Print the plan as one JSON object.")
    orders: bool = option(False, "Print every order as well.")
    people: int = option(20, "Number of people whose power is printed, in each part.", valid=Number(least=2, most=100))


@app.command()
@takes(_PlanOptions)
def plan(said: Said) -> None:
    """Check a study's file and print conditions, steps, time, orders, scales and comparisons."""
    from ..report import counted
    from ..study import design as study
    from ._show import in_columns, paragraph

    def block(heading: str, rows: Iterable[tuple[str, str]]) -> None:
        typer.echo(f"\n{typer.style(heading, bold=True)}")
        in_columns(rows, indent=2)

    options = _PlanOptions.of(said)
    design = study.load_design(options.study)
    if options.json:
        typer.echo(as_json(study.design_as_json(design) | {"power": study.power_as_json(design, options.people)}))
        return
    paragraph(typer.style(design.title, bold=True))
    in_columns(study.head_rows(design))
    for part in design.parts:
        block(f"Part {part.name}: {counted(len(part.conditions), 'condition')}", study.condition_rows(part))
        whole, phases = study.session_rows(design, part)
        typer.echo(f"  A session: {whole}")
        in_columns(phases, indent=4)
        orders = len(study.rows_for(design, part.name))
        typer.echo(f"  Orders: {orders}")
        in_columns(study.balance_rows(design, part), indent=4)
        for row in study.order_rows(design, part) if options.orders else ():
            in_columns([row], indent=4)
        if options.orders and orders > study.MOST_ORDERS:
            typer.echo(f"    .. and {orders - study.MOST_ORDERS} more; --json has them all")
    block("Scales", ((scale.name, study.scale_text(scale)) for scale in study.every_scale(design)))
    families = [(family.name, study.family_text(family)) for family in design.families]
    block("Comparisons, each family with Holm's correction", families)
    if not families:
        typer.echo("  none planned")
    for power in study.power_as_json(design, options.people):
        block("Power of one comparison", study.power_rows(power))
    if notes := study.notes(design):
        block("Hints", (("-", note) for note in notes))
    else:
        typer.echo("\nNo hints.")


@app.command()
@takes(SessionOptions, attrs.evolve(QUIET, help="Print nothing but errors and a drawn code."))
def run(said: Said) -> None:
    """Run a session: show each condition, ask about it, store every answer at once."""
    from ..study.session.program import run_session

    options, quiet, status = SessionOptions.of(said), said["quiet"], INTERRUPTED
    told: list[str] = []
    ends: list[store.Session] = []

    def end(session: store.Session) -> None:
        ends.append(session)
        if quiet and options.participant.lower() == "new":
            typer.echo(session.code)

    try:
        session = run_session(options, told.append if quiet else typer.echo, quiet=quiet, on_end=end)
        if session.status != "interrupted":
            return
    except (KeyboardInterrupt, Ended) as error:
        if not ends:
            raise
        if isinstance(error, Ended):
            status = 128 + error.args[0]
    # The closing words are printed by now; the usual "nothing unfinished is left" would be wrong.
    if quiet:
        typer.echo(f"hmdwarp: session interrupted: {ends[0].why}; what was answered is stored, {told[-1]}", err=True)
    sys.exit(status)


@attrs.frozen
class _MeasureCommand(Declared):
    """A study, and how to measure it."""

    study: str = _study_field()
    store: Path | None = same_as(_STORE)
    simulated: bool = same_as(_SIMULATED)
    options: MeasureOptions = group(MeasureOptions)


@app.command()
@takes(_MeasureCommand, QUIET)
def measure(said: Said) -> None:
    """Replay each trial's head trace and measure its pictures against zero latency; resumable."""
    from ..experiments.sweep import raise_failed
    from ..study import measure_study
    from ..study.design import load_design
    from ..study.store import Store, folder_to_read
    from ._show import steps

    wanted, quiet = _MeasureCommand.of(said), said["quiet"]
    origin = _origin_of(wanted.options.pilot, wanted.simulated)
    design = load_design(wanted.study, checked=False)  # only its name is needed
    with (
        Store(folder_to_read(design, wanted.store, origin), study=design.name) as data,
        steps("refreshes", quiet=quiet) as (progress, screen),
    ):
        found = measure_study(data, wanted.options, progress, *([] if quiet else [screen.print]))
    if not quiet:
        typer.echo("\n".join(found.describe()))
    raise_failed(found.failed, found.measured + len(found.failed), "the others are kept: run it again")


@attrs.frozen
class _ExportCommand(Declared):
    """An export."""

    study: str = _study_field()
    out: Path = out_field(attrs.NOTHING, "A new folder for the table and the BIDS data set.")
    force: bool = force_field()
    data: _DataOptions = group(_DataOptions)
    parquet: bool | None = option(
        None, "Write ratings.parquet; by default where pyarrow is installed.", off="--no-parquet"
    )
    without_motion: bool = option(False, "Leave out the head motion, by which people can be recognised.")


@app.command()
@takes(_ExportCommand, QUIET)
def export(said: Said) -> None:
    """Write the ratings as CSV and Parquet, and the study as BIDS with the head motion."""
    from ..study.design import load_design
    from ..study.export.write import ExportOptions
    from ..study.export.write import export as write
    from ..study.store import Store, folder_to_read
    from ._show import steps

    wanted = _ExportCommand.of(said)
    origin = _origin_of(wanted.data.pilot, wanted.data.simulated)
    design = load_design(wanted.study, checked=False)
    with Store(folder_to_read(design, wanted.data.store, origin), study=design.name) as data:
        contents = data.contents(pilot=wanted.data.pilot)
    options = ExportOptions(origin, wanted.parquet, wanted.force, not wanted.without_motion)
    with steps("recordings", quiet=said["quiet"]) as (progress, _):
        made = write(contents, design, wanted.out, options, progress)
    if not said["quiet"]:
        typer.echo("\n".join([*made.notes, f"written: {made.folder}"]))


@attrs.frozen
class _AnalyseOptions(Declared):
    """An analysis."""

    sources: tuple[str, ...] = option(
        attrs.NOTHING, _SOURCE, kind=list, positional=True, metavar="FILE|STUDY", names_files=True
    )
    out: Path = out_field(attrs.NOTHING, "Folder for report.html, analysis.json and tables/*.csv.")
    force: bool = force_field()
    paper: PaperOptions = group(PaperOptions)
    store: Path | None = same_as(_STORE)
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
    pilot: bool = same_as(_PILOT)
    simulated: bool = same_as(_SIMULATED)
    seed: int = option(0, "Random seed, where resamples are drawn: not for ratings in steps.", valid=Number())
    resamples: int = option(
        20_000, "Number of resamples, where they are drawn.", valid=Number(least=100, most=10_000_000)
    )


@app.command()
@takes(_AnalyseOptions, JSON, QUIET)
def analyse(said: Said) -> None:
    """Analyse ratings: exact tests, intervals, order effects; writes tables, plots and one page.

    Only sessions with people count; --pilot and --simulated analyse the others by themselves. The
    name of a shipped study without sessions stands for the ratings published with it ('thesis').
    """
    from ..study.analysis import full_analysis
    from ..study.analysis.findings import Resampling, claims_for
    from ..study.analysis.long_table import SourceOptions, ratings_from_all

    options = _AnalyseOptions.of(said)
    origin = _origin_of(options.pilot, options.simulated) if options.pilot or options.simulated else ""
    missing = tuple(filter(None, map(str.strip, options.missing.split(","))))
    pairs = [pair.partition("=") for pair in filter(None, options.columns.split(","))]
    if not all(role and name for role, _, name in pairs):
        raise InputError(f"--columns '{options.columns}': expected ROLE=NAME,.., like participant=who,rating=mos")
    names = {role.strip(): name.strip() for role, _, name in pairs}
    columns = SourceOptions(names, options.scale, options.low_is_good, origin, missing)
    with full_analysis.analysis_folder(options.out, force=options.force) as out:
        ratings = ratings_from_all(options.sources, options.store, columns)
        published, note = claims_for(options.claims, ratings, columns)
        ratings = attrs.evolve(ratings, notes=(*ratings.notes, *([note] if note else [])))
        resampling = Resampling(options.seed, options.resamples)
        data = full_analysis.analyse(ratings, resampling, options.family or (), published)
        page = full_analysis.write_analysis(out, data, command_line(), options.paper)
    print_results(said, data, lambda: _print(data), page)


def _print(data: dict[str, Any]) -> None:
    from ..report import best_first, counted, study_lines, terminal_table
    from ._show import console, paragraph

    screen = console()

    def table(title: str, heads: Any, lines: list[list[str]]) -> None:
        typer.echo()
        names = [" ".join(head).strip() for head in heads]
        cells = [max(map(len, column)) for column in zip(*lines, strict=True)] or [0] * len(names)
        if sum(max(len(name), cell) + 1 for name, cell in zip(names, cells, strict=True)) > screen.width:
            # It would take that from the names of the rows.
            folded = zip(names[1:], cells[1:], strict=True)
            names[1:] = [textwrap.fill(name, max(cell, 1), break_long_words=False) for name, cell in folded]
        screen.print(terminal_table(names, lines, title=title, title_style="bold"))

    def paragraphs(texts: Iterable[str], *, apart: bool = False) -> None:
        for text in texts:
            if apart:
                typer.echo()
            paragraph(text)

    compared, missing = (sum(part[key] for part in data["preferences"]) for key in ("answers", "missing"))
    given = counted(compared, "comparison") if data["preferences"] else counted(data["ratings"], "rating")
    people = counted(data["participants"], "participant")
    paragraphs([
        typer.style(data["title"], bold=True),
        f"{people}, {given}, {data['missing'] + missing} missing; from {data['source']}.",
        *(f"note: {note}" for note in data["notes"]),
    ])  # fmt: skip
    for part in data["preferences"]:
        title = f"{part['part'] or 'Scores'}: JOD, {counted(part['people'], 'person')}"
        table(title, *study_lines("scores", best_first(part["conditions"])))
        paragraphs(part["sentences"])
    for scale in data["scales"]:
        for part in scale["parts"]:
            measure, people = scale["measure"], counted(part["participants"], "participant")
            lines = study_lines("conditions", part["conditions"], mean=measure["mean_name"])
            table(f"{part['part'] or 'Conditions'}: {measure['title']}, {people}", *lines)
            paragraphs([part["friedman_sentence"], part["reference_sentence"], *part["order_sentences"]])
        for part in dict.fromkeys(row["part"] for row in scale["comparisons"]):
            rows = [row for row in scale["comparisons"] if row["part"] == part]
            title = f"{part}: {_SIGN}" if part else _SIGN.capitalize()
            table(title, *study_lines("comparisons in 80 columns", rows))
        found = [row["sentence"] for row in (*scale["comparisons"], *scale["claims"])]
        paragraphs([*found, *(scale["prediction"] or {}).get("sentences", ())], apart=True)
    typer.echo()
    drawn = f"{data['resamples']} drawn with seed {data['seed']}"
    paragraph(f"{data['compared']} BCa intervals: all resamples for ratings in steps, otherwise {drawn}.")
    if ends := ", ".join(f"{number} {status}" for status, number in data["sittings"]["counts"].items()):
        paragraph(f"Sessions: {ends}.")


@attrs.frozen
class _WithdrawOptions(Declared):
    """Who withdraws from which study."""

    study: str = _study_field()
    code: str = option(attrs.NOTHING, "The participant's code.", positional=True, metavar="CODE")
    data: _DataOptions = group(_DataOptions)
    yes: bool = option(False, "Erase without confirmation.")


@app.command()
@takes(_WithdrawOptions)
def withdraw(said: Said) -> None:
    """Erase all ratings, events and head traces of a participant; the code stays reserved."""
    from ..study.design import load_design
    from ..study.store import BEYOND, Store, store_folder

    options = _WithdrawOptions.of(said)
    code, origin = options.code, _origin_of(options.data.pilot, options.data.simulated)
    design: designs.Design | None = None
    try:
        design = load_design(options.study, checked=False)
        folder = store_folder(design, options.data.store, origin)
    except InputError:
        if design is not None or options.data.store is None:
            raise
        folder = options.data.store  # the file of the study may be broken
    with Store(folder, study=None if design is None else design.name, say=typer.echo) as opened:
        if not opened.finish_withdrawal(code):
            if not options.yes and not sys.stdin.isatty():
                raise InputError(f"withdrawing {code} cannot be undone: use --yes, or a terminal for the confirmation")
            found = opened.holdings(code)
            typer.echo(f"Participant {found.code} in {folder}: {found.describe()}.")
            typer.echo(f"Exports call this participant {found.sub}: write it down, it is erased as well.")
            if not options.yes and not typer.confirm("Erase it for good?"):
                typer.echo("Nothing was erased.")
                return
        erased = opened.withdraw(code)
        known, amount = (code, "the rest of it") if erased is None else (erased.code, erased.describe())
    typer.echo(
        f"Participant {known} has withdrawn; erased: {amount}. The code stays marked, and their order is free. {BEYOND}"
    )
