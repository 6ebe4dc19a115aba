"""Tables and picture of docs/study*.md: scales, keys, the thesis' ratings, coverage, power."""

from __future__ import annotations

import csv
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.special import ndtr

from hmdwarp.cli.catalogue import entries
from hmdwarp.display import Command
from hmdwarp.report import p_text, pair_text
from hmdwarp.study.design import Ask, design_from_text
from hmdwarp.study.dialogs import CONTROLS, QuestionDialog
from hmdwarp.study.power import Simulation, pairs_model, power_from, tally_of
from hmdwarp.study.scales import load_scale
from hmdwarp.study.statistics import JOD_SPREAD

Program = Callable[..., None]
WORDS = ("pairs (+/0/-)", "mean difference", "BCa 95 %", "Hodges-Lehmann", "exact p", "Holm 3 / 6", "r")


def scales_table() -> str:
    """Return every scale that is part of the package."""
    lines = ["| scale | what it is | asks | source |", "| --- | --- | --- | --- |"]
    for row in entries("scales"):
        asks = row["asks"].split(":")[0] if row["kind"] == "questionnaire" else row["asks"]
        lines.append(f"| `{row['name']}` | {row['summary']} | {asks} | {row['source']} |")
    return "\n".join(lines)


def keys_table() -> str:
    """Return the keys of a question, from the list that window and controllers use."""
    lines = ["| key | what it does |", "| --- | --- |"]
    for one in CONTROLS:
        if one.what:
            keys = ", ".join(
                f"`{key}`" for key in (one.written or one.key, *(key for key in one.also if "KP" not in key))
            )
            lines.append(f"| {keys} | {one.what} |")
    lines.append("| mouse | points at the scale, the wheel moves, a click answers |")
    return "\n".join(lines)


def thesis_table(folder: Path, program: Program) -> str:
    """Return the analysis of the ratings that the thesis published."""
    out = folder / "thesis"
    program("study", "analyse", "thesis", "--out", str(out), "--quiet")
    with (out / "tables" / "comparisons.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    lines = ["| part | compared | " + " | ".join(WORDS) + " |", "|" + " --- |" * (len(WORDS) + 2)]
    for row in rows:
        mean, low, high, shift, from_, to, r = (
            float(row[name]) for name in ("mean", "low", "high", "shift", "shift_low", "shift_high", "rank_biserial")
        )
        p, holm, holm_all = (p_text(float(row[name])) for name in ("p", "holm", "holm_all"))
        figures = (
            f"{row['n']} ({row['better']}/{row['equal']}/{row['worse']})",
            f"{mean:+.3f}",
            f"{low:+.2f} .. {high:+.2f}",
        )
        figures += (f"{shift:+.2f} ({from_:+.2f} .. {to:+.2f})", p, f"{holm} / {holm_all}", f"{r:+.2f}")
        lines.append(
            f"| {row['part']} | {pair_text(row['baseline'], row['condition'])} | " + " | ".join(figures) + " |"
        )
    return "\n".join(lines)


def coverage_table(root: Path) -> str:
    """Return how often the analysis is right in 1000 simulated studies with known effects."""
    return subprocess.run(
        [sys.executable, "-m", "tests.study.coverage"], cwd=root, check=True, capture_output=True, text=True
    ).stdout


def power_text(folder: Path) -> str:
    """Return what `study power` prints for half a grade in the study `quick`."""
    command = ["study", "power", "quick", "--effect", "0.5", "--out", str(folder / "power")]
    program = [sys.executable, "-m", "hmdwarp", *command]
    printed = subprocess.run(program, check=True, capture_output=True, text=True).stdout
    # The line left out names this run's folder.
    lines = [line for line in printed.rstrip().splitlines() if not line.startswith("Table and plot:")]
    return "\n".join(["```text", *lines, "```"])


PAIRS = """schema = 1
name = "pairs"
title = "Which is better?"
[common]
scene = "room"
[trial]
shows = "pair"
seconds = 8
scales = ["{scale}"]
[[condition]]
name = "late"
warp = "none"
[[condition]]
name = "warped"
[[family]]
name = "a warp against none"
compare = [{{ better = "warped", baseline = "late" }}]
"""
PAIRS_PEOPLE, PAIRS_STUDIES = (10, 20, 30, 40, 60), 1000


def pairs_power_table() -> str:
    """Return the power of one comparison, forced and with ties, for some effects."""
    lines = [
        "| true difference | share of forced choices | answers | "
        + " | ".join(f"{n} people" for n in PAIRS_PEOPLE)
        + " |",
        "| ---: | ---: | --- |" + " ---: |" * len(PAIRS_PEOPLE),
    ]
    for jod in (0.0, 0.5, 1.0, 1.5):
        for name, words in (("preference", "forced"), ("preference_or_tie", "or *no difference*")):
            design = design_from_text(PAIRS.format(scale=name), "pairs.toml", checked=False)
            scale = design.scales[0]
            model = pairs_model(design, scale, jod)
            simulation = Simulation(model, design, scale, PAIRS_PEOPLE, seed=1)
            found = power_from(simulation, [tally_of(simulation, range(PAIRS_STUDIES))])
            shares = (next(iter(at_n.found.values())).value for at_n in found.at)
            figures = " | ".join(f"{share:.0%}" for share in shares)
            lines.append(f"| {jod:g} JOD | {ndtr(jod / JOD_SPREAD):.0%} | {words} | {figures} |")
    return "\n".join(lines)


def question_picture(path: Path) -> None:
    """Draw a rating and a sickness score as the participant sees them."""
    panels = [_asked("grade", "right", "left"), _asked("misc", "right", "left", "left", "left")]
    height = max(len(panel) for panel in panels)
    padded = [np.pad(panel, ((0, height - len(panel)), (0, 0))) for panel in panels]
    Image.fromarray(np.hstack([padded[0], np.zeros((height, 40), np.uint8), padded[1]])).save(path, optimize=True)


def _asked(name: str, *steps: str) -> np.ndarray:
    scale = load_scale(name)
    asked = QuestionDialog(Ask(f"trial/1/{name}", scale, scale.items[0], "trial", 1, "trial/1"), lambda: 0.0)
    asked.handle([Command(step) for step in steps])
    return asked.panel().ink()
