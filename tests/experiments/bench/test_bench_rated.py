"""JOD in a bench: of clips that end at its instants, and nothing else changes by it."""

from __future__ import annotations

import csv

import attrs
from ratings import crashing_torch, quiet, with_cvvdp  # noqa: F401  (a fixture)

from hmdwarp.experiments.bench import bench

from .test_bench_cases import TINY, untimed

PLAIN = attrs.evolve(
    TINY, warps=("forward", "rotation"), fills=("none", "memory"), latencies_ms=(200.0,), sizes=((96, 80),),
    recordings=("look-around",), headset="flat-90", seconds=0.5, guard=1.0, instants=2,
)  # fmt: skip
RATED = attrs.evolve(PLAIN, jod_s=8 / 60)


def unrated(rows: list[dict]) -> list[dict]:
    """Return rows without ratings and without the digest of options, which has that of --jod."""
    return [{key: row[key] for key in row if key not in ("jod", "made_with")} for row in untimed(rows)]


def test_a_crash_while_rating_costs_only_the_rating(tmp_path, crashing_torch):  # noqa: F811
    result = bench(attrs.evolve(RATED, fills=("none",), out=tmp_path / "out"))
    assert all("jod" not in row and row["quality"]["flip"]["mean"] > 0 for row in result.data["rows"])
    assert [note for note in result.data["notes"] if "JOD" in note] == [crashing_torch]


@with_cvvdp
@quiet
def test_all_else_stays_as_it_is_in_batches_of_any_size(tmp_path, monkeypatch):
    """Fills that remember see the same refreshes before each measured one."""
    plain = bench(attrs.evolve(PLAIN, out=tmp_path / "plain"))
    steps: list[tuple[float, float]] = []
    rated = bench(attrs.evolve(RATED, out=tmp_path / "rated"), lambda done, total: steps.append((done, total)))
    assert unrated(rated.data["rows"]) == unrated(plain.data["rows"])
    assert not any("jod" in row for row in plain.data["rows"])
    assert all(len(row["jod"]["clips"]) == 2 for row in rated.data["rows"])
    assert steps[-1] == (2, 2) and steps == sorted(steps)
    assert any(note.startswith("JOD by ColorVideoVDP") for note in rated.data["notes"])
    assert "<dt>JOD</dt>" in rated.report.read_text(encoding="utf-8")
    with (tmp_path / "rated" / "bench.csv").open(encoding="utf-8", newline="") as file:
        written = [float(row["jod"]) for row in csv.DictReader(file)]
    assert written == [row["jod"]["mean"] for row in rated.data["rows"]]
    monkeypatch.setattr("hmdwarp.run.measuring.GPU_BATCH_BYTES", 1)
    monkeypatch.setattr("hmdwarp.run.measuring.MEMORY_PART", 0.0)
    alone = bench(attrs.evolve(RATED, out=tmp_path / "alone"))
    assert [row["jod"] for row in alone.data["rows"]] == [row["jod"] for row in rated.data["rows"]]
