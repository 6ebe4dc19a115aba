"""A layer, a strategy with state, a warp, a fill and an effect from another package.

The package is that of docs/adding-a-warp.md, as it stands there.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

GUIDE = Path(__file__).resolve().parents[2] / "docs" / "adding-a-warp.md"
FILES = dict(re.findall(r"^```text\n# (\S+)\n(.*?)^```", GUIDE.read_text(encoding="utf-8"), re.DOTALL | re.M))


@pytest.fixture(scope="module")
def package(tmp_path_factory) -> Path:
    """Return a folder in which the guide's package is installed."""
    folder = tmp_path_factory.mktemp("site")
    (folder / "my_package").mkdir()
    (folder / "my_package" / "__init__.py").touch()
    for path, text in FILES.items():
        (folder / path).write_text(text, encoding="utf-8")
    groups = tomllib.loads(FILES["pyproject.toml"])["project"]["entry-points"]
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
    "replay look-around --scene planes --size 48x40 --seconds 0.5 --rate 60 --latency 50 --guard 1 --lens none "
    "--headset flat-90 --metrics-every 10 --workers 0 --images 0 --loss 0.3"
)
COMMANDS = (
    f"{COMMON} --strategy beacons --out kept",
    f"{COMMON} --warp rotation --fill grey --effects none --out plain",
    f"{COMMON} --warp rotation --fill grey --effects dim --out dimmed",
    "plan --scene planes --warp rotation --fill grey --effects dim",
    "list layers",
)


@pytest.fixture(scope="module")
def work(package) -> Path:
    """Return a folder in which the commands have run, in one process beside the package."""
    folder = package / "work"
    folder.mkdir()
    code = (
        "import sys\nfrom hmdwarp.cli import main\nfor line in sys.argv[1:]:\n    sys.argv[1:] = line.split()\n"
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


def test_a_store_from_outside_keeps_what_arrives(work):
    """Lost frames are sent again, so all of it arrives; discs cover some pixels before the fill."""
    summary = summary_of(work / "kept")
    assert (summary["warp"], summary["fill"]) == ("beacons", "grey")
    (kept,) = summary["client_models"]
    assert kept["budget"] == 100 and 16 * kept["beacons"] == kept["geometry_bytes"] > 0
    assert "s beacons" in (work / "kept" / "report.html").read_text(encoding="utf-8").replace("<wbr>", "")
    assert 0 < summary["quality"]["hole_share"]["mean"] < 1


def test_a_fill_and_an_effect_from_outside_change_the_picture(work):
    plain, dimmed = (summary_of(work / name) for name in ("plain", "dimmed"))
    assert (plain["fill"], plain["effects"], dimmed["effects"]) == ("grey", [], ["dim"])
    assert plain["filled"]["empty"] == 0
    assert dimmed["quality"]["psnr_db"]["mean"] < plain["quality"]["psnr_db"]["mean"] - 3


def test_the_plan_and_the_lists_name_them(work):
    printed = (work / "printed.txt").read_text(encoding="utf-8")
    assert all(name in printed for name in ("the middle of each mesh, sent once", "fill grey", "dimming"))
