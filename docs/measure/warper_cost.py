"""What a Warper costs beyond the passes that it runs: printed for docs/rgbd.md.

The passes alone and the Warper take turns in one process, on the same textures. Counted is the
processor time of the calling thread: Python and the driver's part of it, without what llvmpipe's
own threads draw and without what other programs take. With --ratios: the processor time of all
threads of a call with arrays, over that of its passes.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np
from apparatus import in_turns, options, print_table, sizes_in
from metrics.pictures import flip, ssim

from hmdwarp import Fov, Pose, View, Warper
from hmdwarp.client import Compensator, PassInputs
from hmdwarp.frames import EyeImage
from hmdwarp.gpu import COLOUR, SCALAR, Gpu, allocate, upload
from hmdwarp.image.picture_arrays import raw_picture
from hmdwarp.metrics import PairPass

# The smaller one has next to nothing to draw, and shows the cost of the calls alone.
SIZES, WARM = "64x48,640x480", 10
RATIO_SIZES, MOST = "640x480,1280x800,2064x2240", 1.25
LATE, NOW = (View(Pose((x, 0, 0)), Fov.symmetric(1.2, 0.95)) for x in (0.0, 0.03))


def measured(size: tuple[int, int], rounds: int, gpu: Gpu) -> dict[str, float]:
    """Return the milliseconds of the calling thread in each way: the passes alone come first."""
    wide, high = size
    rng = np.random.default_rng(0)
    colour, depth_m = rng.integers(0, 255, (high, wide, 3), np.uint8), np.full((high, wide), 2.0)
    with Warper(size, gpu=gpu) as warper:
        passes = Compensator(gpu, warper.plan, None, size, size)
        own = allocate(gpu.gl, size, COLOUR), allocate(gpu.gl, size, SCALAR)
        upload(own[0], rng.random((high, wide, 4), np.float32)), upload(own[1], np.full((high, wide), 0.5, np.float32))
        calls: dict[str, Callable[[], object]] = {
            "the passes alone": lambda: passes.run(PassInputs(EyeImage(LATE, *own), NOW, 0)),
            "`warp_textures`, read where they are": lambda: warper.warp_textures(*own, LATE, NOW),
            "`warp`, arrays": lambda: warper.warp(colour, depth_m, LATE, NOW),
        }
        took = in_turns(gpu, calls, rounds, clock=time.thread_time_ns, warm=WARM, waits=False)
        passes.close()
        for texture in own:
            texture.release()
    return {name: float(np.median(each)) for name, each in took.items()}


def call_over_passes(gpu: Gpu, size: tuple[int, int], rounds: int) -> tuple[str, float]:
    """Return a line on `warp` of bytes and float32 depth, and its ratio to all its passes."""
    wide, high = size
    colour = np.random.default_rng(0).integers(0, 256, (high, wide, 3), np.uint8)
    depth_m = np.tile(np.float32(2) + (np.arange(wide) * 6 // wide).astype(np.float32), (high, 1))  # steps
    raw = raw_picture(colour, depth_m)
    with Warper(size, gpu=gpu) as warper:
        warper.warp(colour, depth_m, LATE, NOW)
        pair, buffers = warper._pairs[0], warper._buffers
        sent = warper._take_in.send(raw, buffers)
        made = warper._compensator.run(PassInputs(EyeImage(LATE, *pair), NOW, 0))
        calls: dict[str, Callable[[], object]] = {
            "in": lambda: warper._take_in.run(raw, sent, pair, buffers.found, 0),
            "warp": lambda: warper._compensator.run(PassInputs(EyeImage(LATE, *pair), NOW, 0)),
            "out": lambda: warper._give_out.run(made.shown, made.warped, None, None, "srgb8", buffers),
            "whole": lambda: warper.warp(colour, depth_m, LATE, NOW),
        }
        took = in_turns(gpu, calls, rounds)
    ms = {name: float(np.median(each)) for name, each in took.items()}
    passes = ms["in"] + ms["warp"] + ms["out"]
    line = (
        f"Warper.warp, {wide}x{high}: {ms['whole']:.1f} ms of all threads; its passes {ms['in']:.1f} in, "
        f"{ms['warp']:.1f} warp and fill, {ms['out']:.1f} out: {ms['whole'] / passes:.2f} times (limit {MOST:g}); "
        f"{ms['whole'] / ms['warp']:.2f} times warp and fill"
    )
    return line, ms["whole"] / passes


def measuring_pictures(gpu: Gpu, size: tuple[int, int], rounds: int) -> str:
    """Return a line on FLIP and SSIM of a pair of pictures by the libraries, and by passes."""
    truth = np.random.default_rng(0).integers(0, 256, (size[1], size[0], 3), np.uint8)
    shown, passes = np.roll(truth, 1, axis=1), PairPass(gpu, size, 20.0)
    calls = {
        "library": lambda: (flip(shown, truth, 20.0), ssim(shown, truth)),
        "own": lambda: passes.run(shown, truth),
    }
    library, own = (float(np.median(each)) for each in in_turns(gpu, calls, rounds).values())
    passes.close()
    how = f"{library:.0f} ms by the libraries, {own:.0f} ms by passes: {own / library:.2f} times"
    return f"FLIP and SSIM, {size[0]}x{size[1]}: {how}"


def print_ratios(gpu: Gpu, rounds: int, sizes: Sequence[tuple[int, int]]) -> list[str]:
    """Print a line for each size, and return those above the limit."""
    found = [call_over_passes(gpu, size, rounds) for size in sizes]
    print("\n".join([*(line for line, _ in found), *(measuring_pictures(gpu, size, rounds) for size in sizes[:2])]))
    return [line for line, ratio in found if ratio > MOST]


def main() -> None:
    """Print a table, or the ratios."""
    chosen = options(
        __doc__,
        rounds=(0, "by default 200, and 9 of the ratios"),
        ratios=(False, "print them instead"),
        sizes=("", f"WxH, with commas; by default {SIZES}, and {RATIO_SIZES} of the ratios"),
    )
    sizes = sizes_in(chosen.sizes or (RATIO_SIZES if chosen.ratios else SIZES))
    with Gpu() as gpu:
        if chosen.ratios:
            print_ratios(gpu, chosen.rounds or 9, sizes)
            return
        rounds = chosen.rounds or 200
        columns = [measured(size, rounds, gpu) for size in sizes]
    print(f"Milliseconds of the calling thread, `iterative` with `pyramid`, medians of {rounds} turns, llvmpipe.\n")
    heads = ["call", *(head for wide, high in sizes for head in (f"{wide}x{high}", "beyond the passes"))]
    rows = []
    for way in columns[0]:
        pairs = ((found[way], found[way] - found["the passes alone"]) for found in columns)
        rows.append([way, *(f"{ms:.2f}" for pair in pairs for ms in pair)])
    print_table(heads, rows)


if __name__ == "__main__":
    main()
