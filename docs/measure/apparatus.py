"""What the measuring scripts share: options, turns, tables, and finding tests/ and docs/.

Its name comes first, so that sorted imports find it before the helpers of tests/.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hmdwarp.geometry import View
from hmdwarp.gpu import Gpu
from hmdwarp.headsets import Headset
from hmdwarp.poses import load_trace

ROOT = Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "docs"), str(ROOT / "tests")]

from pages import markdown  # noqa: E402 (a module of docs/)

Methods = Mapping[str, Callable[[], object]]


def options(doc: str | None, said: Sequence[str] | None = None, **known: tuple[Any, str]) -> argparse.Namespace:
    """Return a script's options. known: default, which gives the type, and help of each."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, (default, told) in known.items():
        how: dict[str, Any] = {"action": "store_true"} if default is False else {"default": default}
        parser.add_argument(f"--{name}", help=told, **how | ({} if default is False else {"type": type(default)}))
    return parser.parse_args(said)


def sizes_in(text: str) -> list[tuple[int, ...]]:
    """Return the sizes of a text such as "64x48,640x480"."""
    return [tuple(map(int, size.split("x"))) for size in text.split(",") if size]


def in_turns(
    gpu: Gpu,
    methods: Methods,
    rounds: int,
    *,
    clock: Callable[[], int] = time.process_time_ns,
    warm: int = 1,
    before: Callable[[], object] | None = None,
    waits: bool = True,
) -> dict[str, np.ndarray]:
    """Return the milliseconds of each method in each round, after some to warm up.

    Between two runs of a method all others run, as in a frame loop, and another one begins each
    round: what one leaves in the caches costs the next. before: runs before each round, which then
    keeps its order. clock: by default the processor time of all threads. waits: for the GPU.
    """
    times: dict[str, list[float]] = {name: [] for name in methods}
    names = list(methods)
    for number in range(warm + rounds):
        first = 0 if before else number % len(names)
        if before:
            before()
        for name in names[first:] + names[:first]:
            gpu.gl.finish()
            started = clock()
            methods[name]()
            if waits:
                gpu.gl.finish()
            times[name].append((clock() - started) * 1e-6)
            gpu.timer.collect()
    return {name: np.array(each[warm:]) for name, each in times.items()}


def ratio(gpu: Gpu, one: Callable[[], object], other: Callable[[], object], rounds: int) -> float:
    """Return the median over pairs of runs of what one takes over what the other takes."""
    took = in_turns(gpu, {"one": one, "other": other}, rounds)
    return float(np.median(took["one"] / took["other"]))


def views_of(headset: Headset, late_ns: int, at_ns: int) -> list[View]:
    """Return a late and the newest view of the left eye in look-around."""
    track = load_trace("look-around").track
    return [headset.views(track.at(track.start_ns + ns).pose)[0] for ns in (at_ns - late_ns, at_ns)]


def print_table(heads: Sequence[str], rows: Sequence[Sequence[str]], texts: int = 1) -> None:
    """Print a Markdown table whose first columns are texts."""
    print(markdown(heads, rows, texts))
