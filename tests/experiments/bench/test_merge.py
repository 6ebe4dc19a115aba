"""Benches joined: quality once, times for each machine, and drivers that disagree are found."""

from __future__ import annotations

import base64
import csv
import json
from pathlib import Path

import attrs
import numpy as np
import pytest
from bench_files import WITHOUT_PAGE
from commands import hmdwarp

from hmdwarp.base import InputError, MachineError
from hmdwarp.experiments.bench import MergeOptions, bench, merge
from hmdwarp.experiments.bench import read as read_rows
from hmdwarp.experiments.bench.bench_run import NAMES
from hmdwarp.metrics import BOUND, block_means, blocks_apart, blocks_text
from hmdwarp.report.bench.rows import COLUMNS, cases

from .test_bench import TINY, untimed


@pytest.fixture(scope="module")
def benches(tmp_path_factory) -> list[Path]:
    """A bench of two latencies, and each of them by itself."""
    options = attrs.evolve(TINY, recordings=("walk",), start_s=0.2)
    made = [tmp_path_factory.mktemp("bench") / "out" for _ in range(3)]
    for out, latencies in zip(made, ((50.0, 100.0), (50.0,), (100.0,)), strict=True):
        with WITHOUT_PAGE:
            bench(attrs.evolve(options, latencies_ms=latencies, out=out))
    return made


def merged(folders, tmp_path: Path, **how) -> dict:
    return merge(MergeOptions(folders=tuple(folders), out=tmp_path / "merged", force=True, **how)).data


def read(folder: Path) -> dict:
    return json.loads((folder / "bench.json").read_text(encoding="utf-8"))


def elsewhere(folder: Path, to: Path, levels: float = 0.0, **changes) -> Path:
    """A copy, as another machine would have made it, with pictures off by so many levels."""
    data = {**read(folder), **changes}
    data["machine"]["host"] = "other"
    for row in data["rows"]:
        row["machine"]["host"] = "other"
        row["time_ms"]["total"]["median"] *= 3
        for at, text in row["blocks"].items():
            blocks = np.frombuffer(base64.b64decode(text), "<u2").copy()
            blocks[7] = min(blocks[7] + 256 * levels, 65535) if blocks[7] < 32768 else blocks[7] - 256 * levels
            row["blocks"][at] = base64.b64encode(blocks.tobytes()).decode()
    to.mkdir()
    (to / "bench.json").write_text(json.dumps(data), encoding="utf-8")
    return to


def test_parts_together_are_the_whole(benches, tmp_path):
    whole, *parts = benches
    data = merged(parts, tmp_path)
    assert untimed(data["rows"]) == untimed(read(whole)["rows"])
    assert read(tmp_path / "merged") == json.loads(json.dumps(data))
    assert (tmp_path / "merged" / "bench.html").is_file()
    with (tmp_path / "merged" / "bench.csv").open(encoding="utf-8", newline="") as file:
        written = list(csv.DictReader(file))
    assert len(written) == 2
    for row, texts in zip(read_rows(tmp_path / "merged"), written, strict=True):  # the same, with types
        assert [*row] == [*texts] == NAMES
        for name, text in texts.items():
            assert (row[name] in (None, "")) if text == "" else type(row[name])(text) == row[name], name


def test_the_page_describes_every_column():
    """By its name, or by the pattern of names that its row has."""
    page = (Path(__file__).resolve().parents[3] / "docs" / "scale.md").read_text(encoding="utf-8")
    told = page[page.index("| column |") :].split("\n\n")[0]
    for name in (name for name in NAMES if COLUMNS[name].kind is not float):
        assert f"`{name}`" in told, name


def test_each_machine_has_its_times_and_a_front_of_its_own(benches, tmp_path):
    other = elsewhere(benches[0], tmp_path / "other", levels=0.9 * BOUND)
    data = merged((benches[0], other), tmp_path)
    hosts = [row["machine"]["host"] for row in data["rows"]]
    assert len(hosts) == 4 and hosts.count("other") == 2
    assert [len(case.rows) for case in cases(data["rows"])] == [1] * 4
    for case in cases(data["rows"]):
        assert len({row["machine"]["host"] for row in case.front()}) == 1
    ours, theirs = data["rows"][0], data["rows"][2]
    assert ours["quality"] == theirs["quality"] and ours["blocks"] == theirs["blocks"]
    assert theirs["time_ms"]["total"]["median"] == 3 * ours["time_ms"]["total"]["median"]
    assert any(note.startswith("other: ") for note in data["notes"])


def test_two_gpus_of_one_machine_have_their_own_times(benches, tmp_path):
    """The second was left out without a word, as if it had been measured twice."""
    both = [elsewhere(benches[0], tmp_path / name) for name in ("first", "second")]
    data = read(both[1])
    for about in (data, *data["rows"]):
        about["machine"]["gl_renderer"] = "another GPU"
    (both[1] / "bench.json").write_text(json.dumps(data), encoding="utf-8")
    rows = merged(both, tmp_path)["rows"]
    assert len(rows) == 2 * len(read(both[0])["rows"])
    assert {row["machine"]["host"] for row in rows[len(rows) // 2 :]} == {"other (another GPU)"}


def test_a_page_of_many_cases_shows_the_first(benches, tmp_path, monkeypatch):
    monkeypatch.setattr("hmdwarp.experiments.bench.bench_run.MOST_SHOWN", 1)
    merged(benches[1:], tmp_path)
    page = (tmp_path / "merged" / "bench.html").read_text(encoding="utf-8")
    assert "shows the first 1 of 2 cases" in page and "50 ms" in page and "100 ms" not in page
    assert len(read(tmp_path / "merged")["rows"]) == 2


def test_drivers_that_disagree_are_named(benches, tmp_path):
    other = elsewhere(benches[0], tmp_path / "other", levels=1.2 * BOUND)
    done = hmdwarp("bench", "merge", benches[0], other, "--out", tmp_path / "merged")
    assert done.returncode == MachineError.exit_status
    told = " ".join(done.stderr.split())
    assert "walk, 50 ms, rotation + none: a part of the picture is 6.0 levels of 255 apart on" in told
    assert "other (" in told and "and 1 more" in told
    assert not (tmp_path / "merged").exists()


def test_benches_of_different_programs_are_refused(benches, tmp_path):
    older = elsewhere(benches[0], tmp_path / "older", program="0")
    (tmp_path / "empty").mkdir()
    for folder, words in ((older, "different programs"), (tmp_path / "empty", "no such file")):
        with pytest.raises(InputError, match=words):
            merged((benches[0], folder), tmp_path)
    with pytest.raises(InputError, match="expected two or more"):
        MergeOptions(folders=(benches[0],), out=tmp_path)


def test_the_means_of_blocks_know_what_a_picture_shows():
    picture = np.random.default_rng(1).integers(0, 256, (50, 61, 3), np.uint8)
    blocks = block_means(picture)
    assert blocks.shape == (8, 8, 3)
    assert blocks[0, 0] == pytest.approx(picture[:6, :7].mean(axis=(0, 1)))
    assert blocks[7, 7] == pytest.approx(picture[43:, 53:].mean(axis=(0, 1)))
    other = picture.copy()
    other[:6, :7, 1] //= 2
    apart = abs(picture[:6, :7, 1].mean() - other[:6, :7, 1].mean())
    assert blocks_apart(blocks_text(blocks), blocks_text(block_means(other))) == pytest.approx(apart, abs=1 / 256)
    small = block_means(picture[:3, :2])
    assert small.shape == (3, 2, 3) and blocks_apart(blocks_text(small), blocks_text(blocks)) == float("inf")
