"""JOD in a bench: of clips that end at its instants, and nothing else changes by it."""

from __future__ import annotations

import csv
import math

import attrs
import pytest
from ratings import crashing_torch, quiet, with_cvvdp  # noqa: F401  (a fixture)
from replays import run

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


@with_cvvdp
@quiet
def test_a_clip_is_rated_as_in_a_replay(tmp_path):
    """The first clip of a replay of the same head, scene and warp has the same refreshes."""
    count = 16  # of 30 refreshes the one measured is 15
    one = attrs.evolve(RATED, warps=("forward",), fills=("none",), instants=1, out=tmp_path / "bench")
    (row,) = bench(attrs.evolve(one, jod_s=count / 60)).data["rows"]
    same = {name: getattr(one, name) for name in ("guard", "predict", "samples")}
    run(tmp_path / "replay", warp="forward", latency_ms=200.0, jod_s=count / 60, **same)
    with (tmp_path / "replay" / "jod.csv").open(encoding="utf-8", newline="") as file:
        left = [float(row["jod"]) for row in csv.DictReader(file) if row["eye"] == "0" and int(row["frame"]) < count]
    assert len(left) == count
    assert row["jod"]["refresh_mean"] == pytest.approx(math.fsum(left) / count, rel=1e-12)  # rounding of a sum
