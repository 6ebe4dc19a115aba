"""What foveated frames save and cost at a late gaze: two tables for docs/foveation.md.

Replays of made-up eyes, and processor time of all threads for one eye, with foveated and with whole
frames by turns in one process. With ColorVideoVDP installed the first table has JOD as well.
"""

from __future__ import annotations

import importlib.util
import itertools
import math
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from apparatus import options, print_table, ratio, views_of
from eyes import with_eyes
from replays import run

from hmdwarp.client import Compensator, PassInputs, build_plan
from hmdwarp.client.effects import ExpandPass, Tools
from hmdwarp.geometry import Fovea
from hmdwarp.gpu import Gpu
from hmdwarp.headsets import load_headset
from hmdwarp.link.codec import Coding
from hmdwarp.metrics import jod
from hmdwarp.poses import load_trace, synthesise, write_synthetic
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

LATENCIES_MS = (0.0, 100.0)
FRAMES = {
    "whole": {},
    "40 degrees": {"fovea_deg": 40.0},
    "20 degrees": {"fovea_deg": 20.0},
    "20 degrees, rim of 8": {"fovea_deg": 20.0, "rim": 8},
}
# 100 Hz: each latency is a whole number of refreshes.
OPTIONS = {
    "scene": "room", "warp": "iterative", "fill": "pyramid", "guard": 1.2, "rate_hz": 100.0, "start_s": 1.0,
    "metrics_every": 5, "force": True, "coding": Coding("h264"), "headset": "flat-90", "samples": 4,
}  # fmt: skip
CHAINS = ("rotation/none", "iterative/pyramid", "forward/interpolate")
HEADSET, GUARD, LATE_NS, AT_NS = "quest-3", 1.1, 50_000_000, 3_000_000_000
FOVEA = Fovea(30.0)


def quality(gpu: Gpu, side: int, seconds: float) -> None:
    """Print bits and quality by latency and frames."""
    heads = ["late", "frames", "pixels sent", "Mbit/s", "off, p50", "off, p95", "PSNR near the gaze", "PSNR"]
    missing = [module for module in jod.MODULES if importlib.util.find_spec(module) is None]
    if missing:
        print(f"no column JOD: not installed: {', '.join(missing)} (pip install '.[jod]')", file=sys.stderr)
    rated = {} if missing else {"jod_s": min(seconds, 1.0)}
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        trace = Path(folder) / "looking.csv"
        with trace.open("w", encoding="utf-8") as file:
            write_synthetic(with_eyes(synthesise("look-around", seconds=seconds + 2)), file)
        known = {**OPTIONS, **rated, "trace": str(trace), "size": (side, side), "seconds": seconds}
        for latency_ms, (name, sets) in itertools.product(LATENCIES_MS, FRAMES.items()):
            summary = run(Path(folder) / "out", gpu=gpu, latency_ms=latency_ms, **known, **sets).summary
            gaze = summary["gaze"]
            cells = [f"{latency_ms:g} ms", name, pixels(side, sets), f"{summary['link']['mbit_s']:.2f}"]
            cells += [f"{gaze['off_deg'][key]:.1f}" for key in ("p50", "p95")]
            cells += [f"{gaze['psnr_db']:.2f}", f"{summary['quality']['psnr_db']['mean']:.2f}"]
            rows.append(cells + ([] if missing else [f"{summary['jod']['mean']:.2f}"]))
    print_table([*heads, *([] if missing else ["JOD"])], rows, texts=2)


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
    headset = load_headset(HEADSET)
    size = tuple(round(scale * side) for side in headset.eye_size_px)
    late, shown = views_of(headset, LATE_NS, AT_NS)
    server = Server(gpu, load_scene("room"), samples=4)
    needs = build_plan((), "iterative", "none", "none", client_geometry=True, fovea=FOVEA).needs
    drawing = (lambda n=n: server.recycle(server.draw_frame([late], 0, size, GUARD, n)) for n in (needs, None))
    cells, shares = [ratio(gpu, *drawing, rounds)], [""]
    for chain in CHAINS:
        methods: list[Callable[[], object]] = []
        share = "none"
        for fovea in (FOVEA, None):
            plan = build_plan((), *chain.split("/"), "none", client_geometry=True, fovea=fovea)
            frame = server.draw_frame([late], 0, size, GUARD, plan.needs)
            client = Compensator(gpu, plan, None, frame.eyes[0].size, size, hides=shown.hidden is not None)
            inputs = PassInputs(frame.eyes[0], shown)
            methods.append(lambda client=client, inputs=inputs: client.run(inputs))
            if plan.expands:
                alone = ExpandPass(gpu, frozenset(plan.foveated), frame.eyes[0].size, size, Tools(None, 1))
                expanding = ratio(gpu, lambda alone=alone, inputs=inputs: alone.run(inputs), methods[0], rounds)
                share = f"{100 * expanding:.0f} %"
        cells.append(ratio(gpu, *methods, rounds))
        shares.append(share)
    server.close()
    heads = ["frames of 30 degrees", "drawing", *(f"`{chain.replace('/', '`, `')}`" for chain in CHAINS)]
    whole = ["processor time, of whole frames'", *(f"{cell:.2f}" for cell in cells)]
    print_table(heads, [whole, ["of it the expansion", *shares]])


def main() -> None:
    """Measure and print."""
    chosen = options(
        __doc__,
        rounds=(15, "of each pair"),
        side=(240, "pixels of a picture's side"),
        seconds=(1.0, "of each replay"),
        scale=(0.4, "of the headset's own size, for the price"),
    )
    with Gpu() as gpu:
        quality(gpu, chosen.side, chosen.seconds)
        print()
        price(gpu, chosen.scale, chosen.rounds)


if __name__ == "__main__":
    main()
