"""The tables of a study's analysis, as text, for the page, the terminal and CSV files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..words import Heads, interval, p_text, pair_text, plain, signed

Row = Mapping[str, Any]
Lines = tuple[Heads, list[list[str]]]

# By file.
_CSV_COLUMNS = {
    "jod.csv": (
        "part", "scale", "condition", "reference", "jod", "low", "high", "preferred", "other_preferred", "neither",
    ),
    "preferences.csv": (
        "part", "scale", "family", "condition", "baseline", "people", "for", "against", "neither", "jod", "low", "high",
        "share", "share_low", "share_high", "p", "holm", "holm_of",
    ),
    "conditions.csv": (
        "scale", "part", "condition", "reference", "n", "missing", "median", "mean", "low", "high", "sd", "q1", "q3",
        "least", "most",
    ),
    "comparisons.csv": (
        "scale", "part", "family", "condition", "baseline", "n", "better", "equal", "worse", "mean", "sd", "median",
        "w_plus", "w_minus", "p", "smallest_p", "holm", "holm_of", "holm_all", "holm_all_of",
        "rank_biserial", "shift", "shift_low", "shift_high", "shift_level", "low", "high",
    ),
    "ratings.csv": ("scale", "part", "participant", "condition", "value"),
    "differences.csv": ("scale", "part", "condition", "baseline", "participant", "difference"),
    "missing.csv": ("scale", "part", "participant", "session", "condition", "why"),
}  # fmt: skip


def condition_lines(rows: Iterable[Row], mean_name: str) -> Lines:
    """Return the heads and cells of the table of a part's conditions."""
    names = ("condition", "n", "missing", "median", mean_name, "95 %", "sd", "quartiles")
    return _heads(*names), [
        [
            condition_text(row),
            str(row["n"]),
            str(row["missing"]),
            plain(row["median"]),
            plain(row["mean"]),
            _range(row["low"], row["high"]),
            plain(row["sd"]),
            _range(row["q1"], row["q3"]),
        ]
        for row in rows
    ]


def condition_text(row: Row) -> str:
    """Return a condition's name, marked as the hidden reference unless the name says so."""
    unmarked = not row["reference"] or "reference" in row["condition"].lower()
    return row["condition"] if unmarked else f"{row['condition']} (reference)"


def _heads(*names: str, **units: str) -> Heads:
    return [(name, units.get(name, "")) for name in names]


def _range(low: float | None, high: float | None) -> str:
    return "–" if low is None else f"{plain(low)} .. {plain(high)}"


def comparison_lines(rows: Sequence[Row]) -> Lines:
    """Return the heads and cells of the table of comparisons, as a paper prints it."""
    heads = (
        ("compared", ""), ("pairs", "+/0/-"), ("mean", ""), ("BCa 95 %", ""), ("shift", ""),
        ("exact interval", ""), ("W+/W-", ""), ("exact p", ""), ("Holm", "family"), ("Holm", "all"), ("r", ""),
    )  # fmt: skip
    return heads, [_comparison(row) for row in rows]


def _comparison(row: Row) -> list[str]:
    name = ": ".join([*filter(None, [row["part"]]), pair_text(row["baseline"], row["condition"])])
    if not row["n"]:
        return [name, "0", *["–"] * 9]
    return [
        name,
        pairs_text(row),
        signed(row["mean"], 3),
        interval(row["low"], row["high"]),
        signed(row["shift"]),
        _exact(row["shift_low"], row["shift_high"], row["shift_level"]),
        f"{row['w_plus']:g}/{row['w_minus']:g}",
        p_text(row["p"]),
        p_text(row["holm"]),
        p_text(row["holm_all"]),
        signed(row["rank_biserial"]),
    ]


def _exact(low: float | None, high: float | None, level: float | None, digits: int = 2) -> str:
    """Return an interval with its true level: levels come in steps."""
    return interval(low, high, digits) + ("" if level is None else f" ({100 * level:.1f} %)")


def pairs_text(row: Row) -> str:
    """Return "12 (6/1/5)": pairs, of them rated better, the same, worse."""
    return f"{row['n']} ({row['better']}/{row['equal']}/{row['worse']})"


def felt_lines(rows: Iterable[Row]) -> Lines:
    """Return the heads and cells of the table of questionnaires."""
    names = ("score", "pairs", "before", "after", "change", "exact interval", "exact p")
    lines = []
    for row in rows:
        middle = [plain(row["before"], 1), plain(row["after"], 1), signed(row.get("change"), 1)]
        exact = _exact(row.get("low"), row.get("high"), row.get("level"), 1)
        lines.append([f"{row['scale']} {row['score']}", str(row["n"]), *middle, exact, p_text(row.get("p"))])
    return _heads(*names, before="median", after="median"), lines


def once_lines(rows: Iterable[Row]) -> Lines:
    """Return the heads and cells of the table of questionnaires that were answered once."""
    lines = []
    for row in rows:
        quartiles = [plain(row[name], 2) for name in ("low_quartile", "median", "high_quartile")]
        possible = "–" if row["least"] is None else f"{row['least']:g} to {row['most']:g}"
        name = f"{row['scale']} {row['when']}: {row['score_title']}"
        lines.append([name, str(row["n"]), *quartiles, possible])
    return _heads("score", "answers", "lower quartile", "median", "upper quartile", "possible"), lines


def score_lines(rows: Iterable[Row]) -> Lines:
    """Return the heads and cells of the table of a part's scores, the best condition first."""
    counts = ("preferred", "other_preferred", "neither")
    lines = [
        [
            condition_text(row),
            signed(row["jod"]),
            interval(row["low"], row["high"]),
            *(str(row[name]) for name in counts),
        ]
        for row in sorted(rows, key=lambda row: -row["jod"])
    ]
    return _heads("condition", "score", "95 %", "preferred", "other preferred", "neither", score="JOD"), lines


def preference_lines(rows: Iterable[Row]) -> Lines:
    """Return the heads and cells of the table of compared pairs."""
    lines = [
        [
            pair_text(row["baseline"], row["condition"]),
            f"{row['for']}/{row['neither']}/{row['against']}",
            signed(row["jod"]),
            interval(row["low"], row["high"]),
            f"{row['share']:.0%}",
            p_text(row["p"]),
            p_text(row["holm"]),
        ]
        for row in rows
    ]
    return _heads("compared", "answers +/0/-", "JOD", "95 %", "would choose it", "exact p", "Holm"), lines


def correlation_lines(measures: Iterable[Row]) -> Lines:
    """Return the heads and cells of the table of measures against the ratings."""
    return _heads("metric", "r", "95 %", "p", "df", r="within people"), [
        [row["title"], signed(row["r"]), interval(row["low"], row["high"]), p_text(row["p"]), str(row["dof"])]
        for row in measures
    ]


def csv_tables(data: Row) -> dict[str, tuple[Sequence[str], list[dict[str, Any]]]]:
    """Return (columns, rows) by file name: every number of the analysis, unrounded."""
    rows: dict[str, list[dict[str, Any]]] = {name: [] for name in _CSV_COLUMNS}

    def add(name: str, *entries: Row) -> None:
        whole = {key: value for entry in entries for key, value in entry.items()}
        rows[name].append({key: whole.get(key) for key in _CSV_COLUMNS[name]})

    for scale in data["scales"]:
        named = {"scale": scale["measure"]["name"]}
        for part in scale["parts"]:
            for row in part["conditions"]:
                own = named | {"part": part["part"]}
                add("conditions.csv", row, own)
                for who, value in row["ratings"].items():
                    add("ratings.csv", row, own, {"participant": who, "value": value})
        for row in scale["comparisons"]:
            add("comparisons.csv", row)
            for who, value in row["differences"].items():
                add("differences.csv", row, named, {"participant": who, "difference": value})
        for row in scale["missing"]:
            add("missing.csv", named, row)
    for part in data["preferences"]:
        for row in part["conditions"]:
            add("jod.csv", part, row)
        for row in part["comparisons"]:
            add("preferences.csv", part, row)
    absent = () if data["preferences"] else ("jod.csv", "preferences.csv")
    return {name: (columns, rows[name]) for name, columns in _CSV_COLUMNS.items() if name not in absent}
