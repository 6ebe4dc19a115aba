"""One rule for what commands write: nothing of others is overwritten, unless forced."""

from __future__ import annotations

import re
import resource

import pytest

from hmdwarp.poses import load_trace
from hmdwarp.resources import folder

WALK = folder("recordings") / "walk.csv"
ONCE = ("--warp", "none", "--fill", "none", "--instants", "1", "--rounds", "1")
TINY = [
    "--scene",
    "planes",
    "--size",
    "48x40",
    "--headset",
    "rift-dk1",
    "--seconds",
    "0.1",
    "--workers",
    "0",
    "--quiet",
]
RATINGS = "participant,condition,rating\n" + "".join(
    f"{who},{what},{who % 3 + 1}\n" for who in range(6) for what in "ab"
)

# Arguments before --out, and a file of the folder that each writes.
FOLDERS = {
    "replay": (["replay", "still", "--against", "", *TINY], "report.html"),
    "bench": (["bench", "still", *ONCE, *TINY], "bench.html"),
    "live": (
        ["live", "--source", "offscreen", "--trace", "walk", "--pictures", "2", "--quiet", *TINY[:4]],
        "frames.csv",
    ),
    "analyse": (["study", "analyse", "ratings.csv", "--scale", "acr", "--quiet"], "tables/missing.csv"),
}
FILES = {
    "synth": ["trace", "synth", "walk", "--seconds", "0.1", "--out"],
    "convert": ["trace", "convert", WALK],
    "record": ["record", "--source", "synthetic", "--seconds", "0.1", "--quiet", "--out"],
    "live --record": [*FOLDERS["live"][0], "--record"],
}


@pytest.fixture(autouse=True)
def working_folder(tmp_path, monkeypatch):
    place = tmp_path / "here"
    place.mkdir()
    (place / "ratings.csv").write_text(RATINGS)
    monkeypatch.chdir(place)
    return place


@pytest.fixture
def others(tmp_path):
    """others(name): a folder with a file of another program, where that command writes one."""

    def make(name):
        out = tmp_path / "out"
        (out / FOLDERS[name][1]).parent.mkdir(parents=True)
        (out / FOLDERS[name][1]).write_text("precious")
        (out / "mine.txt").write_text("mine")
        return out

    return make


@pytest.mark.parametrize("name", FOLDERS)
def test_a_folder_with_a_file_of_others_is_refused(name, command, others):
    (arguments, written), out = FOLDERS[name], others(name)
    command(*arguments, "--out", out).refused(written, "--force")
    assert (out / written).read_text() == "precious"
    assert not list(out.glob(".*"))


@pytest.mark.parametrize("name", [name for name in FOLDERS if name != "bench"])  # which takes long
def test_a_folder_is_forced_and_then_ours(name, command, others):
    (arguments, written), out = FOLDERS[name], others(name)
    for options in (["--force"], []):
        done = command(*arguments, "--out", out, *options)
        assert done.status == 0, done
    assert (out / "mine.txt").read_text() == "mine"
    assert not (out / written).exists() or (out / written).read_text() != "precious"


@pytest.mark.parametrize("name", FILES)
def test_a_file_is_refused_and_then_forced(name, command, tmp_path):
    out = tmp_path / "out.csv"
    out.write_text("precious")
    command(*FILES[name], out).refused("out.csv exists already", "--force")
    assert out.read_text() == "precious"
    assert command(*FILES[name], out, "--force").status == 0
    assert len(load_trace(out).track) > 1


@pytest.mark.parametrize("name", FOLDERS | FILES)
def test_no_name_is_not_the_working_folder(name, command, working_folder):
    arguments = [*FOLDERS[name][0], "--out"] if name in FOLDERS else FILES[name]
    command(*arguments, "").refused("''", "expected a name; '.' is the working folder")
    assert [path.name for path in working_folder.iterdir()] == ["ratings.csv"]


def test_record_says_what_a_full_disk_has_taken(program, tmp_path):
    out = tmp_path / "walk.csv"
    done = program(
        *("record", "--source", "synthetic", "--kind", "walk", "--out", out),
        env={"PYTHONDONTWRITEBYTECODE": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (6000, 6000)),
    )
    track = load_trace(out).track
    assert done.status == 3 and "make room" in done.err, done
    assert f"{out}: {len(track)} poses, {track.duration_ns * 1e-9:.3f} s; left out: " in done.err
    assert re.search(r"left out: \d+ lost, as the disk did not take them\n", done.err), done
