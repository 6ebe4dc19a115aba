"""What wrong input gets.

One line that names it, the right exit status, and earlier results as they were.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import needs
import numpy as np
import pytest

from hmdwarp.cli._app import options_of_commands
from hmdwarp.resources import folder

WALK = folder("recordings") / "walk.csv"


@pytest.fixture
def kept(tmp_path):
    """An output folder with earlier results.

    Afterwards they must be there as before, and nothing beside them.
    """
    out = tmp_path / "out"
    (out / "images").mkdir(parents=True)
    before = {
        "summary.json": b'{"hmdwarp": "0"}',
        "frames.csv": b"frame\n",
        "report.html": b"<html>",
        "images/frame-000000-left.png": b"png",
        "mine.txt": b"mine",
    }
    for name, data in before.items():
        (out / name).write_bytes(data)
    yield out
    found = {p.relative_to(out).as_posix(): p.read_bytes() for p in out.rglob("*") if p.is_file()}
    assert found == before
    assert sorted(p.name for p in out.iterdir()) == ["frames.csv", "images", "mine.txt", "report.html", "summary.json"]


# --- traces


def traces() -> dict[str, bytes | None]:
    walk = WALK.read_bytes()
    lines = walk.splitlines(keepends=True)
    cells = [line.split(b",") for line in lines[20:]]  # one bad row is dropped, so many rows of a file are bad
    return {
        "missing.csv": None,
        "empty.csv": b"",
        "binary.csv": np.random.default_rng(3).bytes(5000),
        "zeros.csv": bytes(3000),
        "header-only.csv": b"".join(lines[:5]),
        "one-row.csv": b"".join(lines[:6]),
        "nan.csv": b"".join([*lines[:20], *(b",".join([c[0], b"nan", *c[2:]]) for c in cells)]),
        "infinite.csv": b"".join([*lines[:20], *(b",".join([*c[:7], b"inf\n"]) for c in cells)]),
        "words.csv": b"this is not\na head trace\nat all\n",
        "cut-in-a-number.csv": walk[:330],
    }


@pytest.mark.parametrize("name", traces())
def test_traces_that_cannot_be_used(name, command, quick, kept, tmp_path):
    path = tmp_path / name
    if (data := traces()[name]) is not None:
        path.write_bytes(data)
    done = command("replay", path, *quick)
    done.refused(str(path))
    if name in ("nan.csv", "infinite.csv"):
        done.refused("line 21", "nan" if name == "nan.csv" else "inf")


@pytest.mark.parametrize(
    "arguments",
    [
        ("replay", "FOLDER"),
        ("plan", "--scene", "FOLDER"),
        ("plan", "--scene", "FOLDER.glb"),
        ("plan", "--headset", "FOLDER"),
        ("plan", "--headset", "FOLDER.toml"),
        ("study", "plan", "FOLDER"),
    ],
)
def test_a_folder_is_called_one(arguments, command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    typed = [
        str(tmp_path / argument.replace("FOLDER", "folder")) if "FOLDER" in argument else argument
        for argument in arguments
    ]
    folder = next(argument for argument in typed if argument.startswith(str(tmp_path)))
    Path(folder).mkdir()
    command(*typed).refused(folder, "is a directory")


# --- names


@pytest.mark.parametrize(
    ("option", "wrong", "nearest"),
    [
        ("--warp", "foward", "forward"),
        ("--fill", "interpolat", "interpolate"),
        ("--lens", "radail", "radial"),
        ("--scene", "rooom", "room"),
        ("--headset", "rift", "rift-dk1"),
        ("--format", "tumm", "tum"),
        ("--predict", "constant-velocity", "constant_velocity"),
        ("--against", "rotations", "rotation"),
        ("--warp", "qqqq", ""),  # near nothing
    ],
)
def test_unknown_names_get_the_nearest_known_one(option, wrong, nearest, command, quick, kept):
    done, guess = command("replay", "still", *quick, option, wrong), f"did you mean '{nearest}'?"
    done.refused(f"'{wrong}'", "known are", guess if nearest else "")
    assert ("did you mean" in done.err) == bool(nearest)


def test_unknown_recording(command, quick, kept):
    command("replay", "lookaround", *quick).refused("unknown recording 'lookaround'", "did you mean 'look-around'?")


@pytest.mark.parametrize("source", ["synthetic", "openxr", "desktop"])
def test_a_recording_refuses_an_unknown_scene_whether_or_not_a_window_opens(source, command, tmp_path):
    done = command("record", "--out", tmp_path / "a.csv", "--source", source, "--scene", "rooom", "--seconds", 0.1)
    done.refused("'rooom'", "did you mean 'room'?")
    assert list(tmp_path.iterdir()) == []


def test_a_trace_is_not_written_under_a_pictures_name(command, tmp_path):
    done = command("trace", "synth", "still", "--out", tmp_path / "a.png", "--seconds", 1)
    done.refused("a.png: found '.png'", "expected a name in .csv")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "arguments",
    [
        ["replai"],
        ["list", "warp"],
        ["list", "warps", "foward"],
        ["replay", "still", "--wrap", "x"],
        ["replay"],
        ["warp"],
    ],
)
def test_unknown_commands_and_options(arguments, command):
    command(*arguments).refused("hmdwarp")


# --- numbers


@pytest.mark.parametrize(
    ("option", "value", "told"),
    [
        ("--latency", "-1", "--latency -1 ms: expected a finite number of at least 0 ms"),
        ("--latency", "nan", "latency nan"), ("--latency", "inf", "--latency inf ms: expected a finite number"),
        ("--latency", "soon", "'--latency', 'soon'"),
        ("--metrics-every", "0", "--metrics-every 0: expected a whole number of at least 1"),
        ("--latency", "20001", "longer than the trace 'still' (20.000 s)"), ("--size", "0x0", "'0x0'"),
        ("--size", "-1x5", "'-1x5'"), ("--size", "abc", "'abc'"), ("--size", "640", "'640'"),
        ("--size", "64x64x64", "'64x64x64'"), ("--size", "1e3x4", "'1e3x4'"), ("--size", "99999x8", "99999x8"),
        ("--size", "8x999999", "8x999999"), ("--guard", "0.9", "guard 0.9"), ("--guard", "nan", "guard nan"),
        ("--guard", "inf", "guard inf"), ("--guard", "1e9", "guard 1e+09"), ("--guard", "-2", "guard -2"),
        ("--guard", "1.5x0.9", "guard 0.9"), ("--guard", "1600x900", "guard 1600x900"),
        ("--rendered-size", "8x8", "rendered size 8x8 is smaller"),
        ("--rendered-size", "1.25x1.125", "'1.25x1.125'"), ("--rendered-size", "99999x99999", "no field of view"),
        ("--rate", "0", "rate 0 Hz"), ("--rate", "nan", "rate nan"), ("--rate", "-60", "rate -60 Hz"),
        ("--rate", "1e6", "rate 1e+06 Hz"), ("--metrics-every", "-3", "metrics-every -3"),
        ("--metrics-every", "2.5", "--metrics-every"), ("--start", "20", "start 20 s"),
        ("--start", "-1", "start -1 s"), ("--start", "nan", "start nan"), ("--seconds", "0", "seconds 0 s"),
        ("--seconds", "nan", "seconds nan"), ("--seconds", "-2", "seconds -2 s"),
        ("--horizon", "-1", "horizon -1 ms"), ("--workers", "-1", "workers -1"),
        ("--workers", "1000000", "workers 1e+06"), ("--images", "-1", "images -1"),
        ("--quat-order", "wxzy", "'wxzy'"), ("--scale", "0", "scale 0"), ("--scale", "nan", "scale nan"),
        ("--trace-rate", "-5", "rate -5"), ("--segment", "0", "segment 0"), ("--segment", "7", "segment 7"),
        ("--size", "8000x8000 --guard 8", "guard 8 .*this GPU's limit"),
        ("--headset", "flat-90 --lens radial", "flat-90.* no lens.*--lens none"),
        ("--size", "7x7 --video", "14x7.*16x16"), ("--latency", "٢", "'٢'"), ("--guard", "٢", "'٢'"),
        ("--size", "٦٤x٤٨", "'٦٤x٤٨'"), ("--warp", "mesh:grid=٦٤", "grid is '٦٤'"),
        ("--require", "psnr_db.mean>=٣", "psnr_db.mean>=٣"), ("--tolerance", "psnr_db=٣ --baseline .", "found '٣'"),
        ("--response", "sum:render=٣", "'sum:render=٣'"),
    ],
)  # fmt: skip
def test_impossible_values_are_refused(option, value, told, command, quick, kept):
    done = command("replay", "still", *quick, option, *value.split())
    done.refused()
    assert told in done.err or re.search(told, done.err), done


# --- texts of every kind

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


@pytest.mark.parametrize(
    "arguments",
    [
        ("replay", "LONG.csv"),
        ("plan", "--scene", "LONG"),
        ("plan", "--frames", "LONG"),
        ("plan", "--headset", "LONG"),
        ("plan", "--client", "LONG"),
        ("record", "--source", "synthetic", "--seconds", "0.1", "--out", "LONG"),
        ("serve", "--listen", "127.0.0.1:*", "--key-pair", "LONG"),
        ("study", "withdraw", "quick", "P01", "--store", "LONG"),
    ],
)
def test_a_name_longer_than_the_system_takes_is_the_user_s_input(arguments, command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command(*(argument.replace("LONG", "x" * 300) for argument in arguments)).refused("x" * 12)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("address", ["", "*:5570", "127.0.0.1:*", "127.0.0.1:0", "a host:5570", "127.0.0.1:70000"])
def test_a_server_s_address_has_a_host_and_a_port(address, command):
    done = command("live", "--source", "offscreen", "--trace", "walk", "--connect", address)
    done.refused(f"--connect '{address}': expected")


def test_frames_that_never_come_end_a_run_that_nobody_watches(command):
    """At one refresh a second, 12 are 12 s of its simulated clock."""
    run = ("live", "--source", "offscreen", "--trace", "walk", "--size", "16x12", "--rate", 1, "--quiet")
    command(*run, "--loss", 1).refused("no frame has arrived within", "--loss")


def test_more_frames_than_memory_holds(command, quick, kept):
    """16384 x 16384 pixels of 12 bytes for two eyes are 6 GB a frame, 16 frames at a time."""
    from hmdwarp.platforms import memory_bytes

    if memory_bytes() > 85e9:
        pytest.skip("this machine has more than 85 GB of memory")
    command("replay", "still", *quick, "--guard", "1", "--size", "16384x16384").refused(
        "latency 200 ms keeps 16 frames", "GB", status=3
    )


# --- files


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("corrupt.glb", b"glTF rubbish"),
        ("empty.ply", b""),
        ("points.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n"),
        ("missing.glb", None),
        ("scene.blend", b"BLENDER"),
    ],
)
def test_scene_files_that_cannot_be_used(name, data, command, quick, kept, tmp_path):
    path = tmp_path / name
    if data is not None:
        path.write_bytes(data)
    command("replay", "still", *quick, "--scene", path).refused(str(path))


@pytest.mark.parametrize(
    ("text", "told"),
    [(None, "no such file"), ("name = ", "Invalid value"), ('name = "x"\n', "missing"), ("\x00", "mine.toml")],
)
def test_headset_files_that_cannot_be_used(text, told, command, quick, kept, tmp_path):
    path = tmp_path / "mine.toml"
    if text is not None:
        path.write_text(text, encoding="utf-8")
    command("replay", "still", *quick, "--headset", path).refused(str(path), told)


def test_out_is_a_file(command, quick, tmp_path):
    (tmp_path / "file").write_text("mine", encoding="utf-8")
    for out in (tmp_path / "file", tmp_path / "file" / "below"):
        command("replay", "still", *quick, "--out", out).refused(str(out), "choose a folder")
    assert (tmp_path / "file").read_text(encoding="utf-8") == "mine"


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


@pytest.mark.parametrize("options", [[], ["--video", "--seconds", "3"]])
def test_a_disk_that_fills_up(options, command, quick, tiny_disk):
    """The page alone is larger than what is left.

    With --video the disk may be full before the loop is through.
    """
    (tiny_disk / "filler").write_bytes(bytes(200 * 1024))
    (tiny_disk / "summary.json").write_text('{"hmdwarp": "0"}', encoding="utf-8")
    command("replay", "walk", *quick, *options, "--out", tiny_disk).refused(str(tiny_disk), "No space left", status=3)
    assert sorted(p.name for p in tiny_disk.iterdir()) == ["filler", "summary.json"]


# --- the machine


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


# --- what a file names


def test_a_scene_that_names_a_device_or_a_file_elsewhere(command, tmp_path, monkeypatch):
    monkeypatch.setenv("HMDWARP_ALLOW_OUTSIDE", "")  # given back after the test
    scene = tmp_path / "scene" / "scene.gltf"
    scene.parent.mkdir()
    for name, says in (("/dev/zero", "is a device"), ("/etc/passwd", "lies outside"), ("../there.bin", "lies outside")):
        (tmp_path / "there.bin").write_bytes(bytes(36))
        scene.write_text(json.dumps({"asset": {"version": "2.0"}, "buffers": [{"uri": name, "byteLength": 36}]}))
        command("plan", "--scene", scene).refused(name, says)
    command("plan", "--scene", scene, "--allow-outside").refused("no triangles")  # it is read
