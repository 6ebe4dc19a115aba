"""compare.html: strategies beside each other, on a page that loads nothing from the network."""

from __future__ import annotations

import base64
import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..metrics import JOD, PRIMARY, TRUTH_PREFERRED, Figure, metrics, pareto, ratings_of
from .named_points import MARKER_PT, axes_in, draw_front, draw_names, scale_axis, scatter_figure
from .parts import CLOCK_NAMES, Cell, Line, PageChart, PageTable, environment
from .pictures import jpeg_bytes
from .source_texts import source_facts
from .style import PAGE, css_variables, drawing, dress, not_measured, svg_text
from .tables import axes_of_traces

if TYPE_CHECKING:
    from rich.table import Table

Row = Mapping[str, Any]
# Loads what was shown, and the truth.
Pictures = Callable[[], tuple[NDArray, NDArray]]

_PICTURE_WIDTH = 420
_WIDTH_IN, _HEIGHT_IN = 4.7, 3.3


@attrs.frozen
class _Column:
    figure: Figure
    value: Callable[[Row], float | None]

    @property
    def head(self) -> tuple[str, str]:
        return self.figure.label, self.figure.unit

    def text(self, row: Row) -> str:
        return self.figure.text(self.value(row))


def _quality(name: str) -> _Column:
    return _Column(metrics.get(name).short_figure, lambda row: row["quality"][name]["mean"])


def _rated(figure: Figure) -> _Column:
    return _Column(figure, lambda row: ratings_of(row)[figure.name])


def _taken(name: str, label: str, unit: str, digits: int, scale: float = 1.0) -> _Column:
    return _Column(Figure(name, label, unit, digits, scale), lambda row: row[name])


COLUMNS = {
    column.figure.name: column
    for column in (
        _quality("flip"),
        _quality("psnr_db"),
        _quality("flicker"),
        _quality("hole_share"),
        _taken("client_ms", "client", "ms an eye", 1),
        _taken("server_ms", "server", "ms", 0),
        _taken("mbit_s", "link", "Mbit/s", 1),
        _taken("up_mbit_s", "poses back", "Mbit/s", 2),
        _taken("start_bytes", "before the first frame", "MB", 1, 1e-6),
        _taken("client_bytes", "held", "MB", 0, 1e-6),
    )
}
# Where ColorVideoVDP rated the clips.
RATED = tuple(_rated(figure) for figure in (JOD, TRUTH_PREFERRED))
# What a front is drawn over: the error against each of these.
COSTS = ("client_ms", "mbit_s")


def render_compare_page(data: Mapping[str, Any], pictures: Sequence[Pictures]) -> str:
    """Return the text of the page from the content of compare.json.

    data: also `cases`, how many there are where `rows` are the first of more. pictures: of each
    row. All text from the data is escaped.
    """
    rows: list[Row] = list(data["rows"])
    return environment().get_template("compare.html").render(
        count=len(data["strategies"]),
        facts=_facts(rows),
        command=data.get("command") or "",
        strategies=data["strategies"],
        notes=_notes(data),
        cases=[(label, _table(label, group), _strip(group, shown)) for label, group, shown in _cases(rows, pictures)],
        clients=[_client(client, rows) for client in data["clients"]],
        assigned=_assigned(data),
        clock=CLOCK_NAMES.get(data["clock"], data["clock"]),
        seconds=data["seconds"],
        machine=data["machine"],
        version=data["hmdwarp"],
        light=css_variables(dark=False),
        dark=css_variables(dark=True),
    )  # fmt: skip


def compare_table(rows: Iterable[Row]) -> Table:
    """Return the rows for the terminal, case by case, the least error first."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    shown = [COLUMNS[name] for name in ("flip", "psnr_db", "client_ms", "mbit_s", "start_bytes")]
    heads = {"start_bytes": "MB first", "mbit_s": "Mbit/s", "client_ms": "ms"}
    table = Table(box=SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("strategy")
    for column in shown:
        table.add_column(heads.get(column.figure.name, column.figure.label), justify="right", no_wrap=True)
    for label, group, _ in _cases(list(rows), []):
        table.add_section()
        table.add_row(Text(label, style="bold"))
        for row in _ordered(group):
            table.add_row(row["strategy"], *(column.text(row) for column in shown))
    return table


def _columns(rows: Iterable[Row]) -> list[_Column]:
    """Return the columns of a table: those of a rating only where every row has one."""
    return [*COLUMNS.values(), *(RATED if all("jod" in row for row in rows) else ())]


def compare_markdown(rows: Iterable[Row]) -> str:
    """Return the rows as a Markdown table, case by case, the least error first."""
    rows = list(rows)
    columns = _columns(rows)
    heads = ["case", "strategy", *(" ".join(filter(None, column.head)) for column in columns)]
    lines = ["| " + " | ".join(heads) + " |", "| --- | --- |" + " ---: |" * len(columns)]
    for label, group, _ in _cases(rows, []):
        for row in _ordered(group):
            cells = [label, f"`{row['strategy']}`", *(column.text(row) for column in columns)]
            lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def assigned_markdown(data: Mapping[str, Any]) -> str:
    """Return which classes can run what, as a Markdown table. data: as compare.json."""
    table = _assigned(data)
    lines = ["| " + " | ".join(label for label, _ in table.heads) + " |", "|" + " --- |" * len(table.heads)]
    for line in table.lines:
        lines.append("| " + " | ".join(cell.text for cell in line.cells) + " |")
    return "\n".join(lines) + "\n"


def chosen_markdown(data: Mapping[str, Any], links_mbit_s: Sequence[float]) -> str:
    """Return which strategy is best for whom at each latency, as a Markdown table.

    For each client of the comparison, over its own link and over links of these rates. Errors are
    means over the recordings; a strategy counts where it suits on all of them. data: as
    compare.json.
    """
    latencies = list(dict.fromkeys(row["latency_ms"] for row in data["rows"]))
    recordings = len({row["trace"] for row in data["rows"]})
    lines = ["| for whom | " + " | ".join(f"{latency:g} ms" for latency in latencies) + " |"]
    lines.append("| --- |" + " --- |" * len(latencies))
    for rate, client in itertools.product((None, *links_mbit_s), data["clients"]):
        who = client["summary"] if rate is None else f"over a link of {rate:g} Mbit/s"
        rows = [row for row in data["rows"] if not row["unfit"][client["name"]]]
        cells = [_best_of([row for row in rows if row["latency_ms"] == one], rate, recordings) for one in latencies]
        lines.append(f"| `{client['name']}`: {who} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _best_of(rows: Sequence[Row], link_mbit_s: float | None, recordings: int) -> str:
    """Return the strategy of the least error, with what it takes, as text.

    rows: of one latency. It is none where the link carries none on all recordings.
    """
    by_name: dict[str, list[Row]] = {}
    for row in rows:
        by_name.setdefault(row["strategy"], []).append(row)
    suited = [group for group in by_name.values() if len(group) == recordings]
    carried = [group for group in suited if link_mbit_s is None or max(map(_rate, group)) <= link_mbit_s]
    if not carried:
        least = min(suited, key=lambda group: max(map(_rate, group)), default=None)
        return (
            "none" if least is None else f"none; least: `{least[0]['strategy']}`, {max(map(_rate, least)):.1f} Mbit/s"
        )
    best = min(carried, key=lambda group: sum(map(_error, group)))
    flip, rate = (sum(map(value, best)) / len(best) for value in (_error, _rate))
    first_mb = max(row["start_bytes"] for row in best) * 1e-6
    first = f", {first_mb:.1f} MB first" if first_mb >= 0.05 else ""
    if first and link_mbit_s is not None:
        first += f": {8 * first_mb / link_mbit_s:.0f} s"
    return f"`{best[0]['strategy']}` (FLIP {flip:.3f}, {rate:.1f} Mbit/s{first})"


def _rate(row: Row) -> float:
    return float(row["mbit_s"])


def _label(row: Row) -> str:
    return f"{row['trace']}, {row['latency_ms']:g} ms"


def _cases(rows: Sequence[Row], pictures: Sequence[Pictures]) -> list[tuple[str, list[Row], list[Pictures]]]:
    """Return (label, rows, their pictures) of each recording and latency, and of each machine."""
    hosts = [row["machine"].get("host") for row in rows]
    on = [f", on {host}" if len({*hosts}) > 1 else "" for host in hosts]  # times of two are not comparable
    paired = [(_label(row) + where, row, shown) for row, where, shown in itertools.zip_longest(rows, on, pictures)]
    return [
        (label, [row for one, row, _ in paired if one == label], [shown for one, _, shown in paired if one == label])
        for label in dict.fromkeys(label for label, _, _ in paired)
    ]


def first_cases(rows: Iterable[Row], most: int) -> tuple[list[int], int]:
    """Return which rows are of the first cases, at most so many, and how many cases there are."""
    known: dict[tuple[str, Any], bool] = {}
    each = ((_label(row), row["machine"].get("host")) for row in rows)
    numbers = [number for number, case in enumerate(each) if known.setdefault(case, len(known) < most)]
    return numbers, len(known)


def _error(row: Row) -> float:
    error = row["quality"][PRIMARY]["mean"]
    return float("inf") if error is None else float(error)


def _ordered(rows: Iterable[Row]) -> list[Row]:
    return sorted(rows, key=_error)


def _facts(rows: Sequence[Row]) -> list[tuple[str, str]]:
    first = rows[0]
    link = first["link"]
    return [
        ("recordings", ", ".join(dict.fromkeys(row["trace"] for row in rows))),
        *((f"axes of {trace}", axes) for trace, axes in axes_of_traces(rows).items()),
        ("latencies", ", ".join(dict.fromkeys(f"{row['latency_ms']:g} ms" for row in rows))),
        *source_facts(first),
        ("an eye", "x".join(map(str, first["size"]))),
        ("codec", link["codec"]),
        ("refreshes a run", str(first["frames"])),
    ]


def _notes(data: Mapping[str, Any]) -> list[str]:
    notes = [f"{one['strategy']} is left out: {one['why']}." for one in data["left_out"]]
    shown = len(_cases(data["rows"], []))
    if data.get("cases", shown) > shown:
        notes.append(f"This page shows the first {shown} of {data['cases']} cases; compare.csv and .json have all.")
    if data["clock"] != "gpu":
        notes.append(
            "No GPU: client times compare strategies with each other, and no class is measured by its budget of time."
        )
    return [*notes, *dict.fromkeys(note for row in data["rows"] for note in row["notes"])]


def _table(label: str, group: Sequence[Row]) -> PageTable:
    columns = _columns(group)
    lines = [Line((Cell(row["strategy"], False), *(Cell(one.text(row)) for one in columns))) for row in _ordered(group)]
    heads = (("strategy", ""), *(column.head for column in columns))
    return PageTable(f"{label}, least FLIP first", heads, tuple(lines))


def _strip(group: Sequence[Row], pictures: Sequence[Pictures]) -> list[tuple[str, str]]:
    """Return (caption, data URI) of the truth and of what each strategy shows."""
    by_row = sorted(zip(group, pictures, strict=True), key=lambda pair: _error(pair[0]))
    truth = [("what should be seen", _uri(by_row[0][1]()[1]))]
    return truth + [(f"{row['strategy']}: FLIP {COLUMNS[PRIMARY].text(row)}", _uri(load()[0])) for row, load in by_row]


def _uri(picture: NDArray) -> str:
    from PIL import Image

    small = Image.fromarray(picture)
    small.thumbnail((_PICTURE_WIDTH, _PICTURE_WIDTH), Image.Resampling.LANCZOS)
    return f"data:image/jpeg;base64,{base64.b64encode(jpeg_bytes(np.asarray(small))).decode()}"


def _client(client: Mapping[str, str], rows: Sequence[Row]) -> dict[str, Any]:
    """Return the fronts of one client: what it can run, case by case."""
    cases = []
    for label, group, _ in _cases(rows, []):
        can = [row for row in group if not row["unfit"][client["name"]]]
        cases.append((label, [_front(label, client["name"], can, cost) for cost in COSTS], _best(can)))
    return {**client, "cases": cases}


def _best(can: Sequence[Row]) -> str:
    if not can:
        return "It can run none of the strategies."
    best = _ordered(can)[0]
    parts = [f"{one.figure.label} {one.text(best)} {one.figure.unit}".strip() for one in COLUMNS.values()]
    return f"Least error: {best['strategy']} ({', '.join(parts[:2])}; {', '.join(parts[4:7])})."


def _front(label: str, client: str, rows: Sequence[Row], cost: str) -> PageChart:
    column = COLUMNS[cost]
    rows = [row for row in rows if row["quality"][PRIMARY]["mean"] is not None]
    best = pareto(rows, lambda row: (row["quality"][PRIMARY]["mean"], row[cost]))
    heading = f"error against {' '.join(column.head)}"
    names = ", ".join(row["strategy"] for row in sorted(best, key=lambda row: row[cost])) or "nothing it can run"
    words = f"{heading}, {client}, {label}. Front, from cheap to dear: {names}."
    content = [(row["strategy"], row["quality"][PRIMARY]["mean"], row[cost]) for row in rows]
    with drawing((label, client, cost, content)):
        figure = scatter_figure(_WIDTH_IN, _HEIGHT_IN)
        axes = axes_in(figure, (0.62, 0.5, _WIDTH_IN - 0.1, _HEIGHT_IN - 0.15))
        dress(axes, PAGE)
        axes.set_xlabel(" in ".join(filter(None, column.head)))
        axes.set_ylabel("FLIP, lower is better")
        if rows:
            _draw(axes, rows, best, cost)
        else:
            not_measured(axes, PAGE)
        return PageChart.of(heading, svg_text(figure), words)


def _draw(axes: Any, rows: Sequence[Row], best: Sequence[Row], cost: str) -> None:
    is_best = np.array([any(row is one for one in best) for row in rows])
    spent = scale_axis(axes.xaxis, np.array([float(row[cost]) for row in rows]), logarithmic=True)
    error = np.array([row["quality"][PRIMARY]["mean"] for row in rows])
    error = scale_axis(axes.yaxis, error, logarithmic=True)
    line = draw_front(axes, spent[is_best], error[is_best], PAGE, higher=False)
    for x, y, row, filled in zip(spent, error, rows, is_best, strict=True):
        colour = PAGE.warp(row["warp"])
        shown = colour if filled else "none"
        axes.plot(x, y, marker="o", markersize=MARKER_PT, color=colour, markerfacecolor=shown, clip_on=False, zorder=3)
    names = {row["strategy"]: [number] for number, row in enumerate(rows)}
    draw_names(axes, names, np.stack([spent, error], axis=1), is_best, line, PAGE)


def _assigned(data: Mapping[str, Any]) -> PageTable:
    """Return which classes the thesis gives each strategy, which can run it here, and why not."""
    lines = []
    for strategy in data["strategies"]:
        rows = [row for row in data["rows"] if row["strategy"] == strategy["name"]]
        names = [client["name"] for client in data["clients"]]
        can = [name for name in names if not any(row["unfit"][name] for row in rows)]
        why = [f"{name}: {next(row['unfit'][name] for row in rows if row['unfit'][name])}" for name in names
               if name not in can]  # fmt: skip
        texts = (strategy["name"], ", ".join(strategy["classes"]), ", ".join(can) or "none", "; ".join(why) or "–")
        lines.append(Line(tuple(Cell(text, False) for text in texts)))
    heads = (("strategy", ""), ("meant for", ""), ("can run it here", ""), ("what the others lack", ""))
    return PageTable("Strategies and classes of clients", heads, tuple(lines))
