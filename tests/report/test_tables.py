"""The small table of the terminal: what is marked as better. What it says: test_words.py."""

import re

from hmdwarp.metrics import QUALITY
from hmdwarp.report import comparison_table, summary_html

from .samples import a_baseline, a_summary, some_rows


def best(summary, *baselines) -> dict:
    """By metric, which of the runs is marked."""
    lines = [
        [cell.style == "best" for cell in line.cells[1::2]] for line in comparison_table(summary, *baselines).lines
    ]
    assert not any(map(any, lines[len(QUALITY) :]))  # of times, none
    return {name: line.index(True) for name, line in zip(QUALITY, lines, strict=False) if any(line)}


def test_the_better_one_is_marked_whichever_column_it_is_in_and_none_within_the_noise():
    """Two runs of equal methods differ at every instant, now this way and now that."""
    good, bad, other = some_rows(0), some_rows(0, worse=3), some_rows(1)
    marked = {"psnr_db": 0, "ssim": 0, "flip": 0, "flicker": 0}
    assert best(a_summary(good), a_baseline(good, bad)) == marked
    assert best(a_summary(bad), a_baseline(bad, good)) == dict.fromkeys(marked, 1)
    assert best(a_summary(good), a_baseline(good, other)) == {}


def test_a_notebook_shows_the_same_table():
    """Names and figures are the terminal's; a name cannot be markup."""
    good, bad = a_summary(some_rows(0)), a_baseline(some_rows(0), some_rows(0, worse=3))
    rows = re.findall(r"<tr>(.*?)</tr>", summary_html(good, {**bad, "warp": "<none>"}))
    cells = [re.findall(r"<t[hd].*?>(.*?)</t[hd]>", row) for row in rows]
    assert cells[0] == ["", "forward", "&lt;none&gt;"]
    figures = [cell.text for line in comparison_table(good, bad).lines for cell in line.cells[1::2]]
    assert [cell.removesuffix(" *") for row in cells[1:] for cell in row[1:]] == figures
    assert sum(cell.endswith(" *") for row in cells for cell in row) == 4


def test_the_best_of_three_is_marked_where_it_is_sure():
    """The run only if it is better than both; a baseline only if it is better than the run."""
    good, bad, worst = some_rows(0), some_rows(0, worse=3), some_rows(0, worse=5)
    cases = ((good, (bad, worst)), (bad, (worst, good)), (bad, (good, worst)), (good, (good, bad)))
    marked = [best(a_summary(mine), *(a_baseline(mine, other) for other in others)) for mine, others in cases]
    assert [one.get("psnr_db") for one in marked] == [0, 2, 1, None]
