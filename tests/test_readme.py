"""Every command and line of Python in README.md and docs/*.md runs, as a reader would run it.

A block of kind `sh` or `python` runs as it is but for smaller pictures, in an empty folder for each
page; a block of kind `shell` opens a window or a page. A block of kind `text` needs people, a
headset or the checkout, so it is only read.
"""

from __future__ import annotations

import importlib
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from urllib.request import HTTPCookieProcessor, build_opener

import needs
import pytest
from bench_files import NO_PAGE
from commands import hmdwarp
from display.virtual_screen import VirtualScreen
from serving import Serving, free_port
from study.session.conftest import hurry

ROOT = Path(__file__).resolve().parents[1]
TOP = (ROOT / "README.md", ROOT / "CONTRIBUTING.md")
TOPS = (".", "hmdwarp", "shaders", "hmdwarp/client", "tests")  # of paths that pages name
PAGES = {path.name: path.read_text(encoding="utf-8") for path in (*TOP, *sorted((ROOT / "docs").glob("*.md")))}
BLOCKS = {
    name: re.findall(r"^```(sh|shell|python)\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    for name, text in PAGES.items()
}
LIVE = sorted(
    {line for blocks in BLOCKS.values() for kind, text in blocks if kind == "shell" for line in text.splitlines()}
)

# Of an option given twice the last counts: what is drawn is smaller and shorter here.
SMALLER = {
    "hmdwarp replay ": " --size 64x80 --seconds 0.2 --images 1 --workers 0",
    "hmdwarp bench ": " --size 64x80 --workers 0 --instants 1 --rounds 1",
    "hmdwarp compare ": " --size 48x40 --workers 0",
    "hmdwarp live ": " --size 64x80",
    "hmdwarp choose ": " --size 32x40 --seconds 0.1",
}
# Where the page of what ran is drawn, which takes longer than such a run; and who draws it.
WITH_PAGES = ("README.md", "getting-started.md")
NO_PAGES = (
    ("run.run_summary.render_report", "no page"), ("run.live_log.render_live_report", "no page"),
    ("experiments.bench.bench_run.bench_page", NO_PAGE), ("experiments.bench.compare_run.compare_page", NO_PAGE),
)  # fmt: skip

# What the examples of a page must leave behind.
LEFT = {
    "README.md": ("out/walk/report.html", "out/bench/bench.json", "out/thesis/report.html"),
    "bench.md": ("out/bench/bench.html", "out/budget/report.html"),
    "getting-started.md": ("out/first/report.html", "out/first/summary.json", "out/first/frames.csv"),
    "headsets.md": ("out/viewer/report.html",),
    "live.md": ("out/offscreen/report.html", "rehearsal.csv"),
    "replay.md": ("out/turn/replay.mp4", "out/link/report.html", "mine.csv", "mine.tum"),
    "frames.md": ("out/recorded/report.html", "out/recorded/summary.json", "out/recorded-bench/bench.json"),
    "rgbd.md": ("frame.npz", "warped.png"),
    "your-own-scene.md": ("shop.ply", "out/shop/report.html"),
    "thesis.md": ("out/thesis-again/thesis.html", "out/thesis-again/results.json"),
    "study.md": ("tables/ratings.csv", "analysis/report.html"),
    "study-analysis.md": ("out/thesis/report.html",),
}


def run(command: list[str], folder: Path) -> None:
    """Run a command as a user would, with the console script first in PATH."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        command, cwd=folder, env={**os.environ, "PATH": path}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}\n{done.stderr}"


def run_block(block: str, folder: Path, servers: dict[str, subprocess.Popen]) -> None:
    """Run commands, those of hmdwarp in this process unless one stays in the background.

    servers: what stays there, each once for a page.
    """
    for statement in re.findall(r"^[^\n]*<<'END'\n.*?^END$|^[^\n]+", block, re.DOTALL | re.MULTILINE):
        if statement.endswith(" &"):
            words = [sys.executable, "-m", *shlex.split(statement.removesuffix(" &"))]
            servers[statement] = servers.get(statement) or subprocess.Popen(words, cwd=folder, stderr=subprocess.PIPE)
        elif statement.startswith("hmdwarp "):
            done = hmdwarp(*shlex.split(statement)[1:], folder=folder)
            assert done.returncode == 0, f"{statement}\n{done.stdout}\n{done.stderr}"
        elif not statement.startswith(("kill ", "server=")):
            run(["sh", "-ec", statement], folder)


def smaller(block: str) -> str:
    """Return the commands of a block with the options of SMALLER; of a study, less to show.

    A suite says by itself what is run: see small_suites.
    """
    block = block.replace('size = "160x200"', 'size = "64x80"').replace("seconds = 1\n", "seconds = 0.3\n")
    block = re.sub(r'(--scene |scene = ")room', r"\1planes", block)
    block = block.replace("voxels:size=32", "voxels:size=8,cones=4")
    block = re.sub("^(hmdwarp serve .*) &$", r"\1 --samples 1 &", block, flags=re.MULTILINE)
    lines = block.splitlines()
    return "\n".join(line + "".join(_more(line, *each) for each in SMALLER.items()) for line in lines)


def _more(line: str, start: str, options: str) -> str:
    """Return the options of a command that starts so."""
    if not line.startswith(start):
        return ""
    return " --workers 0" if "--suite" in line else options + _plain(line)


def _plain(line: str) -> str:
    """Return options of fewer and plainer frames, and of a scene where the command names none."""
    if "--frames" in line or "--connect" in line:
        return ""
    fewer = " --samples 1" + " --rate 30" * line.startswith("hmdwarp replay ")
    return fewer + ("" if "--scene" in line else " --scene planes")


@pytest.fixture
def small_suites(tmp_path_factory, monkeypatch) -> None:
    """Let named benchmarks draw 48x30 without antialiasing, of one person and small scenes."""
    text = (ROOT / "hmdwarp/experiments/bench/suites.toml").read_text(encoding="utf-8")
    file = tmp_path_factory.mktemp("suites") / "suites.toml"
    text = re.sub("size = .*\nsamples = .*", 'size = ["48x30"]\nsamples = 1', text)
    text = text.replace('"room,spheres,workshop"', '"planes,spheres"')
    file.write_text(re.sub(r'traces = \[("[^"]+").*\]', r"traces = [\1]", text), encoding="utf-8")
    monkeypatch.setattr("hmdwarp.experiments.bench.suites._FILE", file)
    for name in ("INSTANTS", "ROUNDS"):  # of the short bench that chooses
        monkeypatch.setattr(f"hmdwarp.run.choosing.{name}", 1)


@pytest.mark.slow(25)
@pytest.mark.usefixtures("small_suites")
@pytest.mark.parametrize(
    "page", [name for name, blocks in BLOCKS.items() if {"sh", "python"} & {kind for kind, _ in blocks}]
)
def test_a_page_runs_from_top_to_bottom(page, tmp_path, monkeypatch):
    hurry(monkeypatch)
    monkeypatch.chdir(tmp_path)
    for name, nothing in () if page in WITH_PAGES else NO_PAGES:
        monkeypatch.setattr(f"hmdwarp.{name}", lambda *_, nothing=nothing, **__: nothing)
    ports, servers = {port: str(free_port()) for port in ("5570", "5571")}, {}
    try:
        for kind, block in BLOCKS[page]:
            text = re.sub("|".join(ports), lambda port: ports[port[0]], block)
            if kind == "python" and page == "README.md":
                run([sys.executable, "-c", text], tmp_path)
            elif kind == "python":
                exec(compile(text, page, "exec"), {"__name__": "__main__"})
            elif kind == "sh" and not text.startswith("make "):
                run_block(smaller(text), tmp_path, servers)
    finally:
        for server in servers.values():
            server.terminate()
            server.communicate()
    for name in LEFT.get(page, ()):
        assert (tmp_path / name).stat().st_size > 0, name
    assert not _untracked([path.name + "/" * path.is_dir() for path in tmp_path.iterdir()]), "add them to .gitignore"


def _untracked(names: list[str]) -> list[str]:
    """Those of the names that would be untracked files at the top of a clone."""
    ignored = subprocess.run(
        ["git", "-C", str(ROOT), "check-ignore", "--no-index", *names], capture_output=True, text=True, check=False
    )
    if ignored.returncode > 1:  # no git, or no clone
        return []
    return [name for name in names if name not in ignored.stdout.splitlines()]


@pytest.mark.parametrize("command", [line for line in LIVE if line.startswith("hmdwarp serve")])
def test_the_served_pages_can_be_opened(command):
    """At ports that are free here."""
    pytest.importorskip("aiohttp", reason="aiohttp is not installed: pip install '.[web]'")
    options = [re.sub(r"(127\.0\.0\.1):\d+", r"\1:*", option) for option in shlex.split(command)[2:]]
    with Serving(*options) as serving:
        keeps_cookies = build_opener(HTTPCookieProcessor())
        with keeps_cookies.open(serving.line("for a browser").split()[-1]) as page:
            assert page.status == 200 and b"<script" in page.read()


@pytest.mark.slow
@needs.programs("Xvfb")
@pytest.mark.parametrize("command", [line for line in LIVE if not line.startswith("hmdwarp serve")])
def test_the_live_commands_open_a_window(command, tmp_path):
    small = " --pictures 3 --size 96x120 --scene planes"  # of an option given twice the last counts
    kept = tmp_path / "screen"
    kept.mkdir()
    with VirtualScreen(kept) as screen:
        run(["env", f"DISPLAY={screen.display}", "sh", "-ec", command + small], tmp_path)


def test_the_tables_of_the_front_page_are_those_of_the_results(monkeypatch):
    """They are tables of docs/, less some columns: `make docs OPTIONS=readme` writes them."""
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    regenerate = importlib.import_module("regenerate")
    assert (
        re.search(r"<!-- results -->\n(.*?)<!-- end -->", PAGES["README.md"], re.DOTALL)[1]
        == regenerate.front_page() + "\n"
    )


@pytest.mark.parametrize("page", PAGES)
def test_every_picture_and_page_it_points_to_is_there(page):
    """Pages of docs/ point only to files of docs/, so that their links work in a site as well."""
    on_top = page in {path.name for path in TOP}
    folder = ROOT if on_top else ROOT / "docs"
    for target, anchor in re.findall(r"\]\(([^)#:]+)(#[^)]*)?\)", PAGES[page]):
        assert (folder / target).is_file(), target
        assert on_top or "/" not in target, target
        if anchor:
            assert anchor.removeprefix("#") in _anchors((folder / target).read_text(encoding="utf-8")), target + anchor


@pytest.mark.parametrize("page", PAGES)
def test_every_file_it_names_is_there(page):
    """Paths count from TOPS; mine and NAME are placeholders."""
    for path in re.findall(r"`([\w.-]+/[\w./-]+\.(?:py|comp|glsl|md|toml|csv))`", PAGES[page]):
        if not re.search(r"mine|NAME|^(out|my)", path):
            assert any((ROOT / top / path).is_file() for top in TOPS), path


def _anchors(text: str) -> set[str]:
    """Return the anchors of a page's headings, as GitHub and MkDocs make them."""
    heads = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}
