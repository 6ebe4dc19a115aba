"""A bench is a set of cases: what is done stays done, what failed says why and is run again."""

from __future__ import annotations

from pathlib import Path

import attrs
import pytest

from hmdwarp.base import folder
from hmdwarp.experiments.bench import BenchOptions, bench
from hmdwarp.experiments.sweep import KeptOptions

TINY = BenchOptions(
    warps=("rotation",), fills=("none",), latencies_ms=(50.0, 100.0), scenes=("planes",), sizes=((48, 40),),
    headset="rift-dk1", rate_hz=60.0, seconds=0.3, guard=1.1, instants=1, rounds=1, workers=0,
)  # fmt: skip
AGAIN = KeptOptions(resume=True)


@pytest.fixture
def heads(tmp_path) -> list[Path]:
    """Two recordings of the user's own."""
    paths = [tmp_path / "heads" / f"{name}.csv" for name in ("first", "second")]
    paths[0].parent.mkdir()
    for path, shipped in zip(paths, ("look-around", "walk"), strict=True):
        path.write_bytes((folder("recordings") / f"{shipped}.csv").read_bytes())
    return paths


def untimed(rows: list[dict]) -> list[dict]:
    return [{key: value for key, value in row.items() if key != "time_ms"} for row in rows]


def written(out: Path) -> dict[str, int]:
    return {path.name: path.stat().st_mtime_ns for path in (out / "cases").glob("*.json")}


def test_interrupted_and_resumed_is_the_whole_run(tmp_path, heads):
    options = attrs.evolve(TINY, recordings=tuple(map(str, heads)), out=tmp_path / "out")

    def stop(done: int, total: int) -> None:
        if done == 3:
            raise KeyboardInterrupt

    options.out.mkdir()
    (options.out / "bench.json").write_text('{"hmdwarp": "0"}')  # of an earlier bench
    with pytest.raises(KeyboardInterrupt):
        bench(options, stop)
    before = written(options.out)
    assert len(before) == 2 and (options.out / "bench.json").read_text() == '{"hmdwarp": "0"}'

    said: list[str] = []
    resumed = bench(attrs.evolve(options, sweep=AGAIN), say=said.append)
    assert said[0].startswith("2 of 4 cases are kept from before")
    assert before.items() <= written(options.out).items() and len(written(options.out)) == 4

    plain = bench(attrs.evolve(options, out=tmp_path / "plain"))
    assert untimed(resumed.data["rows"]) == untimed(plain.data["rows"])
    assert written(options.out).keys() == written(tmp_path / "plain").keys()


def test_a_case_is_identified_by_content(tmp_path, heads):
    """The content of a trace counts, not its place; who runs it and where it goes do not."""
    options = attrs.evolve(TINY, recordings=(str(heads[0]),), latencies_ms=(50.0,), out=tmp_path / "out")
    first = bench(options)
    moved = tmp_path / heads[0].name
    heads[0].rename(moved)
    same = attrs.evolve(options, recordings=(str(moved),), command="hmdwarp bench", workers=1, sweep=AGAIN)
    assert bench(same).swept.known == 1
    moved.write_bytes(moved.read_bytes() + b"\n")
    assert bench(same).swept.known == 0
    assert bench(attrs.evolve(same, instants=2)).swept.known == 0
    assert first.swept.known == 0
