"""The small table of the terminal.

Every figure is there, the better one is marked, nothing is invented.
"""

import io
import re

from rich.console import Console

from hmdwarp.metrics import QUALITY, aggregate
from hmdwarp.report import comparison_table, summary_html, summary_table

from .samples import a_baseline, a_summary, some_rows


def printed(*summaries, width=80) -> str:
    console = Console(file=io.StringIO(), width=width)
    console.print(summary_table(*summaries))
    return console.file.getvalue()


def best(summary, *baselines) -> dict:
    """By metric, which of the runs is marked."""
    lines = [
        [cell.style == "best" for cell in line.cells[1::2]] for line in comparison_table(summary, *baselines).lines
    ]
    assert not any(map(any, lines[len(QUALITY) :]))  # of times, none
    return {name: line.index(True) for name, line in zip(QUALITY, lines, strict=False) if any(line)}


def test_fits_into_a_terminal_of_80_columns():
    text = printed(a_summary(some_rows(0)), a_baseline(some_rows(0), some_rows(1, worse=3)))
    words = "forward|none|PSNR [dB]|SSIM|FLIP|Holes [%]|Flicker|Time, warp [ms]|wall clock|200 ms"
    assert [word for word in words.split("|") if word not in text] == []
    assert "…" not in text  # nothing was cut off


def test_the_better_one_is_marked_whichever_column_it_is_in_and_none_within_the_noise():
    """Two runs of equal methods differ at every instant, now this way and now that."""
    good, bad, other = some_rows(0), some_rows(0, worse=3), some_rows(1)
    marked = {"psnr_db": 0, "ssim": 0, "flip": 0, "flicker": 0}
    assert best(a_summary(good), a_baseline(good, bad)) == marked
    assert best(a_summary(bad), a_baseline(bad, good)) == dict.fromkeys(marked, 1)
    assert best(a_summary(good), a_baseline(good, other)) == {}
    text = printed(a_summary(good), a_baseline(good, bad))
    assert len(re.findall(r"\d \*", text)) == 4
    assert "*: the best of the line, by the 95 % interval of the difference" in " ".join(text.split())
    assert "*" not in printed(a_summary(good))


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
    text = printed(a_summary(good), a_baseline(good, bad), a_baseline(good, worst, "forward"))
    assert max(map(len, text.splitlines())) <= 80 and "…" not in text


def test_means_have_their_interval():
    rows = some_rows(0)
    entry = aggregate(rows)["quality"]["psnr_db"]
    low, high = entry["interval"]
    text = printed(a_summary(rows))
    assert (
        f"{entry['mean']:.2f} ±{(high - low) / 2:.2f}" in text
        and "± or (low to high): 95 % interval of the mean" in text
    )


def test_an_interval_ends_where_the_figure_does():
    """Of errors 0, 0, 0, 0, 0 and 0.3 the mean is 0.05, and no error is below 0."""
    rows = [{"frame": at, "eye": 0, "flip": 0.3 * (at == 5), "ssim": 1 - 0.3 * (at == 5)} for at in range(6)]
    quality = aggregate(rows)["quality"]
    assert quality["flip"]["interval"][0] == 0 and quality["ssim"]["interval"][1] == 1
    high = quality["flip"]["interval"][1]
    summary = {**a_summary(), "quality": {**a_summary()["quality"], **{"flip": quality["flip"]}}}
    assert f"0.0500 (0 to {high:.2g})" in printed(summary)


def test_with_too_few_instants_there_are_neither_intervals_nor_marks():
    few, worse = (some_rows(0, seconds=5 / 9, worse=worse) for worse in (1, 3))
    assert len({row["frame"] for row in few if "flip" in row}) == 5
    text = printed(a_summary(few), a_baseline(few, worse))
    assert "±" not in text and re.search(r"\d \*", text) is None
    assert "No intervals and no *: they need 6 measured refreshes" in " ".join(text.split())


def test_an_unmeasured_figure_is_a_dash():
    nothing = {**a_summary(), **aggregate([])}
    text = printed(nothing, a_summary())
    assert text.count("–") == 2 * 11  # mean and p95 of six figures and five times
    assert best(nothing, a_summary()) == {}


def test_columns_that_share_a_warp_have_distinct_heads():
    one, other = a_summary(), {**a_summary(), "fill": "none"}
    text = printed(one, other, width=120)
    assert "forward, interpolate" in text and "forward, none" in text
    assert "baseline" in printed(one, one)
