"""What foveated frames save and cost at a late gaze: two tables for docs/foveation.md.

Replays of made-up eyes, and processor time of all threads for one eye, with foveated and with whole
frames by turns in one process.
"""

from __future__ import annotations

import argparse
import itertools
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from replays import run

from hmdwarp.client import Compensator, PassInputs, build_plan
from hmdwarp.geometry import Fovea
from hmdwarp.gpu import Gpu
from hmdwarp.headsets import load_headset
from hmdwarp.link.codec import Coding
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
    "metrics_every": 5, "force": True, "coding": Coding("h264"), "headset": "flat-90",
}  # fmt: skip
CHAINS = ("rotation/none", "iterative/pyramid", "forward/interpolate")
HEADSET, GUARD, LATE_NS, AT_NS = "quest-3", 1.1, 50_000_000, 3_000_000_000


def quality(gpu: Gpu, side: int, seconds: float) -> None:
    """Print bits and quality by latency and frames."""
    print("| late | frames | pixels sent | Mbit/s | off, p50 | off, p95 | PSNR near the gaze | PSNR |")
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    with tempfile.TemporaryDirectory() as folder:
        trace = Path(folder) / "looking.csv"
        with trace.open("w", encoding="utf-8") as file:
            write_synthetic(synthesise("look-around", seconds=seconds + 2, gaze=True), file)
        known = {**OPTIONS, "trace": str(trace), "size": (side, side), "seconds": seconds}
        for latency_ms, (name, sets) in itertools.product(LATENCIES_MS, FRAMES.items()):
            summary = run(Path(folder) / "out", gpu=gpu, latency_ms=latency_ms, **known, **sets).summary
            gaze, link = summary["gaze"], summary["link"]
            cells = [pixels_sent(side, sets), f"{link['mbit_s']:.2f}"]
            cells += [f"{gaze['off_deg'][key]:.1f}" for key in ("p50", "p95")]
            cells += [f"{gaze['psnr_db']:.2f}", f"{summary['quality']['psnr_db']['mean']:.2f}"]
            print(f"| {latency_ms:g} ms | {name} | " + " | ".join(cells) + " |", flush=True)


def pixels_sent(side: int, sets: dict) -> str:
    """Return the share of a whole frame's pixels."""
    if not sets:
        return "100 %"
    view = load_headset("flat-90").views(load_trace("look-around").track.at(0).pose)[0]
    fov, size = view.fov.guarded(OPTIONS["guard"], (side, side))
    small = Fovea(sets["fovea_deg"], sets.get("rim", 4)).small(fov, size, size)
    return f"{100 * small[0] * small[1] / (size[0] * size[1]):.0f} %"


def price(gpu: Gpu, scale: float, rounds: int) -> None:
    """Print what drawing and each chain take of the processor, as a share of whole frames'."""
    headset, track = load_headset(HEADSET), load_trace("look-around").track
    size = tuple(round(scale * side) for side in headset.eye_size_px)
    late, shown = (headset.views(track.at(track.start_ns + ns).pose)[0] for ns in (AT_NS - LATE_NS, AT_NS))
    server, fovea = Server(gpu, load_scene("room")), Fovea(30.0)
    heads = ["frames of 30 degrees", "drawing", *(f"`{chain.replace('/', '`, `')}`" for chain in CHAINS)]
    print(f"| {' | '.join(heads)} |")
    print("| --- |" + " ---: |" * (1 + len(CHAINS)))
    pairs: list[tuple[Callable[[], object], ...]] = []
    for chain in CHAINS:
        methods = []
        for each in (fovea, None):
            plan = build_plan((), *chain.split("/"), "none", client_geometry=True, fovea=each)
            frame = server.draw_frame([late], 0, size, GUARD, plan.needs)
            client = Compensator(gpu, plan, None, frame.eyes[0].size, size, hides=shown.hidden is not None)
            methods.append(lambda client=client, frame=frame: client.run(PassInputs(frame.eyes[0], shown)))
        pairs.append(tuple(methods))
    needs = build_plan((), "iterative", "none", "none", client_geometry=True, fovea=fovea).needs
    pairs.insert(
        0, tuple(lambda n=n: server.recycle(server.draw_frame([late], 0, size, GUARD, n)) for n in (needs, None))
    )
    cells = [f"{ratio(gpu, *pair, rounds):.2f}" for pair in pairs]
    print(f"| processor time, of whole frames' | {' | '.join(cells)} |")
    server.close()


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
