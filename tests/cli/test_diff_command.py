"""A run is equal to itself run again; what differs is told, and ends with status 4."""

import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """Options of a tiny replay, and its folder."""
    import sys

    from hmdwarp.cli import main

    out = tmp_path_factory.mktemp("stored") / "run"
    options = ["--scene", "planes", "--size", "48x40", "--seconds", "0.1", "--workers", "0", "--against", "none"]
    options += ["--metrics-every", "2", "--images", "2", "--quiet"]
    before = sys.argv
    sys.argv = ["hmdwarp", "replay", "look-around", *options, "--out", str(out)]
    try:
        with pytest.raises(SystemExit) as left:
            main()
    finally:
        sys.argv = before
    assert not left.value.code
    return options, out


def test_a_replay_run_again_is_equal_and_requirements_are_read_of_it(command, stored, tmp_path):
    options, out = stored
    junit = tmp_path / "junit.xml"
    again = ["replay", "look-around", *options, "--out", tmp_path / "again", "--baseline", out]
    command(*again, "--require", "psnr_db.mean>=1, none:flip.mean<=1", "--junit", junit).done()
    assert junit.read_text().count("<testcase") == 3 and 'failures="0"' in junit.read_text()
    assert command("diff", out, tmp_path / "again").done().out == "equal, but for times\n"
    assert command("diff", out / "summary.json", tmp_path / "again").done()
    made = json.loads((out / "summary.json").read_text())["made_with"]
    assert {"commit", "options", "numpy", "moderngl", "python"} == {*made}
    # The baseline would be overwritten.
    command("replay", "look-around", *options, "--out", out, "--baseline", out).refused("another --out")


def test_a_requirement_that_does_not_hold_leaves_all_results_and_status_4(command, stored, tmp_path):
    options, out = stored
    done = command(
        "replay", "look-around", *options, "--fill", "none", "--out", tmp_path / "run", "--baseline", out,
        "--require", "psnr_db.mean>=99, total_ms.median/none:total_ms.median<0", "--junit", tmp_path / "junit.xml",
    )  # fmt: skip
    lines = done.err.splitlines()
    assert done.status == 4 and all(line.startswith("hmdwarp: ") for line in lines)
    assert "psnr_db.mean>=99: it is" in lines[0] and "total_ms.median<0: it is" in lines[1]
    assert "hmdwarp: baseline: set-up: fill was memory+pyramid, is none" in lines
    *_, last = ElementTree.parse(tmp_path / "junit.xml").getroot().iter("failure")
    assert ["hmdwarp: " + line for line in [last.get("message"), *last.text.splitlines()]] == lines[2:]
    assert {"summary.json", "frames.csv", "report.html", "images", "diff.html"} <= {
        p.name for p in (tmp_path / "run").iterdir()
    }


def test_a_changed_pixel_is_found_and_shown_and_a_tolerance_allows_it(command, stored, tmp_path):
    _, out = stored
    other = tmp_path / "other"
    (other / "images").mkdir(parents=True)
    summary = json.loads((out / "summary.json").read_text())
    for path in out.glob("images/*.png"):
        (other / "images" / path.name).write_bytes(path.read_bytes())
    name = min(path.name for path in out.glob("images/*.png"))
    picture = np.asarray(Image.open(out / "images" / name)).copy()
    picture[20, 10, 0], picture[20, 11, 0] = picture[20, 10, 0] & 252, picture[20, 11, 0] | 3  # darker, brighter
    Image.fromarray(picture).save(other / "images" / name)
    summary["digests"][f"images/{name}"] = "0" * 64
    summary["quality"]["psnr_db"]["mean"] += 0.01
    (other / "summary.json").write_text(json.dumps(summary))
    done = command("diff", out, other, "--out", tmp_path / "page", "--json")
    assert done.status == 4 and done.err.count("\n") == 2
    assert all(a != b for a, b in re.findall(r"figure: \S+ was (\S+), is (\S+)$", done.err, re.MULTILINE))
    assert "figure: quality.psnr_db.mean was" in done.err and f"picture: images/{name} differs in" in done.err
    found = json.loads(done.out)
    assert not found["equal"] and found["pictures"][0]["largest"] <= 3
    assert name in (tmp_path / "page" / "diff.html").read_text()
    assert command("diff", out, other, "--tolerance", "psnr_db=0.02, pixel=3").done()


def test_a_summary_alone_is_called_by_its_name(command, stored, tmp_path, monkeypatch):
    _, out = stored
    summary = json.loads((out / "summary.json").read_text())
    summary["digests"] = dict.fromkeys(summary["digests"], "0" * 64)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "old.json").write_text(json.dumps(summary))
    done = command("diff", "old.json", out)
    assert "differs, and is not kept in old.json" in done.err and "frames.csv differs; old.json has none" in done.out


def test_what_is_no_replay_is_refused(command, stored, tmp_path):
    _, out = stored
    command("diff", out, tmp_path).refused("summary.json")
    (tmp_path / "summary.json").write_text("{}")
    command("diff", out, tmp_path).refused("no summary of schema")
    command("diff", out, out, "--tolerance", "psnr=1").refused("--tolerance psnr=1")
