"""An experiment of the thesis: what it claims, what to run, what to compute, and the rule.

All of them stand in thesis.toml. A new one is an entry there.
"""

from __future__ import annotations

import functools
import itertools
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from ...errors import InputError, unknown_name
from ...options import group, option, out_field, same_as
from ...run import RunOptions
from ..sweep.options import ExperimentOptions, KeptOptions, own_first
from .run_kinds import (
    FULL_SIZE,
    LATENCIES_MS,
    RATED_MS,
    FactRun,
    Figures,
    PictureRun,
    RatingsRun,
    Rule,
    Run,
    StreamRun,
    motions,
    number_of,
    usual,
)

KINDS = ("forward", "rotate", "sideways", "backward")
Table = Mapping[str, Any]


@attrs.frozen
class Cell:
    """One setting: its place in the table of the experiment, and what is run for it."""

    row: str
    column: str
    runs: tuple[Run, ...]
    # What is computed, see run_kinds.py.
    computed: str

    def number(self, figures: Sequence[Figures]) -> float | None:
        """Return the number from the figures of the runs, in their order; None if not known."""
        return number_of(self.computed, figures)


@attrs.frozen(kw_only=True)
class Experiment:
    """One figure, time or claim of the thesis."""

    # For --only.
    name: str
    # Where the thesis has it.
    source: str
    # The claim, as a sentence.
    claim: str
    # The thesis's value or finding.
    thesis: str
    # What the number is, as a noun.
    measured: str
    rule: Rule
    unit: str = ""
    digits: int = 2
    # Turns the number into `unit`.
    scale: float = 1.0
    cells: tuple[Cell, ...] = ()
    # Runs whose pictures are shown; of a stream the time line of its frames.
    pictures: tuple[PictureRun | StreamRun, ...] = ()
    # Whether the number is a weak stand-in for what the claim is about.
    weak: bool = False
    # What the reader must know; not computed.
    note: str = ""

    @classmethod
    def of(cls, table: Table) -> Experiment:
        """Return the experiment of an entry of thesis.toml."""
        plain = {name: value for name, value in table.items() if name not in ("number", "rule", "cells", "pictures")}
        cells = tuple(cell for part in table["cells"] for cell in _cells(part, table["number"]))
        pictures = tuple(run for part in table.get("pictures", ()) for run in _pictures(part))
        return cls(**plain, rule=Rule.of(table["rule"]), cells=cells, pictures=pictures)

    def runs(self) -> tuple[Run, ...]:
        """Return all runs, each once."""
        found = [run for cell in self.cells for run in cell.runs]
        return tuple(dict.fromkeys([*found, *self.pictures]))

    def rule_words(self) -> str:
        """Return the rule in words."""
        return f"{self.measured}: {self.rule.words(self.unit, self.scale)}"


@functools.cache
def experiments() -> tuple[Experiment, ...]:
    """Return all experiments, in the order of the page."""
    text = Path(__file__).with_name("thesis.toml").read_text(encoding="utf-8")
    return tuple(Experiment.of(table) for table in tomllib.loads(text)["experiment"])


def experiments_named(names: Sequence[str]) -> tuple[Experiment, ...]:
    """Return the experiments of these names in the order of the page; all for no name.

    A beginning stands for all that begin so: "ratings", or "fig28" for "fig28-30".
    Errors: UnknownNameError.
    """
    known = [each.name for each in experiments()]
    chosen = set[str]()
    for name in names:
        found = [name] if name in known else [each for each in known if name and each.startswith(name)]
        if not found:
            raise unknown_name("experiment of the thesis", name, known)
        chosen.update(found)
    return tuple(each for each in experiments() if not names or each.name in chosen)


def _cells(table: Table, number: str) -> Iterator[Cell]:
    """Yield the cells of one entry of `cells`."""
    number = table.get("number", number)
    if "row" in table:
        yield Cell(table["row"], table["column"], tuple(map(_run, table["runs"])), number)
    elif "parts" in table:
        for part in table["parts"]:
            runs = [RatingsRun(part=part, latency_ms=latency_ms) for latency_ms in RATED_MS]
            if "column" in table:
                yield Cell(part, table["column"], tuple(runs), number)
            else:
                yield from (Cell(part, _ms(run.latency_ms), (run,), number) for run in runs)
    else:
        by = table.get("by", {"": table.get("runs", [{}])})
        latencies = [float(latency_ms) for latency_ms in table.get("latencies", LATENCIES_MS)]
        sets = [latencies] if table.get("together") else [[latency_ms] for latency_ms in latencies]
        for motion, (label, runs), some in itertools.product(motions(*table.get("motions", KINDS)), by.items(), sets):
            column = f"{', '.join(f'{latency_ms:g}' for latency_ms in some)} ms"
            found = tuple(_run(run, motion=motion, latency_ms=latency_ms) for latency_ms in some for run in runs)
            yield Cell(str(motion), f"{label} at {column}" if label else column, found, number)


def _pictures(table: Table) -> Iterator[PictureRun | StreamRun]:
    """Yield the runs of one entry of `pictures`."""
    if "codec" in table:
        yield _run(table)
    else:
        shown = itertools.product(table["motions"], table.get("latencies", (400,)), table.get("runs", [{}]))
        for kind, latency_ms, run in shown:
            yield _run(run, motion=usual(kind), latency_ms=float(latency_ms))


def _run(table: Table, **more: Any) -> Any:
    """Return the run of a table: a fact's, a stream's, or one of pictures."""
    values: dict[str, Any] = {name: tuple(value) if isinstance(value, list) else value for name, value in table.items()}
    if "fact" in values:
        return FactRun(**values)
    if "codec" in values:
        return StreamRun(**values)
    return PictureRun(**{"motion": usual("sideways"), "latency_ms": 400.0, **values, **more})


def _ms(latency_ms: float) -> str:
    return f"{latency_ms:g} ms"


_RUN = attrs.fields(RunOptions)
QUICK_SCALE = 1 / 8
QUICK_SIZE = (160, 100)


def _names(texts: list[str]) -> tuple[str, ...]:
    return tuple(name.strip() for text in texts for name in text.split(","))


@attrs.frozen(kw_only=True, field_transformer=own_first)
class ThesisOptions(ExperimentOptions):
    """Which experiments of the thesis to run again, and how large.

    Errors: UnknownNameError for an unknown experiment; InputError for a size with
    `quick`.
    """

    out: Path = out_field(attrs.NOTHING, "Folder for thesis.html, results.json, results.csv and the folder cases.")
    only: tuple[str, ...] = option(
        (),
        "Only these experiments, by their names on the page; for several, repeat it or use commas.",
        kind=list,
        default=None,
        metavar="NAME,..",
        parse=_names,
    )
    quick: bool = option(
        False, "Small pictures and the middle speed only: a check that everything runs, in two minutes."
    )
    size: tuple[int, int] | None = same_as(
        _RUN.size,
        help=f"Pixels of one eye, by default {FULL_SIZE[0]}x{FULL_SIZE[1]}; streams keep those of the thesis.",
    )
    sweep: KeptOptions = group(KeptOptions)

    def __attrs_post_init__(self) -> None:
        experiments_named(self.only)
        if self.quick and self.size is not None:
            raise InputError(f"size {self.size[0]}x{self.size[1]} beside --quick, which has its own: leave one out")

    @property
    def eye_size(self) -> tuple[int, int]:
        """Pixels of one eye."""
        return self.size or (QUICK_SIZE if self.quick else FULL_SIZE)
