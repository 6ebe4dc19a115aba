"""The table as Parquet says what the table says, with types."""

from __future__ import annotations

import csv
from pathlib import Path

import attrs
import pytest

from hmdwarp.experiments.bench import MergeOptions, bench, merge
from hmdwarp.experiments.bench.bench_rows import NAMES
from hmdwarp.report.bench.rows import COLUMNS

from .test_bench_cases import TINY

parquet = pytest.importorskip("pyarrow.parquet")
PAGE = Path(__file__).resolve().parents[3] / "docs" / "scale.md"


def test_it_holds_the_table(tmp_path):
    options = attrs.evolve(TINY, recordings=("walk",), start_s=0.2, parquet=True)
    parts = []
    for latency in TINY.latencies_ms:
        parts.append(tmp_path / f"{latency:g}")
        bench(attrs.evolve(options, latencies_ms=(latency,), out=parts[-1]))
    merge(MergeOptions(folders=tuple(parts), out=tmp_path / "both", parquet=True))
    table = parquet.read_table(tmp_path / "both" / "bench.parquet")
    assert table.column_names == NAMES
    with (tmp_path / "both" / "bench.csv").open(encoding="utf-8", newline="") as file:
        written = list(csv.DictReader(file))
    assert len(written) == 2
    for row, texts in zip(table.to_pylist(), written, strict=True):
        for name, text in texts.items():
            value = row[name]
            assert (value in (None, "")) if text == "" else type(value)(text) == value, name


def test_the_page_describes_every_column():
    """By its name, or by the pattern of names that its row has."""
    page = PAGE.read_text(encoding="utf-8")
    told = page[page.index("| column |") :].split("\n\n")[0]
    for name in (name for name in NAMES if COLUMNS[name].kind is not float):
        assert f"`{name}`" in told, name
