"""Command lines of `refused.toml`: each is refused in one line that names what is wrong, before
anything is drawn or written.
"""

from __future__ import annotations

import re
import shlex
import tomllib
from pathlib import Path

import pytest

import hmdwarp.gpu.context

TABLE = tomllib.loads(Path(__file__).with_name("refused.toml").read_text(encoding="utf-8"))
BENCH = "--scene planes --size 48x40 --seconds 0.3 --instants 1 --rounds 1 --workers 0 --guard 1.1"
CASES = [(begin, typed) for begin, lines in TABLE.items() for typed in lines]


@pytest.mark.parametrize(("begin", "typed"), CASES, ids=lambda text: text or "hmdwarp")
def test_a_command_line_is_refused_in_one_line(begin, typed, command, quick, tmp_path, monkeypatch, request):
    own = {"OUT": [str(tmp_path / "out")], "OUT.png": [str(tmp_path / "out.png")], "QUICK": quick}
    own["QUICK_BENCH"] = [*shlex.split(BENCH), "--out", str(tmp_path / "out")]
    text = f"{begin} {typed}".replace("LONG", "x" * 300).replace("FOLDER", str(tmp_path / "folder"))
    words = [part for word in shlex.split(text) for part in own.get(word, [word])]
    folders = [Path(word) for word in words if word.startswith(str(tmp_path / "folder"))]
    for folder in folders:
        folder.mkdir()
    if begin == "replay still QUICK":
        request.getfixturevalue("kept")
    if words[0] in ("bench", "plan"):
        monkeypatch.setattr(hmdwarp.gpu.context, "create_context", lambda: pytest.fail("the GPU was started"))
    done = command(*words)
    done.refused()
    for told in TABLE[begin][typed]:
        assert told in done.err or re.search(told, done.err), done
    assert begin == "replay still QUICK" or list(tmp_path.iterdir()) == folders
