"""The wheel works from any folder: shaders, recordings, headsets, templates travel in it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.slow


def run(*command: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Without PYTHONPATH, so that nothing comes from the checkout by accident."""
    env = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")}
    return subprocess.run(
        [str(part) for part in command], check=False, capture_output=True, text=True, cwd=cwd, env=env
    )


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("wheel")
    # --no-isolation: hatchling is there already, so this needs no network.
    done = run(sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", out, ROOT, cwd=out)
    assert done.returncode == 0, done.stdout + done.stderr
    (built,) = out.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory) -> Path:
    """Return the bin folder of a fresh environment with the wheel in it.

    The wheel's dependencies come from the environment of this test.
    """
    place = tmp_path_factory.mktemp("elsewhere")
    venv.create(place / "env", with_pip=False)
    bin_folder = place / "env" / "bin"
    install = [
        sys.executable, "-m", "pip", "--python", bin_folder / "python", "install", "--no-index", "--no-deps",
        "--quiet", wheel,
    ]  # fmt: skip
    done = run(*install, cwd=place)
    assert done.returncode == 0, done.stdout + done.stderr
    # A .pth only appends to sys.path: the packages there are seen, but the .pth of the editable
    # checkout among them is not run.
    (site,) = (place / "env" / "lib").glob("python3*/site-packages")
    (site / "outer.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    return bin_folder


def expected(folder: str, *endings: str) -> set[str]:
    return {p.relative_to(ROOT).as_posix() for p in (ROOT / folder).rglob("*") if p.suffix in endings}


def test_wheel_holds_all_that_is_not_python(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    shaders = expected("shaders", ".comp", ".vert", ".frag", ".glsl")
    recordings = expected("recordings", ".csv", ".md")
    assert shaders and any(name.endswith("look-around.csv") for name in recordings)
    missing = {f"hmdwarp/_data/{name}" for name in shaders | recordings} - names
    inside = expected("hmdwarp/headsets", ".toml") | expected("hmdwarp/report", ".html", ".css", ".js", ".j2")
    inside |= expected("hmdwarp/study", ".toml", ".csv", ".sql") | expected("hmdwarp/scenes", ".xz")
    assert any(name.endswith("rift-dk1.toml") for name in inside)
    assert not (missing | (inside - names)), "files that the program reads did not get into the wheel"


def test_type_checkers_see_that_the_package_is_typed(wheel):
    """PEP 561: without this file they take every name for Any."""
    assert "hmdwarp/py.typed" in zipfile.ZipFile(wheel).namelist()


def test_wheel_holds_nothing_else(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.split("/")[0] for name in names} == {
        "hmdwarp",
        next(n.split("/")[0] for n in names if ".dist-info" in n),
    }
    assert not [name for name in names if "__pycache__" in name or name.endswith((".pyc", ".log"))]
    assert any(name.endswith("licenses/LICENSE") for name in names)


def test_installed_copy_is_the_one_that_runs(installed, tmp_path):
    where = run(installed / "python", "-c", "import hmdwarp; print(hmdwarp.__file__)", cwd=tmp_path)
    assert Path(where.stdout.strip()).is_relative_to(installed.parent), where.stdout + where.stderr


@pytest.mark.parametrize("kind", ["warps", "scenes", "formats", "studies"])
def test_lists_from_another_folder(installed, tmp_path, kind):
    done = run(installed / "hmdwarp", "list", kind, "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert all(entry["name"] for entry in json.loads(done.stdout))


def test_replays_a_shipped_recording_by_its_bare_name(installed, tmp_path):
    done = run(
        installed / "hmdwarp", "replay", "look-around", "--scene", "room", "--latency", "100",
        "--warp", "forward", "--fill", "interpolate", "--lens", "radial", "--headset", "rift-dk1",
        "--size", "64x80", "--start", "1", "--seconds", "0.3", "--out", "result", "--quiet",
        cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "result" / "summary.json").read_text(encoding="utf-8"))
    assert (summary["scene"], summary["warp"], summary["headset"], summary["size"]) == (
        "room",
        "forward",
        "rift-dk1",
        [64, 80],
    )
    assert summary["frames"] > 0
    assert (tmp_path / "result" / "report.html").stat().st_size > 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["result"]
