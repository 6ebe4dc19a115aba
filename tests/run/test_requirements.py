"""What results have to be: parsed, checked on rows, and written as JUnit XML."""

from xml.etree import ElementTree as Xml

import pytest

from hmdwarp.errors import InputError, RequirementError
from hmdwarp.metrics import QUALITY, STAGES
from hmdwarp.run.requirements import Baseline, Requirements, hold
from tests.report.samples import a_summary

OURS, OTHER = a_summary(), a_summary(warp="rotation")
MEAN = OURS["quality"]["psnr_db"]["mean"]


def missed(text, rows=(OURS,), others=(OTHER,), **more):
    return Requirements.of({"require": text, **more}).missed(rows, others)


@pytest.mark.parametrize("figure", [*(f"{q}.mean" for q in QUALITY), *(f"{s}_ms.p95" for s in STAGES)])
def test_every_figure_of_the_summary_holds_above_and_fails_below_its_value(figure):
    assert missed(f"{figure}>=-1e9") == [] and missed(f"{figure} <= 1e9") == []
    (line,) = missed(f"{figure}<-1e9")
    assert line.startswith(f"{figure}<-1e9: it is ") and "look-around in room, 200 ms" in line


@pytest.mark.parametrize("relation, holds", [(">=", True), ("<=", True), (">", False), ("<", False)])
def test_equal_values_tell_the_relations_apart(relation, holds):
    assert (missed(f"psnr_db.mean{relation}{MEAN!r}") == []) is holds


def test_several_are_told_a_line_each_and_end_with_status_4():
    lines = missed("psnr_db.mean>=99, flip.p95<=1,ssim.mean>=2")
    assert [line.partition(":")[0] for line in lines] == ["psnr_db.mean>=99", "ssim.mean>=2"]
    with pytest.raises(RequirementError) as error:
        hold(lines)
    assert error.value.exit_status == 4 and str(error.value).splitlines() == lines
    hold([])


def test_names_choose_rows_and_ratios_take_the_row_of_the_same_frames():
    assert missed("rotation:psnr_db.mean>=99")[0].count("rotation+interpolate") == 1
    assert "(forward+interpolate, " in missed("forward+interpolate:psnr_db.mean>=99")[0]
    assert missed("total_ms.median/rotation:total_ms.median<=1.0001") == []
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


def test_junit_holds_every_requirement_with_its_failure(tmp_path):
    path = tmp_path / "junit.xml"
    required = Requirements.of({"require": "psnr_db.mean>=99, flip.p95<=1", "junit": path})
    required.prepare(force=False)
    (line,) = required.missed([OURS], [OTHER])
    suite = Xml.parse(path).getroot()
    assert (suite.get("tests"), suite.get("failures")) == ("2", "1")
    assert [case.get("name") for case in suite] == ["psnr_db.mean>=99", "flip.p95<=1"]
    assert [failure.get("message") for failure in suite.iter("failure")] == [line]
    with pytest.raises(InputError, match="exists already"):
        required.prepare(force=False)
    with pytest.raises(InputError, match="expected --require or --baseline too"):
        Requirements.of({"junit": path}).prepare(force=True, has_baseline=False)
    with pytest.raises(InputError, match="expected --require too"):
        Requirements.of({"junit": path}).prepare(force=True)


@pytest.mark.parametrize("text", ["psnr=1", "psnr_db", "psnr_db=-1", "psnr_db=nan", "pixel=x"])
def test_a_wrong_tolerance_is_refused(text):
    with pytest.raises(InputError, match="--tolerance"):
        Baseline.of({"tolerance": text})
    with pytest.raises(InputError, match="without --baseline"):
        Baseline.of({"tolerance": "pixel=2"})
