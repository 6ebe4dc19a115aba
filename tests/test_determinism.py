"""The same command twice gives the same bits: pictures, rows, quality.

With any number of measuring processes.
"""

from __future__ import annotations

import pytest
from replays import contents, rows_of, run

TIMED = ("warp_ms", "fill_ms", "effects_ms", "lens_ms", "total_ms")
PASSES = {"fill": "interpolate", "lens": "radial", "headset": "rift-dk1", "against": "rotation"}
RUN = {"trace": "look-around", **PASSES, "images": 4, "seconds": 0.4}


def untimed(folder) -> list[dict[str, str]]:
    return [{name: text for name, text in row.items() if name not in TIMED} for row in rows_of(folder)]


def pictures(folder) -> dict[str, bytes]:
    return {name: data for name, data in contents(folder).items() if name.startswith("images/")}


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    out = tmp_path_factory.mktemp("first")
    return out, run(out, **RUN)


@pytest.mark.parametrize("workers", [0, 1, 2])
def test_the_same_bits_again(workers, first, tmp_path):
    folder, result = first
    again = run(tmp_path, **RUN, workers=workers)
    assert pictures(tmp_path) == pictures(folder) and len(pictures(folder)) > 0
    assert untimed(tmp_path) == untimed(folder)
    assert again.summary["quality"] == result.summary["quality"]
    assert again.summary["against"][0]["quality"] == result.summary["against"][0]["quality"]


@pytest.mark.parametrize("warp", ["forward", "backward", "planar"])
def test_every_kind_of_pass_gives_the_same_bits(warp, tmp_path):
    """forward's ties, planar's median and backward's second drawing could each depend on the order
    in which threads run.
    """
    wanted = {
        **RUN, "seconds": 0.1, "metrics_every": 1, "images": 6, "against": "", "trace": "walk", "warp": warp,
        "scene": "spheres",
    }  # fmt: skip
    run(tmp_path / "a", **wanted)
    run(tmp_path / "b", **wanted)
    assert untimed(tmp_path / "a") == untimed(tmp_path / "b")
    assert pictures(tmp_path / "a") == pictures(tmp_path / "b")


def test_measuring_does_not_change_the_shown_pictures(first, tmp_path):
    """Reading pictures back, drawing the truth and running a second warp must leave no trace in the
    first one's pictures.
    """
    from replays import seen, small

    plain = seen(small(trace="walk", fill="interpolate", seconds=0.2), every=4)
    run(tmp_path, trace="walk", fill="interpolate", seconds=0.2, metrics_every=1, against="planar")
    again = seen(small(trace="walk", fill="interpolate", seconds=0.2))[::1]
    for number, eye in enumerate(plain):
        twin = again[2 * 4 * (number // 2) + number % 2]
        assert (eye.shown == twin.shown).all() and (eye.coverage == twin.coverage).all()
