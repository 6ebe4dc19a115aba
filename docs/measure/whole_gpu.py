"""Everything that is to be measured on a GPU, in at most nine minutes: `make bench-gpu OUT=FOLDER`.

Needs no network. Writes gpu.json and a page, gpu.md; `make docs OPTIONS=gpu:FOLDER/gpu.json` files
the page in docs/gpu.md by the GPU's name. What comes first matters most: once the minutes are
spent the rest is left out, and named. With --quick: all of it once, on tiny pictures.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import attrs
from apparatus import options
from gpu_tables import section

HERE = Path(__file__).resolve().parent
SCHEMA = 1
FEW = ("none", "rotation", "iterative", "backward", "layered")
MORE = (*FEW, "planar", "forward_ordered", "forward_raster", "splat", "multi", "mesh", "mesh_adaptive")


FILLS = ("none", "interpolate", "pyramid", "memory+pyramid")


@attrs.frozen
class Work:
    """How much is measured."""

    # (w, h) of one eye, warps beside `forward`, fills; the most important first.
    benches: tuple[tuple[str, tuple[str, ...], tuple[str, ...]], ...]
    bench_options: tuple[str, ...]
    scene: str = "room"
    chains: tuple[str, ...] = ()  # options of gpu_chain.py beside the sizes
    frames: int = 600  # of each live run
    refreshes: int = 300  # of each row of bench-live
    arrays: tuple[str, ...] = ()  # options of warper_cost.py


DK1 = ("--headset", "rift-dk1")  # of every figure in docs/ that names no other
ALL = Work(
    (("1280x800", MORE, FILLS), ("2064x2208", FEW, FILLS)),
    ("--instants", "3", "--rounds", "5"),
)
QUICK = Work(
    (("48x40", ("rotation",), ("none", "pyramid")),),
    ("--instants", "1", "--rounds", "1", "--seconds", "0.1", "--workers", "0"),
    "planes", ("--refreshes", "2", "--busy", "65536"), 10, 2, ("--sizes", "48x40"),
)  # fmt: skip


class Measuring:
    """Runs parts one after the other until the time is over; `left_out` names the others."""

    def __init__(self, folder: Path, minutes: float) -> None:
        self.folder, self.left_out = folder, list[str]()
        self._started = time.monotonic()
        self._seconds = minutes * 60

    @property
    def seconds(self) -> float:
        """Since the start."""
        return time.monotonic() - self._started

    def part(self, name: str, *command: str, statuses: Sequence[int] = (0,)) -> str | None:
        """Return what a command prints, None for one that fails or is not through in time."""
        print(f"{self.seconds:5.0f} s  {name}", flush=True)
        left = self._seconds - self.seconds
        try:
            if left <= 0:
                raise subprocess.TimeoutExpired(command, 0)
            done = subprocess.run([sys.executable, *command], capture_output=True, text=True, check=False, timeout=left)
        except subprocess.TimeoutExpired:
            self.left_out.append(f"{name}: no time was left")
            return None
        if done.returncode not in statuses:
            last = (done.stderr.strip().splitlines() or ["no message"])[-1]
            self.left_out.append(f"{name}: {last}")
            return None
        return done.stdout

    def results(self, name: str, command: str, *options: str, file: str) -> dict[str, Any] | None:
        """Return the JSON file that a command of hmdwarp writes."""
        out = self.folder / name.replace(" ", "-")
        if self.part(name, "-m", "hmdwarp", command, *options, "--force", "--out", str(out)) is None:
            return None
        return json.loads((out / file).read_text(encoding="utf-8"))


def measure(folder: Path, work: Work, minutes: float) -> dict[str, Any]:
    """Return all that gpu.json has. Raises: SystemExit where there is no OpenGL."""
    run = Measuring(folder, minutes)
    told = run.part("doctor", "-m", "hmdwarp", "doctor", "--json")
    if told is None:
        raise SystemExit(f"{run.left_out[0]}: 'hmdwarp doctor' says what is missing")
    doctor = json.loads(told)["findings"]
    sizes = ",".join(size for size, *_ in work.benches)
    chains = run.part(
        "chains with a busy GPU", str(HERE / "gpu_chain.py"), "--scene", work.scene, "--sizes", sizes, *work.chains
    )
    benches, lives = [], []
    for size, warps, fills in work.benches:
        chosen = ("--warp", ",".join(("forward", *warps)), "--fill", ",".join(fills))
        what = ("look-around", *DK1, "--scene", work.scene, "--size", size, "--quiet")
        benches.append(run.results(f"bench {size}", "bench", *what, *chosen, *work.bench_options, file="bench.json"))
    for size, *_ in work.benches:
        what = ("--source", "offscreen", "--trace", "look-around", *DK1, "--scene", work.scene, "--size", size)
        lives.append(run.results(f"live {size}", "live", *what, "--pictures", str(work.frames), file="summary.json"))
    arrays = run.part("calls with arrays", str(HERE / "warper_cost.py"), "--ratios", *work.arrays)
    # Status 1: a limit is exceeded, which it says.
    costs = ("--frames", str(work.refreshes), "--scene", work.scene)
    loop = run.part("bench-live", str(HERE / "live_cost.py"), *costs, statuses=(0, 1))
    return {
        "schema": SCHEMA,
        "doctor": doctor,
        "chains": json.loads(chains) if chains else [],
        "bench": [bench for bench in benches if bench],
        "live": [live for live in lives if live],
        "bench_live": loop,
        "arrays": arrays,
        "left_out": run.left_out,
        "seconds": run.seconds,
    }


def main() -> None:
    """Measure, and write gpu.json and its page."""
    asked = options(
        __doc__,
        out=(Path("out/gpu"), "folder for gpu.json, gpu.md and what they come from"),
        minutes=(9.0, "after which the rest is left out"),
        quick=(False, "all of it once, on tiny pictures"),
    )
    asked.out.mkdir(parents=True, exist_ok=True)
    data = measure(asked.out, QUICK if asked.quick else ALL, asked.minutes)
    (asked.out / "gpu.json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    page = asked.out / "gpu.md"
    page.write_text(section(data), encoding="utf-8")
    for line in data["left_out"]:
        print(f"left out: {line}")
    print(f"page: {page}")


if __name__ == "__main__":
    main()
