"""Every script in examples/ runs as it is and writes what its header promises."""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
from study import tiny

from hmdwarp.client.warps import warps

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SCRIPTS = sorted(EXAMPLES.glob("*.py"))


def header(script: Path) -> tuple[str, list[str]]:
    """Return what the script says it shows, and the names of what it writes."""
    shows, writes = script.read_text(encoding="utf-8").splitlines()[:2]
    assert shows.startswith("# Shows: ") and shows.endswith("."), shows
    assert writes.startswith("# Writes: "), writes
    names = re.sub(r"\(.*?\)", "", writes.removeprefix("# Writes: "))
    return shows, [name.strip() for name in names.split(",")]


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_it_runs_and_writes_what_it_promises(script, tmp_path, monkeypatch):
    """From another folder; files have content and folders hold files.

    Commands that it starts run in this process; a warp that it registers goes with it.
    """
    _, promised = header(script)
    out = tmp_path / "out"
    if script.stem != "replay_summary":  # whose page is the first that people see
        monkeypatch.setattr("hmdwarp.run.run_summary.render_report", lambda *_, **__: "no page")
    monkeypatch.setattr("hmdwarp.run.replay_run.worker_count", lambda _: 0)
    run, ran_here = subprocess.run, lambda words: tiny.ran(*words[words.index("hmdwarp") + 1 :])
    if "import subprocess" in script.read_text(encoding="utf-8"):
        monkeypatch.setattr(
            subprocess, "run", lambda words, **how: ran_here(words) if "hmdwarp" in words else run(words, **how)
        )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [str(script), str(out)])
    known = warps.names()
    runpy.run_path(str(script), run_name="__main__")
    for name in {*warps.names()} - {*known}:
        del warps._entries[name]
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    for name in promised:
        path = out / name
        assert path.stat().st_size > 0 if path.is_file() else list(path.iterdir()), name
    assert {path.name for path in out.iterdir()} == {name.partition("/")[0] for name in promised}


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_it_is_short_and_needs_no_private_name(script):
    text = script.read_text(encoding="utf-8")
    assert text.count("\n") <= 45
    assert f'"out/{script.stem}"' in text, "where it writes when run by hand"
    assert not re.findall(r"^\s*(?:from|import) hmdwarp\S*\._|import _", text, re.MULTILINE)
