"""Tables of docs/strategies.md and docs/thesis.md, from compare.json and results.json."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from pages import markdown

from hmdwarp.metrics import PRIMARY
from hmdwarp.report.bench.rows import Column, cases, table_of
from hmdwarp.report.compare_page import COLUMNS, OF_COMPARE, columns_of
from hmdwarp.report.thesis_page import is_conditional, weak_text

Row = Mapping[str, Any]


def compare_markdown(rows: Iterable[Row]) -> str:
    """Return the rows as a Markdown table, case by case, the least error first."""
    rows = list(rows)
    groups, (_, *columns) = cases(rows, OF_COMPARE), columns_of(rows)
    label_of = {id(row): group.label for group in groups for row in group.rows}
    case = Column.of_text("case", value=lambda row: label_of[id(row)])
    quoted = Column.of_text(
        "strategy", value=lambda row: COLUMNS["strategy"].text(row).replace(row["strategy"], f"`{row['strategy']}`", 1)
    )
    ordered = (row for group in groups for row in sorted(group.rows, key=_error))
    return table_of("", [case, quoted, *columns], ordered).markdown()


def chosen_markdown(data: Mapping[str, Any], links_mbit_s: Sequence[float]) -> str:
    """Return which strategy is best for whom at each latency, as a Markdown table.

    For each client of the comparison, over its own link and over links of these rates. Errors are
    means over the recordings; a strategy counts where it suits on all of them. data: as
    compare.json.
    """
    latencies = list(dict.fromkeys(row["latency_ms"] for row in data["rows"]))
    recordings = len({row["trace"] for row in data["rows"]})
    lines = []
    for rate, client in itertools.product((None, *links_mbit_s), data["clients"]):
        who = client["summary"] if rate is None else f"over a link of {rate:g} Mbit/s"
        rows = [row for row in data["rows"] if not row["unfit"][client["name"]]]
        cells = [
            _best_of([row for row in rows if row["latency_ms"] == latency], rate, recordings) for latency in latencies
        ]
        lines.append([f"`{client['name']}`: {who}", *cells])
    heads = ["for whom", *(f"{latency:g} ms" for latency in latencies)]
    return markdown(heads, lines, texts=len(heads))


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


def _error(row: Row) -> float:
    error = row["quality"][PRIMARY]["mean"]
    return float("inf") if error is None else float(error)


def summary_markdown(results: Sequence[Mapping[str, Any]]) -> str:
    """Return names of claims that hold or cannot be told, and a table of the others."""
    experiments = {experiment["name"]: (experiment, data) for data in results for experiment in data["experiments"]}
    used = [data for _, data in experiments.values()]
    runs = [f"pictures of {'x'.join(map(str, data['size']))} on {data['machine']['gl_renderer']}" for data in used]
    heads, lines = ["claim", "ours", "rule", "verdict"], list[list[str]]()
    named: dict[str, list[str]] = {"holds": [], "cannot be told": []}
    for name, (one, _) in experiments.items():
        if one["verdict"] in named:
            named[one["verdict"]].append(f"`{name}`" + weak_text(one))
            continue
        where = f" ({one['holds_at'].partition(':')[0]})" if is_conditional(one) else ""
        claim, verdict = f"{one['claim']} ({one['source']})", one["verdict"] + weak_text(one) + where
        lines.append([text.replace("|", "/") for text in (claim, one["ours"] or "–", one["rule"], verdict)])
    made = f"hmdwarp {results[0]['hmdwarp']}; {' and '.join(dict.fromkeys(runs))}."
    told = "".join(f"\n{verdict.capitalize()}: {'; '.join(names) or '–'}." for verdict, names in named.items())
    return f"{made}{told}\n\n{markdown(heads, lines, texts=4)}"
