"""What has become of the aims of speed and quality: an older checkout and this one, taking turns.

Run by hand with the folder of the older checkout: `make docs OPTIONS=before:FOLDER`.
"""

from __future__ import annotations

import json
import os
import resource
import statistics
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from math import inf
from pathlib import Path

import attrs
from pages import ROOT

ROUNDS = 2
TRACES = ("look-around", "walk")
BENCH = (
    *("bench", *TRACES, "--warp", "forward,iterative,backward", "--fill", "none,interpolate,pyramid,memory+pyramid"),
    *("--no-grid", "--no-fused", "--instants", "2", "--quiet"),
)
REPLAY = ("replay", "look-around", "--seconds", "3", "--quiet", "--images", "0")
THESIS = ("--warp", "forward", "--fill", "interpolate", "--guard", "1", "--predict", "none")
CODED = ("--seconds", "1", "--codec", "h264", "--warp", "iterative", "--fill", "none", "--guard", "1")


@attrs.frozen
class Version:
    """What one version gave, of all rounds."""

    # (ms, PSNR dB, FLIP), by recording, warp and fill.
    rows: Mapping[tuple[str, str, str], tuple[float, float, float]]
    # Processor seconds of a replay with the thesis's method.
    replay_s: float
    # Of the default replay: PSNR dB and share of empty pixels.
    psnr_db: float
    empty: float
    # Bytes of depth over those of colour, on a link with a codec.
    depth_share: float

    def ms(self, trace: str, warp: str, fill: str) -> float:
        return self.rows[trace, warp, fill][0]


def measured(older: Path, folder: Path) -> dict[str, Version]:
    """Run both versions, in turns."""
    trees = {"before": older, "after": ROOT}
    benches: dict[str, list[Path]] = {name: [] for name in trees}
    seconds: dict[str, list[float]] = {name: [] for name in trees}
    for number in range(ROUNDS):
        for name, tree in trees.items():
            out = folder / f"{name}-{number}"
            _run(tree, *BENCH, "--out", str(out))
            benches[name].append(out / "bench.json")
            seconds[name].append(_run(tree, *REPLAY, *THESIS, "--out", str(out / "thesis")))
    found = {}
    for name, tree in trees.items():
        _run(tree, *REPLAY, "--out", str(folder / name))
        _run(tree, *REPLAY, *CODED, "--out", str(folder / f"{name}-coded"))
        usual, coded = (_summary(folder / one) for one in (name, f"{name}-coded"))
        streams = coded["link"]["layers_mbit_s"]
        found[name] = Version(
            _rows(benches[name]),
            statistics.median(seconds[name]),
            usual["quality"]["psnr_db"]["mean"],
            usual["quality"]["hole_share"]["mean"] if "filled" not in usual else usual["filled"].get("empty", 0.0),
            streams["inverse_depth"] / streams["colour"],
        )
    return found


def _run(tree: Path, *arguments: str) -> float:
    """Run a version's command; return the processor seconds that it took."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "hmdwarp", *arguments, "--force"]
    subprocess.run(command, check=True, cwd=tree, env={**os.environ, "PYTHONPATH": str(tree)})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def _summary(folder: Path) -> dict:
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


def _rows(files: Sequence[Path]) -> dict[tuple[str, str, str], tuple[float, float, float]]:
    """Return the median of each figure over the runs."""
    found: dict[tuple[str, str, str], list[tuple[float, float, float]]] = {}
    for file in files:
        for row in json.loads(file.read_text(encoding="utf-8"))["rows"]:
            figures = row["time_ms"]["total"]["median"], *(row["quality"][name]["mean"] for name in ("psnr_db", "flip"))
            found.setdefault((row["trace"], row["warp"], row["fill"]), []).append(figures)
    return {key: tuple(map(statistics.median, zip(*each, strict=True))) for key, each in found.items()}


def table(older: Path, folder: Path) -> str:
    """Return a line for each aim: what it was, what it is, and whether that is enough."""
    found = measured(older, folder)
    lines = ["| aim | recording | before | after | after / before | |", "| --- | --- | ---: | ---: | ---: | --- |"]

    def add(
        aim: str, trace: str, figure: Callable[[Version], float], form: str, *, least: float = -inf, most: float = inf
    ) -> None:
        before, after = (figure(found[name]) for name in ("before", "after"))
        ratio = f"{after / before:.2f}" if before else "–"
        met = "met" if least <= after <= most else "not met"
        lines.append(f"| {aim} | {trace} | {before:{form}} | {after:{form}} | {ratio} | {met} |")

    was = found["before"]
    for trace in TRACES:
        add(
            "`iterative` + `pyramid` over `iterative` + `interpolate`: at most 1.5", trace,
            lambda v, t=trace: v.ms(t, "iterative", "pyramid") / v.ms(t, "iterative", "interpolate"), ".2f", most=1.5,
        )  # fmt: skip
        add(
            "... PSNR in dB: at most 0.2 less", trace,
            lambda v, t=trace: v.rows[t, "iterative", "pyramid"][1], ".2f",
            least=was.rows[trace, "iterative", "pyramid"][1] - 0.2,
        )  # fmt: skip
        add(
            "best in the time of `forward` + `interpolate`: dB gained, at least 3", trace,
            lambda v, t=trace: _best_in_time(v, t)[1], "+.2f", least=3,
        )  # fmt: skip
        add("... FLIP over its: at most 0.6", trace, lambda v, t=trace: _best_in_time(v, t)[2], ".2f", most=0.6)
        add(
            "`iterative`, ms an eye: 1.3 times as fast", trace, lambda v, t=trace: v.ms(t, "iterative", "none"), ".1f",
            most=was.ms(trace, "iterative", "none") / 1.3,
        )  # fmt: skip
        add(
            "`backward` with its depth over `forward`: at most 1", trace,
            lambda v, t=trace: v.ms(t, "backward", "none") / v.ms(t, "forward", "none"), ".2f", most=1,
        )  # fmt: skip
    trace = TRACES[0]
    add(
        "a replay of 3 s with the thesis's method, processor seconds: half", trace, lambda v: v.replay_s, ".1f",
        most=was.replay_s / 2,
    )  # fmt: skip
    add("the default replay, PSNR in dB: at least 28", trace, lambda v: v.psnr_db, ".1f", least=28)
    add("... empty pixels in %: none", trace, lambda v: 100 * v.empty, ".2f", most=0)
    add("depth over colour on a link with a codec: at most 1", trace, lambda v: v.depth_share, ".2f", most=1)
    return "\n".join(lines)


def _best_in_time(version: Version, trace: str) -> tuple[float, float, float]:
    """Return ms, dB gained and share of the FLIP of the best method in the thesis's time."""
    ms, psnr_db, flip = version.rows[trace, "forward", "interpolate"]
    every = [row for key, row in version.rows.items() if key[0] == trace and row[0] <= ms]
    best = min(every, key=lambda row: row[2])
    return best[0], best[1] - psnr_db, best[2] / flip
