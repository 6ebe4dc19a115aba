"""The tables of a study's analysis, as text, for the page, the terminal and CSV files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..words import interval, p_text, pair_text, plain, signed

Row = Mapping[str, Any]
Heads = tuple[tuple[str, str], ...]

CONDITION_COLUMNS = (
    "scale", "part", "condition", "reference", "n", "missing", "median", "mean", "low", "high", "sd", "q1", "q3",
    "least", "most",
)  # fmt: skip
COMPARISON_COLUMNS = (
    "scale", "part", "family", "condition", "baseline", "n", "better", "equal", "worse", "mean", "sd", "median",
    "w_plus", "w_minus", "p", "smallest_p", "holm", "holm_of", "holm_all", "holm_all_of",
    "rank_biserial", "shift", "shift_low", "shift_high", "shift_level", "low", "high",
)  # fmt: skip
RATING_COLUMNS = ("scale", "part", "participant", "condition", "value")
DIFFERENCE_COLUMNS = ("scale", "part", "condition", "baseline", "participant", "difference")
SCORE_COLUMNS = (
    "part", "scale", "condition", "reference", "jod", "low", "high", "preferred", "other_preferred", "neither",
)  # fmt: skip
PREFERENCE_COLUMNS = (
    "part", "scale", "family", "condition", "baseline", "people", "for", "against", "neither", "jod", "low", "high",
    "share", "share_low", "share_high", "p", "holm", "holm_of",
)  # fmt: skip
MISSING_COLUMNS = ("scale", "part", "participant", "session", "condition", "why")


def condition_lines(rows: Iterable[Row], mean_name: str) -> tuple[Heads, list[list[str]]]:
    """Return the heads and cells of the table of a part's conditions."""
    names = ("condition", "n", "missing", "median", mean_name, "95 %", "sd", "quartiles")
    lines = []
    for row in rows:
        counts = [str(row["n"]), str(row["missing"])]
        middle = [plain(row["median"]), plain(row["mean"]), _range(row["low"], row["high"]), plain(row["sd"])]
        lines.append([condition_text(row), *counts, *middle, _range(row["q1"], row["q3"])])
    return tuple((name, "") for name in names), lines


def condition_text(row: Row) -> str:
    """Return a condition's name, marked as the hidden reference unless the name says so."""
    unmarked = not row["reference"] or "reference" in row["condition"].lower()
    return row["condition"] if unmarked else f"{row['condition']} (reference)"


def _range(low: float | None, high: float | None) -> str:
    return "–" if low is None else f"{plain(low)} .. {plain(high)}"


def comparison_lines(rows: Sequence[Row]) -> tuple[Heads, list[list[str]]]:
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


def felt_lines(rows: Iterable[Row]) -> tuple[Heads, list[list[str]]]:
    """Return the heads and cells of the table of questionnaires."""
    names = ("score", "pairs", "before", "after", "change", "exact interval", "exact p")
    heads = tuple((name, "median" if name in ("before", "after") else "") for name in names)
    lines = []
    for row in rows:
        middle = [plain(row["before"], 1), plain(row["after"], 1), signed(row.get("change"), 1)]
        exact = _exact(row.get("low"), row.get("high"), row.get("level"), 1)
        lines.append([f"{row['scale']} {row['score']}", str(row["n"]), *middle, exact, p_text(row.get("p"))])
    return heads, lines


def once_lines(rows: Iterable[Row]) -> tuple[Heads, list[list[str]]]:
    """Return the heads and cells of the table of questionnaires that were answered once."""
    names = ("score", "answers", "lower quartile", "median", "upper quartile", "possible")
    lines = []
    for row in rows:
        quartiles = [plain(row[name], 2) for name in ("low_quartile", "median", "high_quartile")]
        possible = "–" if row["least"] is None else f"{row['least']:g} to {row['most']:g}"
        name = f"{row['scale']} {row['when']}: {row['score_title']}"
        lines.append([name, str(row["n"]), *quartiles, possible])
    return tuple((name, "") for name in names), lines


def score_lines(rows: Iterable[Row]) -> tuple[Heads, list[list[str]]]:
    """Return the heads and cells of the table of a part's scores, the best condition first."""
    heads = (
        ("condition", ""),
        ("score", "JOD"),
        ("95 %", ""),
        ("preferred", ""),
        ("other preferred", ""),
        ("neither", ""),
    )
    lines = [
        [
            condition_text(row),
            signed(row["jod"]),
            interval(row["low"], row["high"]),
            *(str(row[name]) for name in ("preferred", "other_preferred", "neither")),
        ]
        for row in sorted(rows, key=lambda row: -row["jod"])
    ]
    return heads, lines


def preference_lines(rows: Iterable[Row]) -> tuple[Heads, list[list[str]]]:
    """Return the heads and cells of the table of compared pairs."""
    names = ("compared", "answers +/0/-", "JOD", "95 %", "would choose it", "exact p", "Holm")
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
    return tuple((name, "") for name in names), lines


def _named(part: Row, row: Row, columns: Sequence[str]) -> dict[str, Any]:
    own = {"part": part["part"], "scale": part["scale"], **row}
    return {key: own[key] for key in columns}


def csv_tables(data: Row) -> dict[str, tuple[Sequence[str], list[dict[str, Any]]]]:
    """Return (columns, rows) by file name: every number of the analysis, unrounded."""
    conditions: list[dict[str, Any]] = []
    comparisons: list[dict[str, Any]] = []
    ratings: list[dict[str, Any]] = []
    differences: list[dict[str, Any]] = []
    missing: list[dict[str, Any]] = []
    for scale in data["scales"]:
        named = {"scale": scale["measure"]["name"]}
        for part in scale["parts"]:
            for row in part["conditions"]:
                own = named | {"part": part["part"], "condition": row["condition"]}
                conditions.append({key: (row | own).get(key) for key in CONDITION_COLUMNS})
                ratings += [own | {"participant": who, "value": value} for who, value in row["ratings"].items()]
        for row in scale["comparisons"]:
            comparisons.append({key: row[key] for key in COMPARISON_COLUMNS})
            own = named | {key: row[key] for key in ("part", "condition", "baseline")}
            differences += [
                own | {"participant": who, "difference": value} for who, value in row["differences"].items()
            ]
        missing += [named | row for row in scale["missing"]]
    parts = data["preferences"]
    scores = [_named(part, row, SCORE_COLUMNS) for part in parts for row in part["conditions"]]
    preferences = [_named(part, row, PREFERENCE_COLUMNS) for part in parts for row in part["comparisons"]]
    paired = {"jod.csv": (SCORE_COLUMNS, scores), "preferences.csv": (PREFERENCE_COLUMNS, preferences)}
    return (paired if parts else {}) | {
        "conditions.csv": (CONDITION_COLUMNS, conditions),
        "comparisons.csv": (COMPARISON_COLUMNS, comparisons),
        "ratings.csv": (RATING_COLUMNS, ratings),
        "differences.csv": (DIFFERENCE_COLUMNS, differences),
        "missing.csv": (MISSING_COLUMNS, missing),
    }
