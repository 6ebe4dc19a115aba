"""The settings of a condition are the options of `hmdwarp live`, no more, no less."""

from __future__ import annotations

import inspect
import sys
from pathlib import Path

import attrs
import pytest
from together import together

from hmdwarp.cli import runs as live_command
from hmdwarp.options.named_files import OUTSIDE
from hmdwarp.run import LiveOptions
from hmdwarp.study.design import DISPLAY, KINDS, live_options
from hmdwarp.study.design.definitions import _NOT_SETTINGS, PICTURE, check_settings, resolve_paths


def test_every_option_of_live_is_a_setting_or_says_why_not():
    options = set(inspect.signature(live_command.live).parameters)
    options -= {OUTSIDE.name}  # of every command: a file grants itself nothing
    assert options == set(KINDS) | set(_NOT_SETTINGS) and not set(KINDS) & set(_NOT_SETTINGS)
    assert set(DISPLAY) < set(PICTURE) < set(KINDS)


def by_command_line(monkeypatch, *arguments: str) -> LiveOptions:
    """What `hmdwarp live` would run."""
    from hmdwarp.cli import main

    caught: list[LiveOptions] = []

    def ran(options: LiveOptions, *_: object) -> None:
        caught.append(options)
        raise SystemExit(0)

    monkeypatch.setattr("hmdwarp.run.live", ran)
    monkeypatch.setattr("hmdwarp.cli.end_cleanly", lambda: None)
    monkeypatch.setattr(sys, "argv", ["hmdwarp", "live", *arguments])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 0
    return caught[0]


SETTINGS = [
    ({}, ""),
    ({"latency": 400, "warp": "mesh:cut=slope", "fill": "none"}, "--latency=400 --warp=mesh:cut=slope --fill=none"),
    ({"jitter": "normal:5", "lens": "none"}, "--jitter=normal:5 --lens=none"),
    ({"warp": "mesh", "wide": True}, "--warp=mesh --wide"),
    ({"warp": "backward", "fused": True}, "--warp=backward --fused"),
    ({"full-screen": True, "vsync": False}, "--full-screen --no-vsync"),
    ({"full_screen": True, "gc_between": False}, "--full-screen --gc-anywhere"),
    ({"size": "96x120", "rate": 75, "view": "flat"}, "--size=96x120 --rate=75 --view=flat"),
    ({"guard": 1.5}, "--guard=1.5"),
    ({"guard": "1.5", "loss": "0.02", "loss-burst": 3}, "--guard=1.5 --loss=0.02 --loss-burst=3"),
    ({"loss": 0.02, "bandwidth": 50, "queue": 99}, "--loss=0.02 --bandwidth=50 --queue=99"),
    ({"codec": "h264", "crf": 30}, "--codec=h264 --crf=30"),
    ({"codec": "h264", "bitrate": 3}, "--codec=h264 --bitrate=3"),
    ({"predict": "constant_velocity", "horizon": 50}, "--predict=constant_velocity --horizon=50"),
    ({"reconnect": 5, "hang": 2, "depth_layer": False}, "--reconnect=5 --hang=2 --no-depth-layer"),
    ({"scene": "spheres", "effects": "none"}, "--scene=spheres --effects=none"),
    ({"scene-scale": 0.01, "viewpoint": "1,2,-3"}, "--scene-scale=0.01 --viewpoint=1,2,-3"),
    ({"scene-up": "z", "viewpoint": 0, "animation": 1}, "--scene-up=z --viewpoint=0 --animation=1"),
    ({"mirrors": "screen", "headset": "flat-90"}, "--mirrors=screen --headset=flat-90"),
    ({"warp": "auto", "budget": 4, "bench": "b.json"}, "--warp=auto --budget=4 --bench=b.json"),
]


@together("settings, arguments", SETTINGS)
def test_a_setting_means_what_the_option_means(monkeypatch, settings, arguments):
    wanted = by_command_line(monkeypatch, *arguments.split())
    assert live_options(settings) == attrs.evolve(wanted, panel=False, command="")


def test_options_of_the_run_are_added(tmp_path):
    options = live_options({"latency": 100}, source="offscreen", trace="walk", record=tmp_path / "x.csv", seconds=3)
    found = (options.source, options.trace, options.record, options.seconds)
    assert found == ("offscreen", "walk", tmp_path / "x.csv", 3)


def test_a_scene_is_loaded_once():
    scenes: dict = {}
    options = check_settings({"scene": "planes", "latency": 0}, scenes)
    first = scenes[options.scene_key]
    check_settings({"scene": "planes", "latency": 100}, scenes)
    assert scenes == {options.scene_key: first}


def test_files_are_found_from_the_study_file(tmp_path):
    settings = {"scene": "mine.glb", "headset": "mine.toml", "delay-trace": "d.csv", "bench": "b.json", "warp": "mesh"}
    folder = tmp_path / "studies"
    assert resolve_paths(folder, settings) == {
        "scene": str(folder / "mine.glb"), "headset": str(folder / "mine.toml"), "delay_trace": str(folder / "d.csv"),
        "bench": str(folder / "b.json"), "warp": "mesh",
    }  # fmt: skip
    here = str(Path.cwd() / "beside" / "mine.glb")  # wherever one works later
    assert resolve_paths(Path("beside"), {"scene": "mine.glb"}) == {"scene": here}
    for name, value in (("scene", "mine.xml"), ("scene", "MINE.OBJ"), ("headset", "mine.json")):
        assert resolve_paths(folder, {name: value}) == {name: str(folder / value)}
    assert resolve_paths(folder, {"scene": "room", "headset": "rift-dk1"}) == {"scene": "room", "headset": "rift-dk1"}
