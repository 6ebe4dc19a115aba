"""How long one eye takes, against OpenCV on the same frame in the same process: `make bench-quick`.

Prints ratios, which carry over between machines better than times do. Each round runs every method
once, so that a machine that slows down slows all of them; the figures are medians over the rounds.
OpenCV uses two threads. Then what a call with arrays takes over its passes. At the end: how many
frames a second a whole replay makes, from typing the command to its page, and how long the command
line takes to start.

With --aims: the processor time of all threads, OpenCV's on one, which a machine with other work
changes less than it does the clock on the wall; how near the warps' aims are, and what stands in
their way.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from apparatus import Methods, in_turns, options, print_table, sizes_in
from rich.console import Console
from rich.table import Table
from warper_cost import RATIO_SIZES, print_ratios

from hmdwarp import Warper
from hmdwarp.client import Compensator, PassInputs, ShownPicture
from hmdwarp.client.fills import fills
from hmdwarp.client.lens import lenses
from hmdwarp.client.warps import warps
from hmdwarp.geometry import Fov, View
from hmdwarp.gpu import SCALAR, Canvas, Gpu, allocate
from hmdwarp.headsets import load_headset
from hmdwarp.poses import load_trace
from hmdwarp.run.measuring import OpenCvWarp
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

# OpenCV's threads spin for a few milliseconds after their work, on the cores that the next method
# needs; so it comes last.
PAUSE_S = 0.05
TIMED = ("backward", "forward", "iterative", "none", "planar", "rotation")  # `hmdwarp bench` times all the others
# Against which OpenCV function each warp is held, and the ratio it must not exceed, per size.
LIMITS = {
    (1280, 800): {"rotation": ("remap", 3.0), "backward": ("remap", 3.0), "forward": ("warpFrame", 1.2)},
    (2064, 2208): {"forward": ("warpFrame", 0.75)},
}
REPLAY = (
    "look-around",
    "--scene",
    "room",
    "--headset",
    "rift-dk1",
    "--size",
    "640x400",
    "--metrics-every",
    "10",
    "--quiet",
)
LEAST_FRAMES_PER_S = 10.0
STARTS = {"import hmdwarp": (0.3, "-c", "import hmdwarp"), "hmdwarp --help": (0.5, "-m", "hmdwarp", "--help")}
FILLS = ("none", "pyramid", "memory", "memory+pyramid")
# What, over what, at most, how it is told: the aims, then what they are made of.
AIMS = (
    ("fill memory+pyramid", "fill none", 2.0, "`iterative` with `memory+pyramid` over it without"),
    ("backward with its depth", "forward", 1.0, "`backward` with the client's depth over `forward`"),
    ("forward", "warpFrame", None, "`forward` over cv2.warpFrame"),
    ("none", "forward", None, "copying a picture (`none`) over `forward`"),
    ("depth", "forward", None, "drawing the client's depth alone over `forward`"),
    ("depth, 2x2 pixels", "depth", None, "the same without pixels: its triangles"),
    ("backward", "forward", None, "`backward` without the client's depth over `forward`"),
    ("unseeded", "iterative", None, "`iterative` without its seed (`seed=rotation`) over `iterative`"),
    ("iterative", "warpFrame", None, "`iterative` over cv2.warpFrame"),
    ("fill memory", "fill none", None, "`iterative` with `memory` over it without"),
    ("fill pyramid", "fill none", None, "`iterative` with `pyramid` over it without"),
)


class Case:
    """A late frame of `room` and the view 200 ms later, on the GPU and as OpenCV wants it."""

    def __init__(self, gpu: Gpu, server: Server, size: tuple[int, int], time_s: float) -> None:
        self.gpu, self.server, self.size = gpu, server, size
        half = np.arctan(np.tan(np.deg2rad(48)) * np.array([1, size[1] / size[0]]))
        self._fov, self._time_s = Fov(-half[0], half[0], -half[1], half[1]), time_s
        self._track = load_trace("look-around").track
        self.shown, self.rendered = self._view(0), server.draw(self._view(0.2), size)
        self.client_depth = allocate(gpu.gl, size, SCALAR)
        self._draw_depth()
        self.inputs = PassInputs(self.rendered, self.shown, client_inverse_depth=self.client_depth)
        self.canvas, self._other = Canvas(gpu.gl, size), Canvas(gpu.gl, size)

    def _view(self, late_s: float) -> View:
        now_ns = self._track.start_ns + round((self._time_s - late_s) * 1e9)
        return View(self._track.at(now_ns).pose, self._fov)

    def _draw_depth(self) -> None:
        """Draw the client's own depth, as it must before each warp that reads it."""
        self.server.draw_depth(self.shown, self.size, self.client_depth)

    def methods(self) -> dict[str, Callable[[], object]]:
        """Return what the tables time, by name, OpenCV's last."""
        made: dict[str, Callable[[], object]] = {}
        for name in TIMED:
            warp = warps.get(name)(self.gpu, self.size, self.size)
            made[name] = lambda warp=warp: warp.run(self.inputs, self.canvas)
        backward = made["backward"]
        made["backward with its depth"] = lambda: (self._draw_depth(), backward())
        fill = fills.get("interpolate")(self.gpu, self.size, self.size)
        made["fill interpolate"] = lambda: fill.run(self.inputs, ShownPicture(self.canvas), ShownPicture(self._other))
        lens = lenses.get("radial")(self.gpu, load_headset("rift-dk1"), self.size)
        made["lens radial"] = lambda: lens.run(self.canvas, self.shown.fov, 0, self._other)
        opencv = OpenCvWarp(self.gpu, self.size, self.size)
        depth, picture, mask, motion, camera, _ = opencv.arrays(self.inputs)
        wide, high = self.size
        x, y = np.meshgrid(np.arange(wide, dtype=np.float32), np.arange(high, dtype=np.float32))
        turned = np.stack([x, y, np.ones_like(x)], axis=-1) @ (
            camera @ motion[:3, :3].T @ np.linalg.inv(camera)
        ).T.astype(np.float32)
        map_x, map_y = (np.ascontiguousarray(turned[..., k] / turned[..., 2]) for k in (0, 1))
        out = np.empty_like(picture)
        made["remap"] = lambda: cv2.remap(picture, map_x, map_y, cv2.INTER_LINEAR, dst=out)
        made["warpFrame"] = lambda: cv2.warpFrame(depth, picture, mask, motion, camera)
        return made

    def parts(self) -> dict[str, Callable[[], object]]:
        """Return what the aims need beside that; `memory` has older pictures, and learns anew."""
        iterative = warps.get("iterative")
        unseeded = iterative(self.gpu, self.size, self.size, iterative.Settings(seed="rotation"))
        few = allocate(self.gpu.gl, (2, 2), SCALAR)
        made: dict[str, Callable[[], object]] = {
            "unseeded": lambda: unseeded.run(self.inputs, self.canvas),
            "depth": self._draw_depth,
            "depth, 2x2 pixels": lambda: self.server.draw_depth(self.shown, (2, 2), few),
        }
        older = [self.server.draw(self._view(late_s), self.size) for late_s in (0.6, 0.4)]
        for fill in FILLS:
            with Warper(self.size, warp="iterative", fill=fill, gpu=self.gpu) as warper:
                chain = Compensator(self.gpu, warper.plan, None, self.size, self.size)
            for rendered in older:
                chain.run(PassInputs(rendered, self.shown))
            made[f"fill {fill}"] = lambda chain=chain: (chain.renew(), chain.run(self.inputs))
        return made


def timed(gpu: Gpu, methods: Methods, rounds: int) -> dict[str, np.ndarray]:
    """Return the milliseconds of each method in each round, on the wall's clock."""
    first = next(iter(methods.values()))

    def stay_awake() -> None:
        """Work for a pause: a processor that has slept is slow for a while."""
        until = time.perf_counter() + PAUSE_S
        while time.perf_counter() < until:
            first()
            gpu.gl.finish()

    return in_turns(gpu, methods, rounds, clock=time.perf_counter_ns, before=stay_awake)


def warm(gpu: Gpu, methods: Methods, size: tuple[int, int], rounds: int) -> str:
    """Return a line of the same ratios in tight loops, where what is touched may stay cached."""
    names = (*LIMITS[size], *(other for other, _ in LIMITS[size].values()))
    times = {name: float(np.median(timed(gpu, {name: methods[name]}, rounds)[name])) for name in names}
    ratios = (
        f"{name} {times[name]:.2f} ms, {times[name] / times[other]:.2f} x {other}"
        for name, (other, _) in LIMITS[size].items()
    )
    return f"alone in a tight loop: {'; '.join(ratios)}"


def table(size: tuple[int, int], times: dict[str, np.ndarray]) -> tuple[Table, list[str]]:
    """Return what was measured at one size, and which limits were missed."""
    heads = ("method", "median ms", "least ms", "against", "ratio", "limit")
    out, missed = Table(*heads, title=f"{size[0]}x{size[1]}, one eye", title_justify="left"), []
    for name, values in times.items():
        other, limit = LIMITS[size].get(name, (None, 0.0))
        ratio = float(np.median(values) / np.median(times[other])) if other else 0.0
        cells = (other, f"{ratio:.2f}", f"{limit:g}") if other else ("", "", "")
        out.add_row(name, f"{np.median(values):.2f}", f"{values.min():.2f}", *cells)
        if ratio > limit:
            missed.append(f"{name} at {size[0]}x{size[1]}: {ratio:.2f} times {other}, limit {limit:g}")
    return out, missed


def aims(case: Case, rounds: int) -> None:
    """Print ratios of processor times."""
    needed = {name for aim in AIMS for name in aim[:2]}
    methods = {name: run for name, run in (case.methods() | case.parts()).items() if name in needed}
    took = {name: float(np.median(each)) for name, each in in_turns(case.gpu, methods, rounds).items()}
    rows = []
    for what, other, most, told in AIMS:
        ratio = took[what] / took[other]
        aim = ["", ""] if most is None else [f"{most:g}", "met" if ratio <= most else "not met"]
        rows.append([told, f"{ratio:.2f}", *aim])
    heads = [f"ratio of processor times, {case.size[0]}x{case.size[1]}", "measured", "aim", ""]
    print_table(heads, rows)


def seconds_of(*arguments: str) -> float:
    """Return the wall time of a Python of its own."""
    started = time.perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - started


def whole_replay(seconds: float) -> tuple[str, bool]:
    """Return frames a second of a replay with start-up and report; and whether they are too few."""
    with tempfile.TemporaryDirectory() as out:
        took = seconds_of("-m", "hmdwarp", "replay", *REPLAY, "--seconds", f"{seconds:g}", "--out", out)
        frames = json.loads((Path(out) / "summary.json").read_text(encoding="utf-8"))["frames"]
    rate = f"{frames / took:.1f} a second (limit {LEAST_FRAMES_PER_S:g})"
    return f"whole replay, 640x400 per eye, {frames} frames: {rate}", frames / took < LEAST_FRAMES_PER_S


def commands(console: Console, seconds: float, rounds: int) -> list[str]:
    """Print what whole commands take, and return what is too slow."""
    missed = []
    if seconds:
        line, is_slow = whole_replay(seconds)
        console.print(line)
        missed += [line] * is_slow
    told = []
    for name, (limit_s, *arguments) in STARTS.items():
        took_s = float(np.median([seconds_of(*arguments) for _ in range(rounds)]))
        told.append(f"{name} {took_s:.2f} s (limit {limit_s:g})")
        missed += told[-1:] * (took_s > limit_s)
    console.print(f"start: {'; '.join(told)}")
    return missed


def main() -> None:
    """Measure and print."""
    chosen = options(
        __doc__,
        aims=(False, "print how near the aims are instead"),
        rounds=(0, "by default 15, and 25 of the aims"),
        time=(3.0, "seconds into look-around"),
        seconds=(5.0, "of the whole replay; 0 leaves it out"),
        sizes=(3, "leave out the sizes after so many"),
    )
    rounds = chosen.rounds or (25 if chosen.aims else 15)
    cv2.setNumThreads(1 if chosen.aims else 2)
    console, missed = Console(), []
    with Gpu() as gpu:
        server = Server(gpu, load_scene("room"))
        if chosen.aims:
            aims(Case(gpu, server, next(iter(LIMITS)), chosen.time), rounds)
            return
        console.print(f"{gpu.renderer}, OpenCV {cv2.__version__}, {rounds} rounds")
        for size in [*LIMITS][: chosen.sizes]:
            methods = Case(gpu, server, size, chosen.time).methods()
            shown, slow = table(size, timed(gpu, methods, rounds))
            console.print(shown)
            console.print(warm(gpu, methods, size, rounds))
            missed += slow
        server.close()
        missed += print_ratios(gpu, max(rounds // 3, 1), sizes_in(RATIO_SIZES)[: chosen.sizes])
    for line in [*missed, *commands(console, chosen.seconds, rounds)]:
        console.print(f"missed: {line}")


if __name__ == "__main__":
    main()
