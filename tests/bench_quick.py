"""How long one eye takes, against OpenCV on the same frame in the same process: `make bench-quick`.

Prints ratios, which carry over between machines better than times do. Each round runs every method
once, so that a machine that slows down slows all of them; the figures are medians over the rounds.
OpenCV uses two threads. Then what a call with arrays takes over its passes. At the end: how many
frames a second a whole replay makes, from typing the command to its page, and how long the command
line takes to start.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from bench_feed import SIZES, over_memcpy
from bench_warper import RATIO_SIZES, print_ratios
from rich.console import Console
from rich.table import Table

from hmdwarp.client import PassInputs, ShownPicture
from hmdwarp.client.fills import fills
from hmdwarp.client.lens import lenses
from hmdwarp.client.warps import warps
from hmdwarp.colour import picture_from_linear
from hmdwarp.geometry import Fov, View
from hmdwarp.gpu import SCALAR, Canvas, Gpu, allocate, download
from hmdwarp.headsets import load_headset
from hmdwarp.poses import load_trace
from hmdwarp.run.combinations import opencv_camera, opencv_depth, opencv_motion
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

# OpenCV's threads spin for a few milliseconds after their work, on the cores that the next method
# needs; so it comes last.
PAUSE_S = 0.05
LATENCY_NS = 200_000_000
# Against which OpenCV function each warp is held, and the ratio it must not exceed, per size.
TIMED = ("backward", "forward", "iterative", "none", "planar", "rotation")  # `hmdwarp bench` times all the others
LIMITS = {
    (1280, 800): {"rotation": ("remap", 3.0), "backward": ("remap", 3.0), "forward": ("warpFrame", 1.2)},
    (2064, 2208): {"forward": ("warpFrame", 0.75)},
}


REPLAY = ("look-around", "--scene", "room", "--size", "640x400", "--metrics-every", "10", "--quiet")
LEAST_FRAMES_PER_S = 10.0
_SHORT = ("--size", "640x400", "--latency", "100", "--latency", "200")
AGAIN = (
    ("replay", *REPLAY[1:5], "--seconds", "0.4", "--against", "none,forward+interpolate", "--metrics-every", "1"),
    ("compare", *_SHORT, "--seconds", "0.3", "--strategy", "depth_image,rotation"),
    ("bench", *_SHORT, "--warp", "forward,iterative", "--instants", "6"),
)
START_LIMITS_S = {"import hmdwarp": 0.3, "hmdwarp --help": 0.5}


class Case:
    """One late frame of `room` and the view 200 ms later, on the GPU and as OpenCV wants it."""

    def __init__(self, gpu: Gpu, server: Server, size: tuple[int, int], time_s: float) -> None:
        self.gpu, self.size = gpu, size
        track = load_trace("look-around").track
        now = track.start_ns + round(time_s * 1e9)
        half = np.arctan(np.tan(np.deg2rad(48)) * np.array([1, size[1] / size[0]]))
        fov = Fov(-half[0], half[0], -half[1], half[1])
        self.shown = View(track.at(now).pose, fov)
        self.rendered = server.draw(View(track.at(now - LATENCY_NS).pose, fov), size)
        self.server, self.client_depth = server, allocate(gpu.gl, size, SCALAR)
        self._draw_depth()
        self.inputs = PassInputs(self.rendered, self.shown, client_inverse_depth=self.client_depth)
        self.canvas, self.other = Canvas(gpu.gl, size), Canvas(gpu.gl, size)

    def _draw_depth(self) -> None:
        """Draw the client's own depth, as it must before each warp that reads it."""
        self.server.draw_depth(self.shown, self.size, self.client_depth)

    def methods(self) -> dict[str, Callable[[], object]]:
        made: dict[str, Callable[[], object]] = {}
        for name in TIMED:
            warp = warps.get(name)(self.gpu, self.size, self.size)
            made[name] = lambda warp=warp: warp.run(self.inputs, self.canvas)
        backward = made["backward"]
        made["backward with its depth"] = lambda: (self._draw_depth(), backward())
        fill = fills.get("interpolate")(self.gpu, self.size, self.size)
        made["fill interpolate"] = lambda: fill.run(self.inputs, ShownPicture(self.canvas), ShownPicture(self.other))
        lens = lenses.get("radial")(self.gpu, load_headset("rift-dk1"), self.size)
        made["lens radial"] = lambda: lens.run(self.canvas, self.shown.fov, 0, self.other)
        return {**made, **self._opencv()}

    def _opencv(self) -> dict[str, Callable[[], object]]:
        picture = picture_from_linear(download(self.rendered.colour))
        depth, mask = opencv_depth(download(self.rendered.inverse_depth))
        wide, high = self.size
        camera, motion = opencv_camera(self.shown, self.size), opencv_motion(self.rendered.view, self.shown)
        x, y = np.meshgrid(np.arange(wide, dtype=np.float32), np.arange(high, dtype=np.float32))
        turned = np.stack([x, y, np.ones_like(x)], axis=-1) @ (
            camera @ motion[:3, :3].T @ np.linalg.inv(camera)
        ).T.astype(np.float32)
        map_x, map_y = (np.ascontiguousarray(turned[..., k] / turned[..., 2]) for k in (0, 1))
        out = np.empty_like(picture)
        return {
            "remap": lambda: cv2.remap(picture, map_x, map_y, cv2.INTER_LINEAR, dst=out),
            "warpFrame": lambda: cv2.warpFrame(depth, picture, mask, motion, camera),
        }


def measure(gpu: Gpu, methods: dict[str, Callable[[], object]], rounds: int) -> dict[str, np.ndarray]:
    """Milliseconds of each method in each round, after one round to warm up.

    Between two runs of a method all others run, as in a frame loop: nobody finds the caches as it
    left them.
    """
    times: dict[str, list[float]] = {name: [] for name in methods}
    first = next(iter(methods.values()))
    for number in range(rounds + 1):
        awake_until = time.perf_counter() + PAUSE_S
        while time.perf_counter() < awake_until:  # not asleep: a processor that has slept is slow for a while
            first()
            gpu.gl.finish()
        for name, run in methods.items():
            gpu.gl.finish()
            started = time.perf_counter_ns()
            run()
            gpu.gl.finish()
            if number:
                times[name].append((time.perf_counter_ns() - started) * 1e-6)
    return {name: np.array(values) for name, values in times.items()}


def warm(gpu: Gpu, methods: dict[str, Callable[[], object]], size: tuple[int, int], rounds: int) -> str:
    """One line.

    The same ratios with each method alone in a tight loop, where everything it touches may stay in
    the caches.
    """
    times = {}
    for name in (*LIMITS[size], *{other for other, _ in LIMITS[size].values()}):
        alone = {name: methods[name]}
        times[name] = float(np.median(measure(gpu, alone, rounds)[name]))
    ratios = (
        f"{name} {times[name]:.2f} ms, {times[name] / times[other]:.2f} x {other}"
        for name, (other, _) in LIMITS[size].items()
    )
    return f"alone in a tight loop: {'; '.join(ratios)}"


def table(size: tuple[int, int], times: dict[str, np.ndarray]) -> tuple[Table, list[str]]:
    """What was measured at one size, and which limits were missed."""
    out = Table(
        "method",
        "median ms",
        "least ms",
        "against",
        "ratio",
        "limit",
        title=f"{size[0]}x{size[1]}, one eye",
        title_justify="left",
    )
    missed = []
    for name, values in times.items():
        other, limit = LIMITS[size].get(name, (None, None))
        ratio = float(np.median(values) / np.median(times[other])) if other else None
        cells = (other, f"{ratio:.2f}", f"{limit:g}") if other else ("", "", "")
        out.add_row(name, f"{np.median(values):.2f}", f"{values.min():.2f}", *cells)
        if other and ratio > limit:
            missed.append(f"{name} at {size[0]}x{size[1]}: {ratio:.2f} times {other}, limit {limit:g}")
    return out, missed


def seconds_of(*arguments: str) -> float:
    """Wall time of a Python of its own."""
    started = time.perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - started


def whole_replay(seconds: float) -> tuple[str, list[str]]:
    """Frames a second of a whole replay with its default comparison, start-up and report included.

    And whether that is too few.
    """
    with tempfile.TemporaryDirectory() as out:
        took = seconds_of("-m", "hmdwarp", "replay", *REPLAY, "--seconds", f"{seconds:g}", "--out", out)
        frames = json.loads((Path(out) / "summary.json").read_text(encoding="utf-8"))["frames"]
    told = (
        f"whole replay, 640x400 per eye, {frames} frames: {frames / took:.1f} a second (limit {LEAST_FRAMES_PER_S:g})"
    )
    return told, [told] if frames / took < LEAST_FRAMES_PER_S else []


def cpu_of(*arguments: str) -> float:
    """Processor time of a Python of its own and its children."""
    before = os.times()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def second_runs() -> str:
    """What a cache spares the second of two equal runs."""
    found = []
    for command, *options in AGAIN:
        with tempfile.TemporaryDirectory() as folder:
            again = (
                "-m",
                "hmdwarp",
                command,
                "look-around",
                *options,
                "--cache",
                f"{folder}/kept",
                "--quiet",
                "--force",
            )
            first, second = (cpu_of(*again, "--out", f"{folder}/out") for _ in range(2))
        found.append(f"{command} {first:.1f} s, then {second:.1f}: {second / first:.2f} times")
    return f"processor time with --cache: {'; '.join(found)}"


def starting(rounds: int) -> tuple[str, list[str]]:
    """Medians of what each start of the program costs; and which are too long."""
    how = {"import hmdwarp": ("-c", "import hmdwarp"), "hmdwarp --help": ("-m", "hmdwarp", "--help")}
    took = {name: float(np.median([seconds_of(*arguments) for _ in range(rounds)])) for name, arguments in how.items()}
    told = {name: f"{name} {seconds:.2f} s (limit {START_LIMITS_S[name]:g})" for name, seconds in took.items()}
    return f"start: {'; '.join(told.values())}", [told[name] for name in told if took[name] > START_LIMITS_S[name]]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--time", type=float, default=3.0, help="seconds into look-around")
    parser.add_argument("--seconds", type=float, default=5.0, help="of the whole replay; 0 leaves commands out")
    parser.add_argument("--sizes", type=int, default=len(RATIO_SIZES), help="leave out the sizes after so many")
    arguments = parser.parse_args()
    cv2.setNumThreads(2)
    console, missed = Console(), []
    with Gpu() as gpu:
        server = Server(gpu, load_scene("room"))
        console.print(f"{gpu.renderer}, OpenCV {cv2.__version__}, {arguments.rounds} rounds")
        for size in [*LIMITS][: arguments.sizes]:
            methods = Case(gpu, server, size, arguments.time).methods()
            shown, rendered = table(size, measure(gpu, methods, arguments.rounds))
            console.print(shown)
            console.print(warm(gpu, methods, size, arguments.rounds))
            missed += rendered
        server.close()
        missed += print_ratios(gpu, max(arguments.rounds // 3, 1), RATIO_SIZES[: arguments.sizes])
    for line, rendered in (
        *([whole_replay(arguments.seconds)] if arguments.seconds else []),
        starting(arguments.rounds),
    ):
        console.print(line)
        missed += rendered
    for line in (*map(over_memcpy, SIZES), *([second_runs()] if arguments.seconds else [])):
        console.print(line)
    for line in missed:
        console.print(f"missed: {line}")


if __name__ == "__main__":
    main()
