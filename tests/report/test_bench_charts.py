"""The bench's charts.

Every warp has a number and its name in the key, its look never changes, and any data can be drawn.
"""

import io
import itertools
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from hmdwarp.metrics import REGIONS, aggregate
from hmdwarp.report import PAGE, PAPER, Series, canvas, css_variables, draw_numbers, markers_of, time_series, warp_of
from hmdwarp.report.bench.page import pareto_chart, pareto_plot_png, pareto_text, region_parts, regions_chart
from hmdwarp.report.bench.rows import bench_table, cases

from .bench_samples import WARPS, a_bench, a_row, some_rows
from .samples import some_rows as some_frames

NASTY = "<b>&'\"$x_1$</b>--> ]]> 漢字"


def words(svg: str) -> list[str]:
    root = ElementTree.fromstring(svg)
    return ["".join(node.itertext()) for node in root.iter("{http://www.w3.org/2000/svg}text")]


def key_of(svg: str) -> dict[str, str]:
    """The numbers of the key, by the names that they stand for."""
    return {
        name: number for number, _, name in (word.partition(" ") for word in words(svg)) if number.isdigit() and name
    }


def one_case(**choice):
    (case,) = cases(some_rows(**{"traces": ("walk",), "latencies": (200.0,), **choice}))
    return case


def all_charts():
    rows = some_rows(traces=("walk",), latencies=(200.0,))
    yield "flip", pareto_chart(cases(rows)[0])
    yield "psnr", pareto_chart(cases(rows)[0], "psnr_db")
    yield "regions", regions_chart(cases(rows)[0])
    for seed in (0, 1):
        lines = [Series.of(label, some_frames(seed), "flip") for label in ("forward", NASTY)]
        yield f"time {seed}", time_series(lines, "unit")


def test_every_chart_takes_its_colours_from_the_page_and_shares_no_ids():
    seen: set[str] = set()
    variables = set(re.findall(r"(--[\w-]+):", css_variables(dark=False))) | {"--chart-ink", "--chart-grid"}
    for name, text in all_charts():
        root = ElementTree.fromstring(text)
        assert "viewBox" in root.attrib and not {"width", "height"} & set(root.attrib), name
        assert set(re.findall(r"var\((--[\w-]+)\)", text)) <= variables and not re.findall(
            r"#0[0-9a-f]0\w{3}\b", text
        ), name
        assert set(re.findall(r"(?:fill|stroke): (#\w+)", text)) <= {"#000000", "#ffffff"}, (
            name
        )  # markers' defaults, overridden on use
        assert "<style" not in text and "http" not in text.replace("http://www.w3.org", ""), name
        ids = set(re.findall(r' id="([^"]+)"', text))
        assert not ids & seen, name
        assert set(re.findall(r"url\(#(\w+)\)|href=\"#(\w+)\"", text)) <= {(i, "") for i in ids} | {
            ("", i) for i in ids
        }, name
        seen |= ids


def test_warps_and_baselines_have_names_and_a_key():
    rows = some_rows(traces=("walk",), latencies=(200.0,))
    rows += [a_row("mesh:grid=64", fill, "walk", baseline="CloudXR.js") for fill in ("none", "pyramid")]
    (case,) = cases(rows)
    for measure in ("flip", "psnr_db"):
        found = words(pareto_chart(case, measure))
        key = key_of(pareto_chart(case, measure))
        assert key.keys() == {*WARPS, "mesh:grid=64 (CloudXR.js)"}
        assert sorted(map(int, key.values())) == [*range(1, len(key) + 1)]
        assert [name for name, number in key.items() if number not in found] == [], "beside a point"
        assert {"fill none", "fill interpolate", "fill pyramid"} <= set(found)


def test_the_front_is_filled_bold_and_in_words():
    case = one_case(fills=("interpolate",))
    text = pareto_chart(case)
    best = {row["warp"] for row in case.front()}
    bold = {m[1] for m in re.finditer(r'<text style="[^"]*(?:bold|700)[^"]*"[^>]*>([^<]*)', text)}
    key = key_of(text)
    assert bold == {key[name] for name in best} and 1 < len(best) < len(case.rows)
    assert [name for name in best if f"{name} with fill interpolate" not in pareto_text(case)] == []
    hollow = len(re.findall(r"<use [^>]*fill: none|<use [^>]*fill-opacity: 0", text))
    filled = len(re.findall(r"<use [^>]*fill: var\(--warp", text))
    # The list of colours is filled too.
    assert (filled, hollow >= len(case.rows) - len(best)) == (len(best) + len(WARPS), True)
    for measure, worst in (("flip", 1), ("psnr_db", 0)):  # the staircase begins there
        axes = pareto_chart(case, measure).figure.axes[0]
        (stairs,) = (line for line in axes.lines if line.get_drawstyle() == "steps-post")
        assert stairs.get_ydata()[0] == axes.get_ylim()[worst]


def test_the_same_data_give_the_same_chart():
    case = one_case(warps=("none", "forward", "backward"))
    for make in (lambda: pareto_chart(case), lambda: regions_chart(case), lambda: [*all_charts()][-1]):
        assert make() == make()


@pytest.mark.parametrize("measure", ["flip", "psnr_db"])
@pytest.mark.parametrize("count", [0, 1, 2])
def test_few_points_or_none(count, measure):
    rows = [a_row(warp) for warp in list(WARPS)[:count]] + [a_row("mesh", **aggregate([]))]
    (case,) = cases(rows)
    assert ("not measured" in words(pareto_chart(case, measure))) == (count == 0)
    assert ("nothing was measured" in pareto_text(case, measure)) == (count == 0)


def test_without_a_row_that_the_client_can_run_there_is_no_front():
    (case,) = cases([a_row("mesh", lacks="it takes the whole scene"), a_row("backward", lacks="so does this")])
    assert "mesh" in key_of(pareto_chart(case)) and "the bench's client can run none" in pareto_text(case)


def test_odd_values_can_be_drawn():
    perfect = {name: {"mean": value, "p95": value} for name, value in (("flip", 0.0), ("psnr_db", 100.0))}
    for time in (0.0, 1e-9, 7.0, 1e5):
        times = {"total": {"median": time, "p95": time}}
        rows = [
            a_row(w, quality={**a_row()["quality"], **perfect}, time_ms={**a_row()["time_ms"], **times})
            for w in ("none", "mesh")
        ]
        (case,) = cases([*rows, a_row("backward")])
        for measure in ("flip", "psnr_db"):
            assert "mesh" in key_of(pareto_chart(case, measure))
    nothing = {name: {"share": 0.0, "flip": None, "psnr_db": None} for name in REGIONS}
    assert "forward" in words(regions_chart(cases([a_row(regions=nothing, fill="none")])[0]))


def test_names_are_text_whatever_they_hold():
    rows, (_, lines) = [a_row(NASTY, fill=NASTY), a_row()], [*all_charts()][-1]
    assert {"forward", "unit", "time in s"} <= set(words(lines))
    for text in (pareto_chart(cases(rows)[0]), regions_chart(cases(rows)[0]), lines):
        assert "<b>" not in text and any(NASTY in word for word in words(text))


def test_a_spec_with_settings_looks_like_its_warp():
    specs = ["mesh", "mesh:cut=slope", "mesh:cut=identity", "new_warp"]
    assert {PAGE.warp(spec) for spec in specs[:3]} == {PAGE.warp("mesh")} != {PAGE.warp("forward")}
    assert (
        PAGE.warp("new_warp").startswith("#") and PAPER.warp("new_warp").startswith("#") and warp_of("a:b=1,c=2") == "a"
    )
    assert key_of(pareto_chart(cases([a_row(spec) for spec in specs])[0])).keys() == {*specs}


def test_markers_do_not_depend_on_who_else_is_there_for_known_fills_and_never_coincide():
    fills = [f"fill-{letter}" for letter in "abcdefgh"]
    chosen = markers_of(["interpolate", *fills, "none"])
    assert len(set(chosen.values())) == 10
    assert (
        markers_of(["none"])["none"] == chosen["none"]
        and markers_of(["interpolate"])["interpolate"] == chosen["interpolate"]
    )


def luminance(colour: str) -> float:
    """Source: WCAG 2.2, relative luminance."""
    channels = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


@pytest.mark.parametrize("dark, card", [(False, "#ffffff"), (True, "#1c2126")])
def test_every_warp_s_colour_can_be_seen_and_none_is_another_s(dark, card):
    """Contrast of 3 to the paper, what WCAG 2.2 asks of graphics (1.4.11); card: the page's own."""
    colours = dict(re.findall(r"(--warp-[\w-]+): (#\w{6})", css_variables(dark)))
    assert len(colours) == len(set(colours.values())) >= len(WARPS)
    pairs = {name: sorted((luminance(colour), luminance(card))) for name, colour in colours.items()}
    assert [name for name, (low, high) in pairs.items() if (high + 0.05) / (low + 0.05) < 3] == []


# Of linear red, green and blue. Source: Vienot, Brettel and Mollon 1999, Digital video colourmaps
# for checking the legibility of displays by dichromats; grey: WCAG 2.2, relative luminance.
SEEN_AS = {
    "deuteranopia": ((0.29275, 0.70725, 0.0), (0.29275, 0.70725, 0.0), (-0.02234, 0.02234, 1.0)),
    "protanopia": ((0.11238, 0.88762, 0.0), (0.11238, 0.88762, 0.0), (0.00401, -0.00401, 1.0)),
    "grey": ((0.2126, 0.7152, 0.0722),) * 3,
}


@pytest.mark.parametrize("sight", SEEN_AS)
def test_warps_whose_colours_merge_have_numbers_and_lines_of_their_own(sight):
    """Where two are within 0.12 of a channel's range, no one tells small marks apart by them."""

    def seen(colour: str) -> np.ndarray:
        encoded = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
        return np.clip(np.asarray(SEEN_AS[sight]) @ encoded**2.2, 0, 1) ** (1 / 2.2)

    colours = {name: seen(PAPER.warp(name)) for name in WARPS}
    merged = {
        name
        for name in WARPS
        if any(np.abs(colours[name] - colours[other]).max() < 0.12 for other in WARPS if other != name)
    }
    assert merged, "the colours alone would do: is this test needed?"
    (case,) = cases(some_rows(WARPS, traces=("walk",), latencies=(200.0,)))
    text = pareto_chart(case)
    named, key = words(text), key_of(text)
    fills = len({row["fill"] for row in case.rows})
    for name in merged:
        assert key[name] in named, "beside a point"
        variable = re.escape(f"var(--warp-{name.replace('_', '-')})")
        lines = re.findall(
            rf'<path d="([^"]*)"[^>]*style="fill: none; stroke: {variable}; [^"]*stroke-width: 0.7', text
        )
        assert [len(re.findall("[ML]", line)) for line in lines] == [fills], name


def test_numbers_stand_beside_their_points_and_apart():
    """In a crowd of 40 each number is within 24 pt of its point, and no two cover each other."""
    rng = np.random.default_rng(3)
    points = rng.uniform(0.2, 0.8, (40, 2))
    with canvas("", (6.0, 5.0), box=(0.5, 0.5, 5.9, 4.9)) as axes:
        draw_numbers(axes, {index: index + 1 for index in range(40)}, points, np.zeros(40, bool), PAGE)
        renderer = axes.figure.canvas.get_renderer()
        boxes = [text.get_window_extent(renderer) for text in axes.texts]
        assert all(np.hypot(*text.get_position()) < 24 for text in axes.texts)
        assert [text.get_text() for text in axes.texts] == [str(number) for number in range(1, 41)]
        assert not any(one.overlaps(other) for one, other in itertools.combinations(boxes, 2))


def test_regions_add_up_to_the_whole():
    row = a_row()
    added, within = zip(*region_parts(row), strict=True)
    assert (
        sum(added) == pytest.approx(sum(r["share"] * r["flip"] for r in row["regions"].values())) and len(within) == 4
    )
    assert region_parts(a_row(regions={})) is None and region_parts(a_row(regions={"inside_holes": {}})) is None
    assert "not measured" in words(regions_chart(cases([a_row(regions={})])[0]))


@pytest.mark.parametrize("columns", [None, 1])
def test_the_picture_for_the_readme(tmp_path, columns):
    rows = some_rows(warps=list(WARPS)[::3], fills=("interpolate",), traces=("walk",), latencies=(200.0,))
    path = tmp_path / "pareto.png"
    pareto_plot_png(path, [*rows, a_row(trace=NASTY)], columns=columns)
    data = path.read_bytes()
    with Image.open(io.BytesIO(data)) as image:
        picture = np.asarray(image.convert("RGB"))
    assert picture.shape[1] == 1600 and (picture[0] == 255).all()
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 50
    pareto_plot_png(path, [], columns=columns)
    assert [p.name for p in tmp_path.iterdir()] == ["pareto.png"]


def test_a_whole_bench_fits_the_terminal():
    assert bench_table(a_bench()["rows"]).row_count == 180 + 6
