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

ROOT = Path(__file__).resolve().parents[2]
SMALL = "look-around --headset rift-dk1 --size 48x40 --seconds 0.1 --metrics-every 9 --workers 0 --images 0"
SMALL += " --scene planes --out"
ADDED = tomllib.loads((ROOT / "hmdwarp" / "cloudlight" / "entry_points.toml").read_text(encoding="utf-8"))
# Command lines, and the line with which one is refused.
COMMANDS = {
    "list strategies": "", "list warps": "", "list layers": "", f"replay {SMALL} default": "",
    "plan --scene planes": "", "warp --help": "",
    f"replay {SMALL} refused --strategy photons": "unknown strategy 'photons': ",
    f"replay {SMALL} refused --warp irradiance": "unknown warp 'irradiance': ",
    f"replay {SMALL} refused --indirect voxels": "unknown indirect light 'voxels'",
    f"replay {SMALL} refused --scene lantern": "scene 'lantern' has lamps, and no indirect light",
}  # fmt: skip
CODE = (
    "import sys\nfrom hmdwarp.cli import main\n"
    "for line in sys.argv[1:]:\n    sys.argv[1:] = line.split()\n    print('>', line, flush=True)\n"
    "    try:\n        main()\n    except SystemExit as left:\n"
    "        print('status', left.code or 0, file=sys.stderr, flush=True)"
)


def test_without_it_everything_else_runs_and_what_it_adds_is_refused_in_one_line(tmp_path):
    """All of these in one process."""
    without = shutil.ignore_patterns("__pycache__", "cloudlight")
    shutil.copytree(ROOT / "hmdwarp", tmp_path / "hmdwarp", ignore=without)
    for name in ("shaders", "recordings"):
        (tmp_path / name).symlink_to(ROOT / name)
    paths = os.pathsep.join(filter(None, (str(tmp_path), os.environ.get("PYTHONPATH"))))
    done = subprocess.run(
        [sys.executable, "-c", CODE, *COMMANDS], env={**os.environ, "PYTHONPATH": paths}, cwd=tmp_path,
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    *said, end = done.stderr.split("status ")
    assert done.returncode == 0 and len(said) == len(COMMANDS), done.stderr
    statuses = [text.splitlines()[0] for text in (*said[1:], end)]
    assert statuses == ["2" if refusal else "0" for refusal in COMMANDS.values()], done.stderr
    for text, refusal in zip(said, COMMANDS.values(), strict=True):
        assert not refusal or sum(refusal in line for line in text.splitlines()) == 1, text
    summary = json.loads((tmp_path / "default" / "summary.json").read_text(encoding="utf-8"))
    assert summary["quality"]["psnr_db"]["mean"] > 0 and not (tmp_path / "refused").exists()
    assert "depth_image" in done.stdout
    assert not [name for name in ADDED["warps"] if f"\n{name} " in done.stdout]


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
