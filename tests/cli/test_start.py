"""Commands that draw nothing start quickly: they load and build only what they print."""

from __future__ import annotations

import subprocess
import sys

import pytest

from hmdwarp.errors import InputError
from hmdwarp.scenes import Scene, SceneSource, scenes

# Each of these takes a third of a second to load, or more.
HEAVY = ("scipy", "matplotlib", "skimage", "trimesh", "statsmodels", "pingouin")
AFTER = f"""
import sys
from hmdwarp.cli import main
try:
    main()
except SystemExit as left:
    print("status", left.code)
from hmdwarp.scenes import load_scene
print("loaded", [name for name in {HEAVY} if name in sys.modules])
print("painted", [texture.name for texture in load_scene("room").textures if "image" in vars(texture)])
"""


@pytest.mark.parametrize("arguments", [["plan"], ["study", "plan", "quick"], ["doctor"]], ids=" ".join)
def test_a_command_that_draws_nothing_loads_no_heavy_library_and_paints_no_texture(arguments):
    done = subprocess.run(
        [sys.executable, "-c", AFTER, *arguments], check=False, capture_output=True, text=True, encoding="utf-8"
    )
    assert done.stdout.splitlines()[-3:] == ["status 0", "loaded []", "painted []"], done.stderr


@pytest.mark.parametrize(
    "wrong",
    [
        ["replay", "walk", "--warp", "bogus"],
        ["replay", "walk", "--against", "bogus"],
        ["replay", "walk", "--predict", "bogus"],
        ["bench", "walk", "--warp", "bogus"],
        ["bench", "walk", "--fill", "bogus"],
    ],
    ids=" ".join,
)
def test_names_are_checked_before_a_scene_is_built(wrong, command, unbuildable, tmp_path):
    command(*wrong, "--scene", unbuildable, "--out", tmp_path / "out").refused("'bogus': known are")


@pytest.fixture
def unbuildable(monkeypatch):
    """The name of a scene that fails when it is built."""

    def build() -> Scene:
        raise InputError("the scene was built")

    source, found = SceneSource("unbuildable", "", build), scenes.get
    monkeypatch.setattr(scenes, "get", lambda name: source if name == source.name else found(name))
    monkeypatch.setattr(scenes, "names", lambda: [source.name])
    return source.name
