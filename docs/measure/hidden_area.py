"""What leaving out a headset's hidden area saves: a table for docs/headsets.md.

Processor time of all threads for one eye, with the area left out and drawn by turns in one process,
and the bytes of the same replay's coded frames.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

from apparatus import options, print_table, ratio, views_of
from replays import run

from hmdwarp.client import Compensator, PassInputs, build_plan
from hmdwarp.gpu import Gpu
from hmdwarp.headsets import load_headset
from hmdwarp.link.codec import Coding
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

LATE_NS, GUARD, AT_NS = 100_000_000, 1.1, 3_000_000_000
HEADSETS = ("index", "quest-3")
CHAINS = ("iterative/pyramid", "iterative/memory+pyramid", "forward/interpolate", "mesh/constant")
AIM = 0.7  # of the hidden share


def methods_of(gpu: Gpu, server: Server, name: str, scale: float) -> list[Callable[[], object]]:
    """Return drawing one eye, and each chain, at a share of the headset's size."""
    headset = load_headset(name)
    size = (round(scale * headset.eye_size_px[0]), round(scale * headset.eye_size_px[1]))
    late, shown = views_of(headset, LATE_NS, AT_NS)
    fov, rendered_size = late.fov.guarded(GUARD, size)
    rendered = server.draw(late.within(fov), rendered_size)
    made: list[Callable[[], object]] = [
        lambda: server.pool(rendered_size).release(server.draw(late.within(fov), rendered_size).colour)
    ]
    for chain in CHAINS:
        plan = build_plan((), *chain.split("/"), "none", client_geometry=True)
        client = Compensator(gpu, plan, None, rendered_size, size, hides=shown.hidden is not None)
        made.append(lambda client=client: client.run(PassInputs(rendered, shown)))
    return made


def fewer_bytes(gpu: Gpu, name: str) -> float:
    """Return the share of bytes that coded frames of both eyes save, at an eighth of the size."""
    size = tuple(side // 8 for side in load_headset(name).eye_size_px)
    chosen = {"size": size, "guard": GUARD, "scene": "room", "seconds": 1.0, "rate_hz": 20.0, "samples": 4}
    chosen |= {"coding": Coding("h264", depth="exact"), "metrics_every": 20, "force": True}
    found = []
    for headset in (name, f"{name}:hidden=drawn"):
        with tempfile.TemporaryDirectory() as folder:
            found.append(run(Path(folder), gpu=gpu, headset=headset, **chosen).summary["link"]["frame_bytes"])
    return 1 - found[0] / found[1]


def main() -> None:
    """Measure and print."""
    chosen = options(__doc__, rounds=(15, "of each pair"), scale=(0.4, "of the headset's own size on each axis"))
    heads = ["headset", "hidden", "drawing", *(f"`{chain.replace('/', '`, `')}`" for chain in CHAINS), "bytes"]
    rows = []
    with Gpu() as gpu:
        server = Server(gpu, load_scene("room"), samples=4)
        for name in HEADSETS:
            both = (methods_of(gpu, server, one, chosen.scale) for one in (name, f"{name}:hidden=drawn"))
            share = load_headset(name).eyes[0].hidden_share
            saved = [1 - ratio(gpu, *pair, chosen.rounds) for pair in zip(*both, strict=True)]
            cells = (f"{part:.1%} ({part / share:.2f})" + " met" * (part >= AIM * share) for part in saved)
            rows.append([f"`{name}`", f"{share:.1%}", *cells, f"{fewer_bytes(gpu, name):.1%}"])
        server.close()
    print_table(heads, rows)


if __name__ == "__main__":
    main()
