"""`hmdwarp compare`: every strategy on the same heads, and which clients each suits."""

from __future__ import annotations

import csv
import html
import json
import re
from pathlib import Path

import attrs
import numpy as np
import pytest
from cli.conftest import complaints
from commands import hmdwarp
from recorded_folders import taken, write_npz
from replays import scene_for
from report_tables import chosen_markdown, compare_markdown

from hmdwarp.base import InputError
from hmdwarp.client import build_plan
from hmdwarp.client.classes import client_names, load_client
from hmdwarp.client.strategies import strategies
from hmdwarp.experiments.bench import CompareOptions
from hmdwarp.experiments.bench.compare_run import client_bytes, decoded_mpx_s, start_bytes, unfit
from hmdwarp.experiments.bench.suite_means import compared_entry, over_all
from hmdwarp.experiments.bench.suites import suites
from hmdwarp.frames import EyeSizes
from hmdwarp.report.bench.rows import first_cases
from hmdwarp.report.compare_page import OF_COMPARE, compare_page

NAMED = ("imposter", "depth_image", "light", "proxy")
QUICK = ("--size", "48x40", "--samples", "1", "--headset", "flat-90", "--start", "1.1", "--seconds", "0.1")
QUICK += ("--scene", "spheres", "--workers", "0", "--quiet")


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("compare") / "out"
    chosen = [part for name in NAMED for part in ("--strategy", name)]
    done = hmdwarp("compare", "look-around", *chosen, "--latency", "100,200", *QUICK, "--out", out)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    return out


@pytest.fixture(scope="module")
def data(folder) -> dict:
    return json.loads((folder / "compare.json").read_text(encoding="utf-8"))


def test_rows_are_of_one_head_over_one_link_and_say_what_each_takes_and_whom_it_suits(data):
    rows = data["rows"]
    assert [(row["latency_ms"], row["strategy"]) for row in rows] == [(ms, name) for ms in (100, 200) for name in NAMED]
    assert len({row["frames"] for row in rows}) == 1 and {row["link"]["codec"] for row in rows} == {"h264"}
    for row in rows:
        link, parts = row["link"], row["link"]["response_ms"]
        assert row["server_ms"] == parts["render_ms"] + parts["encode_ms"] > parts["encode_ms"] >= 0
        assert (row["mbit_s"], row["up_mbit_s"]) == (link["mbit_s"], link["up_mbit_s"])
        assert row["client_ms"] == row["time_ms"]["total"]["median"]
        assert 0 < row["mbit_s"] == pytest.approx(sum(link["layers_mbit_s"].values()))
    # A proxy stands on the way that all have.
    ways = [(row["latency_ms"], row["link"]["proxy"]) for row in rows if row["strategy"] == "proxy"]
    assert [(way["latency_ms"], way["total_latency_ms"]) for _, way in ways] == [(75, 100), (150, 200)]
    # Data that is sent once counts at the start.
    start, held, why = (
        {row["strategy"]: row[name] for row in rows} for name in ("start_bytes", "client_bytes", "unfit")
    )
    assert start["imposter"] == start["depth_image"] == 0 < start["light"]
    assert 0 < held["imposter"] < held["depth_image"] < held["light"] and held["light"] > start["light"]
    assert why["imposter"] == {"class-1": "", "class-2": "", "class-3": ""}
    assert "compute shaders" in why["depth_image"]["class-1"] and not why["depth_image"]["class-2"]
    assert "the whole scene" in why["light"]["class-2"] and not why["light"]["class-3"]


TINY = ("--latency", "20", "--size", "32x24", "--samples", "1", "--start", "0", "--seconds", "0.05")
TINY += ("--metrics-every", "2")


def compared(out: Path, *options: str) -> tuple[dict, str]:
    """A comparison of three refreshes: compare.json, and what the terminal says."""
    done = hmdwarp("compare", "look-around", *TINY, "--headset", "flat-90", "--workers", "0", "--out", out, *options)
    assert done.returncode == 0, done.stderr
    return json.loads((out / "compare.json").read_text(encoding="utf-8")), " ".join(done.stdout.split())


@pytest.mark.slow(10)
def test_by_default_all_run_but_what_the_scene_does_not_call_for(tmp_path):
    """What would do the same as another is left out too; terminal and page say how to have it."""
    data, told = compared(tmp_path / "out", "--scene", "planes")
    suited = {name for name in strategies.names() if scene_for(name) == "planes"}
    assert {row["strategy"] for row in data["rows"]} == suited
    assert {entry["strategy"] for entry in data["left_out"]} == {*strategies.names()} - suited
    why = {entry["strategy"]: entry["why"] for entry in data["left_out"]}
    assert "its light stands still" in why["photons"]
    assert why["soft_bodies"] == (
        "nothing in 'planes' calls for it, so that it would do what 'depth_image' does; name it by --strategy to run it"
    )
    page = html.unescape((tmp_path / "out" / "compare.html").read_text(encoding="utf-8"))
    for name, reason in why.items():
        assert f"{name} is left out: {reason}" in told and f"{name} is left out: {reason}." in page
    both, _ = compared(tmp_path / "two", "--scene", "planes", "--strategy", "depth_image,soft_bodies", "--quiet")
    first, other = both["rows"]
    assert (other["strategy"], other["quality"]) == ("soft_bodies", first["quality"]), "they do the same"


def test_the_table_and_the_page_hold_all_of_it(folder, data):
    with (folder / "compare.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["strategy"] for row in rows] == [row["strategy"] for row in data["rows"]]
    assert all(float(row["flip"]) > 0 and float(row["mbit_s"]) > 0 for row in rows)
    page = (folder / "compare.html").read_text(encoding="utf-8")
    # The truth and three strategies in two cases; two fronts in two cases for three clients.
    assert page.count("<img") == 2 * (1 + len(NAMED)) and page.count("<svg") == 2 * 2 * 3
    assert not re.findall(r'(?:src|href)="(?!data:|#)', page)
    for name in (*NAMED, "class-1", "class-2", "class-3"):
        assert name in page


def page_of(data: dict) -> str:
    """Of pictures in the dark: what was shown, and the truth."""
    dark = np.zeros((4, 4, 3), np.uint8)
    return compare_page(data, [lambda: (dark, dark)] * len(data["rows"])).html()


def test_a_page_of_many_cases_shows_the_first_and_says_so_and_nothing_is_taken_for_html(data):
    found, count = first_cases(data["rows"], 1, OF_COMPARE)
    first_ms = data["rows"][0]["latency_ms"]
    assert count == 2
    assert found == {number: row for number, row in enumerate(data["rows"]) if row["latency_ms"] == first_ms}
    odd = {**data, "rows": [*found.values()], "cases": count, "command": "<script>alert(1)</script>"}
    assert "This page shows the first 1 of 2 cases" in page_of(odd) and "<script>" not in page_of(odd)


@pytest.mark.parametrize("client", client_names())
def test_a_link_too_narrow_and_a_decoder_too_slow_are_reasons(client, data):
    """By any class: a strategy that takes ten times what it has of either is not for it."""
    plan = build_plan((), "none", "none", "none", client_geometry=False)
    able, sizes = load_client(client), EyeSizes((96, 60), (96, 60))
    row = next(row for row in data["rows"] if row["strategy"] == "imposter")
    takes = decoded_mpx_s(row, plan, sizes)
    uncoded = {**row, "link": {**row["link"], "codec": "none"}}
    timed = {**row, "clock": "gpu", "time_ms": {"total": {"median": 100.0}}}
    for of, has, why in (
        (row, {}, ""),
        (row, {"download_mbit_s": row["mbit_s"], "decoder_mpx_s": takes}, ""),
        (row, {"download_mbit_s": row["mbit_s"] * 0.999}, "Mbit/s"),
        (row, {"decoder_mpx_s": takes * 0.999}, "the client decodes"),
        (uncoded, {"decoder_mpx_s": 0.0}, ""),
        (timed, {"budget_ms": 1.0}, "ms an eye"),
    ):
        found = unfit(of, plan, sizes, attrs.evolve(able, **has))
        assert why in found and bool(found) == bool(why), has


def test_a_scene_that_crosses_counts_packed_and_is_held_unpacked():
    held = {"geometry_bytes": 500, "texture_bytes": 500}
    crossed = {"start_up_bytes": 10, "first_picture_bytes": 60, "arrived_bytes": 400}
    assert start_bytes({"client_models": [held, {**held, **crossed}]}) == 1000 + 60
    assert start_bytes({"client_models": [{**held, **crossed, "first_picture_bytes": None}]}) == 400
    assert start_bytes({}) == 0


def test_what_a_strategy_takes_is_counted_from_its_own_figures():
    """By hand: `multi` reads colour (8 bytes a pixel) and depth (4) of two eyes, of this frame and
    of two older ones.
    """
    sizes, pixels = EyeSizes((96, 60), (96, 60)), 2 * 96 * 60
    plan = build_plan((), "multi", "none", "none", client_geometry=False)
    models = [{"geometry_bytes": 7, "texture_bytes": 5}]
    summary = {"link": {}, "server_rate_hz": 20.0, "rate_hz": 60.0, "client_models": models}
    assert client_bytes(summary, plan, sizes) == 3 * 12 * pixels + 12
    assert decoded_mpx_s(summary, plan, sizes) == pytest.approx(2 * pixels * 20e-6)
    assert decoded_mpx_s({**summary, "link": {"proxy": {}}}, plan, sizes) == pytest.approx(2 * pixels * 60e-6)
    assert decoded_mpx_s({**summary, "server_rate_hz": None}, plan, sizes) == pytest.approx(2 * pixels * 60e-6)


@pytest.mark.parametrize("name", suites())
def test_a_suite_says_scenes_people_and_links_and_foresees_no_motion_unless_asked(name):
    options, bench = CompareOptions.of({"suite": name}), suites()[name].sets
    assert {*options.scenes} <= {*bench["scene"][0].split(",")} and {*options.recordings} <= {*bench["traces"]}
    assert len(options.scenes) >= 3 and len(options.recordings) >= 3  # fewer have no intervals
    assert all(link.bandwidth is not None and link.bandwidth.mbit >= 10 for link in options.links)
    for said in ({"bandwidth": "3"}, {"loss": "0.1"}, {"scene": "planes"}, {"latency": ["10"]}, {"frames": "x"}):
        with pytest.raises(InputError, match="the suite says what is run"):
            CompareOptions.of({"suite": name, **said})
    assert options.client_motion == CompareOptions.of({}).client_motion == "extrapolated"
    assert CompareOptions.of({"client_motion": "foreseen"}).client_motion == "foreseen"
    if name == "brief":
        assert options.seconds >= 10  # so that a loss of 1 % is many frames
    if name == "standard":  # half a minute of each strategy, over links that are lived
        lived = {(link.bandwidth.mbit, 0.0 if link.loss is None else link.loss.mean) for link in options.links}
        assert lived == {(rate, loss) for rate in (10, 25, 50, 100) for loss in (0.0, 0.01)}
        assert options.latencies_ms == (50, 100, 200, 400, 800) and options.strategies == ()
        assert len(options.recordings) * options.seconds >= 30


def test_means_of_a_suite_are_those_of_a_bench_link_by_link():
    def row(head, scene, over, strategy, flip):
        quality = {"flip": {"mean": flip}, "psnr_db": {"mean": None if flip is None else 30 - flip}}
        case = {"trace": head, "scene": scene, "latency_ms": 50.0, "over": over, "strategy": strategy}
        return {**case, "quality": quality, "at_instants": {name: {"1": one["mean"]} for name, one in quality.items()}}

    rows = [
        row(head, scene, over, strategy, 0.1 * n + 0.01 * (head + scene).count("c") + 0.3 * (over == "slow"))
        for head in "abc"
        for scene in "xyc"
        for over in ("slow", "fast")
        for n, strategy in enumerate(("best", "other"))
    ]
    lost = row("a", "x", "slow", "gone", None)
    assert compared_entry("", rows) == {}
    suite = compared_entry("standard", [*rows, lost])["suite"]
    assert [(one["over"], one["strategy"]) for one in suite["over_all"]] == [
        (over, strategy) for over in ("slow", "fast") for strategy in ("best", "other")
    ]
    for one in suite["over_all"]:
        assert one["rank"] == {"best": float(one["strategy"] == "best"), "interval": one["rank"]["interval"]}
        assert (one["heads"], one["scenes"]) == (3, 3) and one["flip"]["interval"] is not None
    slow = [one | {"warp": one["strategy"], "fill": "none"} for one in rows if one["over"] == "slow"]
    assert [one["flip"] for one in over_all(slow)] == [one["flip"] for one in suite["over_all"][:2]]


def finite(constant: str) -> float:
    raise AssertionError(constant)


@pytest.mark.parametrize("shut", [("--bandwidth", "0.02"), ("--loss", "1")])
def test_what_a_link_lets_nothing_through_for_is_said_in_words(tmp_path, shut):
    """A model needs no link once it is there, but frames to say what time it is."""
    named = ("--strategy", "rotation", "--strategy", "model")
    done = hmdwarp("compare", "look-around", *named, "--scene", "planes", *TINY, "--headset", "flat-90", "--workers",
                   "0", *shut, "--out", tmp_path / "out")  # fmt: skip
    assert done.returncode == 0 and not complaints(done.stderr), done.stderr
    data = json.loads((tmp_path / "out" / "compare.json").read_text("utf-8"), parse_constant=finite)
    silent = [row["strategy"] for row in data["rows"] if "nothing" in row]
    assert silent == (["rotation"] if shut[0] == "--bandwidth" else ["rotation", "model"])
    assert not data["left_out"] and len(data["rows"]) == 2
    row = data["rows"][0]
    lost = "dropped" if shut[0] == "--bandwidth" else "lost"
    assert row["nothing"].startswith("no frame arrived in time (drawn ") and lost in row["nothing"]
    assert row["link"]["frames"]["drawn"] > 0 == row["frames"] and set(row["unfit"].values()) == {row["nothing"]}
    with (tmp_path / "out" / "compare.csv").open(encoding="utf-8") as file:
        (line, *_) = csv.DictReader(file)
    assert line["flip"] == line["client_ms"] == "" and row["nothing"] in line["unfit"]
    page = html.unescape((tmp_path / "out" / "compare.html").read_text("utf-8"))
    page = re.sub('<wbr>|data:[^"]*', "", page)
    assert "rotation: no frame arrived" in done.stdout and " nan" not in done.stdout
    for text in (page, compare_markdown(data["rows"]).replace("`", "")):
        assert f"rotation: {row['nothing']}" in text and not re.search(r"\bnan\b", text, re.IGNORECASE)
    assert f"{len(silent)} run{'s' * (len(silent) > 1)} showed nothing" in page
    assert len(re.findall("<figcaption>model: FLIP|<figcaption>rotation: FLIP", page)) == 2 - len(silent)
    assert "rotation" not in chosen_markdown(data, ())
    in_means = compared_entry("quick", data["rows"])["suite"]["over_all"]
    assert [entry["strategy"] for entry in in_means] == ["rotation", "model"][len(silent) :]


def test_recorded_frames_are_compared_by_what_colour_and_depth_allow(tmp_path):
    """Strategies that send a scene, a mirror or a second eye are left out, each with its reason."""
    frames = tmp_path / "walk-past"
    frames.mkdir()
    write_npz(frames, taken(12, (60, 40)))
    said = ("--frames", frames, "--latency", "100", "--workers", "0", "--quiet", "--out", tmp_path / "out")
    done = hmdwarp("compare", *said)
    assert (done.returncode, done.stderr) == (0, "")
    data = json.loads((tmp_path / "out" / "compare.json").read_text(encoding="utf-8"))
    ran, left_out = {row["strategy"] for row in data["rows"]}, {entry["strategy"] for entry in data["left_out"]}
    assert {"imposter", "depth_image"} <= ran and {"model", "proxy", "points"} <= left_out
    (why,) = (entry["why"] for entry in data["left_out"] if entry["strategy"] == "voxels")
    assert "it is not drawn here, and its light is in its frames" in why
    assert {(row["scene"], row["trace"], row["headset"], *row["size"]) for row in data["rows"]} == {
        ("walk-past", "walk-past", "camera", 60, 40)
    }
    by_name = {row["strategy"]: row["quality"]["psnr_db"]["mean"] for row in data["rows"]}
    assert by_name["depth_image"] > by_name["imposter"] + 3
    for wrong in (("walk",), ("--headset", "flat-90"), ("--scene", "room"), ("--rate", "60")):
        refused = hmdwarp("compare", *wrong, *said)
        assert (refused.returncode == 2) == (wrong != ("--scene", "room")), wrong  # the default says nothing
