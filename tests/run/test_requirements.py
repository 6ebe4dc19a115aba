"""What results have to be: parsed, checked on rows, and told to people and to programs."""

import re
from xml.etree import ElementTree as Xml

import pytest

from hmdwarp.base import InputError, RequirementError
from hmdwarp.metrics import QUALITY, STAGES
from hmdwarp.report import figure_of, is_same
from hmdwarp.run.requirements import Gate, Requirements, Tolerance
from tests.report.samples import a_summary

OURS, OTHER = a_summary(), a_summary(warp="rotation")
MEAN = OURS["quality"]["psnr_db"]["mean"]


def missed(text, rows=(OURS,), others=(OTHER,)):
    return Requirements.of({"require": text}).judge(rows, others).failures()


@pytest.mark.parametrize("figure", [*(f"{q}.mean" for q in QUALITY), *(f"{s}_ms.p95" for s in STAGES)])
def test_every_figure_of_the_summary_holds_above_and_fails_below_its_value(figure):
    assert missed(f"{figure}>=-1e9") == [] and missed(f"{figure} <= 1e9") == []
    (line,) = missed(f"{figure}<-1e9")
    assert line.startswith(f"FAILED {figure} < -1e9: measured ")
    assert figure_of(figure).unit in line and "look-around" not in line  # one row needs no name


@pytest.mark.parametrize("relation, holds", [(">=", True), ("<=", True), (">", False), ("<", False)])
def test_equal_values_tell_the_relations_apart(relation, holds):
    assert (missed(f"psnr_db.mean{relation}{MEAN!r}") == []) is holds


@pytest.mark.parametrize("above", [1e-1, 1e-4, 1e-9])
def test_a_measured_value_has_the_digits_that_tell_it_from_the_limit(above):
    """And no more than four where these do: 28.21 dB against 35."""
    (line,) = missed(f"psnr_db.mean>={MEAN + above!r}")
    assert float(re.search(r"measured (\S+) dB$", line)[1]) < MEAN + above
    assert re.fullmatch(r"FAILED psnr_db.mean >= 99: measured \d\d\.\d\d dB", missed("psnr_db.mean>=99")[0])


def test_several_are_told_a_line_each_after_the_verdict_and_end_with_status_4():
    required = Requirements.of({"require": "psnr_db.mean>=99, flip.p95<=1,ssim.mean>=2"})
    with pytest.raises(RequirementError) as error:
        required.end(required.judge([OURS]))
    first, *lines = str(error.value).splitlines()
    assert error.value.exit_status == 4 and first == "FAILED: 2 of 3 requirements"
    assert [line.partition(":")[0] for line in lines] == ["FAILED psnr_db.mean >= 99", "FAILED ssim.mean >= 2"]
    holds = Requirements.of({"require": "flip.p95<=1"})
    assert holds.end(holds.judge([OURS])) is None and holds.judge([OURS]).text() == "PASSED: 1 requirement met"


def test_names_choose_rows_and_ratios_take_the_row_of_the_same_frames():
    two = missed("rotation:psnr_db.mean>=99, psnr_db.mean>=99")
    assert [line.partition("(")[2][:8] for line in two] == ["rotation", "forward+"]  # two rows are named
    assert missed("total_ms.median/rotation:total_ms.median<=1.0001") == []
    assert missed("total_ms.median/rotation:total_ms.median<1")[0].endswith(" < 1: measured 1")
    slower = {**OTHER, "latency_ms": 400.0}
    assert "0 results of 'rotation'" in missed("total_ms.median/rotation:total_ms.median<=2", others=(slower,))[0]
    said = missed("mesh:grid=64:psnr_db.mean>=1")[0]
    assert "no result of 'mesh:grid=64'; there is forward+interpolate and rotation+interpolate" in said
    unmeasured = {**OURS, "quality": {**OURS["quality"], "flip": {"mean": None, "p95": None}}}
    assert "not measured" in missed("flip.mean<=1", rows=(unmeasured,))[0]


@pytest.mark.parametrize(
    "text, told",
    [
        ("psnr.mean>=1", "did you mean 'psnr_db.mean'"),
        ("psnr_db.median>=1", "unknown figure"),
        ("psnr_db.mean", "expected FIGURE>=NUMBER"),
        ("psnr_db.mean>=x", "expected FIGURE>=NUMBER"),
        ("psnr_db.mean>=nan", "expected FIGURE>=NUMBER"),
        ("psnr_db.mean>=1 flip.p95<=2", "expected FIGURE>=NUMBER"),
        ("psnr_db.mean==1", "expected FIGURE>=NUMBER"),
        (",", "expected FIGURE>=NUMBER"),
    ],
)
def test_what_cannot_be_required_is_refused_before_the_run(text, told):
    with pytest.raises(InputError, match="--require") as error:
        Requirements.of({"require": text})
    assert told in str(error.value)


def test_junit_holds_the_run_with_its_time_and_every_requirement(tmp_path):
    path = tmp_path / "junit.xml"
    required = Requirements.of({"require": "psnr_db.mean>=99, flip.p95<=1", "junit": path})
    required.prepare(force=False)
    with pytest.raises(RequirementError):
        required.end(required.judge([OURS], [OTHER]))
    suite = Xml.parse(path).getroot()
    assert (suite.get("tests"), suite.get("failures")) == ("3", "1")
    assert [case.get("name") for case in suite] == ["run", "psnr_db.mean >= 99", "flip.p95 <= 1"]
    assert all(float(case.get("time")) >= 0 for case in suite) and suite[0].get("time") == suite.get("time")
    assert [failure.get("message") for failure in suite.iter("failure")] == [f"measured {MEAN:.4g} dB"]
    with pytest.raises(InputError, match="exists already"):
        required.prepare(force=False)


TOLERANCES = (
    ("psnr_db=0.05", "quality.psnr_db.mean", 0.05),
    ("psnr_db=0.05", "regions.seen.psnr_db", 0.05),
    ("psnr_db=0.05", "rows.psnr_db", 0.05),
    ("psnr_db=0.05", "quality.ssim.mean", 0),
    ("figures=1%", "link.mbit_s", 0.3),
    ("figures=1%, quality=0.5, quality.psnr_db=2%", "quality.psnr_db.p95", 0.6),
    ("figures=1%, quality=0.5, quality.psnr_db=2%", "quality.ssim.p95", 0.5),
    ("regions=2, psnr_db=0.1", "regions.seen.psnr_db", 0.1),
    ("filled=0.001, filled=1%", "filled.memory", 0.3),
)


@pytest.mark.parametrize("text, key, most", TOLERANCES)
def test_a_tolerance_is_that_of_the_name_that_fits_most_closely(text, key, most):
    """Of a stored 30: absolute, or of the stored value; beyond it by 1e-6 it is a difference."""
    allows = Tolerance.of(text).allows
    assert allows(key, 30.0, 30.0 + most - 1e-9) and allows(key, 30.0, 30.0 - most + 1e-9)
    assert not allows(key, 30.0, 30.0 + most + 1e-6) and not allows(key, 30.0, None)
    assert allows(key, None, None) and is_same(key, 30.0, 30.0 * (1 + 1e-10))


@pytest.mark.parametrize("text", ["psnr=1", "psnr_db", "psnr_db=-1", "psnr_db=nan", "pixel=x", "pixel=1%", "pixels=%"])
def test_a_wrong_tolerance_is_refused(text):
    with pytest.raises(InputError, match="--tolerance"):
        Gate.of({"tolerance": text})
    for said in ({"tolerance": "pixel=2"}, {"update_baseline": True}):
        with pytest.raises(InputError, match="without --baseline"):
            Gate.of(said)
