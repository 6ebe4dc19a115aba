"""Strategies: each by its name through replay, live and a study's condition."""

from __future__ import annotations

from pathlib import Path

import pytest
from commands import hmdwarp
from replays import scene_for

from hmdwarp.base import InputError, options_of
from hmdwarp.client import parse_warp
from hmdwarp.client.effects import effects
from hmdwarp.client.strategies import options_of_strategy, strategies
from hmdwarp.pipeline import PipelineOptions, build_plan_for
from hmdwarp.scenes import load_scene
from hmdwarp.study.design import live_options

NAMES = strategies.names()


@pytest.fixture(params=NAMES)
def name(request) -> str:
    return request.param


def test_a_strategy_is_the_options_that_it_sets_and_says_what_it_is(name):
    strategy, sets, scene = strategies.get(name), options_of_strategy(name), load_scene(scene_for(name))
    told = (strategy.summary, strategy.crosses, strategy.client, strategy.late, strategy.source)
    assert all(text and text == text.strip() and not text.endswith(".") for text in told)
    assert set(strategy.classes) <= {1, 2, 3} and strategy.classes
    assert set(sets) <= {option.name for option in options_of(PipelineOptions)} - {"strategy"}
    effects.forced(sets.get("effects", "auto"))
    assert "fills" not in strategy.client or sets.get("fill") != "none"
    by_name, by_hand = PipelineOptions.of({"strategy": name}), PipelineOptions.of(sets)
    assert build_plan_for(by_name, None, scene) == build_plan_for(by_hand, None, scene)
    assert by_name.strategy == name == live_options({"strategy": name}).strategy
    # Several pictures besides the newest frame's own.
    assert name != "views" or parse_warp(sets["warp"]).settings.views > 1


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ({"strategy": "imposter", "warp": "forward"}, "--warp forward beside --strategy imposter"),
        ({"strategy": "imposter", "warp": "iterative"}, "--warp iterative beside --strategy imposter"),
        ({"strategy": "imposter", "fill": "pyramid"}, "--fill pyramid beside --strategy imposter"),
        ({"strategy": "light", "effects": "none"}, "--effects none beside --strategy light"),
        ({"strategy": "imposter:"}, "settings after the colon"),
        ({"strategy": "imposter:speed=1"}, "is no setting of 'none'"),
        ({"strategy": "depth_image:warp=forward"}, "it has no settings"),
        ({"strategy": "depth_image", "warp": "rotation"}, "reads no depth"),
        ({"strategy": "impostor"}, "did you mean 'imposter'"),
    ],
)
def test_options_that_exclude_each_other_are_refused(said, words, tmp_path):
    with pytest.raises(InputError, match=words):
        build_plan_for(PipelineOptions.of(said), None, None)
    with pytest.raises(InputError, match="strategy 'imposter' with fill"):
        PipelineOptions(strategy="imposter")
    chosen = PipelineOptions.of({"strategy": "depth_image", "warp": "forward", "fill": "interpolate"})
    assert (chosen.warp, chosen.fill) == ("forward", "interpolate")


def test_a_client_that_cannot_run_it_is_refused_with_the_reason(tmp_path: Path):
    done = hmdwarp("replay", "look-around", "--strategy", "light", "--client", "class-1", "--out", tmp_path / "run")
    assert done.returncode == 2 and "class-1" in done.stderr and "nothing of the scene" in done.stderr
    assert not (tmp_path / "run").exists()
