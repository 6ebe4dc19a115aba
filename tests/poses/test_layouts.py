"""Files of many layouts with known truth: read right, or never without a word."""

from __future__ import annotations

from pathlib import Path

import attrs

from hmdwarp.poses import load_trace

from . import layouts

ROOT = Path(__file__).parents[2]


def test_no_layout_is_read_wrong_and_the_table_says_how_each_is_read(tmp_path):
    """`make docs OPTIONS=trace-layouts` writes the table."""
    assert len({layout.name for layout in layouts.LAYOUTS}) == len(layouts.LAYOUTS)
    truth = load_trace("walk").track
    outcomes = {layout.name: layouts.verdict(layout, truth, tmp_path) for layout in layouts.LAYOUTS}
    assert [name for name, (outcome, _) in outcomes.items() if outcome == layouts.WRONG] == []
    page = (ROOT / "docs" / "traces.md").read_text(encoding="utf-8")
    assert layouts.contradicted_text() in page
    for layout in layouts.LAYOUTS:
        assert layouts.line(layout, *outcomes[layout.name]) in page


def test_a_file_that_is_read_wrong_is_called_wrong(tmp_path):
    """The verdict can fail: a left-handed world whose preset nobody states is a mirror image."""
    mirrored = attrs.evolve(layouts.LAYOUTS[0], name="mirrored", axes="world=-x,y,-z head=-x,y,-z")
    assert layouts.verdict(mirrored, load_trace("walk").track, tmp_path)[0] == layouts.WRONG
