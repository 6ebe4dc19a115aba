"""Sets of cases, run here and on a cluster: what is kept, what fails, what is run again."""

from __future__ import annotations

import os
from collections import Counter

import pytest

from hmdwarp.base import InputError, MachineError
from hmdwarp.base.identity import identity_of
from hmdwarp.experiments.sweep import KeptOptions, run_cases
from hmdwarp.experiments.sweep.sweep_case import held

from .cheap import Cheap, cases, sweep


def squares(swept) -> dict[int, int]:
    return {case.what.number: result["square"] for case, result in swept.results()}


def ran(out) -> Counter:
    return Counter(map(int, (out / "ran").read_text(encoding="utf-8").split()))


def test_each_case_is_run_once_and_kept(tmp_path):
    swept = sweep(tmp_path, 20)
    assert squares(swept) == {number: number**2 for number in range(20)}
    assert ran(tmp_path) == Counter(range(20))
    swept.raise_failures()
    assert sweep(tmp_path, 20).known == 0 and ran(tmp_path) == Counter([*range(20)] * 2)  # without --resume


def test_resuming_runs_only_the_cases_that_failed_or_are_damaged(tmp_path):
    first = sweep(tmp_path, 20, "wrong")
    assert [failure.why for failure in first.failed] == ["13 is no number for this"]
    with pytest.raises(InputError, match="1 of 20 cases failed: number 13: 13 is no number"):
        first.raise_failures()
    again = sweep(tmp_path, 20, "wrong", resume=True)
    assert (again.known, len(again.failed)) == (19, 1)
    assert ran(tmp_path) == Counter(range(20)) + Counter([13])
    damaged = tmp_path / "cases" / f"{cases(20, 'wrong')[0].identity}.json"
    damaged.write_text("{}", encoding="utf-8")
    assert sweep(tmp_path, 20, "wrong", resume=True).known == 18


@pytest.mark.parametrize("text", ["local", "local:0", "local:x", "somewhere", "tcp://host", "host:port"])
def test_wrong_cluster_addresses_are_refused(text):
    with pytest.raises(InputError, match="expected local:N, or the address of a Dask scheduler"):
        KeptOptions(cluster=text)


def test_a_scheduler_that_is_not_there(tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("hmdwarp.experiments.sweep.sweep_case.CONNECT_S", 0.2)
    with pytest.raises(MachineError, match="no Dask scheduler there"):
        sweep(tmp_path, 1, cluster="127.0.0.1:1")


@pytest.mark.slow(15)
def test_a_cluster_gives_what_this_process_gives(tmp_path):
    """Data crosses with the case; a case that fails, or ends its worker, leaves the others."""
    pytest.importorskip("distributed")
    (tmp_path / "head.csv").write_text("a trace", encoding="utf-8")
    said: list[str] = []
    file, out = str(tmp_path / "head.csv"), tmp_path / "out"
    swept = sweep(out, 20, "deadly", file, said.append, cluster="local:2")
    wanted = {number: number**2 for number in range(20) if number != 13}
    assert squares(swept) == wanted
    assert {result["text"] for _, result in swept.results()} == {"a trace"}
    assert len({result["pid"] for _, result in swept.results()}) >= 2
    assert said[0].startswith("dashboard: http://127.0.0.1:")
    # Once, and again twice; a neighbour on the same worker may have been lost with it.
    assert ran(out)[13] == 3 and all(ran(out)[number] >= 1 for number in wanted)
    with pytest.raises(MachineError, match="number 13: its worker died, and 2 more that ran it again"):
        swept.raise_failures()
    assert squares(sweep(out, 20, "plain", file, resume=True)).keys() == set(range(20))


@pytest.mark.parametrize(
    ("scene", "texture"),
    [
        ({"room.gltf": '{"images": [{"uri": "a%20wall.png"}]}', "a wall.png": "red"}, "a wall.png"),
        ({"room.obj": "mtllib it.mtl", "it.mtl": " map_Kd wood/oak.png", "wood/oak.png": "red"}, "wood/oak.png"),
        ({"room.ply": "ply\ncomment TextureFile oak.png", "oak.png": "red"}, "oak.png"),
    ],
)
def test_a_scene_is_the_files_that_it_names_and_not_what_lies_beside(tmp_path, scene, texture):
    """Results are often written beside it: a run would not know its own cases again."""
    for name, text in scene.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    room = str(tmp_path / next(iter(scene)))
    before = identity_of("kind", room)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "bench.json").write_text("{}", encoding="utf-8")
    assert identity_of("kind", room) == before
    (tmp_path / texture).write_text("green", encoding="utf-8")
    assert identity_of("kind", room) != before


def test_a_folder_is_one_run_s_and_what_it_keeps_stays_until_another_has_succeeded(tmp_path):
    with held(tmp_path), pytest.raises(MachineError, match=rf"since .*, process {os.getpid()} on"), held(tmp_path):
        raise AssertionError("two hold it")
    sweep(tmp_path, 3)
    kept = {*(tmp_path / "cases").iterdir()}

    def ends(done: int, total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_cases(Cheap(tmp_path / "ran"), cases(5, "plain", ""), tmp_path, KeptOptions(), ends)
    assert kept <= {*(tmp_path / "cases").iterdir()}
    sweep(tmp_path, 1)
    assert len([*(tmp_path / "cases").iterdir()]) == 1
