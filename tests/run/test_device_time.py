"""What passes take on a device that is not here: a model between what memory allows and a GPU."""

from __future__ import annotations

import tomllib
from pathlib import Path

import attrs
import pytest
from bench_files import a_bench, a_row
from pages import rows_of
from replays import small

from hmdwarp.client import build_plan
from hmdwarp.client.classes import client_names, load_client
from hmdwarp.run import choose, choosing
from hmdwarp.run.choosing import device_ms

SIZE = (2064, 2208)
DEVICES = [device for device in map(load_client, client_names()) if device.memory_gb_s < 1e9]


def plan(warp: str, fill: str = "none"):
    return build_plan((), warp, fill, "none", client_geometry=True)


def test_measured_passes_are_those_of_the_gpu_s_table():
    """A fill adds at most so much to any warp; the memory's is what it adds to its pyramid's."""
    path = Path(choosing.__file__).with_name("measured_passes.toml")
    measured = tomllib.loads(path.read_text(encoding="utf-8"))
    rows = rows_of("gpu NVIDIA H100 80GB HBM3")
    none, *others = (
        [float(row[f"{fill}, 2064x2208"].split()[0]) for row in rows]
        for fill in ("none", "interpolate", "pyramid", "memory+pyramid")
    )
    assert measured["warps"] == dict(zip((row["warp"].strip("`") for row in rows), none, strict=True))
    pairs = zip(("interpolate", "pyramid", "memory"), others, (none, none, others[1]), strict=True)
    added = {fill: max(ms - of for ms, of in zip(own, base, strict=True)) for fill, own, base in pairs}
    assert measured["fills"] == pytest.approx(added, abs=1e-9) and measured["gpu"]["size"] == [*SIZE]


def test_the_thesis_s_own_times_lie_between_the_ends():
    """GTX 765M, by its maker 64 GB/s and 1.3 TFLOPS; both eyes: warp 2 ms, interpolation 3 ms."""
    thesis = attrs.evolve(load_client("class-2"), memory_gb_s=64.0, compute_tflops=1.3)
    warp, filled = (device_ms(plan("forward", fill), (1280, 800), thesis) for fill in ("none", "interpolate"))
    assert warp[0] < 1.0 < warp[2] and filled[0] - warp[0] < 1.5 < filled[2] - warp[2]


@pytest.mark.parametrize("device", DEVICES, ids=lambda device: device.name)
def test_the_least_is_what_crosses_the_memory_once_and_all_grows_with_pixels(device):
    """`rotation` reads a colour and writes one, 8 bytes each; `iterative` reads 4 of depth too."""
    for warp, moved in (("rotation", 16), ("iterative:frames=1", 20)):
        least, middle, most = device_ms(plan(warp), SIZE, device)
        assert least == pytest.approx(moved * SIZE[0] * SIZE[1] / device.memory_gb_s * 1e-6)
        assert middle == pytest.approx((least * most) ** 0.5) and least <= most
        half = device_ms(plan(warp), (SIZE[0], SIZE[1] // 2), device)
        assert half == pytest.approx((least / 2, middle / 2, most / 2))
    unknown, known = (device_ms(plan(warp), SIZE, device)[2] for warp in ("similarity", "splat"))
    assert unknown == known, "what was not measured counts as the slowest that was"


def test_a_choice_for_a_device_goes_by_its_model_whatever_this_machine_took(tmp_path):
    levels = (("rotation", 1e6, 0.3), ("iterative", 1.0, 0.2), ("splat", 1e-3, 0.1))
    path = a_bench(tmp_path / "b.json", [a_row(warp, "none", ms, flip) for warp, ms, flip in levels])
    least, middle, most = device_ms(plan("iterative"), (96, 80), load_client("quest-3"))
    choice = choose(small(warp="auto", client="quest-3", budget_ms=1.01 * middle, bench=path))
    assert (choice.options.warp, choice.level.total_ms, choice.range_ms) == ("iterative", middle, (least, most))
    assert choice.following.warp == "splat" and choice.following.total_ms > 1.01 * middle
    assert f"{least:.1f} to {most:.1f} ms on 'quest-3'" in choice.notes[1] and "&bench" in choice.notes[1]
