"""Without the package everything else runs: it is found as another package is."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SMALL = "look-around --headset rift-dk1 --size 48x40 --seconds 0.1 --metrics-every 9 --workers 0 --images 0"
SMALL += " --scene planes --out"
ADDED = tomllib.loads((ROOT / "hmdwarp" / "cloudlight" / "entry_points.toml").read_text(encoding="utf-8"))
# Command lines that run, and those that are refused with that status and line.
RUN = ("list strategies", "list warps", "list layers", f"replay {SMALL} default", "plan --scene planes", "warp --help")
REFUSED = {
    f"replay {SMALL} refused --strategy photons": (2, "unknown strategy 'photons': "),
    f"replay {SMALL} refused --warp irradiance": (2, "unknown warp 'irradiance': "),
    f"replay {SMALL} refused --indirect voxels": (2, "unknown indirect light 'voxels'"),
    f"replay {SMALL} refused --scene lantern": (2, "scene 'lantern' has lamps, and no indirect light"),
}
CODE = (
    "import sys\nfrom hmdwarp.cli import main\n"
    "for line in sys.argv[1:]:\n    sys.argv[1:] = line.split()\n    print('>', line, flush=True)\n"
    "    try:\n        main()\n    except SystemExit as left:\n"
    "        print('status', left.code or 0, file=sys.stderr, flush=True)"
)


@pytest.fixture(scope="module")
def ran(tmp_path_factory) -> tuple[Path, subprocess.CompletedProcess[str]]:
    """Return a folder in which all these have run, in one process, without the package."""
    folder = tmp_path_factory.mktemp("apart")
    without = shutil.ignore_patterns("__pycache__", "cloudlight")
    shutil.copytree(ROOT / "hmdwarp", folder / "hmdwarp", ignore=without)
    for name in ("shaders", "recordings"):
        (folder / name).symlink_to(ROOT / name)
    paths = os.pathsep.join(filter(None, (str(folder), os.environ.get("PYTHONPATH"))))
    done = subprocess.run(
        [sys.executable, "-c", CODE, *RUN, *REFUSED], env={**os.environ, "PYTHONPATH": paths}, cwd=folder,
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return folder, done


def test_everything_else_runs_without_it(ran):
    folder, done = ran
    statuses = [line for line in done.stderr.splitlines() if line.startswith("status")]
    assert statuses[: len(RUN)] == ["status 0"] * len(RUN), done.stderr
    summary = json.loads((folder / "default" / "summary.json").read_text(encoding="utf-8"))
    assert summary["quality"]["psnr_db"]["mean"] > 0
    assert "depth_image" in done.stdout
    assert not [name for name in ADDED["warps"] if f"\n{name} " in done.stdout]


def test_what_it_adds_is_refused_in_one_line_without_it(ran):
    folder, done = ran
    said = done.stderr.splitlines()
    ends = [number for number, line in enumerate(said) if line.startswith("status")][len(RUN) - 1 :]
    for (status, message), start, end in zip(REFUSED.values(), ends, ends[1:], strict=False):
        lines = [line for line in said[start + 1 : end] if message in line]
        assert len(lines) == 1 and said[end] == f"status {status}", said[start + 1 : end + 1]
    assert len(ends) == 1 + len(REFUSED) and not (folder / "refused").exists()


def test_its_entries_are_registered_under_their_names():
    registries = {
        "lights": "scenes", "layers": "frames.layers", "parts": "sources.server.parts", "warps": "client.warps",
        "strategies": "client.strategies",
    }  # fmt: skip
    assert ADDED.keys() == registries.keys()
    for name, place in registries.items():
        registry = getattr(import_module(f"hmdwarp.{place}"), name)
        for entry, module in ADDED[name].items():
            assert registry.get(entry).name == entry and registry.get(entry).__module__ == module
