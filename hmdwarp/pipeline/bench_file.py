"""The rows of a bench.json, read apart from the levels: help texts load those, and no NumPy."""

from __future__ import annotations

from pathlib import Path

import attrs

from ..errors import InputError
from ..options.documents import json_in
from ..options.named_files import RESULTS
from ..report import SCHEMA, summary_faults
from .levels import Row


def read_rows(path: Path) -> list[Row]:
    """Return the rows of a bench.json, less those of strategies.

    Errors: InputError naming the file and its fault.
    """
    wanted = attrs.evolve(RESULTS, what="the bench.json that hmdwarp bench wrote")
    bench = json_in(path, wanted)
    if not isinstance(bench, dict) or not isinstance(bench.get("rows"), list):
        raise InputError(f"{path}: it has no list of 'rows'; expected the bench.json that hmdwarp bench wrote")
    if bench.get("schema") != SCHEMA:
        raise InputError(
            f"{path}: its schema is {bench.get('schema')!r}, this program reads {SCHEMA}: run hmdwarp bench again"
        )
    for number, row in enumerate(bench["rows"]):
        faults = summary_faults(row)
        if faults:
            raise InputError(f"{path}: row {number}: {'; '.join(faults)}")
    return [row for row in bench["rows"] if not row.get("strategy")]
