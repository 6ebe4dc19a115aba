"""Trials that show two: both are seen, one right after the other, before the question."""

from __future__ import annotations

import pytest

from hmdwarp.study.dialogs.dialog_panels import MessagePanel
from hmdwarp.study.store import COMPLETE, INTERRUPTED

from .sessions import TEXT, closing, contents, losing, run


def pairs(folder):
    """A study of two conditions, so of one pair."""
    path = folder / "small.toml"
    text = TEXT.format(more="").replace("seconds = 0.1", 'shows = "pair"\nseconds = 0.1')
    path.write_text(text.replace('["grade"]', '["preference"]'), encoding="utf-8")
    return path


def shown(path) -> list[tuple[str, int, bool]]:
    return [(showing.key, showing.presentation, showing.complete) for showing in contents(path).showings]


def test_both_are_shown_and_then_compared(tmp_path, gpu, monkeypatch):
    path = pairs(tmp_path)
    ran = run(monkeypatch, gpu, path)
    assert ran.error is None
    assert ran.session.status == COMPLETE
    stored = contents(path)
    assert shown(path) == [("trial/1/first", 1, True), ("trial/1/second", 1, True)]
    assert len({showing.trace for showing in stored.showings}) == 2
    assert {showing.condition for showing in stored.showings} == {"plainly-late", "spun-about"}
    (answer,) = stored.answers
    assert (answer.value, answer.showing) == (2, stored.showings[1].id)
    titles = [panel.title for panel in ran.display.panels if isinstance(panel, MessagePanel)]
    assert "Trial 1 of 1: first" in titles
    assert "Trial 1 of 1: second" in titles
    assert not any("late" in title or "spun" in title for title in titles)


def test_the_reference_comes_before_each_condition(tmp_path, gpu, monkeypatch):
    """Itself included; each rating is about what came second."""
    path = tmp_path / "small.toml"
    text = TEXT.format(more="").replace("seconds = 0.1", 'shows = "reference first"\nseconds = 0.1')
    text += "reference = true\n"  # of the last condition
    path.write_text(text.replace('["grade"]', '["dcr"]'), encoding="utf-8")
    ran = run(monkeypatch, gpu, path)
    assert ran.error is None
    assert ran.session.status == COMPLETE
    stored = contents(path)
    (order,) = stored.sessions[0].order
    keys = [f"trial/{trial}/{turn}" for trial in (1, 2) for turn in ("reference", "second")]
    assert shown(path) == [(key, 1, True) for key in keys]
    assert [showing.condition for showing in stored.showings] == ["spun-about", order[0], "spun-about", order[1]]
    assert [answer.showing for answer in stored.answers] == [stored.showings[1].id, stored.showings[3].id]
    titles = [panel.title for panel in ran.display.panels if isinstance(panel, MessagePanel)]
    assert "Trial 2 of 2: reference" in titles
    assert "Trial 2 of 2: second" in titles


@pytest.mark.parametrize("how", ["lost", "closed"])
def test_a_disturbed_second_shows_both_again(tmp_path, gpu, monkeypatch, how):
    """It counts only right after the first, so that one is shown once more too."""
    (tmp_path / "whole").mkdir()
    assert run(monkeypatch, gpu, pairs(tmp_path / "whole")).error is None
    pictures = contents(tmp_path / "whole" / "small.toml").showings[0].actual["pictures"]
    path = pairs(tmp_path)
    ran = run(monkeypatch, gpu, path, at={pictures + 1: {"lost": losing(), "closed": closing()}[how]})
    if how == "closed":
        assert ran.session.status == INTERRUPTED
        ran = run(monkeypatch, gpu, path, resume=True)
    assert ran.session.status == COMPLETE
    keys = [(key, complete) for key, _, complete in shown(path)]
    assert keys[-2:] == [("trial/1/first", True), ("trial/1/second", True)]
    assert keys[:2] == [("trial/1/first", True), ("trial/1/second", False)]
    assert len(contents(path).answers) == 1
    assert contents(path).answers[0].showing == contents(path).showings[-1].id
