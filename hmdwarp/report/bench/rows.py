"""The rows of a bench in comparable groups, their figures by flat names, and the table of them."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import attrs

from ...metrics import (
    JOD,
    LEAST_INSTANTS,
    PRIMARY,
    REGIONS,
    STAGES,
    TRUTH_PREFERRED,
    Figure,
    differ,
    error_and_time,
    excludes_zero,
    metrics,
    metrics_in_order,
    paired,
    pareto,
    ratings_of,
)
from ..run_texts import Cell, Line, Table, listed

if TYPE_CHECKING:
    from rich.table import Table as TerminalTable

Row = Mapping[str, Any]

# What rows that can be compared share: (key, its text). The first two stand in every label.
Conditions = tuple[tuple[str, Callable[[Any], str]], ...]
OF_BENCH: Conditions = (
    ("trace", str),
    ("latency_ms", lambda v: f"{v:g} ms"),
    ("scene", lambda v: f"scene {v}"),
    ("size", lambda v: f"{v[0]}x{v[1]}"),
    ("headset", str),
    ("lens", lambda v: f"lens {v}"),
    ("guard", lambda v: f"guard {v}" if isinstance(v, str) else f"guard {v:g}"),
    ("predict", lambda v: f"predict {v}"),
    ("rate_hz", lambda v: f"{v:g} Hz"),
    ("server_rate_hz", lambda v: f"server {v:g} Hz"),
    ("machine", lambda v: f"on {v['host']}" if v.get("host") else ""),  # times of two are not comparable
)
_IN_EVERY_LABEL = ("trace", "latency_ms", "over")
_MOST_NAMED = 6  # of those that tie
# By which a winner is named.
RULE = (
    f"the least mean {metrics.get(PRIMARY).label}; a tie with each method whose 95 % interval of the paired "
    "difference, over the same instants, includes 0"
)


def row_name(row: Row, with_fill: bool = True) -> str:
    """Return a row's strategy, or its warp, and its fill where there are several."""
    if row.get("strategy"):
        return str(row["strategy"])
    return f"{row['warp']} + {row['fill']}" if with_fill and row["fill"] != "none" else row["warp"]


@attrs.frozen(eq=False)
class Case:
    """Rows of one recording, latency, scene, size and so on: errors and times are comparable."""

    # How this case differs from the others, at least recording and latency.
    label: str
    rows: tuple[Row, ...]

    def ordered(self, measure: str = PRIMARY) -> list[Row]:
        """Return the rows by mean error, the best first, then by time; those not measured last."""
        return sorted(
            self.rows, key=lambda row: tuple((cost is None, cost or 0.0) for cost in error_and_time(row, measure))
        )

    def front(self, measure: str = PRIMARY) -> list[Row]:
        """Return the usable rows that no other beats in both error and time, in their order."""
        return pareto(self.usable, lambda row: error_and_time(row, measure))

    @property
    def usable(self) -> list[Row]:
        """The rows that the bench's client can run."""
        return [row for row in self.rows if not row.get("lacks")]

    def leaders(self, measure: str = PRIMARY) -> list[Row]:
        """Return the best row that the client can run, and its ties by RULE, if any."""
        rows = [row for row in self.ordered(measure) if not row.get("lacks") and _interval(row, measure)]
        values = [row["at_instants"][measure] for row in rows]
        return [row for row, own in zip(rows, values, strict=True) if own is values[0] or not differ(own, values[0])]

    def best(self, column: str) -> list[Row]:
        """Return the rows that are bold in a column: its leaders, or those of the least time."""
        if column in metrics.names() and metrics.get(column).is_contest:
            return self.leaders(column)
        taken = [(COLUMNS[column].value(row), row) for row in self.usable] if column in _TIMES else []
        least = min((value for value, _ in taken if value is not None), default=math.inf)
        return [row for value, row in taken if value == least]

    def verdict(self) -> dict[str, Any]:
        """Return who wins by RULE, as `winners` of bench.json has it, and which metrics disagree.

        A metric does if its own best is better than the winner, and their interval excludes 0.
        Holes, which a method without a warp has none of, are compared within a tie. `paired`:
        the difference of each method to the best, by which it ties or loses.
        """
        best, disagree = self.leaders(), []
        for metric in (metrics.get(name) for name in _RANKS if best and name != PRIMARY):
            others = (self if metric.is_contest else Case("", tuple(best))).leaders(metric.name)
            for other in others[:1]:
                found = _paired(other, best[0], metric.name)
                if excludes_zero(found["interval"]):
                    disagree.append({"metric": metric.name, "best": row_name(other), **found})
        rows = [row for row in self.ordered() if best and row is not best[0] and _interval(row, PRIMARY)]
        return {
            "case": self.label,
            "metric": PRIMARY,
            "rule": RULE,
            "best": [*map(row_name, best)],
            "disagree": disagree,
            "paired": [{"method": row_name(row), **_paired(row, best[0], PRIMARY)} for row in rows],
        }

    def held(self, measure: str = PRIMARY) -> list[Row]:
        """Return the rows of the front that are surely better than the quicker one before them.

        The interval of their difference at the same instants excludes 0. None where there are too
        few instants for an interval.
        """
        kept: list[Row] = []
        for row in sorted(self.front(measure), key=lambda row: error_and_time(row, measure)[1] or 0.0):
            values = row["at_instants"][measure] if _interval(row, measure) else {}
            if values and (not kept or differ(kept[-1]["at_instants"][measure], values)):
                kept.append(row)
        return kept


def _paired(row: Row, first: Row, measure: str) -> dict[str, Any]:
    """Return the mean difference of two rows over the instants of both, and its interval."""
    mean, interval = paired(*(one["at_instants"][measure] for one in (row, first)))
    return {"difference": mean, "interval": interval}


def _interval(row: Row, measure: str) -> Any:
    return row["quality"][measure].get("interval")


def verdict_text(verdict: Mapping[str, Any]) -> str:
    """Return an entry of `winners` in words."""
    names, label = verdict["best"], metrics.get(verdict["metric"]).label
    if not names:
        return f"{verdict['case']}: no winner: intervals need {LEAST_INSTANTS} instants."
    shown = [*names[:_MOST_NAMED], *([f"{len(names) - _MOST_NAMED} more"] if len(names) > _MOST_NAMED else [])]
    won = f"{names[0]} wins by {label}." if len(names) == 1 else f"a tie by {label}: {listed(shown)}."
    others = []
    for one in verdict["disagree"]:
        metric = metrics.get(one["metric"])
        sign = 1 if metric.higher_is_better else -1
        by, *ends = (metric.figure.text(sign * value) for value in (one["difference"], *one["interval"][::sign]))
        told = f"{metric.label} favours {one['best']} by {by} {metric.figure.unit}".rstrip()
        others.append(f"{told} (95 %: {' to '.join(ends)})")
    return f"{verdict['case']}: {won}" + (f" But {listed(others)}." if others else "")


def cases(rows: Iterable[Row], of: Conditions = OF_BENCH) -> list[Case]:
    """Return the groups of comparable rows, in the order in which they first appear."""
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(_conditions(row, of), []).append(row)
    differing = [i for i, (name, _) in enumerate(of) if name in _IN_EVERY_LABEL or len({key[i] for key in groups}) > 1]
    return [Case(", ".join(key[i] for i in differing if key[i]), tuple(group)) for key, group in groups.items()]


def first_cases(rows: Iterable[Row], most: int, of: Conditions = OF_BENCH) -> tuple[dict[int, Row], int]:
    """Return the rows of the first cases by number, at most so many, and the number of cases."""
    known: dict[tuple[str, ...], bool] = {}
    keyed = ((number, row, _conditions(row, of)) for number, row in enumerate(rows))
    shown = {number: row for number, row, key in keyed if known.setdefault(key, len(known) < most)}
    return shown, len(known)


def common(rows: Iterable[Row]) -> list[str]:
    found, columns = [], zip(*(_conditions(row, OF_BENCH) for row in rows), strict=True)
    for (name, _), (text, *others) in zip(OF_BENCH, map(set, columns), strict=False):
        if text and not others and name not in (*_IN_EVERY_LABEL, "machine"):
            found.append(text)
    return found


def _conditions(row: Row, of: Conditions) -> tuple[str, ...]:
    return tuple(text(row[name]) if row.get(name) is not None else "" for name, text in of)


_Value = Callable[[Row], Any]


def at(*keys: str | int, default: Any = None) -> _Value:
    """Return what takes a value from the tables and lists inside a row."""

    def value(row: Any) -> Any:
        for key in keys:
            if not row:
                return default
            row = row[key] if isinstance(key, int) else row.get(key, default)
        return row

    return value


@attrs.frozen
class Column:
    """One column of every table: the page's, the terminal's, those of papers, CSV and Parquet."""

    # Label, and how a number is written; its name is that of the column in a file.
    figure: Figure
    # Takes the value out of a row; None where nothing was measured.
    value: _Value
    # float, int or str.
    kind: type = float
    # Whether files have it.
    is_filed: bool = True
    # Takes what people see, where that is another text.
    shown: _Value | None = None

    @classmethod
    def of_text(cls, name: str, label: str = "", value: _Value | None = None, **more: Any) -> Column:
        """Return a column of texts; by default that of the row's key."""
        return cls(Figure(name, label or name, "", 0), value or at(name, default=""), str, **more)

    @classmethod
    def of_number(
        cls, name: str, label: str = "", unit: str = "", digits: int = 0, scale: float = 1, keys: Any = (), **more: Any
    ) -> Column:
        """Return a column of numbers, those under keys; by default of the column's name."""
        return cls(Figure(name, label or name, unit, digits, scale), at(*(keys or [name])), **more)

    @property
    def name(self) -> str:
        return self.figure.name

    @property
    def is_number(self) -> bool:
        """Whether it stands at the right."""
        return self.kind is not str

    @property
    def head(self) -> tuple[str, str]:
        return self.figure.label, self.figure.unit

    def text(self, row: Row) -> str:
        """Return the cell of this row; a dash where nothing was measured."""
        value = (self.shown or self.value)(row)
        return self.figure.text(value) if self.is_number else "–" if value in (None, "") else str(value)


Columns = dict[str, Column]


def by_name(columns: Iterable[Column]) -> Columns:
    """Return columns by their names, in their order."""
    return {column.name: column for column in columns}


def table_of(
    caption: str, columns: Sequence[Column], rows: Iterable[Row], *, case: Case | None = None, **more: Any
) -> Table:
    """Return the rows as a table. case: theirs, whose front and best are marked."""
    front = set(map(id, case.held())) if case else set()
    best = {c.name: set(map(id, case.best(c.name))) for c in columns} if case else {}

    def cell(column: Column, row: Row) -> Cell:
        style = "best" if id(row) in best.get(column.name, ()) else ""
        return Cell(column.text(row), style if column.is_number else "word")

    lines = [Line(tuple(cell(column, row) for column in columns), id(row) in front) for row in rows]
    return Table(caption, [c.head for c in columns], lines, **more)


def terminal_of(
    columns: Sequence[Column], groups: Sequence[Case], *, has_marks: bool = False, **titles: str
) -> TerminalTable:
    """Return the cases as one table of the terminal, the least error first."""
    lines: list[Line] = []
    for group in groups:
        first, *others = table_of("", columns, group.ordered(), case=group if has_marks else None).lines
        lines += [attrs.evolve(first, group=group.label if len(groups) > 1 else ""), *others]
    return Table("", [c.head for c in columns], lines, has_marks).terminal(**titles)


def metric_columns(*, intervals: bool) -> Iterator[Column]:
    """Yield mean and bad tail of each metric, and the ends and half the width of its interval."""

    def half_width(name: str, row: Row) -> float | None:
        entry = row["quality"][name]
        interval = entry.get("interval")  # cut where the metric ends
        return None if interval is None else max(interval[1] - entry["mean"], entry["mean"] - interval[0])

    for figure in (metric.short_figure for metric in metrics_in_order()):
        takes = functools.partial(at, "quality", figure.name)
        yield from (Column(figure, takes("mean")), Column(_like(figure, "_p95", " p95"), takes("p95")))
        if intervals:
            yield from (Column(_like(figure, end), takes("interval", n)) for n, end in enumerate(("_low", "_high")))
            yield Column(_like(figure, "_spread", " ±"), functools.partial(half_width, figure.name), is_filed=False)


def _like(figure: Figure, name: str, label: str = "") -> Figure:
    return attrs.evolve(figure, name=figure.name + name, label=figure.label + label)


def _rated(figure: Figure) -> Column:
    return Column(figure, lambda row: ratings_of(row).get(figure.name))


# Where ColorVideoVDP rated the clips.
RATED = (_rated(JOD), _rated(TRUTH_PREFERRED))


def _warp_text(row: Row) -> str:
    """Return 'mesh:grid=64 (CloudXR.js)' or 'none (imposter)'."""
    stands_for = row.get("strategy") or row.get("baseline")
    return f"{row['warp']} ({stands_for})" if stands_for else str(row.get("warp"))


def _columns() -> Iterator[Column]:
    text, number = Column.of_text, Column.of_number
    yield from (text("trace", "recording"), text("scene"), number("latency_ms", "latency", "ms"), text("strategy"))
    yield from (text("warp", shown=_warp_text), text("fill"), text("lens"), text("headset"))
    yield from (number("frames", kind=int), number("rate_hz"), number("server_rate_hz", "server", "Hz"))
    yield from map(text, ("guard", "predict", "clock"))
    yield text("size", value=lambda row: "x".join(map(str, row.get("size") or ())), is_filed=False)
    yield from (number("width", keys=("size", 0), kind=int), number("height", keys=("size", 1), kind=int))
    for stage in STAGES:
        label = "" if stage == "total" else f"{stage} "
        yield number(f"{stage}_ms", f"{label}time", "ms", 2, keys=("time_ms", stage, "median"))
        yield number(f"{stage}_ms_p95", f"{label}p95", "ms", 2, keys=("time_ms", stage, "p95"))
    yield from metric_columns(intervals=True)
    for region in REGIONS:
        name = region.replace("_", " ")
        yield number(f"{region}_share", f"{name} share", "%", 1, 100, keys=("regions", region, "share"))
        yield number(f"{region}_psnr_db", f"PSNR {name}", "dB", 2, keys=("regions", region, "psnr_db"))
        yield number(f"{region}_flip", f"FLIP {name}", "", 3, keys=("regions", region, "flip"))
    yield from (*RATED, *map(text, ("client", "lacks", "baseline")))
    yield from (text(name, value=at("machine", name)) for name in ("gl_renderer", "gl_version"))
    yield from (number("cpu_count", keys=("machine", "cpu_count"), kind=int), text("host", value=at("machine", "host")))
    yield text("hmdwarp")
    for name in ("commit", "options", "numpy", "moderngl"):
        yield text(name, value=at("made_with", name, default=""))


COLUMNS = by_name(_columns())


def measure_label(measure: str) -> str:
    """Return the name of a metric with its unit and the direction in which it is better."""
    metric = metrics.get(measure)
    figure, better = metric.short_figure, "higher" if metric.higher_is_better else "lower"
    return f"{figure.label}{f' in {figure.unit}' if figure.unit else ''}, {better} is better"


_RANKS = {metric.name: metric.bench_rank for metric in metrics_in_order() if metric.bench_rank is not None}
_TIMES = ("total_ms", "total_ms_p95")
_DECISION = ("warp", "fill", *_TIMES, *(f"{name}{end}" for name in _RANKS for end in ("", "_spread")))
# The terminal has those that fit beside a long name in 80 columns.
_OF_TERMINAL = ("warp", "fill", "total_ms", PRIMARY, f"{PRIMARY}_spread", "psnr_db", "ssim", "hole_share")


def decision(rows: Iterable[Row], names: Sequence[str] = _DECISION) -> list[Column]:
    """Return the columns to decide from, and JOD where any row was rated."""
    return [COLUMNS[name] for name in (*names, *([JOD.name] if any("jod" in row for row in rows) else []))]


def bench_table(rows: Iterable[Row]) -> TerminalTable:
    """Return all rows for the terminal, case by case, the least error first; a star: the front."""
    rows = list(rows)
    groups = cases(rows)
    heading = groups[0].label if len(groups) == 1 else f"{len(groups)} cases"
    clocks = sorted({{"gpu": "GPU timers", "wall": "wall clock"}.get(row.get("clock", ""), "?") for row in rows})
    caption = (
        f"ordered by {measure_label(PRIMARY)}; {marked_how(rows)}; bold: best of its column, ties too\n"
        f"±: 95 % interval of the mean; time: median per eye, {', '.join(clocks)}"
    )
    columns, title = decision(rows, _OF_TERMINAL), ", ".join([heading, *common(rows)])
    return terminal_of(columns, groups, has_marks=True, title=title, caption=caption)


def marked_how(rows: Iterable[Row], mark: str = "*") -> str:
    """Return what the mark says, or why no row has one."""
    if all(row["quality"][PRIMARY].get("interval") is None for row in rows):
        return f"no {mark}: intervals need {LEAST_INSTANTS} instants"
    return f"{mark}: no other is both quicker and better, by the 95 % interval of the difference"
