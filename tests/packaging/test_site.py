"""The documentation builds as a site without a warning and without a network."""

from __future__ import annotations

import inspect
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

import hmdwarp

ROOT = Path(__file__).resolve().parents[2]
NOWHERE = dict.fromkeys(("http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY"), "http://127.0.0.1:9")


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """Return the folder of the site, built by the line that `make site` runs."""
    out = tmp_path_factory.mktemp("site")
    lines = subprocess.run(["make", "-n", "-C", ROOT, "site"], capture_output=True, text=True, check=True).stdout
    (line,) = [line for line in lines.splitlines() if "mkdocs" in line]
    words = shlex.split(line)
    arguments = words[words.index("-m") :]
    assert "--strict" in arguments, "warnings are errors"
    env = {**os.environ, **NOWHERE, "NO_MKDOCS_2_WARNING": "1"}
    command = [sys.executable, *arguments, "--site-dir", str(out)]
    done = subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    return out


def test_every_public_name_is_in_the_reference(site):
    text = (site / "reference" / "hmdwarp.html").read_text(encoding="utf-8")
    missing = [name for name in hmdwarp.__all__ if f">{name}<" not in text]
    assert not missing


def test_the_reference_has_public_names_alone_and_can_be_searched(site):
    modules = [f"hmdwarp.{name}" for name in hmdwarp.__all__ if inspect.ismodule(getattr(hmdwarp, name))]
    assert {page.stem for page in (site / "reference").glob("*.html")} == {"index", "hmdwarp", *modules}
    assert (site / "search" / "search_index.json").is_file()
    text = (site / "index.html").read_text(encoding="utf-8")
    tasks = ["Replay a recorded head", "Warp your RGB-D", "Run it live", "Compare methods", "Run a rating study"]
    places = [text.index(task) for task in tasks]
    assert places == sorted(places)


def test_fields_stand_with_their_class(site):
    """Inherited ones too: RunOptions has those of the pipeline."""
    pages = [page.read_text(encoding="utf-8") for page in (site / "reference").glob("*.html")]
    (text,) = [page for page in pages if re.search(r'<h2 id="[\w.]+\.RunOptions"', page)]
    assert "<code>latency_ms: float = 200.0</code>" in text and "<code>trace: str = " in text


def test_all_pages_are_there(site):
    pages = {page.stem for page in (ROOT / "docs").glob("*.md")} | {"index", "examples", "recordings", "CHANGELOG"}
    assert pages <= {page.stem for page in site.glob("*.html")}
    for script in (ROOT / "examples").glob("*.py"):
        assert f'id="{script.stem}"' in (site / "examples.html").read_text(encoding="utf-8")
