"""`hmdwarp thesis`: verdicts, runs that fail, and refusals."""

from __future__ import annotations

import json
from functools import partial

import attrs
import pytest
from commands import hmdwarp
from report_tables import summary_markdown

from hmdwarp.experiments.sweep import KeptOptions, run_cases
from hmdwarp.experiments.thesis.experiment import Motion, PictureRun, Verdict, experiments
from hmdwarp.experiments.thesis.run_figures import Thoroughness
from hmdwarp.experiments.thesis.thesis_run import cases_of, thesis_work
from hmdwarp.study.analysis.full_analysis import published_ratings

EXPERIMENTS = experiments()


@pytest.mark.slow(40)
def test_quick_gives_every_experiment_its_verdict(tmp_path, monkeypatch):
    """Each kind of run is there, of the first cells, with smaller pictures than --quick has."""
    out, tiny = tmp_path / "out", Thoroughness((64, 40), 1, 1, 1 / 16, 0.25)
    monkeypatch.setattr("hmdwarp.experiments.thesis.thesis_run.Thoroughness", lambda *_: tiny)
    first = [attrs.evolve(each, cells=each.cells[:1]) for each in EXPERIMENTS]
    monkeypatch.setattr("hmdwarp.experiments.thesis.experiment.experiments_named", lambda _: first)
    done = hmdwarp("thesis", "--quick", "--out", out)
    assert done.returncode == 0, done.stderr
    data = json.loads((out / "results.json").read_text(encoding="utf-8"))
    assert [experiment["name"] for experiment in data["experiments"]] == [experiment.name for experiment in EXPERIMENTS]
    assert sum(data["verdicts"].values()) == len(EXPERIMENTS) and not data["failed"]
    assert set(data["verdicts"]) == {verdict.value for verdict in Verdict}
    page = (out / "thesis.html").read_text(encoding="utf-8")
    for experiment in EXPERIMENTS:
        assert f'id="{experiment.name}"' in page
    assert page.count("data:image/jpeg") >= sum(len(experiment.pictures) for experiment in EXPERIMENTS)
    assert "http://" not in page.replace("http://www.w3.org/", "") and "https://" not in page
    table = summary_markdown([data, {**data, "experiments": data["experiments"][:1]}]).splitlines()
    named = ("holds", "cannot be told")
    assert len(table) == 6 + sum(one["verdict"] not in named for one in data["experiments"])


def _runs(*fills: str) -> tuple[PictureRun, ...]:
    motion = Motion("sideways", 0.5)
    return tuple(PictureRun(motion=motion, latency_ms=200.0, fill=fill, scene="planes") for fill in fills)


def test_a_run_that_fails_leaves_those_on_the_same_frames(tmp_path):
    runs = _runs("none", "nonsense", "interpolate")

    def ran(name: str, some: tuple[PictureRun, ...]):
        cases = cases_of(some, set(runs), Thoroughness((48, 30), 1, 1))
        return run_cases(partial(thesis_work, some, published_ratings), cases, tmp_path / name, KeptOptions())

    swept = ran("all", runs)
    assert [case.what.run.fill for case, _ in swept.results()] == ["none", "interpolate"]
    assert ["nonsense" in failure.why for failure in swept.failed] == [True]
    assert [*ran("alone", runs[2:]).results()] == [*swept.results()][1:]


@pytest.mark.parametrize(
    ("more", "words"), [(("--only", "figg27"), "did you mean 'fig27'"), (("--size", "64x40"), "leave one out")]
)
def test_wrong_input_is_refused_before_anything_is_written(tmp_path, more, words):
    done = hmdwarp("thesis", "--quick", *more, "--out", tmp_path / "out")
    assert done.returncode == 2 and words in " ".join(done.stderr.split())
    assert not (tmp_path / "out").exists()
