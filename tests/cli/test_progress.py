"""Where there is no terminal, a long run tells in lines what it does and how long it will take."""

from __future__ import annotations

import pytest

from hmdwarp.cli import _show


@pytest.mark.parametrize(
    ("steps", "told"),
    [
        # Of how many, and when: the first step has warming up in it.
        ([(0, 61, 100.0)], "refreshes: still preparing"),
        ([(1, 61, 0.0)], "refreshes: 1 of 61"),
        ([(0, 61, 100.0), (1, 61, 120.0), (11, 61, 130.0)], "refreshes: 11 of 61, about 50 s to go"),
        ([(1, 1001, 0.0), (2, 1001, 1.2)], "refreshes: 2 of 1001, about 20 min to go"),
        (
            [(1, 2, 0.0), (2, 2, 1.0)],
            "refreshes: 2 of 2; the last pictures are measured, then the results are written",
        ),
    ],
)
def test_an_estimate_comes_from_the_steps_after_the_first(steps, told):
    lines = _show._Lines("refreshes")
    for step in steps:
        lines.update(*step)
    assert lines.line() == told


def test_a_replay_tells_its_progress_without_a_terminal(command, quick, monkeypatch):
    monkeypatch.setattr(_show, "LINE_EVERY_S", 0.001)
    monkeypatch.setattr(_show, "ESTIMATE_AFTER_S", 0.0)
    done = command("replay", "still", *(word for word in quick if word != "--quiet")).done()
    told = done.err.splitlines()
    assert "preparing scene 'planes', OpenGL and metrics; then 6 refreshes of 'still'" in told
    assert any(line.startswith("refreshes: ") for line in told)


def test_quiet_tells_nothing(command, quick, monkeypatch):
    monkeypatch.setattr(_show, "LINE_EVERY_S", 0.001)
    assert command("replay", "still", *quick).err == ""
