"""The bench's charts.

Every point and line has its name, the look of a warp never changes, and any data can be drawn.
"""

import io
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from hmdwarp.metrics import REGIONS, aggregate
from hmdwarp.report import DASHES, PAGE, PAPER, css_variables, dashes_of, markers_of, warp_of
from hmdwarp.report.bench.charts import (
    AXES,
    axes_of,
    curves,
    displacement_chart,
    displacement_text,
    pareto_chart,
    pareto_plot_png,
    pareto_text,
    region_parts,
    regions_chart,
    traffic,
    traffic_chart,
)
from hmdwarp.report.bench.rows import bench_table, cases

from .bench_samples import WARPS, a_bench, a_grid, a_row, some_rows

NASTY = "<b>&'\"$x_1$</b>--> ]]> 漢字"


def words(svg: str) -> list[str]:
    root = ElementTree.fromstring(svg)
    return ["".join(node.itertext()) for node in root.iter("{http://www.w3.org/2000/svg}text")]


def one_case(**choice):
    (case,) = cases(some_rows(**{"traces": ("walk",), "latencies": (200.0,), **choice}))
    return case


def all_charts():
    grid = a_grid()
    rows = some_rows(traces=("walk",), latencies=(200.0,))
    yield "flip", pareto_chart(cases(rows)[0])
    yield "psnr", pareto_chart(cases(rows)[0], "psnr_db")
    yield "regions", regions_chart(cases(rows)[0])
    yield "traffic", traffic_chart(traffic(rows))
    yield from ((axis, displacement_chart(grid, axis)) for axis in AXES)


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
        # Once in the list of colours, and once beside a point, however many points it has there.
        assert {name: found.count(name) for name in WARPS} == dict.fromkeys(WARPS, 2)
        assert found.count("mesh:grid=64") == found.count("(CloudXR.js)") == 1
        assert {"fill none", "fill interpolate", "fill pyramid"} <= set(found)


def test_the_front_is_filled_bold_and_in_words():
    case = one_case(fills=("interpolate",))
    text = pareto_chart(case)
    best = {row["warp"] for row in case.front()}
    bold = {m[1] for m in re.finditer(r'<text style="[^"]*(?:bold|700)[^"]*"[^>]*>([^<]*)', text)}
    assert bold == best and 1 < len(best) < len(case.rows)
    assert [name for name in best if f"{name} with fill interpolate" not in pareto_text(case)] == []
    hollow = len(re.findall(r"<use [^>]*fill: none|<use [^>]*fill-opacity: 0", text))
    filled = len(re.findall(r"<use [^>]*fill: var\(--warp", text))
    # The list of colours is filled too.
    assert (filled, hollow >= len(case.rows) - len(best)) == (len(best) + len(WARPS), True)


def test_the_same_data_give_the_same_chart():
    grid, case = a_grid(("none", "mesh")), one_case(warps=("none", "forward", "backward"))
    for make in (lambda: pareto_chart(case), lambda: regions_chart(case), lambda: displacement_chart(grid, "yaw")):
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
    assert "mesh" in words(pareto_chart(case)) and "the bench's client can run none" in pareto_text(case)


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
            assert words(pareto_chart(case, measure)).count("mesh") == 2
    nothing = {name: {"share": 0.0, "flip": None, "psnr_db": None} for name in REGIONS}
    assert "forward" in words(regions_chart(cases([a_row(regions=nothing, fill="none")])[0]))
    flat = [{"warp": "mesh", "axis": "x", "offset": x, "flip": 0.0, "psnr_db": 100.0} for x in (-1.0, 0.0, 1.0)]
    assert "mesh" in words(displacement_chart(flat, "x")) and "mesh" in words(
        displacement_chart(flat[:1], "x", "psnr_db")
    )


def test_names_are_text_whatever_they_hold():
    rows = [a_row(NASTY, fill=NASTY), a_row()]
    grid = [{"warp": NASTY, "axis": "x", "offset": x, "flip": 0.1, "psnr_db": 30.0} for x in (-1.0, 1.0)]
    for text in (
        pareto_chart(cases(rows)[0]),
        regions_chart(cases(rows)[0]),
        traffic_chart(traffic(rows)),
        displacement_chart(grid, "x"),
    ):
        assert "<b>" not in text and any(NASTY in word for word in words(text))


def test_a_spec_with_settings_looks_like_its_warp():
    specs = ["mesh", "mesh:cut=slope", "mesh:cut=identity", "new_warp"]
    assert {PAGE.warp(spec) for spec in specs[:3]} == {PAGE.warp("mesh")} != {PAGE.warp("forward")}
    assert len({str(dash) for dash in list(dashes_of(specs).values())[:3]}) == 3
    assert (
        PAGE.warp("new_warp").startswith("#") and PAPER.warp("new_warp").startswith("#") and warp_of("a:b=1,c=2") == "a"
    )
    assert "mesh:" in words(pareto_chart(cases([a_row(spec) for spec in specs])[0]))


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
def test_warps_whose_colours_merge_have_names_and_lines_of_their_own(sight):
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
    named = words(text)
    fills = len({row["fill"] for row in case.rows})
    for name in merged:
        assert named.count(name) == 2, "in the key and beside a point"
        variable = re.escape(f"var(--warp-{name.replace('_', '-')})")
        lines = re.findall(
            rf'<path d="([^"]*)"[^>]*style="fill: none; stroke: {variable}; [^"]*stroke-width: 0.7', text
        )
        assert [len(re.findall("[ML]", line)) for line in lines] == [fills], name


def test_lines_of_one_colour_family_differ_in_their_dashes():
    dashes = dashes_of(WARPS)
    for family in (
        ("rotation", "planar", "environment"),
        ("forward_raster", "forward", "forward_ordered", "splat"),
        ("backward", "iterative", "search"),
        ("mesh", "mesh_adaptive"),
        ("multi", "layered"),
    ):
        assert len({DASHES.index(dashes[name]) for name in family}) == len(family)


def test_displacement_has_all_warps_on_all_axes_in_order():
    grid = a_grid()
    assert axes_of(reversed(grid)) == list(AXES)
    for axis in AXES:
        found = words(displacement_chart(grid, axis))
        assert [name for name in WARPS if name not in found and f"{name} ↑" not in found] == []
        assert ("offset in metres" in found) == (axis in "xyz")
        ends = re.findall(r" ([\d.]+)[,.](?: |$)", displacement_text(grid, axis).partition("from above:")[2])
        assert ends == sorted(ends, key=float, reverse=True) and len(ends) == len(WARPS)
    points = curves([*grid, {"warp": "new", "axis": "x", "offset": 1.0, "flip": None}], "x")
    assert points["new"].shape == (0, 2) and (np.diff(points["none"][:, 0]) > 0).all()


def test_an_axis_without_rows_says_not_measured():
    grid = [{"warp": "mesh", "axis": "x", "offset": 0.0, "flip": None, "psnr_db": None}]
    assert "not measured" in words(displacement_chart(grid, "x"))


def test_regions_add_up_to_the_whole():
    row = a_row()
    added, within = zip(*region_parts(row), strict=True)
    assert (
        sum(added) == pytest.approx(sum(r["share"] * r["flip"] for r in row["regions"].values())) and len(within) == 4
    )
    assert region_parts(a_row(regions={})) is None and region_parts(a_row(regions={"inside_holes": {}})) is None
    assert "not measured" in words(regions_chart(cases([a_row(regions={})])[0]))


def test_each_pass_once_for_each_size():
    rows = [
        *some_rows(),
        a_row(size=[640, 400]),
        a_row("none", passes=[{"name": "warp", "bytes": 0, "bound_ms": 0.0, "median_ms": 1.0}]),
    ]
    found = traffic(rows)
    assert len(found) == len(WARPS) + 2 + 3  # the fill `none` has no pass
    assert {entry.kind for entry in found} == {"warp", "fill", "lens"} and {entry.size for entry in found} == {
        "1280x800",
        "640x400",
    }
    assert all(entry.times_bound == entry.median_ms / entry.bound_ms for entry in found if entry.bound_ms)
    assert "not measured" in words(traffic_chart([])) and "lens radial" in words(traffic_chart(found))
    assert traffic([a_row(passes=[{"name": "warp", "bytes": 0, "bound_ms": None, "median_ms": None}])]) == []


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
