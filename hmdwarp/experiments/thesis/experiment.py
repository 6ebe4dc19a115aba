"""An experiment of the thesis: what it claims, what to run, what to compute, and the rule.

All of them stand in thesis.toml. A new one is an entry there.
"""

from __future__ import annotations

import enum
import functools
import itertools
import math
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from ...base import InputError, option, out_field, same_as, unknown_name
from ...link.codec import EXACT
from ...run import RunOptions
from ..sweep.options import ExperimentOptions, own_first

# Of the head, in m/s; of its rotation, in deg/s. 30 and 113 are the median and the 95th percentile
# of recorded heads.
SPEEDS_M_S = (0.25, 0.5, 1.0)
SPEEDS_DEG_S = (30.0, 60.0, 113.0)
LATENCIES_MS = (200.0, 400.0, 600.0)
_RATED_MS = (200.0, 400.0, 800.0)  # of the ratings
FULL_SIZE = (1280, 800)
ROTATE = "rotate"
KINDS = ("forward", ROTATE, "sideways", "backward")
RATE_HZ = 60.0
# All latencies show the same instants, at which the head has moved at full speed for the longest of
# them: between the ease at the start and the turn. 1.2 m of `room` are free at 1 m/s.
_ONE_WAY_S, TRACE_S = 1.2, 2.0


@attrs.frozen
class Motion:
    """A motion of one kind at a steady speed."""

    kind: str
    # m/s, or deg/s for ROTATE.
    speed: float

    def __str__(self) -> str:
        return f"{self.kind} {self.speed:g} {'deg/s' if self.kind == ROTATE else 'm/s'}"

    @property
    def amplitude(self) -> float:
        """How far it goes before it turns back, in m or degrees."""
        return self.speed * _ONE_WAY_S


def motions(*kinds: str) -> tuple[Motion, ...]:
    """Return each kind at each of its speeds, the slowest first."""
    return tuple(Motion(kind, speed) for kind in kinds for speed in (SPEEDS_DEG_S if kind == ROTATE else SPEEDS_M_S))


def _usual(kind: str) -> Motion:
    return motions(kind)[1]


def _size_text(guard: tuple[float, float]) -> str:
    """Return the rendered picture's pixels for FULL_SIZE."""
    return "x".join(str(round(side * factor)) for side, factor in zip(FULL_SIZE, guard, strict=True))


@attrs.frozen(kw_only=True)
class PictureRun:
    """One warp and fill on frames of one age, looked at while the head moves at full speed."""

    motion: Motion = _usual("sideways")
    latency_ms: float = 400.0
    warp: str = "forward"
    fill: str = "none"
    # Factors of the rendered picture's pixels on both axes.
    guard: tuple[float, float] = (1.0, 1.0)
    scene: str = "room"
    effects: str = "auto"
    mirrors: str = "geometry"  # how the server draws them
    # Of each side of the picture.
    scale: float = 1.0
    # Whether the passes are timed and the change from picture to picture is measured.
    timed: bool = False
    flickers: bool = False

    @property
    def shared(self) -> tuple[Any, ...]:
        """What runs have in common that are measured on the same frames."""
        return (self.scene, self.effects, self.mirrors, self.motion, self.latency_ms, self.guard, self.scale)

    def __str__(self) -> str:
        fill = "" if self.fill == "none" else f" + {self.fill}"
        more = {
            f"rendered {_size_text(self.guard)} for {_size_text((1.0, 1.0))}": self.guard != (1.0, 1.0),
            f"effects {self.effects}": self.effects != "auto",
            f"mirrors {self.mirrors}": self.mirrors != "geometry",
            self.scene: True,
            f"sides times {self.scale:.3g}": self.scale != 1,
            "timed": self.timed,
            "flicker": self.flickers,
        }
        front = f"{self.motion}, {self.latency_ms:g} ms: {self.warp}{fill}"
        return ", ".join([front, *(words for words, is_so in more.items() if is_so)])


@attrs.frozen(kw_only=True)
class StreamRun:
    """Frames that are coded and sent: what they weigh and how long they take."""

    warp: str = "none"
    codec: str = "h264"
    depth: str = EXACT  # the code of depth
    size: tuple[int, int] = FULL_SIZE
    latency_ms: float = 100.0
    trace: str = "walk"
    # Mbit/s of the link; then rendering, encoding and decoding delay a frame as well.
    bandwidth_mbit: float | None = None
    scene: str = "room"
    # None for the display's.
    server_hz: float | None = None

    def __str__(self) -> str:
        link = "" if self.bandwidth_mbit is None else f" {self.bandwidth_mbit:g} Mbit/s,"
        code = "" if self.depth == EXACT else f", depth as {self.depth}"
        rate = "" if self.server_hz is None else f", drawn at {self.server_hz:g} Hz"
        front = f"{'x'.join(map(str, self.size))}, {self.codec},{link} {self.latency_ms:g} ms, {self.warp}"
        return f"{front}{code}, {self.scene}{rate}"


@attrs.frozen(kw_only=True)
class RatingsRun:
    """The ratings that the thesis published: warped against late pictures in one part."""

    part: str
    latency_ms: float

    def __str__(self) -> str:
        return f"published ratings, {self.part}, {self.latency_ms:g} ms"


@attrs.frozen(kw_only=True)
class _FactRun:
    """A number of this program that the thesis has too: see FACTS of run_figures."""

    fact: str

    def __str__(self) -> str:
        return f"fact {self.fact}"


Run = PictureRun | StreamRun | RatingsRun | _FactRun
Figures = dict[str, float | None]


def is_quick(run: Run) -> bool:
    """Return whether --quick keeps the run: of the pictures those at the middle speed."""
    return not isinstance(run, PictureRun) or run.motion == _usual(run.motion.kind)


# Shares below this are a few pixels: their ratios say nothing.
LEAST_SHARE = 1e-4


def number_of(text: str, runs: Sequence[Figures]) -> float | None:
    """Return the number that a text such as "change psnr_db" stands for; None if it is not known.

    runs: the figures of the cell's runs, in their order. "only FIGURE OVER": of the one run, over a
    number. "change FIGURE": from the first run to the last. "ratio FIGURE OF EXPECTED": of the last
    run's to the first's OF; EXPECTED is the ratio that is 1. "least_growth FIGURE": the least ratio
    of a share to that of the run before. "least_step", "greatest_step FIGURE": of the differences
    from run to run. "closed LEFT WHOLE": the part of the holes that the last run does not leave.
    "growth_exponent FIGURE": n where it grows as pixels to the power of n. "none": there is none.
    """
    kind, *words = text.split()
    if kind == "none":
        return None
    name, of, expected = (*words, "", "")[:3]
    every = [run.get(name) for run in runs]
    known = [value for value in every if value is not None]
    (first, *_), last, base = every, every[-1], runs[0].get(of or name)
    found: float | None = None
    if kind == "closed":
        whole = runs[-1].get(of)
        found = None if last is None or whole is None or whole < LEAST_SHARE else 1 - last / whole
    elif kind == "ratio":
        found = None if last is None or not base else last / base / float(expected or 1)
    elif kind == "growth_exponent":
        grown, pixels = number_of(f"ratio {name}", runs), number_of("ratio pixels", runs)
        found = None if not grown or not pixels else math.log(grown) / math.log(pixels)
    elif kind in ("only", "change"):
        if first is not None and last is not None:
            found = last - first if kind == "change" else first / float(of or 1)
    elif len(known) == len(runs):
        pairs = list(itertools.pairwise(known))
        if kind != "least_growth":
            found = {"least_step": min, "greatest_step": max}[kind](after - before for before, after in pairs)
        elif min(known) >= LEAST_SHARE:
            found = min(after / before for before, after in pairs)
    return found


@attrs.frozen
class Rule:
    """The number lies from `low` to `high`, both included."""

    low: float = -math.inf
    high: float = math.inf

    @classmethod
    def of(cls, text: str) -> Rule:
        """Return the rule of a text: "at least 1", "at most 0.5" or "from 0.5 to 2"."""
        kind, first, *rest = text.split()
        if kind == "from":
            return cls(float(first), float(rest[-1]))
        return cls(low=float(rest[-1])) if first == "least" else cls(high=float(rest[-1]))

    def holds(self, value: float) -> bool:
        """Return whether the claim holds for the number."""
        return self.low <= value <= self.high

    def words(self, unit: str, scale: float) -> str:
        """Return the rule for a number that is written in `unit`, `scale` times the stored one."""
        low, high = (f"{limit * scale:g}" for limit in (self.low, self.high))
        if math.isinf(self.low):
            text = f"at most {high}"
        else:
            text = f"at least {low}" if math.isinf(self.high) else f"from {low} to {high}"
        return f"{text} {unit}".strip()


class Verdict(enum.Enum):
    """What the numbers say of a claim."""

    HOLDS = "holds"
    CONDITIONS = "holds under conditions"
    MOSTLY_FAILS = "mostly does not hold"
    FAILS = "does not hold"
    UNKNOWN = "cannot be told"


@attrs.frozen
class Finding:
    """The number of one setting, and whether the claim holds there."""

    row: str
    column: str
    # None where nothing could be measured; then `holds` is None too.
    value: float | None
    holds: bool | None

    @classmethod
    def of(cls, row: str, column: str, value: float | None, rule: Rule) -> Finding:
        """Judge a number; NaN and infinity count as not measured."""
        known = value if value is not None and math.isfinite(value) else None
        return cls(row, column, known, None if known is None else rule.holds(known))


def verdict_of(findings: Iterable[Finding]) -> Verdict:
    """Return the verdict: settings without a number do not count."""
    judged = [finding.holds for finding in findings if finding.holds is not None]
    held = judged.count(True)
    if not judged:
        return Verdict.UNKNOWN
    if 0 < held < len(judged):
        return Verdict.CONDITIONS if 2 * held >= len(judged) else Verdict.MOSTLY_FAILS
    return Verdict.HOLDS if held else Verdict.FAILS


def settings_text(findings: Sequence[Finding], holds: bool | None) -> str:
    """Return the settings whose findings are so: a row, and its columns unless all are so."""
    texts = []
    for row in dict.fromkeys(finding.row for finding in findings):
        of_row = [finding for finding in findings if finding.row == row]
        columns = [finding.column for finding in of_row if finding.holds is holds]
        if columns:
            texts.append(row if len(columns) == len(of_row) else f"{row} ({', '.join(columns)})")
    return "; ".join(texts)


def share_text(findings: Sequence[Finding], holds: bool) -> str:
    """Return how many of the judged settings are so, and which: see settings_text; "" for none."""
    judged = [finding.holds for finding in findings if finding.holds is not None]
    which = settings_text(findings, holds)
    return f"{judged.count(holds)} of {len(judged)} settings: {which}" if which else ""


Table = Mapping[str, Any]


@attrs.frozen
class Cell:
    """One setting: its place in the table of the experiment, what is run for it, and computed."""

    row: str
    column: str
    runs: tuple[Run, ...]
    # As of number_of.
    computed: str


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


@functools.cache
def experiments() -> tuple[Experiment, ...]:
    """Return all experiments, in the order of the page."""
    text = Path(__file__).with_name("thesis.toml").read_text(encoding="utf-8")
    return tuple(Experiment.of(table) for table in tomllib.loads(text)["experiment"])


def experiments_named(names: Sequence[str]) -> tuple[Experiment, ...]:
    """Return the experiments that begin with these names, in the order of the page; all for none.

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
        return
    if "parts" in table:
        for part in table["parts"]:
            runs = [RatingsRun(part=part, latency_ms=latency_ms) for latency_ms in _RATED_MS]
            each = {table["column"]: runs} if "column" in table else {f"{run.latency_ms:g} ms": [run] for run in runs}
            yield from (Cell(part, column, tuple(found), number) for column, found in each.items())
        return
    by = table.get("by", {"": table.get("runs", [{}])})
    latencies = [float(latency_ms) for latency_ms in table.get("latencies", LATENCIES_MS)]
    sets = [latencies] if table.get("together") else [[latency_ms] for latency_ms in latencies]
    for motion, (label, runs), some in itertools.product(motions(*table.get("motions", KINDS)), by.items(), sets):
        column = f"{', '.join(f'{latency_ms:g}' for latency_ms in some)} ms"
        found = tuple(_run(run, motion=motion, latency_ms=latency_ms) for latency_ms in some for run in runs)
        yield Cell(str(motion), f"{label} at {column}" if label else column, found, number)


def _pictures(table: Table) -> list[PictureRun | StreamRun]:
    """Return the runs of one entry of `pictures`."""
    if "codec" in table:
        return [_run(table)]
    shown = itertools.product(table["motions"], table.get("latencies", (400,)), table.get("runs", [{}]))
    return [_run(run, motion=_usual(kind), latency_ms=float(latency_ms)) for kind, latency_ms, run in shown]


def _run(table: Table, **more: Any) -> Any:
    """Return the run of a table: a fact's, a stream's, or one of pictures."""
    values: dict[str, Any] = {name: tuple(value) if isinstance(value, list) else value for name, value in table.items()}
    if "fact" in values:
        return _FactRun(**values)
    return StreamRun(**values) if "codec" in values else PictureRun(**{**values, **more})


_RUN = attrs.fields(RunOptions)
QUICK_SCALE = 1 / 8
_QUICK_SIZE = (160, 100)


@attrs.frozen(kw_only=True, field_transformer=own_first)
class ThesisOptions(ExperimentOptions):
    """Which experiments of the thesis to run again, and how large. Errors: InputError."""

    out: Path = out_field(attrs.NOTHING, "Folder for thesis.html, results.json and the folder cases.")
    only: tuple[str, ...] = option(
        (),
        "Only these experiments, by their names on the page; for several, repeat it or use commas.",
        kind=list,
        default=None,
        metavar="NAME,..",
        parse=lambda texts: tuple(name.strip() for text in texts for name in text.split(",")),
    )
    quick: bool = option(
        False, "Small pictures and the middle speed only: a check that everything runs, in two minutes."
    )
    size: tuple[int, int] | None = same_as(
        _RUN.size,
        help=f"Pixels of one eye, by default {FULL_SIZE[0]}x{FULL_SIZE[1]}; streams keep those of the thesis.",
    )

    def __attrs_post_init__(self) -> None:
        experiments_named(self.only)
        if self.quick and self.size is not None:
            raise InputError(f"size {self.size[0]}x{self.size[1]} beside --quick, which has its own: leave one out")

    @property
    def eye_size(self) -> tuple[int, int]:
        """Pixels of one eye."""
        return self.size or (_QUICK_SIZE if self.quick else FULL_SIZE)
