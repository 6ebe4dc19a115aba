"""The page of one GPU, from what `make bench-gpu` writes, and its place in docs/gpu.md."""

from __future__ import annotations

import gpu_tables
import whole_gpu

SIZES = ((1280, 800), (2064, 2208))


def row(warp: str, size: tuple[int, int], ms: float) -> dict:
    time = {"median": ms, "p95": 2 * ms}
    common = {"trace": "look-around", "warp": warp, "fill": "none", "size": list(size)}
    return {**common, "time_ms": {"total": time, "warp": time}}


def gpu_json(renderer: str = "NVIDIA Some GPU/PCIe/SSE2", warps: dict[str, float] | None = None) -> dict:
    warps = warps or {"forward": 2.0, "mesh": 1.0}
    machine = {"gl_renderer": renderer, "gl_version": "4.3", "cpu_count": 8}
    bench = [
        {
            "hmdwarp": "1.0", "machine": machine, "clock": "gpu",
            "rows": [row(warp, size, ms) for warp, ms in warps.items()],
        }
        for size in SIZES
    ]  # fmt: skip
    doctor = [{"name": "OpenGL", "facts": {"renderer": renderer}}]
    time = {"median": 0.5, "p95": 0.75}
    chain = {"chain": "default chain", "size": [64, 48], "time_ms": {"warp": time, "total": time}}
    told = {
        "live": [], "bench_live": "a table\n", "arrays": "a ratio\n", "left_out": ["live 2: no time"],
        "chains": [chain],
    }  # fmt: skip
    return {"doctor": doctor, "bench": bench, **told}


def test_a_page_has_times_and_what_was_left_out():
    page = gpu_tables.section(gpu_json())
    assert page.startswith("## NVIDIA Some GPU\n")
    assert "none, 1280x800 | none, 2064x2208" in page
    assert "| `mesh` | 1.00 (2.00) | 1.00 (2.00) |" in page
    assert "a table" in page and "a ratio" in page and "- live 2: no time" in page


def test_parts_without_time_left_are_named(tmp_path):
    run = whole_gpu.Measuring(tmp_path, minutes=0)
    assert run.part("a part", "-c", "pass") is None
    run = whole_gpu.Measuring(tmp_path, minutes=1)
    assert run.part("a failure", "-c", "raise SystemExit('why')") is None
    assert run.left_out == ["a failure: why"]
    assert run.part("a part", "-c", "print('done')") == "done\n"
