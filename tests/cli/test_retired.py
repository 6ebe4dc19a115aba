"""What was removed from the command line is answered by what to use instead."""

from __future__ import annotations

import commands
import pytest

from hmdwarp.cli._app import entries

TRACE = {"replay", "live", "bench", "compare", "plan"}


@pytest.mark.parametrize("key", entries())
def test_a_removed_name_ends_with_status_2_and_what_to_use_instead(key):
    words = ["replay" if word == "*" else word.replace("*", "x") for word in key.split()]
    done = commands.hmdwarp(*([*words[:1], "walk", *words[1:]] if words[0] in TRACE - {"live", "plan"} else words))
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert f"was removed: {entries()[key]}" in done.stderr
    assert done.stdout == ""


def test_an_unknown_name_is_no_removed_one():
    done = commands.hmdwarp("replay", "walk", "--no-such-option")
    assert done.returncode == 2
    assert "was removed" not in done.stderr
