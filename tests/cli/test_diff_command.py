"""A run is equal to itself run again; what differs is told, and ends with status 4."""

import json
import shutil
from xml.etree import ElementTree

import numpy as np
import pytest
from commands import hmdwarp
from PIL import Image

from hmdwarp.report import StoredRun


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """Options of a tiny replay, and its folder, recorded as a baseline."""
    folder = tmp_path_factory.mktemp("stored")
    options = ["--scene", "planes", "--headset", "rift-dk1", "--size", "48x40", "--seconds", "0.1", "--workers", "0"]
    options += ["--against", "none"]
    options += ["--metrics-every", "2", "--images", "2", "--quiet"]
    store = ["--out", folder / "first", "--baseline", folder / "run", "--update-baseline"]
    assert not hmdwarp("replay", "look-around", *options, *store).returncode
    return options, folder / "run"


def copied(run, folder, **changes):
    """A copy of a run. changes: of a picture, by the name of its panel (added levels, pixels)."""
    shutil.copytree(run, folder)
    name = min(path.name for path in run.glob("images/*.png"))
    strip = np.asarray(Image.open(folder / "images" / name)).copy()
    summary = json.loads((folder / "summary.json").read_text())
    panels = [*summary["digests"][f"images/{name}"], "error"]
    for panel, (levels, count) in changes.items():
        left = panels.index(panel) * (strip.shape[1] + 6) // len(panels)  # 6 white pixels between two
        part = strip[-20, left : left + count]
        up_and_down = np.resize([levels, -levels], (count, 1))
        strip[-20, left : left + count] = np.clip(part.astype(int) + up_and_down, 0, 255)
        summary["digests"][f"images/{name}"] |= {panel: "0" * 64} if panel != "error" else {}
    Image.fromarray(strip).save(folder / "images" / name)
    (folder / "summary.json").write_text(json.dumps(summary))
    return summary, folder / "summary.json"


def test_a_replay_run_again_is_equal_and_requirements_are_read_of_it(command, stored, tmp_path, monkeypatch):
    options, out = stored
    junit, again = tmp_path / "junit.xml", tmp_path / "again"
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path / "step.md"))
    ran = ["replay", "look-around", *options, "--out", again, "--baseline", out]
    command(*ran, "--require", "psnr_db.mean>=1, none:flip.mean<=1", "--junit", junit).done()
    suite = ElementTree.parse(junit).getroot()
    names = {case.get("name") for case in suite}
    assert suite.get("failures") == "0" and {"run", "psnr_db.mean >= 1", "quality.flip.p95", "filled.empty"} < names
    verdict = "PASSED: 2 requirements met; baseline: identical except for timings"
    assert (tmp_path / "step.md").read_text().startswith(f"### hmdwarp {verdict}\n")
    gate = json.loads((again / "summary.json").read_text())["gate"]
    assert gate["passed"] and gate["verdict"] == verdict and verdict in (again / "report.html").read_text()
    assert command("diff", out, again).done().out == "identical except for timings\n"
    assert command("diff", out / "summary.json", again).done()
    made = json.loads((out / "summary.json").read_text())["made_with"]
    assert {"commit", "options", "numpy", "moderngl", "python"} == {*made}
    command("replay", "look-around", *options, "--out", out, "--baseline", out).refused("another --out")


def test_a_red_run_says_why_everywhere_and_is_accepted_on_request(command, stored, tmp_path, monkeypatch):
    options, out = stored
    base, run = tmp_path / "base", tmp_path / "run"
    shutil.copytree(out, base)
    summary = json.loads((base / "summary.json").read_text())
    summary["quality"]["psnr_db"]["mean"] += 1
    summary["quality"]["flip"]["p95"] *= 2
    (base / "summary.json").write_text(json.dumps(summary))
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(tmp_path / "step.md"))
    ran = ["replay", "look-around", *options, "--lens", "none", "--out", run, "--baseline", base, "--force"]
    failing = ["--require", "psnr_db.mean>=99, flip.mean<=1", "--junit", tmp_path / "junit.xml"]
    done = command(*ran, *failing)
    verdict = "FAILED: 1 of 2 requirements; baseline: 1 figure worse, 1 better, 1 setting (no tolerance)"
    lines = done.err.splitlines()
    assert done.status == 4 and lines[0] == f"hmdwarp: {verdict}"
    assert lines[1].startswith("FAILED psnr_db.mean >= 99: measured ") and lines[2] == "lens: radial -> none"
    assert [line.split()[0] for line in lines[3:6]] == ["metric", "flip.p95", "psnr_db.mean"]  # the larger change first
    assert lines[4].endswith("(-50.00 %)  better") and lines[5].split()[1] == "[dB]" and lines[5].endswith("worse")
    assert lines[-1] == f"pictures and charts: {run / 'diff.html'}"
    told = (tmp_path / "step.md").read_text()
    assert told.startswith(f"### hmdwarp {verdict}\n") and all(line in told for line in lines[1:])
    gate = json.loads((run / "summary.json").read_text())["gate"]
    assert gate["verdict"] == verdict and [one["holds"] for one in gate["requirements"]] == [False, True]
    assert [(one["name"], one["verdict"]) for one in gate["baseline"]["figures"]] == [
        ("quality.flip.p95", "better"),
        ("quality.psnr_db.mean", "worse"),
    ]
    page = (run / "report.html").read_text()
    assert verdict in page and 'href="diff.html"' in page and "psnr_db.mean [dB]" in page.replace("<wbr>", "")
    failures = {case.get("name") for case in ElementTree.parse(tmp_path / "junit.xml").getroot() if len(case)}
    assert failures == {"psnr_db.mean >= 99", "quality.flip.p95", "quality.psnr_db.mean", "all else"}
    # It is stored where the requirements are met, and equal then.
    before = (base / "summary.json").read_bytes()
    refused = command(*ran, *failing, "--update-baseline")
    assert f"; not stored in {base}\n" in refused.err and (base / "summary.json").read_bytes() == before
    command(*ran, "--require", "flip.mean<=1", "--update-baseline").done()
    command(*ran).done()
    assert {"summary.json", "frames.csv", "images"} == {path.name for path in base.iterdir()}
    command(*ran, "--baseline", tmp_path / "alone.json", "--update-baseline").done()
    assert command("diff", tmp_path / "alone.json", run).done()


def test_a_changed_picture_is_found_and_shown_and_a_tolerance_allows_it(command, stored, tmp_path):
    _, out = stored
    summary, path = copied(out, tmp_path / "other", warped=(3, 2))
    summary["quality"]["psnr_db"]["mean"] += 0.01
    path.write_text(json.dumps(summary))
    done = command("diff", out, tmp_path / "other", "--out", tmp_path / "page", "--json")
    assert done.status == 4 and done.err.startswith("hmdwarp: 1 figure better, 1 picture (no tolerance)\n")
    found = json.loads(done.out)
    (picture,), (figure,) = found["pictures"], found["figures"]
    assert not found["equal"] and picture["largest"] == 3 and picture["name"].endswith("-left.png, warped")
    assert figure["unit"] == "dB" and figure["change"] == pytest.approx(0.01) and figure["verdict"] == "better"
    page = (tmp_path / "page" / "diff.html").read_text()
    assert picture["name"] in page and "absolute difference, x16" in page and 'value="blink"' in page
    assert page.count("data:image/png") == 4  # stored, now, stored again over it, difference
    two = 2 / (48 * 40)  # pixels of a panel
    cases = {"pixel=3": True, "pixel=2": False, f"pixels={100 * two}%": True, "pixels=0.001": False}
    for allowed, equal in cases.items():
        for pair in ((out, tmp_path / "other"), (tmp_path / "other", out)):  # brighter, and darker
            done = command("diff", *pair, "--tolerance", f"psnr_db=0.1%, {allowed}")
            assert done.status == (0 if equal else 4), done
    assert command("diff", out, tmp_path / "other", "--tolerance", "figures=1%, pixel=3").out == (
        "identical within tolerance 'figures=1%, pixel=3' (1 figure changed)\n"
    )


def test_a_summary_alone_is_called_by_its_name(command, stored, tmp_path, monkeypatch):
    _, out = stored
    summary, _ = copied(out, tmp_path / "other", truth=(9, 1))
    summary["digests"]["frames.csv"], summary["against"] = "0" * 64, []
    monkeypatch.chdir(tmp_path)
    (tmp_path / "old.json").write_text(json.dumps(summary))
    done = command("diff", "old.json", out)
    assert "differs, and is not kept in old.json" in done.err and "frames.csv differs; old.json has none" in done.out
    assert "against.0.warp: – -> none" in done.err and "against.0.quality.flip.mean" in done.err


def test_what_is_no_replay_is_refused(command, stored, tmp_path):
    _, out = stored
    command("diff", out, tmp_path).refused("summary.json")
    (tmp_path / "summary.json").write_text("{}")
    command("diff", out, tmp_path).refused("no summary of schema")
    old = {**StoredRun.of(out).summary, "digests": {"frames.csv": "0", "images/a.png": "0"}}
    (tmp_path / "summary.json").write_text(json.dumps(old))
    command("diff", out, tmp_path).refused("run it again")
    command("diff", out, out, "--tolerance", "psnr=1").refused("--tolerance psnr=1")
