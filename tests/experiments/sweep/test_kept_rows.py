"""Rows that stay on the disk: what they are, how they are written, and what they do not hold."""

from __future__ import annotations

import gc
import json
import subprocess
import sys
import tracemalloc
from pathlib import Path

from hmdwarp.experiments.sweep import KeptOptions, Result, Separate, SweepCase, run_cases
from hmdwarp.report import write_csv, write_json

ROWS, TEXT = 4, "a picture's figures " * 500  # 40 kB a case


def _swept(out, count: int, rows: int = ROWS, text: str = ""):
    def run(case, step):
        if case.what % 3 == 2:
            return Result({"other": 1})
        return Result({"rows": [{"case": case.what, "row": row, "text": f"{text}{row}"} for row in range(rows)]})

    cases = [SweepCase.of("rows", f"number {number}", number) for number in range(count)]
    return run_cases(Separate(run), cases, out, KeptOptions())


def _rows(swept):
    return swept.rows(lambda result: result.get("rows", ()))


def test_rows_keep_the_order_of_the_cases(tmp_path):
    rows = _rows(_swept(tmp_path, 7, rows=2))
    wanted = [{"case": case, "row": row, "text": str(row)} for case in (0, 1, 3, 4, 6) for row in (0, 1)]
    assert [*rows] == wanted and len(rows) == 10
    assert [rows[number] for number in range(-10, 10)] == wanted * 2
    assert rows[2:5] == wanted[2:5] and rows[::-3] == wanted[::-3]
    assert not _rows(_swept(tmp_path / "none", 0))


def test_rows_on_the_disk_are_written_as_a_list_is(tmp_path):
    rows = _rows(_swept(tmp_path, 4, rows=2, text="two\nlines, \u00fc "))
    for found in (rows, _rows(_swept(tmp_path / "none", 0))):
        for content in ({"rows": found}, {"first": {"a": [1, {}]}, "rows": found, "last": []}):
            write_json(tmp_path / "rows.json", content)
            plain = {**content, "rows": [*found]}
            assert json.loads((tmp_path / "rows.json").read_bytes()) == plain
            write_json(tmp_path / "plain.json", plain)
            assert (tmp_path / "rows.json").read_bytes() == (tmp_path / "plain.json").read_bytes()


def test_a_run_does_not_hold_the_rows_of_its_cases(tmp_path):
    """What grows with a case is its description, of about 1 kB, not its result of 40 kB.

    In a process of its own: what other tests keep and log is not counted.
    """
    command = [sys.executable, __file__, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    few, many, of_few, of_many = map(int, done.stdout.split())
    assert (of_many - of_few) / (many - few) < 4_000


def _peak(folder: Path, count: int) -> int:
    """Bytes that so many cases and their files take at most."""
    gc.collect()
    tracemalloc.start()
    rows = _rows(_swept(folder / str(count), count, text=TEXT))
    write_json(folder / "rows.json", {"rows": rows})
    write_csv(folder / "rows.csv", rows, ("case", "row", "text"))
    found = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return found


if __name__ == "__main__":
    FEW, MANY = 20, 120
    _peak(Path(sys.argv[1]) / "before", 2 * MANY)  # imports, caches, Python's table of texts
    print(FEW, MANY, *(_peak(Path(sys.argv[1]), count) for count in (FEW, MANY)))
