"""What leaving out a headset's hidden area saves: a table for docs/headsets.md.

Processor time of all threads for one eye, with the area left out and drawn by turns in one process,
and the bytes of the same replay's coded frames.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from replays import run

from hmdwarp.client import Compensator, PassInputs, build_plan
from hmdwarp.gpu import Gpu
from hmdwarp.headsets import load_headset
from hmdwarp.link.codec import Coding
from hmdwarp.poses import load_trace
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

LATENCY_NS, GUARD, AT_NS = 100_000_000, 1.1, 3_000_000_000
HEADSETS = ("index", "quest-3")
CHAINS = ("iterative/pyramid", "iterative/memory+pyramid", "forward/interpolate", "mesh/constant")
AIM = 0.7
Methods = Mapping[str, Callable[[], object]]


def methods_of(gpu: Gpu, server: Server, name: str, scale: float) -> dict[str, Callable[[], object]]:
    """Return drawing one eye, and each chain, at a share of the headset's size."""
    headset, track = load_headset(name), load_trace("look-around").track
    size = (round(scale * headset.eye_size_px[0]), round(scale * headset.eye_size_px[1]))
    now = track.start_ns + AT_NS
    late, shown = (headset.views(track.at(ns).pose)[0] for ns in (now - LATENCY_NS, now))
    fov, rendered_size = late.fov.guarded(GUARD, size)
    rendered = server.draw(late.within(fov), rendered_size)
    made: dict[str, Callable[[], object]] = {
        "drawing": lambda: server.pool(rendered_size).release(server.draw(late.within(fov), rendered_size).colour)
    }
    for chain in CHAINS:
        plan = build_plan((), *chain.split("/"), "none", client_geometry=True)
        client = Compensator(gpu, plan, None, rendered_size, size, hides=shown.hidden is not None)
        made[chain] = lambda client=client: client.run(PassInputs(rendered, shown))
    return made


def saved(gpu: Gpu, hidden: Methods, whole: Methods, rounds: int) -> dict[str, float]:
    """Return the share of processor time that each saves: the median over pairs of runs."""
    ratios: dict[str, list[float]] = {name: [] for name in hidden}
    for number in range(rounds + 1):  # the first to warm up
        for name, several in ratios.items():
            pair = (hidden[name], whole[name])[:: 1 if number % 2 else -1]  # who comes second finds warm caches
            first, second = (_took_ns(gpu, each) for each in pair)
            several.append(first / second if number % 2 else second / first)
    return {name: 1 - float(np.median(several[1:])) for name, several in ratios.items()}


def _took_ns(gpu: Gpu, method: Callable[[], object]) -> int:
    gpu.gl.finish()
    started = time.process_time_ns()
    method()
    gpu.gl.finish()
    return time.process_time_ns() - started


def fewer_bytes(gpu: Gpu, name: str) -> float:
    """Return the share of bytes that coded frames of both eyes save, at an eighth of the size."""
    size = tuple(side // 8 for side in load_headset(name).eye_size_px)
    options = {
        "headset": name,
        "size": size,
        "guard": GUARD,
        "scene": "room",
        "seconds": 1.0,
        "rate_hz": 20.0,
        "samples": 4,
    }
    options |= {"coding": Coding("h264", depth="exact"), "metrics_every": 20}
    found = []
    for headset in (name, f"{name}:hidden=drawn"):
        with tempfile.TemporaryDirectory() as folder:
            summary = run(Path(folder), gpu=gpu, **(options | {"headset": headset, "force": True})).summary
            found.append(summary["link"]["frame_bytes"])
    return 1 - found[0] / found[1]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--scale", type=float, default=0.4, help="of the headset's own size on each axis")
    arguments = parser.parse_args()
    columns = [f"`{warp}`, `{fill}`" for warp, fill in (chain.split("/") for chain in CHAINS)]
    print("| headset | hidden | drawing | " + " | ".join(columns) + " | bytes |")
    print("| --- |" + " ---: |" * (len(columns) + 3))
    with Gpu() as gpu:
        server = Server(gpu, load_scene("room"), samples=4)
        for name in HEADSETS:
            both = (methods_of(gpu, server, one, arguments.scale) for one in (name, f"{name}:hidden=drawn"))
            share = load_headset(name).eyes[0].hidden_share
            cells = [
                f"{part:.1%} ({part / share:.2f})" + (" met" if part >= AIM * share else "")
                for part in saved(gpu, *both, arguments.rounds).values()
            ]
            print(f"| `{name}` | {share:.1%} | " + " | ".join(cells) + f" | {fewer_bytes(gpu, name):.1%} |")
        server.close()


if __name__ == "__main__":
    main()
