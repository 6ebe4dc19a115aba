"""compare.html: strategies side by side; and the table for the terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..metrics import PRIMARY, pareto
from ..scenes import KNOWS
from . import page
from .bench.page import suite_section
from .bench.rows import (
    RATED,
    Case,
    Column,
    Conditions,
    by_name,
    cases,
    measure_label,
    metric_columns,
    table_of,
    terminal_of,
)
from .charts import Look, Spot, spots_chart
from .page import texts
from .run_texts import Table, axes_of_traces, counted, source_facts

if TYPE_CHECKING:
    from rich.table import Table as TerminalTable

Row = Mapping[str, Any]
# Loads what was shown, and the truth.
Pictures = Callable[[], tuple[NDArray[Any], NDArray[Any]]]

# What runs that can be compared share.
OF_COMPARE: Conditions = (
    ("trace", str),
    ("latency_ms", lambda v: f"{v:g} ms"),
    ("over", str),
    ("scene", str),
    ("machine", lambda v: f"on {v.get('host')}"),  # times of two are not comparable
)
_PICTURE_WIDTH = 420
_WIDTH_IN = 4.7


def _named(row: Row) -> str:
    """Return the strategy, and why it showed nothing over a link that let nothing through."""
    return f"{row['strategy']}: {row['nothing']}" if "nothing" in row else str(row["strategy"])


def _columns() -> Iterator[Column]:
    text, number = Column.of_text, Column.of_number
    yield from (text("trace"), text("scene"), number("latency_ms"), text("strategy", shown=_named))
    yield from (text("warp"), text("fill"), *metric_columns(intervals=False), *RATED)
    yield number("client_ms", "client", "ms an eye", 1)
    yield number("server_ms", "server", "ms")
    yield number("mbit_s", "link", "Mbit/s", 1)
    yield number("up_mbit_s", "poses back", "Mbit/s", 2)
    yield number("decoded_mpx_s")
    yield number("start_bytes", "before the first frame", "MB", 1, 1e-6)
    yield number("client_bytes", "held", "MB", 0, 1e-6)
    yield text("unfit", value=lambda row: "; ".join(f"{who}: {why}" for who, why in row["unfit"].items() if why))


COLUMNS = by_name(_columns())
# What a notebook shows of each row.
OF_NOTEBOOK = tuple(COLUMNS[name] for name in ["strategy", "flip", "psnr_db", "client_ms", "mbit_s", "start_bytes"])
_SHOWN = (
    *("flip", "psnr_db", "flicker", "hole_share", "client_ms", "server_ms", "mbit_s", "up_mbit_s"),
    *("start_bytes", "client_bytes"),
)
# What a front is drawn over: the error against each of these.
_COSTS = ("client_ms", "mbit_s")


def compare_page(data: Mapping[str, Any], pictures: Sequence[Pictures]) -> page.Page:
    """Return the page from compare.json; `cases`: of how many `rows` are the first."""
    rows: list[Row] = list(data["rows"])
    count, groups = len(data["strategies"]), cases(rows, OF_COMPARE)
    picture_of = {id(row): picture for row, picture in zip(rows, pictures, strict=True)}
    folds = []
    for number, group in enumerate(groups):
        table = table_of(f"{group.label}, least FLIP first", columns_of(group.rows), group.ordered())
        folds.append(
            page.Fold(group.label, [table, page.Group("panels", _strip(group, picture_of))], is_open=number == 0)
        )
    numbers = {strategy["name"]: number for number, strategy in enumerate(data["strategies"], 1)}
    clients = [_client(client, groups, numbers) for client in data["clients"]]
    about = "{first}{rest}. Crosses the link: {crosses}. Late: {late}. ({source})"
    strategies = [
        (one["name"], about.format(**one, first=one["summary"][0].upper(), rest=one["summary"][1:]))
        for one in data["strategies"]
    ]
    suite = data.get("suite")
    if suite is not None:  # names as its table has them: a strategy over a link
        lines = [{**one, "warp": f"{one['strategy']}, {one['over']}", "strategy": ""} for one in suite["over_all"]]
        suite = {**suite, "over_all": lines}
    first, several = rows[0], dict.fromkeys(row["scene"] for row in rows)
    lived = ", ".join(dict.fromkeys(f"({row['over']})" for row in rows if row.get("over")))
    facts = [
        ("recordings", ", ".join(dict.fromkeys(row["trace"] for row in rows))),
        *((f"axes of {trace}", axes) for trace, axes in axes_of_traces(rows).items()),
        ("latencies", ", ".join(dict.fromkeys(f"{row['latency_ms']:g} ms" for row in rows))),
        *([("scenes", ", ".join(several))] if len(several) > 1 else source_facts(first)),
        *([("links", lived)] if lived else []),
        ("an eye", "x".join(map(str, first["size"]))),
        ("codec", first["link"]["codec"]),
        ("each run", ran_text(rows)),
    ]
    notes = [f"{entry['strategy']} is left out: {entry['why']}." for entry in data["left_out"]]
    shown = len(cases(data["rows"], OF_COMPARE))
    if data.get("cases", shown) > shown:
        notes.append(f"This page shows the first {shown} of {data['cases']} cases; compare.csv and .json have all.")
    if data["clock"] != "gpu":
        notes.append(
            "No GPU: client times compare strategies with each other, and no class is measured by its budget of time."
        )
    if silent := [row for row in data["rows"] if "nothing" in row]:
        notes.append(
            f"{counted(len(silent), 'run')} showed nothing, as the link let no frame through in time: their figures "
            "are dashes, and no mean has them."
        )
    note = page.Text(texts("compare")["notes"]["assigned"])
    return page.Page(
        kind="compare",
        title=f"hmdwarp compare: {count} strategies",
        heading=("Strategies of remote rendering", f"{count} of them, {counted(len(groups), 'case')}"),
        facts=[page.fact(label, text) for label, text in facts],
        shared=[f"{label} {text}" for label, text in facts if label in ("scene", "an eye", "codec")],
        command=data.get("command") or "",
        sections=(
            suite_section(suite),
            page.notes_section([*notes, *dict.fromkeys(note for row in data["rows"] for note in row["notes"])]),
            page.Section("Tables and pictures", folds, id="table"),
            page.Section("By class of client", clients, id="clients"),
            page.Section("Who can run what", [note, _assigned_table(data)], id="assigned"),
            page.Section("The strategies", [page.Terms(strategies)], id="strategies", style="reading"),
            page.reading_section("compare"),
        ),
        made_with=[
            *page.machine_pairs(data["hmdwarp"], data["machine"], data["clock"]),
            ("Run in", page.minutes(data["seconds"])),
        ],
    )


def compare_table(rows: Iterable[Row]) -> TerminalTable:
    """Return the rows for the terminal, case by case, the least error first."""
    columns = [COLUMNS[name] for name in ("strategy", "flip", "psnr_db", "client_ms", "mbit_s", "start_bytes")]
    return terminal_of(columns, cases(rows, OF_COMPARE))


def columns_of(rows: Iterable[Row]) -> list[Column]:
    """Return the columns of a table: those of a rating only where every row that showed has one."""
    shown = [row for row in rows if "nothing" not in row]
    rated = shown and all("jod" in row for row in shown)
    return [COLUMNS[name] for name in ("strategy", *_SHOWN, *(("jod", "truth_preferred") if rated else ()))]


def ran_text(rows: Sequence[Row]) -> str:
    """Return how long runs are, of how many people and scenes, and what clients know of motion."""
    refreshes, pictures = (
        max(each)
        for each in zip(*((row["frames"], row.get("measured", {}).get(PRIMARY, 0)) for row in rows), strict=True)
    )
    people, scenes = (len({row[name] for row in rows}) for name in ("trace", "scene"))
    knows = "; ".join(f"what moves {KNOWS[name]}" for name in dict.fromkeys(row["client_motion"] for row in rows))
    return (
        f"{refreshes / rows[0]['rate_hz']:.1f} s, {refreshes} refreshes, {counted(pictures, 'picture')} measured, of "
        f"{counted(people, 'recorded head')} in {counted(scenes, 'scene')}; {knows}"
    )


def _strip(group: Case, picture_of: Mapping[int, Pictures]) -> list[page.Picture]:
    """Return the truth and what each strategy shows."""
    from PIL import Image

    strip: list[page.Picture] = []
    for row in (row for row in group.ordered() if "nothing" not in row):
        shown, truth = picture_of[id(row)]()
        pictures = [] if strip else [("what should be seen", truth)]
        for caption, picture in (*pictures, (f"{row['strategy']}: FLIP {COLUMNS[PRIMARY].text(row)}", shown)):
            small = Image.fromarray(picture)
            small.thumbnail((_PICTURE_WIDTH, _PICTURE_WIDTH), Image.Resampling.LANCZOS)
            strip.append(page.Picture(caption, page.data_uri(np.asarray(small)), caption))
    return strip


def _client(client: Mapping[str, str], groups: Sequence[Case], numbers: Mapping[str, int]) -> page.Article:
    """Return the fronts of one client: what it can run. numbers: of the strategies."""
    folds: list[page.Fold] = []
    for group in groups:
        can = Case(group.label, tuple(row for row in group.rows if not row["unfit"][client["name"]]))
        least = "It can run none of the strategies."
        for best in can.ordered()[:1]:
            columns = [COLUMNS[name] for name in ("flip", "psnr_db", "client_ms", "server_ms", "mbit_s")]
            parts = [f"{column.figure.label} {column.text(best)} {column.figure.unit}".strip() for column in columns]
            least = f"Least error: {best['strategy']} ({', '.join(parts[:2])}; {', '.join(parts[2:])})."
        charts = [_front(can, client["name"], cost, numbers) for cost in _COSTS]
        folds.append(page.Fold(group.label, [page.Group("charts", charts)], least, is_open=not folds))
    return page.Article([page.Heading(client["name"]), page.Text(client["summary"], ""), *folds], id=client["name"])


def _front(can: Case, client: str, cost: str, numbers: Mapping[str, int]) -> page.Chart:
    rows = [(row, row["quality"][PRIMARY]["mean"], row[cost]) for row in can.rows]
    rows = sorted((one for one in rows if one[1] is not None), key=lambda one: numbers[one[0]["strategy"]])
    best = pareto(rows, lambda one: one[1:])
    heading = f"error against {' '.join(COLUMNS[cost].head)}"
    names = ", ".join(row["strategy"] for row, _, _ in sorted(best, key=lambda one: one[2])) or "nothing it can run"
    words = f"{heading}, {client}, {can.label}. Front, from cheap to dear: {names}."
    spots, names_of = list[Spot](), dict[int, str]()
    for one in rows:
        row, error, value = one
        number = numbers[row["strategy"]]
        names_of[number] = row["strategy"]
        spots.append(Spot(value, [error] * 3, Look.of(number - 1), one in best, number))
    x, about = " in ".join(filter(None, COLUMNS[cost].head)), (can.label, client, cost, [one[1:] for one in rows])
    drawn = spots_chart(about, spots, names_of, x=x, y=measure_label(PRIMARY), width_in=_WIDTH_IN)
    return page.Chart.of(heading, drawn, words, "")


def _assigned_table(data: Mapping[str, Any]) -> Table:
    """Return which classes the thesis gives each strategy, which can run it here, and why not."""
    lines = []
    names = [client["name"] for client in data["clients"]]
    for strategy in data["strategies"]:
        rows = [row for row in data["rows"] if row["strategy"] == strategy["name"]]
        # A link that let nothing through says nothing of the clients, unless there is no other.
        rows = [row for row in rows if "nothing" not in row] or rows
        unfit = {name: next((row["unfit"][name] for row in rows if row["unfit"][name]), "") for name in names}
        can = [name for name, why in unfit.items() if not why]
        lacking = [f"{name}: {why}" for name, why in unfit.items() if why]
        meant = ", ".join(strategy["classes"])
        lines.append((strategy["name"], meant, ", ".join(can) or "none", "; ".join(lacking) or "–"))
    heads = [(head, "") for head in ("strategy", "meant for", "can run it here", "what the others lack")]
    return Table.of("Strategies and classes of clients", heads, lines, words=4)
