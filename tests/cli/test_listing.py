"""hmdwarp list, plan, --help and --version.

What there is, told so that people and programs can read it.
"""

from __future__ import annotations

import functools
import json
import re
import subprocess
import sys

import pytest
import typer

from hmdwarp.base import __version__, recording_names
from hmdwarp.cli import catalogue
from hmdwarp.cli._app import app, options_of_commands
from hmdwarp.cli.catalogue import KINDS, entries
from hmdwarp.client.effects import effects
from hmdwarp.client.fills import fills
from hmdwarp.client.lens import lenses
from hmdwarp.client.strategies import strategies
from hmdwarp.client.warps import warps
from hmdwarp.experiments.bench.cases import baselines
from hmdwarp.frames.layers import layers
from hmdwarp.run.measuring import OUTSIDE, missing

from .conftest import ROOT

COMMANDS = ["", "replay", "warp", "list", "plan", "doctor", "trace", "trace info", "trace convert", "headset show"]
HEAVY = {
    *("scipy", "moderngl", "trimesh", "matplotlib", "skimage", "av", "flip_evaluator"),
    *("xr", "glfw", "PIL", "jinja2", "numpy", "rich"),
}

commands = options_of_commands()


@pytest.fixture(autouse=True)
def eighty_columns(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")


@pytest.mark.parametrize("name", commands)
def test_arguments_are_written_in_capitals_in_every_help(name, command):
    """typer puts them into brackets of its own, by its version."""
    usage, _, rest = command(*name.split(), "--help").done().out.partition("\n\n")
    shown = usage.partition("[OPTIONS]")[2]
    assert shown == shown.upper()
    arguments = [option.flag for option in commands[name] if option.positional]
    assert re.findall(r"[A-Z|]+", shown) == arguments
    assert all(f"\n  {argument} " in rest for argument in arguments)


@pytest.mark.parametrize("name", commands)
def test_help_names_every_option_and_help_all_explains_it(name, command):
    brief, short, whole = (command(*name.split(), how).done().out for how in ("--help", "-h", "--help-all"))
    assert short == brief and max(map(len, whole.splitlines())) <= 80
    for option in commands[name]:
        assert re.search(rf"(?<![\w-]){re.escape(option.flag)}\b(?!-)", brief), option.flag
        assert " ".join(option.help.split()[:2]) in " ".join(whole.split()), option.flag
    assert ("--help-all" in brief) == (brief != whole)


def test_list_alone_lists_its_kinds(command):
    out = command("list").done().out
    assert [line.split()[0] for line in out.splitlines() if line and line[0] != " "] == list(KINDS)
    assert json.loads(command("list", "--json").done().out) == [
        {"name": name, "summary": kind.summary} for name, kind in KINDS.items()
    ]


@pytest.mark.parametrize("kind", KINDS)
def test_each_list_is_for_people_in_80_columns_and_for_programs(kind, command, monkeypatch):
    monkeypatch.setattr(catalogue, "entries", functools.cache(entries))
    rows = json.loads(command("list", kind, "--json").done().out)
    assert rows == entries(kind) and all(row["name"] and row["summary"] for row in rows)
    assert all(isinstance(text, str) and text for row in rows for text in row.values())
    assert len({row["name"] for row in rows}) == len(rows)
    assert len({tuple(row) for row in rows}) == 1  # the same keys in all
    lines = command("list", kind).done().out.splitlines()
    assert max(map(len, lines)) <= 80 and not any(line.endswith(" ") for line in lines)
    told = " ".join(" ".join(lines).split())
    assert all(any(line.startswith(f"{row['name']} ") for line in lines) and row["summary"] in told for row in rows)
    table = command("list", kind, "--markdown").done().out.splitlines()
    assert {line.replace("\\|", "").count("|") for line in table} == {len(rows[0]) + 1}
    assert all(f"| `{row['name']}` |" in line for row, line in zip(rows, table[2:], strict=True))
    # Those with most to tell, which are the ones that could be too wide.
    for row in sorted(rows, key=lambda row: len(str(row)))[-6:]:
        out = command("list", kind, row["name"]).done().out
        told = " ".join(out.split())
        assert max(map(len, out.splitlines())) <= 80
        assert all(" ".join(text.split()) in told for text in row.values()), row
    assert json.loads(command("list", kind, row["name"], "--json").out) == [row]


def test_lists_hold_what_the_registries_hold(command):
    told = " ".join(command("replay", "--help").done().out.split())
    assert all(", ".join(sorted(each.names())) in told for each in (warps, fills, lenses, strategies))
    own = [row["name"] for row in json.loads(command("list", "warps", "--json").out) if row["does_as"] == "none"]
    assert own == warps.names()
    assert [row["name"] for row in json.loads(command("list", "recordings", "--json").out)] == recording_names()


def test_warps_hold_what_other_systems_do(command):
    """By the names that a bench takes, with the system; OpenCV's where it is installed."""
    rows = {row["name"]: row for row in entries("warps") if row["does_as"] != "none"}
    there = {name: system for name, system in baselines().items() if name not in OUTSIDE or not missing(name)}
    assert {name: row["does_as"] for name, row in rows.items()} == there
    assert rows["mesh:grid=64"]["summary"].startswith("as CloudXR.js: ")
    assert "grid=64" in rows["mesh:grid=64"]["settings"].split(", ")
    assert re.search("does as +CloudXR.js", command("list", "warps", "mesh:grid=64").done().out)


def test_layers_are_told_with_format_size_bytes_and_who_draws_and_codes_them(command):
    rows = {row["name"]: row for row in json.loads(command("list", "layers", "--json").out)}
    assert list(rows) == layers.names()
    cube = ["rgba16f", "its own", "168.6 MB for each eye of quest-3", "cube", "video"]
    assert [rows["cube"][key] for key in ("format", "size", "bytes", "drawn_by", "coded_as")] == cube
    assert rows["colour"]["carried"] == "once for each eye, always"
    assert rows["others"]["bytes"] == rows["others"]["size"] == "none"


def flags_of(one, name: str = "") -> dict[str, set[str]]:
    """Flags of each command and its groups' commands, as its parser has them."""
    if hasattr(one, "list_commands"):
        inner = {each: one.get_command(None, each) for each in one.list_commands(None)}
        return {k: v for each, sub in inner.items() for k, v in flags_of(sub, f"{name} {each}".strip()).items()}
    flags = {option.opts[0] for option in one.params if option.opts[0].startswith("-")}
    return {name: flags}


def test_options_are_those_of_every_command(command):
    """Of the study's commands too, and none is missing."""
    parsed = flags_of(typer.main.get_command(app))
    listed: dict[str, set[str]] = {name: set() for name in parsed}
    for row in json.loads(command("list", "options", "--json").out):
        for name in row["commands"].split(", "):
            listed[name] |= {row["flag"]} if row["flag"].startswith("-") else set()
    assert listed == parsed
    assert {"--participant", "--simulate", "--console"} <= listed["study run"]


def test_plan_tells_each_pass_with_its_reason_and_what_is_left_out(command):
    out = (
        command("plan", "--scene", "planes", "--warp", "backward", "--fill", "none", "--headset", "flat-90").done().out
    )
    told = " ".join(out.split())
    runs, left_out = told.split("Left out")
    assert "client_depth" in runs and "reads the client's own depth" in runs and "warp backward" in runs
    assert runs.index("client_depth") < runs.index("warp backward")
    assert "reads rendered.colour, rendered.inverse_depth, client.inverse_depth; writes shown.colour" in runs
    assert all(name in left_out for name in ("fill", "lens", *effects.names()))
    assert "fill 'none': " in left_out and "nothing in the scene calls for it" in left_out
    assert max(map(len, out.splitlines())) <= 80


def test_plan_for_programs_has_what_is_printed(command):
    asked = ("plan", "--scene", "planes", "--size", "640x400", "--rate", "90")
    data, told = json.loads(command(*asked, "--json").done().out), " ".join(command(*asked).done().out.split())
    keys = "scene indirect warp fill lens headset eyes passes left_out frame slow notes"
    assert list(data) == keys.split()
    assert all(list(pass_) == ["stage", "name", "reason", "reads", "writes"] for pass_ in data["passes"])
    assert data["passes"] and all(pass_["name"] in told and pass_["reason"] in told for pass_ in data["passes"])
    assert data["left_out"] and all(entry["name"] in told and entry["reason"] in told for entry in data["left_out"])
    frame = data["frame"]
    assert list(frame) == ["eyes", "size", "pixels", "fov_deg", "layers", "bytes", "at_once", "latency_ms", "rate_hz"]
    assert frame["bytes"] == sum(frame["layers"].values()) and f"{frame['bytes'] / 1e6:.1f} MB uncompressed" in told
    assert f"at most {frame['at_once']} of them at 200 ms and 90 Hz" in told
    assert all(f"{key.replace('_', ' ')} {text}" in told for key, text in data["eyes"].items())


def test_plan_corrects_the_lens_of_the_headset(command):
    told = command("plan", "--scene", "planes", "--fill", "none").done().out
    assert "Eyes of quest-3" in told and "lens radial" not in told
    assert "lens radial" in command("plan", "--scene", "planes", "--fill", "none", "--headset", "rift-dk1").done().out


def test_plan_tells_what_is_slow_in_a_scene(command, monkeypatch):
    monkeypatch.setattr("hmdwarp.scenes.slow_in", lambda scene: ("20,480 transparent triangles: simplify them",))
    told = " ".join(command("plan", "--scene", "planes").done().out.split())
    assert "Slow 20,480 transparent triangles: simplify them" in told


def test_plan_counts_bytes_and_frames(command):
    """640x400 of 8 bytes of colour and 4 of depth, two eyes.

    6.144 MB; 200 ms at 90 Hz are 18 refreshes, and 2; two more are averaged.
    """
    usual = ("--scene", "planes", "--size", "640x400", "--guard", "1")
    told = " ".join(command("plan", *usual, "--rate", "90").done().out.split())
    assert "6.1 MB" in told and "at most 22 of them at 200 ms and 90 Hz" in told
    only_colour = " ".join(command("plan", *usual, "--warp", "rotation").done().out.split())
    assert "4.1 MB" in only_colour


def test_plan_starts_no_gl():
    code = "import sys; sys.argv = ['hmdwarp', 'plan', '--scene', 'planes']\nfrom hmdwarp.gpu import context\n"
    code += "def refuse(): raise SystemExit('started')\ncontext.create_context = refuse\n"
    code += "from hmdwarp.cli import main; main()"
    done = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True, cwd=ROOT)
    assert (done.returncode, done.stderr) == (0, "")


def test_version(command):
    # A clone has a commit, a copy of the files has none.
    pattern = rf"hmdwarp {re.escape(__version__)}( [0-9a-f]{{12}}\+?)?\n"
    assert re.fullmatch(pattern, command("--version").done().out)


def test_without_a_command_there_is_help(command):
    done = command()
    assert "Usage: hmdwarp" in done.out and "replay" in done.out and done.err == ""


def test_help_loads_nothing_heavy():
    code = f"import sys\nfrom hmdwarp.cli import main\nfor arguments in {COMMANDS!r}:\n"
    code += "    sys.argv = ['hmdwarp', *arguments.split(), '--help']\n"
    code += "    try: main()\n    except SystemExit: pass\n"
    code += "print('LOADED', *{name.partition('.')[0] for name in sys.modules})"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, cwd=ROOT)
    loaded = set(done.stdout.rpartition("LOADED")[2].split())
    assert "typer" in loaded
    assert loaded & HEAVY == set()


def test_options_of_one_meaning_have_one_name():
    names = {row["name"] for row in entries("options")}
    assert {"trace-rate", "metrics-every", "force", "guard"} <= names
    assert not {"recording", "every", "trace info rate"} & names
