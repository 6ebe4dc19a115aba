"""What a Warper costs beyond the passes that it runs: printed for docs/rgbd.md.

The passes alone and the Warper take turns in one process, on the same textures. Counted is the
processor time of the calling thread: Python and the driver's part of it, without what llvmpipe's
own threads draw and without what other programs take. With --ratios: the processor time of all
threads of a call with arrays, over that of its passes, at the sizes that follow (64x48 ..).
"""

from __future__ import annotations

import itertools
import sys
import time
from collections import deque
from collections.abc import Callable, Sequence
from statistics import median

import attrs
import numpy as np
from metrics.pictures import flip, ssim

from hmdwarp import Fov, Pose, View, Warper
from hmdwarp.client import Compensator, PassInputs
from hmdwarp.frames import EyeImage
from hmdwarp.gpu import COLOUR, SCALAR, Gpu, allocate, upload
from hmdwarp.image.picture_arrays import raw_picture
from hmdwarp.metrics import PairPass

# The smaller one has next to nothing to draw, and shows the cost of the calls alone.
SIZES, WARM = ((64, 48), (640, 480)), 10
RATIO_SIZES, MOST = ((640, 480), (1280, 800), (2064, 2240)), 1.25
WAYS = (
    "the passes alone",
    "`warp_textures`, read where they are",
    "`warp_textures`, taken over: sRGB bytes, metres",
    "`warp`, arrays",
)


def milliseconds(calls: list[Callable[[], object]], gpu: Gpu, rounds: int) -> list[float]:
    """Return the median processor time of each call, which take turns."""
    took: list[list[float]] = [[] for _ in calls]
    for number in range(WARM + rounds):
        # Another one begins each time: what a call leaves in the caches costs the next.
        turn = number % len(calls)
        for one, call in [*zip(took, calls, strict=True)][turn:] + [*zip(took, calls, strict=True)][:turn]:
            gpu.gl.finish()
            started = time.thread_time_ns()
            call()
            spent = (time.thread_time_ns() - started) * 1e-6
            gpu.timer.collect()
            if number >= WARM:
                one.append(spent)
    return [median(times) for times in took]


def measured(size: tuple[int, int], rounds: int, gpu: Gpu) -> list[float]:
    """Return the milliseconds of each of WAYS."""
    wide, high = size
    rng = np.random.default_rng(0)
    colour, depth_m = rng.integers(0, 255, (high, wide, 3), np.uint8), np.full((high, wide), 2.0)
    fov = Fov.symmetric(1.2, 0.95)
    late, now = (View(Pose((x, 0, 0)), fov) for x in (0.0, 0.03))
    with Warper(size, gpu=gpu) as warper:
        passes = Compensator(gpu, warper.plan, None, size, size)
        own = allocate(gpu.gl, size, COLOUR), allocate(gpu.gl, size, SCALAR)
        upload(own[0], rng.random((high, wide, 4), np.float32)), upload(own[1], np.full((high, wide), 0.5, np.float32))
        other = gpu.gl.texture(size, 4), gpu.gl.texture(size, 1, dtype="f4")
        other[0].write(rng.integers(0, 255, (high, wide, 4), np.uint8).tobytes())
        other[1].write(depth_m.astype(np.float32).tobytes())
        calls: list[Callable[[], object]] = [
            lambda: passes.run(PassInputs(EyeImage(late, *own), now, 0)),
            lambda: warper.warp_textures(*own, late, now),
            lambda: warper.warp_textures(*other, late, now, depth_as="metres", encoding="srgb"),
            lambda: warper.warp(colour, depth_m, late, now),
        ]
        found = milliseconds(calls, gpu, rounds)
        passes.close()
        for texture in (*own, *other):
            texture.release()
        return found


def call_over_passes(gpu: Gpu, size: tuple[int, int], rounds: int) -> tuple[str, float]:
    """Return a line on `warp` of bytes and float32 depth, and its ratio to all its passes."""
    wide, high = size
    colour = np.random.default_rng(0).integers(0, 256, (high, wide, 3), np.uint8)
    depth_m = np.tile(np.float32(2) + (np.arange(wide) * 6 // wide).astype(np.float32), (high, 1))  # steps
    late, now = (View(Pose((x, 0, 0)), Fov.symmetric(1.2, 0.95)) for x in (0.0, 0.03))
    raw = raw_picture(colour, depth_m)
    with Warper(size, gpu=gpu) as warper:
        out = attrs.asdict(warper.warp(colour, depth_m, late, now), recurse=False)
        out = {name: out[name] for name in ("colour", "coverage")}
        pair, buffers = warper._pictures[0].pair, warper._buffers[0]
        sent = warper._take_in.send(raw, buffers)
        made = warper._compensator.run(PassInputs(EyeImage(late, *pair), now, 0))
        calls: list[Callable[[], object]] = [
            lambda: warper._take_in.run(raw, sent, pair, buffers.found, 0),
            lambda: warper._compensator.run(PassInputs(EyeImage(late, *pair), now, 0)),
            lambda: warper._give_out.run(made.shown, made.warped, None, None, "srgb8", buffers),
            lambda: warper.warp(colour, depth_m, late, now, out=out),
            lambda: (flying.append(warper.submit(colour, depth_m, late, now, out=out)), flying.popleft().result()),
        ]
        flying = deque(warper.submit(colour, depth_m, late, now, out=out) for _ in range(2))
        took: list[list[float]] = [[] for _ in calls]
        for _, (times, call) in itertools.product(range(rounds), zip(took, calls, strict=True)):
            gpu.gl.finish()
            started = time.process_time_ns()
            call()
            gpu.gl.finish()
            times.append((time.process_time_ns() - started) * 1e-6)
        gpu.timer.collect()
    taking, warping, giving, whole, submitted = map(median, took)
    passes = taking + warping + giving
    ratio = max(whole, submitted) / passes
    line = (
        f"Warper.warp, {wide}x{high}: {whole:.1f} ms of all threads; its passes {taking:.1f} in, {warping:.1f} warp and"
    )
    line += (
        f" fill, {giving:.1f} out: {whole / passes:.2f} times (limit {MOST:g}); {whole / warping:.2f} times warp and"
    )
    line += f" fill; by submit {submitted:.1f} ms, {submitted / passes:.2f} times"
    return line, ratio


def measuring(gpu: Gpu, size: tuple[int, int], rounds: int) -> str:
    """Return a line on FLIP and SSIM of a pair of pictures by the libraries, and by passes."""
    truth = np.random.default_rng(0).integers(0, 256, (size[1], size[0], 3), np.uint8)
    shown = np.roll(truth, 1, axis=1)
    passes = PairPass(gpu, size, 20.0)
    calls: list[Callable[[], object]] = [
        lambda: (flip(shown, truth, 20.0), ssim(shown, truth)),
        lambda: passes.run(shown, truth),
    ]
    took: list[list[float]] = [[] for _ in calls]
    for _, (times, call) in itertools.product(range(rounds), zip(took, calls, strict=True)):
        started = time.process_time_ns()
        call()
        times.append((time.process_time_ns() - started) * 1e-6)
    passes.close()
    library, own = map(median, took)
    how = f"{library:.0f} ms by the libraries, {own:.0f} ms by passes: {own / library:.2f} times"
    return f"FLIP and SSIM, {size[0]}x{size[1]}: {how}"


def print_ratios(gpu: Gpu, rounds: int, sizes: Sequence[tuple[int, int]] = RATIO_SIZES) -> list[str]:
    """Print a line for each size, and return those above the limit."""
    found = [call_over_passes(gpu, size, rounds) for size in sizes]
    print("\n".join([*(line for line, _ in found), *(measuring(gpu, size, rounds) for size in sizes[:2])]))
    return [line for line, ratio in found if ratio > MOST]


def main() -> None:
    """Print a table."""
    if sys.argv[1:2] == ["--ratios"]:
        with Gpu() as gpu:
            sizes = [tuple(map(int, size.split("x"))) for size in sys.argv[2:]]
            print_ratios(gpu, 9, sizes or RATIO_SIZES)
        return
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    with Gpu() as gpu:
        columns = [measured(size, rounds, gpu) for size in SIZES]
    print(f"Milliseconds of the calling thread, `iterative` with `pyramid`, medians of {rounds} turns, llvmpipe.\n")
    heads = "".join(f" {wide}x{high} | beyond the passes |" for wide, high in SIZES)
    print(f"| call |{heads}\n| --- |{' ---: | ---: |' * len(SIZES)}")
    for number, way in enumerate(WAYS):
        cells = "".join(f" {found[number]:.2f} | {found[number] - found[0]:.2f} |" for found in columns)
        print(f"| {way} |{cells}")


if __name__ == "__main__":
    main()
