"""What foveated frames save and cost at a late gaze: two tables for docs/foveation.md.

Replays of made-up eyes, and processor time of all threads for one eye, with foveated and with whole
frames by turns in one process. With ColorVideoVDP installed the first table has JOD as well.
"""

from __future__ import annotations

import argparse
import importlib.util
import itertools
import math
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from eyes import with_eyes
from replays import run

from hmdwarp.client import Compensator, PassInputs, build_plan
from hmdwarp.client.effect_passes.expand import ExpandPass
from hmdwarp.client.effects import Tools
from hmdwarp.geometry import Fovea, View
from hmdwarp.gpu import Gpu
from hmdwarp.headsets import load_headset
from hmdwarp.link.codec import Coding
from hmdwarp.metrics import jod
from hmdwarp.poses import load_trace, synthesise, write_synthetic
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

LATENCIES_MS = (0.0, 20.0, 50.0, 100.0)
FRAMES = {
    "whole": {},
    "40 degrees": {"fovea_deg": 40.0},
    "20 degrees": {"fovea_deg": 20.0},
    "20 degrees, predicted": {"fovea_deg": 20.0, "gaze": "predicted"},
    "20 degrees, rim of 8": {"fovea_deg": 20.0, "rim": 8},
}
# 100 Hz: each latency is a whole number of refreshes.
OPTIONS = {
    "scene": "room", "warp": "iterative", "fill": "pyramid", "guard": 1.2, "rate_hz": 100.0, "start_s": 1.0,
    "metrics_every": 5, "force": True, "coding": Coding("h264"), "headset": "flat-90", "samples": 4,
}  # fmt: skip
CHAINS = ("rotation/none", "iterative/pyramid", "forward/interpolate")
HEADSET, GUARD, LATE_NS, AT_NS = "quest-3", 1.1, 50_000_000, 3_000_000_000


def quality(gpu: Gpu, side: int, seconds: float) -> None:
    """Print bits and quality by latency and frames."""
    heads = ["pixels sent", "Mbit/s", "off, p50", "off, p95", "PSNR near the gaze", "PSNR"]
    missing = [module for module in jod.MODULES if importlib.util.find_spec(module) is None]
    if missing:
        print(f"no column JOD: not installed: {', '.join(missing)} (pip install '.[jod]')", file=sys.stderr)
    rated = {} if missing else {"jod_s": min(seconds, 1.0)}
    heads += [] if missing else ["JOD"]
    print(f"| late | frames | {' | '.join(heads)} |")
    print("| --- | --- |" + " ---: |" * len(heads))
    with tempfile.TemporaryDirectory() as folder:
        trace = Path(folder) / "looking.csv"
        with trace.open("w", encoding="utf-8") as file:
            write_synthetic(with_eyes(synthesise("look-around", seconds=seconds + 2)), file)
        known = {**OPTIONS, **rated, "trace": str(trace), "size": (side, side), "seconds": seconds}
        for latency_ms, (name, sets) in itertools.product(LATENCIES_MS, FRAMES.items()):
            summary = run(Path(folder) / "out", gpu=gpu, latency_ms=latency_ms, **known, **sets).summary
            gaze, link = summary["gaze"], summary["link"]
            cells = [pixels(side, sets), f"{link['mbit_s']:.2f}"]
            cells += [f"{gaze['off_deg'][key]:.1f}" for key in ("p50", "p95")]
            cells += [f"{gaze['psnr_db']:.2f}", f"{summary['quality']['psnr_db']['mean']:.2f}"]
            cells += [] if missing else [f"{summary['jod']['mean']:.2f}"]
            print(f"| {latency_ms:g} ms | {name} | " + " | ".join(cells) + " |", flush=True)


def pixels(side: int, sets: dict) -> str:
    """Return the share of a whole frame's pixels that is sent."""
    if not sets:
        return "100 %"
    view = load_headset("flat-90").views(load_trace("look-around").track.at(0).pose)[0]
    fov, size = view.fov.guarded(OPTIONS["guard"], (side, side))
    fovea = Fovea(sets["fovea_deg"], sets.get("rim", 4))
    return f"{100 * math.prod(fovea.small(fov, size, size)) / math.prod(size):.0f} %"


def price(gpu: Gpu, scale: float, rounds: int) -> None:
    """Print what drawing and each chain take of the processor, as a share of whole frames'."""
    headset, track = load_headset(HEADSET), load_trace("look-around").track
    size = tuple(round(scale * side) for side in headset.eye_size_px)
    late, shown = (headset.views(track.at(track.start_ns + ns).pose)[0] for ns in (AT_NS - LATE_NS, AT_NS))
    server = Server(gpu, load_scene("room"), samples=4)
    heads = ["frames of 30 degrees", "drawing", *(f"`{chain.replace('/', '`, `')}`" for chain in CHAINS)]
    print(f"| {' | '.join(heads)} |")
    print("| --- |" + " ---: |" * (1 + len(CHAINS)))
    cells, shares = row(gpu, server, (late, shown), size, Fovea(30.0), rounds)
    print(f"| processor time, of whole frames' | {' | '.join(cells)} |")
    print(f"| of it the expansion | | {' | '.join(shares)} |")
    server.close()


def row(
    gpu: Gpu, server: Server, views: tuple[View, View], size: tuple[int, int], fovea: Fovea, rounds: int
) -> tuple[list[str], list[str]]:
    """Return the cells of drawing and of each chain, and the share of expansion in each chain."""
    late, shown = views
    shares: list[str] = []
    pairs: list[tuple[Callable[[], object], ...]] = []
    for chain in CHAINS:
        methods = []
        for each in (fovea, None):
            plan = build_plan((), *chain.split("/"), "none", client_geometry=True, fovea=each)
            frame = server.draw_frame([late], 0, size, GUARD, plan.needs)
            client = Compensator(gpu, plan, None, frame.eyes[0].size, size, hides=shown.hidden is not None)
            methods.append(lambda client=client, frame=frame: client.run(PassInputs(frame.eyes[0], shown)))
            if plan.expands:
                inputs, parts = PassInputs(frame.eyes[0], shown), frozenset(plan.foveated)
                alone = ExpandPass(gpu, parts, frame.eyes[0].size, size, Tools(None, 1))
                share = ratio(gpu, lambda alone=alone, inputs=inputs: alone.run(inputs), methods[0], rounds)
                shares.append(f"{100 * share:.0f} %")
            elif each is not None:
                shares.append("none")
        pairs.append(tuple(methods))
    needs = build_plan((), "iterative", "none", "none", client_geometry=True, fovea=fovea).needs
    pairs.insert(
        0, tuple(lambda n=n: server.recycle(server.draw_frame([late], 0, size, GUARD, n)) for n in (needs, None))
    )
    return [f"{ratio(gpu, *pair, rounds):.2f}" for pair in pairs], shares


def ratio(gpu: Gpu, one: Callable[[], object], other: Callable[[], object], rounds: int) -> float:
    """Return the median over pairs of runs; the first warms up."""
    found = [took_ns(gpu, one) / took_ns(gpu, other) for _ in range(rounds + 1)]
    return float(np.median(found[1:]))


def took_ns(gpu: Gpu, method: Callable[[], object]) -> int:
    """Return the processor time of all threads."""
    gpu.gl.finish()
    started = time.process_time_ns()
    method()
    gpu.gl.finish()
    return time.process_time_ns() - started


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--side", type=int, default=240, help="pixels of a picture's side")
    parser.add_argument("--seconds", type=float, default=1.0)
    parser.add_argument("--scale", type=float, default=0.4, help="of the headset's own size, for the price")
    arguments = parser.parse_args()
    with Gpu() as gpu:
        quality(gpu, arguments.side, arguments.seconds)
        print()
        price(gpu, arguments.scale, arguments.rounds)


if __name__ == "__main__":
    main()
