"""The rows of a bench as Parquet, for pandas, DuckDB and the like."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ...resources import __version__, import_extra
from .bench_rows import COLUMNS, TEXTS, WHOLE

_ROWS = 10_000  # of a group: what is in memory at once


def check_parquet() -> None:
    """Check that Parquet can be written, before a long run. Errors: MachineError."""
    import_extra("pyarrow.parquet", "pyarrow", "study")


def write_parquet(path: Path, rows: Iterable[Mapping[str, Any]]) -> None:
    """Write rows under COLUMNS: texts, whole numbers and numbers; null for what is not known.

    Errors: MachineError where pyarrow is missing; OSError.
    """
    pa = import_extra("pyarrow", "pyarrow", "study")
    parquet = import_extra("pyarrow.parquet", "pyarrow", "study")
    types = {**dict.fromkeys(TEXTS, pa.string()), **dict.fromkeys(WHOLE, pa.int64())}
    fields = [(name, types.get(name, pa.float64())) for name in COLUMNS]
    schema = pa.schema(fields, metadata={"made_by": f"hmdwarp {__version__}"})
    with parquet.ParquetWriter(path, schema) as writer:
        rows = iter(rows)
        while group := list(itertools.islice(rows, _ROWS)):
            writer.write_table(pa.Table.from_pylist([_typed(row) for row in group], schema=schema))


def _typed(row: Mapping[str, Any]) -> dict[str, Any]:
    return {name: _value(name, row.get(name)) for name in COLUMNS}


def _value(name: str, value: Any) -> Any:
    if name in TEXTS:
        return None if value is None else str(value)
    if value is None or value == "":
        return None
    return int(value) if name in WHOLE else float(value)
