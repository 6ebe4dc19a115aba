"""The rows of bench.json, and the table as bench.csv and bench.parquet."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import reduce
from operator import add, itemgetter
from pathlib import Path
from typing import Any

import attrs

from ...client.capability import lacking
from ...client.classes import Client
from ...metrics import (
    PRIMARY,
    QUALITY,
    TRUTH_JOD,
    Mismatch,
    QualityPool,
    at_instants,
    blocks_text,
    db_of,
    metrics,
    pooled,
)
from ...report.bench.rows import COLUMNS, Columns, cases, row_name, table_of
from ...resources import __version__, import_extra
from ...run.combinations import ORACLE, Case, Combination
from ...run.replay_setup import ReplayRun
from ...run.run_summary import summary_of_rows
from ...run.side_by_side import Measured
from ..sweep import MOST_SHOWN
from .cases import baselines

OUTSIDE_LACKS = "it is another library's, run on the CPU to compare with"
ORACLE_LACKS = "it knows the depth of the truth, which no client has"
# Keys of a row that grow with its pictures.
LONG = ("at_instants", "blocks", "jod", "jod_failure")
# What a notebook shows of each row.
_SHOWN = ("trace", "scene", "latency_ms", "strategy", "warp", "fill", "flip", "psnr_db", "ssim", "total_ms")
OF_NOTEBOOK = tuple(COLUMNS[name] for name in _SHOWN)
# The columns of bench.csv.
NAMES = [column.name for column in COLUMNS.values() if column.is_filed]


def row_of(setup: ReplayRun, case: Case, measured: Measured, pool: QualityPool, client: Client) -> dict[str, Any]:
    """Return one row of bench.json.

    It has the keys of summary.json, the error by region, the eyes' mismatch, the pictures in few
    numbers, the strategy where it was asked for as one, why the client cannot run it ("" if it
    can), and the system that the warp stands for as a baseline ("" if none).
    """
    combination = measured.combination
    # Nothing without an oracle.
    pixels, seen, error = (math.fsum(column) for column in zip((0, 0, 0.0), *measured.where_seen, strict=True))
    figures, regions = pool.results, pool.regions
    pictures = [{"frame": key[3], **figures[key]} for key in measured.keys]
    passes = combination.warp, combination.fill, combination.plan.lens.name
    base = summary_of_rows(setup, passes, [*measured.times, *pictures])
    return {
        **base,
        "latency_ms": case.latency_ms,  # of the whole way, with a proxy too
        **({"strategy": combination.strategy} if combination.strategy else {}),
        "frames": len(pictures),
        "client": client.name,
        "lacks": _lacks(combination, client),
        "baseline": baselines().get(combination.warp, ""),
        "at_instants": {
            name: {str(frame): value for frame, value in at_instants(pictures, name).items()} for name in QUALITY
        },
        "blocks": {str(frame): blocks_text(blocks) for frame, blocks in measured.blocks.items()},
        "regions": pooled(regions[key] for key in measured.keys),
        **({"where_seen": {"share": seen / pixels, "psnr_db": db_of(error / seen)}} if seen else {}),
        "mismatch": reduce(add, measured.mismatch, Mismatch()).share,
    }


def _lacks(combination: Combination, client: Client) -> str:
    if combination.is_outside:
        return ORACLE_LACKS if combination.warp == ORACLE else OUTSIDE_LACKS
    return lacking(combination.plan, client)


def flat(rows: Iterable[Row], columns: Columns) -> Iterator[dict[str, Any]]:
    """Yield the rows of a file under its columns."""
    filed = [column for column in columns.values() if column.is_filed]
    return ({column.name: column.value(row) for column in filed} for row in rows)


def typed(rows: Iterable[Row], columns: Columns) -> Iterator[dict[str, Any]]:
    """Yield them with the types of the columns; None where a number is not known."""
    for row in flat(rows, columns):
        yield {name: None if value is None else columns[name].kind(value) for name, value in row.items()}


def about_rating(clip_s: float, rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return what a bench says of its JOD, nothing where it has none. rows: all of it."""
    failures = list(dict.fromkeys(row["jod_failure"] for row in rows if "jod_failure" in row))
    display = next((row["jod"]["display"] for row in rows if "jod" in row), None)
    if not clip_s or display is None:
        return failures
    return [
        *failures,
        f"JOD by ColorVideoVDP, where {TRUTH_JOD:g} is like the truth: of clips of {clip_s:g} s that end at each "
        f"instant, before the lens, at {display['rate_hz']:g} Hz, {display['pixels_per_degree']:.1f} pixels per degree "
        f"and {display['peak_cd_m2']:g} cd/m2. Predicted from the pictures: no one was asked.",
    ]


def check_parquet() -> None:
    """Check that Parquet can be written, before a long run. Errors: MachineError."""
    import_extra("pyarrow.parquet", "pyarrow", "study")


def write_parquet(path: Path, rows: Iterable[Mapping[str, Any]]) -> None:
    """Write rows as a table: texts, whole numbers and numbers; null for what is not known.

    Errors: MachineError where pyarrow is missing; OSError.
    """
    pa = import_extra("pyarrow", "pyarrow", "study")
    parquet = import_extra("pyarrow.parquet", "pyarrow", "study")
    kinds = {str: pa.string(), int: pa.int64(), float: pa.float64()}
    fields = [(column.name, kinds[column.kind]) for column in COLUMNS.values() if column.is_filed]
    schema = pa.schema(fields, metadata={"made_by": f"hmdwarp {__version__}"})
    with parquet.ParquetWriter(path, schema) as writer:
        rows = typed(rows, COLUMNS)
        while group := list(itertools.islice(rows, 10_000)):  # what is in memory at once
            writer.write_table(pa.Table.from_pylist(group, schema=schema))


class Rows(list[dict[str, Any]]):
    """The rows of a bench by the columns of bench.csv: texts, numbers, None for what is unknown."""

    def __repr__(self) -> str:
        return f"<Rows: {len(self)} of a bench; to_pandas() returns the table>"

    def _repr_html_(self) -> str:
        """Return the first rows, a notebook shows them."""
        columns = [attrs.evolve(one, value=itemgetter(one.name), shown=None) for one in OF_NOTEBOOK]
        return table_of("", columns, self[:MOST_SHOWN]).html()

    def to_pandas(self) -> Any:
        """Return a pandas.DataFrame with one row for each. Errors: MachineError without pandas."""
        frame = import_extra("pandas", "pandas", "study").DataFrame(list(self), columns=NAMES)
        kinds = {int: "Int64", float: "float64"}  # Int64 may lack a value, int64 may not
        return frame.astype({name: kinds[COLUMNS[name].kind] for name in NAMES if COLUMNS[name].is_number})


Row = Mapping[str, Any]


def left_out_notes(rows: Sequence[Row], client: Client) -> list[str]:
    """Return which methods the front and the choice leave out, and what they would gain.

    rows: of bench.json. Empty if the client can run all of them.
    """
    rows = [row for row in rows if row["warp"] != ORACLE]
    lacking = [row for row in rows if row["lacks"]]
    if not lacking:
        return []

    def figures(row: Row) -> str:
        total = row["time_ms"]["total"]["median"]
        return f"{metrics.get(PRIMARY).short_figure.label} {row['quality'][PRIMARY]['mean']:.3f} in {total:.2f} ms"

    names = ", ".join(dict.fromkeys(map(row_name, lacking)))
    notes = [f"Not in the front: client '{client.name}' ({client.summary}) cannot run {names}. --client names another."]
    for case in cases(rows):
        ordered = [row for row in case.ordered() if row["quality"][PRIMARY]["mean"] is not None]
        best = next((row for row in ordered if not row["lacks"]), None)
        if best is not None and ordered[0]["lacks"]:
            gain = f"{case.label}: a client that can run {row_name(ordered[0])} would have {figures(ordered[0])}"
            notes.append(f"{gain}, where {row_name(best)} has {figures(best)}; {ordered[0]['lacks']}.")
    return notes
