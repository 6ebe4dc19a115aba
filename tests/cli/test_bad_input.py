"""What wrong input gets: one line that names it, an exit status, earlier results as they were."""

from __future__ import annotations

import fnmatch
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import needs
import pytest
from commands import hmdwarp

from hmdwarp.cli._app import entries, options_of_commands
from hmdwarp.gpu import context

WORDS = "this is not\na head trace\nat all\n"
NAN = "".join(f"{k / 60},{k},1.6,nan,0,0,0,1\n" for k in range(60))


@pytest.mark.parametrize(
    ("option", "name", "text", "told"),
    [
        ("", "missing.csv", None, "no such file"),
        ("", "words.csv", WORDS, "words.csv"),
        ("", "nan.csv", f"t,x,y,z,qx,qy,qz,qw\n{NAN}", "line 2.*nan"),
        ("--scene", "corrupt.glb", "glTF rubbish", "corrupt.glb"),
        ("--scene", "missing.glb", None, "missing.glb"),
        ("--headset", "mine.toml", None, "no such file"),
        ("--headset", "mine.toml", "name = ", "Invalid value"),
        ("--headset", "mine.toml", 'name = "x"\n', "missing"),
        ("--headset", "mine.toml", "\x00", "mine.toml"),
    ],
)
def test_a_file_that_cannot_be_used(option, name, text, told, command, quick, kept, tmp_path):
    path = tmp_path / name
    if text is not None:
        path.write_text(text, encoding="utf-8")
    done = command("replay", *([path, *quick] if not option else ["still", *quick, option, path]))
    done.refused(str(path))
    assert re.search(told, done.err), done


commands = options_of_commands()


@pytest.mark.parametrize("name", commands)
def test_an_empty_text_and_a_name_too_long_are_refused_by_the_option_that_got_them(
    name, command, tmp_path, monkeypatch
):
    """As of a shell's variable that is not set. None runs: what else it needs stands there."""
    monkeypatch.chdir(tmp_path)
    needed = [word for o in commands[name] if o.required for word in ([] if o.positional else [o.flag]) + ["x"]]
    for option in commands[name]:
        is_text = option.kind in (str, list, Path)
        if is_text and not (option.positional or option.required or option.may_be_empty):
            command(*name.split(), *needed, f"{option.flag}= ").refused(f"{option.flag} ' ': expected")
        if option.kind is Path and not option.positional:
            long = command(*name.split(), *needed, f"{option.flag}={'x' * 300}")
            long.refused(f"{option.flag} 'xxx", "no file can have this name")
    assert list(tmp_path.iterdir()) == []


def test_more_frames_than_memory_holds(command, quick, kept):
    """16384 x 16384 pixels of 12 bytes for two eyes are 6 GB a frame, 16 frames at a time."""
    from hmdwarp.base import memory_bytes

    if memory_bytes() > 85e9:
        pytest.skip("this machine has more than 85 GB of memory")
    command("replay", "still", *quick, "--guard", "1", "--size", "16384x16384").refused(
        "latency 200 ms keeps 16 frames", "GB", status=3
    )


def give_up_roots_rights() -> None:
    """In a new process.

    Root without the right to write where only others may. Takes effect with the next exec.
    """
    import ctypes

    # PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH: linux/prctl.h, capability.h
    drop, override, read_search = 24, 1, 2
    libc = ctypes.CDLL(None)
    libc.prctl(drop, override, 0, 0, 0)
    libc.prctl(drop, read_search, 0, 0, 0)


def without_rights_to(program: str, place: Path) -> dict:
    """Arguments of a process in which that program fails there."""
    rights = {"preexec_fn": give_up_roots_rights} if os.geteuid() == 0 else {}
    if subprocess.run([program, str(place)], check=False, capture_output=True, **rights).returncode == 0:
        pytest.skip("root's rights cannot be given up here, so everything can be read and written")
    return rights


def test_out_is_read_only(program, quick, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out").chmod(0o555)
    rights = without_rights_to("touch", tmp_path / "out" / "probe")
    for out in (tmp_path / "out", tmp_path / "out" / "below"):
        program("replay", "still", *quick, "--out", out, **rights).refused(
            str(out), "Permission denied", "choose a folder"
        )
    assert list((tmp_path / "out").iterdir()) == []


def test_a_folder_that_may_not_be_read_is_the_user_s_input(program, tmp_path):
    (tmp_path / "closed").mkdir(mode=0)
    rights = without_rights_to("ls", tmp_path / "closed")
    program("plan", "--frames", tmp_path / "closed", **rights).refused(str(tmp_path / "closed"), "Permission denied")


@pytest.fixture
def tiny_disk(tmp_path):
    """A file system of 256 KiB."""
    place = tmp_path / "disk"
    place.mkdir()
    if os.geteuid() != 0 or not shutil.which("mount"):
        pytest.skip(needs.missing("right to mount", needs.AS_ROOT))
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", str(place)], check=False, capture_output=True, text=True
    )
    if mounted.returncode:
        pytest.skip(needs.missing("right to mount", mounted.stderr.strip()))
    try:
        yield place
    finally:
        subprocess.run(["umount", str(place)], check=True)


def test_a_disk_that_is_full_from_the_start(command, quick, tiny_disk):
    (tiny_disk / "filler").write_bytes(bytes(256 * 1024))
    command("replay", "still", *quick, "--out", tiny_disk / "out").refused(
        str(tiny_disk / "out"), "No space left", "make room", status=3
    )
    assert [p.name for p in tiny_disk.iterdir()] == ["filler"]


@pytest.mark.parametrize("options", [[], ["--video", "--seconds", "1"]])
def test_a_disk_that_fills_up(options, command, quick, tiny_disk):
    """The page alone is larger than what is left.

    With --video the disk may be full before the loop is through.
    """
    (tiny_disk / "filler").write_bytes(bytes(240 * 1024))
    (tiny_disk / "summary.json").write_text('{"hmdwarp": "0"}', encoding="utf-8")
    command("replay", "walk", *quick, *options, "--out", tiny_disk).refused(str(tiny_disk), "No space left", status=3)
    assert sorted(p.name for p in tiny_disk.iterdir()) == ["filler", "summary.json"]


@pytest.mark.parametrize("arguments", [["replay", "still"], ["warp"]])
def test_without_opengl(arguments, program, quick, kept, tmp_path):
    from cli.test_warp_command import write_frame, write_pose

    if arguments == ["warp"]:
        write_frame(tmp_path / "frame.npz")
        write_pose(tmp_path / "pose.json")
        arguments = ["warp", tmp_path / "frame.npz", "--to", tmp_path / "pose.json", "--out", tmp_path / "o.npz"]
    else:
        arguments = [*arguments, *quick]
    none = {"__EGL_VENDOR_LIBRARY_FILENAMES": str(tmp_path / "nothing.json"), "DISPLAY": ""}
    done = program(*arguments, env=none)
    done.refused("no OpenGL 4.3", "sudo apt-get install libegl1 libgl1 libgl1-mesa-dri", "hmdwarp doctor", status=3)


def test_a_fault_of_ours_is_one_line_too(command, quick, kept, monkeypatch):
    import hmdwarp.run.measuring

    def broken(*_: object) -> None:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr(hmdwarp.run.measuring.Probe, "read", broken)
    command("replay", "still", *quick).refused("a fault of hmdwarp", "ZeroDivisionError", "HMDWARP_DEBUG=1", status=1)


def test_files_outside_are_read_on_request(command, tmp_path, monkeypatch):
    monkeypatch.setenv("HMDWARP_ALLOW_OUTSIDE", "")  # given back after the test
    (tmp_path / "there.bin").write_bytes(bytes(36))
    (scene := tmp_path / "scene" / "scene.gltf").parent.mkdir()
    buffer = {"uri": "../there.bin", "byteLength": 36}
    scene.write_text(json.dumps({"asset": {"version": "2.0"}, "buffers": [buffer]}))
    command("plan", "--scene", scene).refused("../there.bin", "lies outside")
    command("plan", "--scene", scene, "--allow-outside").refused("no triangles")  # it is read


TABLE = tomllib.loads(Path(__file__).with_name("refused.toml").read_text(encoding="utf-8"))
BENCH = "--scene planes --headset rift-dk1 --size 48x40 --seconds 0.3 --instants 1 --rounds 1 --workers 0 --guard 1.1"
CASES = [(begin, typed) for begin, lines in TABLE.items() for typed in lines]


@pytest.mark.parametrize(("begin", "typed"), CASES, ids=lambda text: text or "hmdwarp")
def test_a_command_line_is_refused_in_one_line(begin, typed, command, quick, tmp_path, monkeypatch, request):
    own = {"OUT": [str(tmp_path / "out")], "OUT.png": [str(tmp_path / "out.png")], "QUICK": quick}
    own["QUICK_BENCH"] = [*shlex.split(BENCH), "--out", str(tmp_path / "out")]
    text = f"{begin} {typed}".replace("LONG", "x" * 300).replace("FOLDER", str(tmp_path / "folder"))
    words = [part for word in shlex.split(text) for part in own.get(word, [word])]
    folders = [Path(word) for word in words if word.startswith(str(tmp_path / "folder"))]
    for folder in folders:
        folder.mkdir()
    if begin == "replay still QUICK":
        request.getfixturevalue("kept")
    if words[0] in ("bench", "plan"):
        monkeypatch.setattr(context, "create_context", lambda: pytest.fail("the GPU was started"))
    done = command(*words)
    done.refused()
    for told in TABLE[begin][typed]:
        assert told in done.err or re.search(told, done.err), done
    assert begin == "replay still QUICK" or list(tmp_path.iterdir()) == folders


TRACE = {"replay", "live", "bench", "compare", "plan"}


@pytest.mark.parametrize("key", entries())
def test_a_removed_name_ends_with_status_2_and_what_to_use_instead(key):
    words = ["replay" if word == "*" else word.replace("*", "x") for word in key.split()]
    done = hmdwarp(*([*words[:1], "walk", *words[1:]] if words[0] in TRACE - {"live", "plan"} else words))
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert f"was removed: {entries()[key]}" in done.stderr
    assert done.stdout == ""


def test_no_command_still_takes_an_option_that_was_removed():
    """A value typed after it would make a run of it, whatever the message without one."""
    taken = {f"{name} {option.flag}" for name, options in options_of_commands().items() for option in options}
    gone = [key for key in entries() if key.split()[-1].startswith("--")]
    assert [key for key in gone if fnmatch.filter(taken, key)] == [] and len(gone) > 30


# Each of these takes a third of a second to load, or more.
HEAVY = ("scipy", "matplotlib", "skimage", "trimesh", "statsmodels", "pingouin")
AFTER = f"""
import sys
from hmdwarp.cli import main
for line in "plan", "study plan quick", "doctor":
    sys.argv[1:] = line.split()
    try:
        main()
    except SystemExit as left:
        print("STATUS", left.code, [name for name in {HEAVY} if name in sys.modules])
from hmdwarp.scenes import load_scene
print("painted", [texture.name for texture in load_scene("room").textures if "image" in vars(texture)])
"""


def test_commands_that_draw_nothing_load_no_heavy_library_and_paint_no_texture():
    done = subprocess.run([sys.executable, "-c", AFTER], check=False, capture_output=True, text=True, encoding="utf-8")
    told = [line for line in done.stdout.splitlines() if line.startswith("STATUS ")]
    assert told == ["STATUS 0 []"] * 3 and done.stdout.endswith("\npainted []\n"), done.stderr
