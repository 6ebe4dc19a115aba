"""The bench's charts.

Every warp has a number and its name in the key, its look never changes, and any data can be drawn.
"""

import itertools
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from skimage.color import deltaE_ciede2000, rgb2lab

from hmdwarp.base import linear_from_srgb, srgb_from_linear
from hmdwarp.metrics import aggregate
from hmdwarp.report import Look, Series, canvas, css_variables, draw_numbers, time_series
from hmdwarp.report.bench.page import looks_of, pareto_chart, pareto_text
from hmdwarp.report.bench.rows import cases, row_name

from .bench_samples import WARPS, a_row, some_rows
from .samples import some_rows as some_frames

NASTY = "<b>&'\"$x_1$</b>--> ]]> 漢字"


def words(svg: str) -> list[str]:
    root = ElementTree.fromstring(svg)
    return ["".join(node.itertext()) for node in root.iter("{http://www.w3.org/2000/svg}text")]


def key_of(svg: str) -> dict[str, str]:
    """The numbers of the key, by the names that they stand for."""
    parts = (word.partition(" ") for word in words(svg))
    return {name: number for number, _, name in parts if number.isdigit() and name}


def one_case(**choice):
    (case,) = cases(some_rows(**{"traces": ("walk",), "latencies": (200.0,), **choice}))
    return case


def all_charts():
    rows = some_rows(traces=("walk",), latencies=(200.0,))
    yield "flip", pareto_chart(cases(rows)[0])
    yield "psnr", pareto_chart(cases(rows)[0], "psnr_db")
    for seed in (0, 1):
        lines = [Series.of(label, some_frames(seed), "flip") for label in ("forward", NASTY)]
        yield f"time {seed}", time_series(lines, "unit")


def test_every_chart_takes_its_colours_from_the_page_and_shares_no_ids():
    seen: set[str] = set()
    variables = set(re.findall(r"(--[\w-]+):", css_variables(dark=False))) | {"--chart-ink", "--chart-grid"}
    for name, text in all_charts():
        root = ElementTree.fromstring(text)
        assert "viewBox" in root.attrib and not {"width", "height"} & set(root.attrib), name
        assert set(re.findall(r"var\((--[\w-]+)\)", text)) <= variables, name
        assert not re.findall(r"#0[0-9a-f]0\w{3}\b", text), name
        # Markers' defaults, overridden on use.
        assert set(re.findall(r"(?:fill|stroke): (#\w+)", text)) <= {"#000000", "#ffffff"}, name
        assert "<style" not in text and "http" not in text.replace("http://www.w3.org", ""), name
        ids = set(re.findall(r' id="([^"]+)"', text))
        assert not ids & seen, name
        assert {one or other for one, other in re.findall(r"url\(#(\w+)\)|href=\"#(\w+)\"", text)} <= ids, name
        seen |= ids


def test_the_front_and_the_best_of_each_warp_have_numbers_that_the_key_explains():
    rows = some_rows(traces=("walk",), latencies=(200.0,))
    rows += [a_row("mesh:grid=64", fill, "walk", baseline="CloudXR.js") for fill in ("none", "pyramid")]
    (case,) = cases(rows)
    for measure in ("flip", "psnr_db"):
        found = words(pareto_chart(case, measure))
        key = key_of(pareto_chart(case, measure))
        assert {name.split(" + ")[0].removesuffix(" (CloudXR.js)") for name in key} == {*WARPS, "mesh:grid=64"}
        assert {row_name(row) for row in case.front(measure)} <= key.keys()
        assert sorted(map(int, key.values())) == [*range(1, len(key) + 1)]
        assert [name for name, number in key.items() if number not in found] == [], "beside a point"


def test_the_front_is_filled_bold_and_in_words():
    case = one_case(fills=("interpolate",))
    text = pareto_chart(case)
    best = {row_name(row) for row in case.front()}
    bold = {m[1] for m in re.finditer(r'<text style="[^"]*(?:bold|700)[^"]*"[^>]*>([^<]*)', text)}
    key = key_of(text)
    assert bold == {key[name] for name in best} and 1 < len(best) < len(case.rows)
    assert [name for name in best if name.replace(" + ", " with fill ") not in pareto_text(case)] == []
    hollow = len(re.findall(r"<use [^>]*fill: none|<use [^>]*fill-opacity: 0", text))
    filled = len(re.findall(r"<use [^>]*fill: var\(--series", text))
    # The marks of the key are filled too.
    assert (filled, hollow >= len(case.rows) - len(best)) == (len(best) + len(key), True)
    for measure, worst in (("flip", 1), ("psnr_db", 0)):  # the staircase begins there
        axes = pareto_chart(case, measure).figure.axes[0]
        (stairs,) = (line for line in axes.lines if line.get_drawstyle() == "steps-post")
        assert stairs.get_ydata()[0] == axes.get_ylim()[worst]


@pytest.mark.parametrize("measure", ["flip", "psnr_db"])
def test_each_point_stands_on_the_interval_of_its_mean(measure):
    case = one_case(fills=("interpolate",))
    axes = pareto_chart(case, measure).figure.axes[0]
    (spans,) = (one for one in axes.collections if hasattr(one, "get_segments"))
    drawn = sorted(tuple(segment[:, 1]) for segment in spans.get_segments())
    assert drawn == sorted(tuple(row["quality"][measure]["interval"]) for row in case.rows)


@pytest.mark.parametrize("measure", ["flip", "psnr_db"])
@pytest.mark.parametrize("count", [0, 1, 2])
def test_few_points_or_none(count, measure):
    rows = [a_row(warp) for warp in list(WARPS)[:count]] + [a_row("mesh", **aggregate([]))]
    (case,) = cases(rows)
    assert ("not measured" in words(pareto_chart(case, measure))) == (count == 0)
    assert ("nothing was measured" in pareto_text(case, measure)) == (count == 0)
    (case,) = cases([{**row, "lacks": "it takes the whole scene"} for row in rows])
    assert "the bench's client can run none" in pareto_text(case)


def test_odd_values_can_be_drawn():
    perfect = {name: {"mean": value, "p95": value} for name, value in (("flip", 0.0), ("psnr_db", 100.0))}
    for time in (0.0, 1e-9, 7.0, 1e5):
        times = {"total": {"median": time, "p95": time}}
        odd = {"quality": a_row()["quality"] | perfect, "time_ms": a_row()["time_ms"] | times}
        rows = [a_row(warp, **odd) for warp in ("none", "mesh")]
        (case,) = cases([*rows, a_row("backward")])
        for measure in ("flip", "psnr_db"):
            assert "mesh + interpolate" in key_of(pareto_chart(case, measure))


def test_names_are_text_whatever_they_hold():
    rows, (_, lines) = [a_row(NASTY, fill=NASTY), a_row()], [*all_charts()][-1]
    assert {"forward", "unit", "time in s"} <= set(words(lines))
    for text in (pareto_chart(cases(rows)[0]), lines):
        assert "<b>" not in text and any(NASTY in word for word in words(text))


def test_warps_share_their_looks_in_all_charts_of_a_page():
    rows = some_rows(traces=("walk",), latencies=(200.0,))
    looks = looks_of(rows)
    assert [*looks] == [*dict.fromkeys(row["warp"] for row in rows)]
    assert len({(look.color, look.marker) for look in map(Look.of, range(56))}) == 56
    (case,) = cases(rows)
    others = pareto_chart(case, "psnr_db", looks=looks), pareto_chart(case, looks=looks).at_width(3.35)
    for chart in (pareto_chart(case, looks=looks), *others):
        marks = chart.figure.legends[0].legend_handles
        for mark in marks:
            warp = mark.get_label().split(" ")[1]
            assert (mark.get_color(), mark.get_marker()) == (looks[warp].color, looks[warp].marker), warp


def linear_of(colour: str) -> np.ndarray:
    return linear_from_srgb(np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255)


def luminance(colour: str) -> float:
    """Source: WCAG 2.2, relative luminance."""
    return float(linear_of(colour) @ (0.2126, 0.7152, 0.0722))


# Of linear light, at full severity. Source: Machado, Oliveira and Fernandes 2009, A
# physiologically-based model for simulation of color vision deficiency, table 1.
SEEN_AS = {
    "all": np.eye(3),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
}


@pytest.mark.parametrize("sight", SEEN_AS)
@pytest.mark.parametrize("dark, card", [(False, "#ffffff"), (True, "#1c2126")])
def test_every_colour_can_be_seen_and_none_is_another_s(dark, card, sight):
    """Contrast of 3 to the paper, what WCAG 2.2 asks of graphics (1.4.11); card: the page's own.

    15 by CIEDE2000 is over six times what is just seen (2.3), as small marks need.
    """
    colours = re.findall(r"--series-\d: (#\w{6})", css_variables(dark))
    assert len(colours) == 8
    contrasts = {colour: sorted((luminance(colour), luminance(card))) for colour in colours}
    assert [colour for colour, (low, high) in contrasts.items() if (high + 0.05) / (low + 0.05) < 3] == []
    light = np.array([linear_of(colour) for colour in colours]) @ SEEN_AS[sight].T
    seen = rgb2lab(srgb_from_linear(np.clip(light, 0, 1))[None])[0]
    apart = {pair: float(deltaE_ciede2000(*seen[[*pair]])) for pair in itertools.combinations(range(8), 2)}
    assert {pair: far for pair, far in apart.items() if far < 15} == {}


def test_numbers_stand_beside_their_points_and_apart():
    """In a crowd of 40 each number is within 24 pt of its point, and no two cover each other."""
    rng = np.random.default_rng(3)
    points = rng.uniform(0.2, 0.8, (40, 2))
    with canvas("", (6.0, 5.0), box=(0.5, 0.5, 5.9, 4.9)) as axes:
        draw_numbers(axes, {index: index + 1 for index in range(40)}, points, np.zeros(40, bool))
        boxes = [text.get_window_extent() for text in axes.texts]
        assert all(np.hypot(*text.get_position()) < 24 for text in axes.texts)
        assert [text.get_text() for text in axes.texts] == [str(number) for number in range(1, 41)]
        assert not any(one.overlaps(other) for one, other in itertools.combinations(boxes, 2))
