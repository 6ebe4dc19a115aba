"""The small table of the terminal.

Every figure is there, the better one is marked, nothing is invented.
"""

import io

from rich.console import Console

from hmdwarp.metrics import aggregate
from hmdwarp.report import comparison_rows, summary_table

from .samples import a_summary, some_rows


def printed(*summaries, width=80) -> str:
    console = Console(file=io.StringIO(), width=width)
    console.print(summary_table(*summaries))
    return console.file.getvalue()


def best(summary, baseline) -> dict:
    return {row.figure.name: row.best for row in comparison_rows(summary, baseline)}


def test_fits_into_a_terminal_of_80_columns():
    text = printed(a_summary(some_rows(0)), a_summary(some_rows(1, worse=3), "none"))
    words = (
        "forward",
        "none",
        "PSNR [dB]",
        "SSIM",
        "FLIP",
        "Holes [%]",
        "Flicker",
        "Time, warp [ms]",
        "wall clock",
        "200 ms",
    )
    assert [word for word in words if word not in text] == []
    assert "…" not in text  # nothing was cut off


def test_the_better_one_is_marked_whichever_column_it_is_in():
    good, bad = a_summary(some_rows(0)), a_summary(some_rows(0, worse=3), "none")
    marked = {"psnr_db": 0, "ssim": 0, "flip": 0, "flicker": 0}
    assert {k: v for k, v in best(good, bad).items() if v is not None} == marked
    assert {k: v for k, v in best(bad, good).items() if v is not None} == dict.fromkeys(marked, 1)
    assert printed(good, bad).count(" * │") == 4
    assert "*" not in printed(good)


def test_equal_after_rounding_is_a_draw():
    one = a_summary(some_rows(0))
    other = a_summary(some_rows(0, worse=1 + 1e-7))
    assert set(best(one, other).values()) == {None}


def test_what_was_not_measured_is_a_dash():
    nothing = {**a_summary(), **aggregate([])}
    text = printed(nothing, a_summary())
    assert text.count("–") == 2 * 11  # mean and p95 of six figures and five times
    assert set(best(nothing, a_summary()).values()) == {None}


def test_columns_that_share_a_warp_have_distinct_heads():
    one, other = a_summary(), {**a_summary(), "fill": "none"}
    text = printed(one, other, width=120)
    assert "forward, interpolate" in text and "forward, none" in text
    assert "baseline" in printed(one, one)
