"""Everything that CONTRIBUTING says can be added, from another package.

The package is that of docs/adding-a-warp.md and docs/adding-others.md, as it stands there.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import attrs
import numpy as np
import pytest

from hmdwarp.base import Declared, InputError, Number, option
from hmdwarp.experiments.thesis.experiment import Experiment
from hmdwarp.study.scales import load_scale

ROOT = Path(__file__).resolve().parents[1]
GUIDES = "".join((ROOT / "docs" / f"adding-{name}.md").read_text(encoding="utf-8") for name in ("a-warp", "others"))
BLOCKS = re.findall(r"^```text\n# (\S+)\n(.*?)^```", GUIDES, re.DOTALL | re.M)
FILES = dict(block for block in BLOCKS if block[0] != "pyproject.toml")
PROJECT = "".join(text for name, text in BLOCKS if name == "pyproject.toml")


@pytest.fixture(scope="module")
def package(tmp_path_factory) -> Path:
    """Return a folder in which the guide's package is installed."""
    folder = tmp_path_factory.mktemp("site")
    (folder / "my_package").mkdir()
    (folder / "my_package" / "__init__.py").touch()
    for path, text in FILES.items():
        (folder / path).write_text(text, encoding="utf-8")
    groups = tomllib.loads(PROJECT)["project"]["entry-points"]
    info = folder / "my_package-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: my-package\nVersion: 1.0\n", encoding="utf-8")
    points = [
        f"[{group}]\n" + "".join(f"{name} = {module}\n" for name, module in entries.items())
        for group, entries in groups.items()
    ]
    (info / "entry_points.txt").write_text("\n".join(points), encoding="utf-8")
    return folder


COMMON = (
    "replay look-around --scene planes --size 48x40 --seconds 0.3 --rate 60 --latency 50 --guard 1 --lens none "
    "--headset flat-90 --metrics-every 10 --workers 0 --images 0 --loss 0.3"
)
COMMANDS = (
    f"{COMMON} --strategy beacons --out kept",
    f"{COMMON} --warp rotation --fill grey --effects none --out plain",
    f"{COMMON} --warp rotation --fill grey --effects dim --out dimmed",
    *(f"{COMMON} --warp {name} --fill none --effects none --predict none --out {name}" for name in ("unmoved", "none")),
    "bench walk --scene planes --warp unmoved --fill none --latency 50 --size 48x40 --guard 1 --instants 2 "
    "--workers 0 --out bench",
    "plan --scene planes --warp rotation --fill grey --effects dim",
    "list layers",
    f"{COMMON} --scene wall --predict still --codec h264_small --jitter rounds --headset mine.toml --out others",
    "trace info phone.csv",
    "replay --frames frames.npz --repair median --rate 60 --latency 50 --workers 0 --images 0 --out recorded",
)


def write_inputs(folder: Path) -> None:
    """Write the user's own files: a headset, a scale, a trace and recorded frames."""
    for kind in ("headsets/flat-90", "study/scales/acr"):
        name = "mine.toml" if "flat" in kind else "scale.toml"
        text = (ROOT / "hmdwarp" / f"{kind}.toml").read_text(encoding="utf-8")
        (folder / name).write_text(text.replace('name = "flat-90"', 'name = "mine"'), encoding="utf-8")
    rows = [f"{10 * n},{0.01 * n},1.6,0,0,0,0,1,99" for n in range(20)]
    (folder / "phone.csv").write_text("timestamp,px,py,pz,qx,qy,qz,qw,battery\n" + "\n".join(rows), encoding="utf-8")
    count, size = 20, (40, 48)
    depth_m = np.full((count, *size), 2.0, np.float32)
    depth_m[:, 10:20, 10:20] = np.nan
    colour = np.random.default_rng(1).integers(0, 255, (count, *size, 3), np.uint8)
    position_m = np.array([(0.002 * n, 1.6, 0) for n in range(count)])
    times = {"time_ns": np.arange(count) * 33_000_000}
    np.savez(folder / "frames.npz", colour=colour, depth_m=depth_m, position_m=position_m, **times)


@pytest.fixture(scope="module")
def work(package) -> Path:
    """Return a folder in which the commands have run, in one process beside the package."""
    folder = package / "work"
    folder.mkdir()
    write_inputs(folder)
    code = (
        "import sys\nfrom hmdwarp.cli import main\nfrom hmdwarp.run import run_summary\n"
        "page = run_summary.render_report\n"
        "for line in sys.argv[1:]:\n    sys.argv[1:] = line.split()\n"
        "    run_summary.render_report = page if 'others' in line else lambda *_, **__: 'no page'\n"
        "    try:\n        main()\n    except SystemExit as left:\n        assert not left.code, line"
    )
    paths = os.pathsep.join(filter(None, (str(package), os.environ.get("PYTHONPATH"))))
    done = subprocess.run(
        [sys.executable, "-c", code, *COMMANDS], env={**os.environ, "PYTHONPATH": paths}, cwd=folder,
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    (folder / "printed.txt").write_text(done.stdout, encoding="utf-8")
    return folder


def summary_of(folder: Path) -> dict:
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


def test_a_fill_and_an_effect_from_outside_change_the_picture(work):
    plain, dimmed = (summary_of(work / name) for name in ("plain", "dimmed"))
    assert (plain["fill"], plain["effects"], dimmed["effects"]) == ("grey", [], ["dim"])
    assert plain["filled"]["empty"] == 0
    assert dimmed["quality"]["psnr_db"]["mean"] < plain["quality"]["psnr_db"]["mean"] - 3


def test_a_warp_in_python_is_measured_as_any_other(work):
    """Without a guard band it does what `none` does, to the last bit."""
    unmoved, none = (summary_of(work / name) for name in ("unmoved", "none"))
    assert unmoved["warp"] == "unmoved" and unmoved["quality"] == none["quality"]
    (row,) = json.loads((work / "bench" / "bench.json").read_text(encoding="utf-8"))["rows"]
    assert row["warp"] == "unmoved" and row["quality"]["flip"]["mean"] > 0


@attrs.frozen
class Mine(Declared):
    """Options of another package."""

    count: int = option(3, "How many.", valid=Number(least=1, most=9))


def refuses_beyond(limits: str) -> bool:
    with pytest.raises(InputError, match=limits):
        Mine.of({"count": 10})
    return Mine.of({"count": 4}).count == 4


def printed_by(work: Path) -> str:
    return (work / "printed.txt").read_text(encoding="utf-8")


def of_thesis() -> Experiment:
    """An experiment as an entry of thesis.toml."""
    return Experiment.of(
        {"name": "mine", "source": "here", "claim": "It holds.", "thesis": "1", "measured": "p", "number": "only p"}
        | {"rule": "at most 0.05", "cells": [{"parts": ["run 1"]}]}
    )


# What each row of CONTRIBUTING's table leaves behind.
PROOFS = {
    "a warp": lambda work: summary_of(work / "kept")["warp"] == "beacons",
    "a fill": lambda work: summary_of(work / "plain")["fill"] == "grey",
    "an effect": lambda work: summary_of(work / "dimmed")["effects"] == ["dim"],
    "a frame layer": lambda work: "the middle of each mesh, sent once" in printed_by(work),
    "a strategy": lambda work: summary_of(work / "kept")["client_models"][0]["beacons"] > 0,
    "a metric": lambda work: summary_of(work / "others")["quality"]["mean_error"]["mean"] > 0,
    "an option": lambda work: refuses_beyond("at most 9"),
    "a scene": lambda work: summary_of(work / "others")["scene"] == "wall",
    "a trace format": lambda work: re.search(r"format +phone", printed_by(work)),
    "a predictor": lambda work: summary_of(work / "others")["predict"] == "still",
    "a repair": lambda work: "mended by median" in " ".join(summary_of(work / "recorded")["notes"]),
    "a codec": lambda work: "h264_small" in json.dumps(summary_of(work / "others")),
    "a delay model": lambda work: "rounds" in (work / "others" / "report.html").read_text(encoding="utf-8"),
    "an experiment of the thesis": lambda work: of_thesis().rule.holds(0.01),
    "a layout of recorded frames": lambda work: summary_of(work / "recorded")["recorded"]["layout"] == "arrays",
    "a headset": lambda work: summary_of(work / "others")["headset"] == "mine",
    "a rating scale": lambda work: load_scale(str(work / "scale.toml")).title,
}


@pytest.mark.parametrize("kind", PROOFS)
def test_what_contributing_names_can_be_added_from_outside(kind, work):
    assert PROOFS[kind](work)


def test_every_row_of_the_table_is_proven():
    table = re.findall(r"^\| (an? [^|]+) \| \d \|", (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"), re.M)
    assert {kind for row in table for kind in row.split(", ")} == PROOFS.keys()
