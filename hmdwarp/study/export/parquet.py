"""The table of ratings as Parquet: typed columns, missing ones as nulls, and what each column is as metadata."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...errors import MachineError
from ...version import __version__
from .columns import FLAG, NUMBER, WHOLE, Column

HOW = "pip install 'hmdwarp[study]'"


def has_parquet() -> bool:
    """Whether the package is there."""
    return importlib.util.find_spec("pyarrow") is not None


def write_parquet(path: Path, rows: Sequence[Mapping[str, Any]], columns: Sequence[Column], title: str) -> None:
    """Errors: MachineError where pyarrow is missing; OSError."""
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError as error:
        raise MachineError(f"Parquet is written by the package pyarrow, which is not installed: {HOW}") from error
    types = {NUMBER: pa.float64(), WHOLE: pa.int64(), FLAG: pa.bool_()}
    fields = [pa.field(c.name, types.get(c.type, pa.string()), metadata=_about(c)) for c in columns]
    about = {"title": title, "made_by": f"hmdwarp {__version__}", "missing": "null"}
    schema = pa.schema(fields, metadata=about)
    arrays = [
        pa.array([_plain(c, row.get(c.name)) for row in rows], field.type)
        for c, field in zip(columns, fields, strict=True)
    ]
    with path.open("wb") as file:
        # Not compressed: a search through the bytes sees what is in it.
        parquet.write_table(pa.Table.from_arrays(arrays, schema=schema), file, compression="none")


def _about(column: Column) -> dict[str, str]:
    told = {"description": column.description, "units": column.units}
    return {name: value for name, value in told.items() if value} | (
        {"levels": json.dumps(dict(column.levels))} if column.levels else {}
    )


def _plain(column: Column, value: Any) -> Any:
    if value is None or value == "":
        return None
    if column.type == NUMBER:
        return float(value)
    if column.type in (WHOLE, FLAG):
        return value
    return value if isinstance(value, str) else str(value)
