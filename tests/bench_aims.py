"""How near the warps' aims of speed are: a table for docs/performance.md.

Processor time of all threads, OpenCV's on one, which a machine with other work changes less than it
does the clock on the wall. All methods take turns in one process.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Mapping

import attrs
import cv2
import numpy as np
from bench_feed import VIEWS
from bench_quick import Case
from PIL import Image

from hmdwarp import View, Warper
from hmdwarp.client import Compensator, PassInputs
from hmdwarp.client.warps import warps
from hmdwarp.colour import linear_from_srgb, srgb8_from_linear
from hmdwarp.frames import EyeImage
from hmdwarp.geometry import inverse_depth_from_metres
from hmdwarp.gpu import SCALAR, Gpu, allocate, download, upload
from hmdwarp.poses import load_trace
from hmdwarp.scenes import load_scene
from hmdwarp.sources.array_passes import LINEAR, SRGB8, Arrays, Scaling
from hmdwarp.sources.server import Renderer, Server

SIZE = (1280, 800)
# (what, over what, at most, what it is over)
FRAMES = tuple(
    (name, f"{name} by NumPy", 1.0, f"{told} over the same by NumPy{' and PIL' if name == 'averaged' else ''}")
    for name, told in (
        ("recorded", "a recorded frame to textures"),
        ("averaged", "a recorded frame averaged to two thirds of its sides"),
        ("full", "a frame of the feed to textures, `--raw full`,"),
        ("half", "a frame of the feed to textures, `--raw half`,"),
        ("given", "a drawn frame to the bytes of `--raw half`"),
    )
)
# Of `iterative` with a fill over it alone: before the aim was set, 1.9, 3.0 and 4.0; half of this.
FILLS = ("none", "pyramid", "memory", "memory+pyramid")
AIMS = (
    *FRAMES,
    ("fill memory+pyramid", "fill none", 2.0, "`iterative` with `memory+pyramid` over it without"),
    ("backward with its depth", "forward", 1.0, "`backward` with the client's depth over `forward`"),
)
PARTS = (
    ("forward", "warpFrame", "`forward` over cv2.warpFrame"),
    ("none", "forward", "copying a picture (`none`) over `forward`"),
    ("depth", "forward", "drawing the client's depth alone over `forward`"),
    ("depth, 2x2 pixels", "depth", "the same without pixels: its triangles"),
    ("backward", "forward", "`backward` without the client's depth over `forward`"),
    ("unseeded", "iterative", "`iterative` without its seed (`seed=rotation`) over `iterative`"),
    ("iterative", "warpFrame", "`iterative` over cv2.warpFrame"),
    ("fill memory", "fill none", "`iterative` with `memory` over it without"),
    ("fill pyramid", "fill none", "`iterative` with `pyramid` over it without"),
)


def methods_of(case: Case, gpu: Gpu) -> dict[str, Callable[[], object]]:
    """Return what the aims and their parts need, by name."""
    iterative = warps.get("iterative")
    unseeded = iterative(gpu, case.size, case.size, iterative.Settings(seed="rotation"))
    few = allocate(gpu.gl, (2, 2), SCALAR)
    every = case.methods()
    wanted = {name for aim in (*AIMS, *PARTS) for name in aim[:2]}
    return {name: run for name, run in every.items() if name in wanted} | {
        "unseeded": lambda: unseeded.run(case.inputs, case.canvas),
        "depth": lambda: case.server.draw_depth(case.shown, case.size, case.client_depth),
        "depth, 2x2 pixels": lambda: case.server.draw_depth(case.shown, (2, 2), few),
    }


def filled(case: Case, gpu: Gpu, time_s: float) -> dict[str, Callable[[], object]]:
    """Return `iterative` with each of FILLS; memory has older pictures, and learns each time."""
    track, found = load_trace("look-around").track, {}
    older = [
        case.server.draw(View(track.at(track.start_ns + round((time_s - late) * 1e9)).pose, case.shown.fov), SIZE)
        for late in (0.6, 0.4)
    ]
    for fill in FILLS:
        with Warper(SIZE, warp="iterative", fill=fill, gpu=gpu) as warper:
            chain = Compensator(gpu, warper.plan, None, SIZE, SIZE)
        for rendered in older:
            chain.run(PassInputs(rendered, case.shown))
        found[f"fill {fill}"] = lambda chain=chain: (chain.renew(), chain.run(case.inputs))
    return found


def measured(gpu: Gpu, methods: Mapping[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Return the median milliseconds of processor time, after one round to warm up."""
    times: dict[str, list[float]] = {name: [] for name in methods}
    for _ in range(rounds + 1):
        for name, run in methods.items():
            gpu.gl.finish()
            started = time.process_time_ns()
            run()
            gpu.gl.finish()
            times[name].append((time.process_time_ns() - started) * 1e-6)
    return {name: float(np.median(values[1:])) for name, values in times.items()}


def frames_taken(gpu: Gpu, size: tuple[int, int]) -> dict[str, Callable[[], object]]:
    """Return how frames go to the GPU and from it, and the same by NumPy, as it was before."""
    rng, renderer = np.random.default_rng(1), Renderer(gpu, load_scene("room"))
    colour, metres = rng.integers(0, 256, (*size[::-1], 4), np.uint8), rng.uniform(0.5, 9, size[::-1]).astype("f4")
    light, inverse, target = rng.random(colour.shape, np.float32).astype(np.float16), 1 / metres, renderer.acquire(size)
    codes, step = rng.integers(0, 65535, metres.shape, np.uint16), float(np.float32(1e-4))
    recorded = Arrays(np.ascontiguousarray(colour[..., :3]), SRGB8, metres, is_apart=True)
    fed = {
        "full": Arrays(light, LINEAR, inverse, is_inverse=True, is_apart=True),
        "half": Arrays(colour, SRGB8, codes, step, is_inverse=True, is_apart=True),
    }
    eye = EyeImage(VIEWS[0], target.colour, target.inverse_depth)
    less = (size[0] * 2 // 3, size[1] * 2 // 3)
    averaged, smaller = attrs.evolve(recorded, scaling=Scaling(less, (0, 0, *size))), renderer.acquire(less)

    def by_numpy(light: np.ndarray, inverse: np.ndarray) -> None:
        upload(target.colour, light.astype(np.float16, copy=False))
        upload(target.inverse_depth, inverse.astype(np.float32, copy=False))

    def recorded_by_numpy() -> None:
        found, covered = linear_from_srgb(recorded.colour).astype(np.float32), np.ones((*metres.shape, 1), np.float32)
        inverse = inverse_depth_from_metres(metres)
        by_numpy(np.concatenate([found, covered], axis=2), np.where(np.isnan(inverse), -1, inverse))

    def averaged_by_numpy() -> None:
        light = linear_from_srgb(recorded.colour)
        found = [
            np.asarray(Image.fromarray(one).resize(less, Image.Resampling.BOX)) for one in np.moveaxis(light, 2, 0)
        ]
        row, column = ((np.arange(n) + 0.5) * (of / n) for n, of in zip(less[::-1], size[::-1], strict=True))
        upload(smaller.colour, np.dstack([*found, np.ones_like(found[0])]).astype(np.float16))
        nearest = metres[row.astype(int)[:, None], column.astype(int)]
        upload(smaller.inverse_depth, inverse_depth_from_metres(nearest).astype(np.float32))

    def half_by_numpy() -> None:
        found = linear_from_srgb(colour).astype(np.float16)
        found[..., 3] = colour[..., 3] > 0
        by_numpy(found, np.where(codes == 65535, np.float32(-1), codes * np.float32(step)))

    def given_by_numpy() -> None:
        drawn, depth = download(target.colour), download(target.inverse_depth)
        np.dstack([srgb8_from_linear(drawn[..., :3]), np.where(drawn[..., 3] > 0, 255, 0).astype(np.uint8)])
        np.where(depth < 0, 65535, np.rint(depth * (65534 / depth.max()))).astype(np.uint16)

    return {
        "recorded": lambda: renderer.take_in(recorded, target),
        "recorded by NumPy": recorded_by_numpy,
        "averaged": lambda: renderer.take_in(averaged, smaller),
        "averaged by NumPy": averaged_by_numpy,
        "full": lambda: renderer.take_in(fed["full"], target),
        "full by NumPy": lambda: by_numpy(light, inverse),
        "half": lambda: renderer.take_in(fed["half"], target),
        "half by NumPy": half_by_numpy,
        "given": lambda: renderer.give_codes(eye),
        "given by NumPy": given_by_numpy,
    }


def table(took: Mapping[str, float]) -> str:
    """Return the ratios as a Markdown table: aims first, then what they are made of."""
    lines = ["| ratio of processor times, 1280x800 | measured | aim | |", "| --- | ---: | ---: | --- |"]
    for what, other, most, told in AIMS:
        ratio = took[what] / took[other]
        lines.append(f"| {told} | {ratio:.2f} | {most:g} | {'met' if ratio <= most else 'not met'} |")
    lines += [f"| {told} | {took[what] / took[other]:.2f} | | |" for what, other, told in PARTS]
    return "\n".join(lines)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=25)
    parser.add_argument("--time", type=float, default=3.0, help="seconds into look-around")
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    with Gpu() as gpu:
        server = Server(gpu, load_scene("room"))
        case = Case(gpu, server, SIZE, arguments.time)
        methods = methods_of(case, gpu) | filled(case, gpu, arguments.time) | frames_taken(gpu, SIZE)
        print(table(measured(gpu, methods, arguments.rounds)))
        server.close()


if __name__ == "__main__":
    main()
