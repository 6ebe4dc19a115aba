"""What a suite takes besides what ships: scenes by others, checked, and recorded sequences."""

from __future__ import annotations

import json

import attrs
import pytest
from recorded_folders import taken, write_npz

from hmdwarp.errors import InputError
from hmdwarp.experiments.bench import BenchOptions
from hmdwarp.experiments.bench.bench_run import Recipe, about_sequence, further, recipes
from hmdwarp.experiments.bench.suites import suites
from hmdwarp.options.identity import hash_of_files
from hmdwarp.sources import sequences


def test_a_suite_goes_on_without_scenes_that_are_not_there_and_says_what_to_get(tmp_path):
    parts, said = further(BenchOptions.of({"suite": "standard", "also": tmp_path}))
    assert not parts
    assert len(said) == len(suites()["standard"].recipes) == 3
    assert all("commit 8fdb2dc" in text and "expected DIR/" in text for text in said)
    assert sum("CC BY 3.0" in text for text in said) == 2
    assert {len(recipe.sha256) for recipe in recipes().values()} == {64}


def test_a_scene_takes_part_only_as_it_was_when_it_was_named(tmp_path):
    (tmp_path / "hut.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    recipe = Recipe("a hut", "a builder", "hut.obj", hash_of_files(tmp_path / "hut.obj"))
    assert recipe.missing(tmp_path) == ""
    changed = attrs.evolve(recipe, sha256="0" * 64).missing(tmp_path)
    assert "expected 0000" in changed and recipe.sha256 in changed
    assert "get a hut" in recipe.missing(None)


def test_recorded_sequences_take_part_with_their_noise_floor(tmp_path):
    for name, facts in (("slide", {"noise_floor_db": 31.5}), ("walk", None)):
        (tmp_path / name).mkdir()
        write_npz(tmp_path / name, taken(8))
        if facts:
            (tmp_path / name / "camera.json").write_text(json.dumps(facts))
    parts, _ = further(BenchOptions.of({"suite": "quick", "also": tmp_path}))
    assert [part.scenes for part in parts] == [("slide",), ("walk",)]
    assert [about_sequence(part)["noise_floor_db"] for part in parts] == [31.5, None]
    assert all(part.sizes == ((29, 19),) for part in parts)  # 36x24 less the guard band


def test_a_noise_floor_is_a_positive_number(tmp_path):
    write_npz(tmp_path, taken(3))
    (tmp_path / "camera.json").write_text('{"noise_floor_db": "low"}')
    with pytest.raises(InputError, match="noise_floor_db is 'low'; expected a positive number of dB"):
        sequences.open(tmp_path)


def test_further_things_are_for_suites_alone(tmp_path):
    with pytest.raises(InputError, match="--also without --suite"):
        BenchOptions.of({"also": tmp_path})
    with pytest.raises(InputError, match="no such folder"):
        further(BenchOptions.of({"suite": "quick", "also": tmp_path / "none"}))
