"""Golden pictures of whole loops, small, on llvmpipe only.

What must be right is tested elsewhere; these only say that something changed.
"""

from __future__ import annotations

import numpy as np
import pytest
from golden_pictures import assert_golden, names_in
from numpy.typing import NDArray
from replays import each_refresh, small

from hmdwarp.base import picture_from_linear
from hmdwarp.gpu import download
from hmdwarp.pipeline import Refresh
from hmdwarp.run import ReplayRun

# What is shown 12 refreshes into a walk or a turn, both eyes side by side after the lens.
WALK = {"trace": "walk", "start_s": 3.0}
BEGINNING = {"trace": "walk", "start_s": 1.2}  # where the test scenes are still in front of the head
LOOPS = {
    "room-forward-interpolate-radial": {
        **WALK, "scene": "room", "warp": "forward", "fill": "interpolate", "lens": "radial",
    },
    "room-backward-none-none": {**WALK, "scene": "room", "warp": "backward"},
    "room-rotation-guard": {"trace": "look-around", "start_s": 2.0, "scene": "room", "warp": "rotation", "guard": 1.4},
    "planes-planar-none-none": {**BEGINNING, "scene": "planes", "warp": "planar"},
    "planes-none-radial": {**BEGINNING, "scene": "planes", "warp": "none", "lens": "radial", "headset": "cardboard-v2"},
    "spheres-forward-none-none": {**BEGINNING, "scene": "spheres", "warp": "forward"},
    "room-iterative-index": {**WALK, "scene": "room", "warp": "iterative", "headset": "index", "guard": 1.2},
}  # fmt: skip
SIZE = (80, 100)

# llvmpipe of one Mesa and LLVM gives the same bits every time. Another one may round a colour the
# other way (one grey level), and a place the other way, which moves an edge or a scattered point by
# a pixel: at most one pixel in 500, or it is a change.
MOVED_SHARE = 1 / 500


def shown(options: dict[str, object]) -> NDArray[np.uint8]:
    """(h, 2w, 3): both panels."""
    pictures: list[NDArray[np.uint8]] = []

    def look(setup: ReplayRun, number: int, refresh: Refresh) -> None:
        if number == 12:
            pictures.append(
                np.concatenate([picture_from_linear(download(eye.panel.texture)) for eye in refresh.eyes], axis=1)
            )

    chosen = {"headset": "rift-dk1", "samples": 4, "size": SIZE, "seconds": 13 / 60, **options}
    each_refresh(small(**chosen), look)
    return pictures[0]


@pytest.fixture(scope="module", autouse=True)
def on_llvmpipe(gpu):
    if "llvmpipe" not in gpu.renderer:
        pytest.skip(
            f"golden pictures are llvmpipe's; this is {gpu.renderer}, which may draw edges and filter textures "
            "otherwise"
        )


@pytest.mark.parametrize("name", LOOPS)
def test_looks_as_before(name, tmp_path):
    assert_golden(name, shown(LOOPS[name]), tmp_path, MOVED_SHARE)


def test_every_golden_picture_is_of_a_loop():
    assert names_in("") == set(LOOPS)
