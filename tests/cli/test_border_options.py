"""--guard auto and --wide on the command line: what runs, what is told, what is refused."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

SMALL = ("--headset", "flat-90", "--latency", "200", "--rate", "30")


def summary(quick: list[str]) -> dict:
    return json.loads((Path(quick[-1]) / "summary.json").read_text())


def test_guard_auto_is_settled_and_told(command, quick):
    loud = [word for word in quick if word != "--quiet"]
    told = command("replay", "look-around", *loud, *SMALL, "--guard", "auto").done().out
    found = summary(quick)["guard"]
    assert 1 < found <= 2
    assert f"--guard {found}" in told and "Guard auto: to lose nothing at 95% of the refreshes takes" in told


def test_wide_goes_before_the_other_fills_and_closes_the_border(command, quick):
    """The head has turned away from the rendered picture.

    The wide one holds what has come into sight.
    """
    usual = ("replay", "fast-turns", *quick, *SMALL, "--guard", "1", "--start", "3", "--fill", "none")
    command(*usual).done()
    without = summary(quick)
    command(*usual, "--wide").done()
    found = summary(quick)
    assert found["fill"] == "wide"
    # 150 x 140 degrees, with a quarter of the pixels of a tangent on each axis. Whole pixels are up
    # to one row and column more, 3 % of 90 x 55.
    wide, own = (
        [math.tan(math.radians(angle / 2)) for angle in fov] for fov in ((150, 140), without["rendered"]["fov_deg"])
    )
    assert without["rendered"]["pixels"] == 1
    assert found["rendered"]["pixels"] == pytest.approx(1 + math.prod(wide) / math.prod(own) / 16, rel=0.03)
    assert without["quality"]["border_share"]["mean"] > 0.05, "there is a border to close"
    assert found["filled"]["wide"] > 0.8 * found["quality"]["border_share"]["mean"]
    assert found["quality"]["psnr_db"]["mean"] > without["quality"]["psnr_db"]["mean"] + 3


def test_plan_says_that_a_guard_is_no_angle(command):
    usual = ("plan", "--scene", "planes", "--headset", "flat-90")
    assert "note:" not in command(*usual, "--guard", "2.5").done().out
    told = " ".join(command(*usual, "--guard", "20").done().out.split())
    assert "note: guard 20 draws 400 times the pixels: --guard is a factor" in told
    assert "not degrees" in json.loads(command(*usual, "--guard", "20", "--json").done().out)["notes"][0]


def test_plan_tells_how_many_pixels_and_which_field_of_view_result(command):
    usual = ("plan", "--scene", "planes", "--headset", "flat-90", "--size", "1280x800")
    for guard in (("--guard", "1.25x1.125"), ("--rendered-size", "1600x900")):
        told = " ".join(command(*usual, *guard).done().out.split())
        assert "1600x900, 1.41 times the pixels, 102.7 x 96.7 degrees" in told
