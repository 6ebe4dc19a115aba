"""The doctor tells each kind of lack apart, says how to mend it, and outlives drivers that crash or
hang.
"""

from __future__ import annotations

import json
import re
import stat
import tomllib
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from hmdwarp.cli import _checks as doctor
from hmdwarp.cli._checks import MISSING, OK, OPTIONAL
from hmdwarp.cli.catalogue import doctor as command


@pytest.fixture
def probe(tmp_path, monkeypatch):
    """Makes every probe a shell script of the test's choosing."""

    def use(script: str) -> None:
        path = tmp_path / "python"
        path.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setattr(doctor.sys, "executable", str(path))

    return use


@pytest.mark.parametrize(
    ("script", "stage", "error", "words"),
    [
        ("""echo 'driver says hello'; echo '{"stage": "a"}'; echo '{"stage": "b"}'; printf '{"sta'""", "b", None, ()),
        (
            """echo '{"stage": "instance"}'; echo 'assertion failed' >&2; kill -SEGV $$""",
            *("instance", "died", ("status -11", "assertion failed")),
        ),
        ("""echo '{"stage": "headset"}'; exec sleep 600""", "headset", "died", ("no answer within 1 s",)),
    ],
    ids=["last whole line", "crash", "hang"],
)
def test_what_was_known_is_kept_with_the_last_words(probe, script, stage, error, words):
    probe(script)
    known = doctor.run_probe("openxr", seconds=1.0 if "sleep" in script else 60.0)
    assert (known["stage"], known.get("error")) == (stage, error)
    assert all(word in known["message"] for word in words)


DIED = {"error": "died", "message": "ended with status -11"}


@pytest.mark.parametrize(
    ("known", "words", "remedy"),
    [
        ({"error": "no OpenXR runtime: start one"}, "no OpenXR runtime: start one", ""),
        ({"call": "xrCreateInstance", **DIED}, "status -11 in xrCreateInstance", "restart, the runtime's service"),
        (DIED, "status -11 as it was loaded", "libgl1"),
    ],
)
def test_openxr_is_optional_and_a_crash_says_in_which_call(known, words, remedy):
    """What keeps it from working is said as live says it: display/test_openxr_diagnosis.py."""
    found = doctor._openxr(known)
    assert found.state == OPTIONAL and words in found.detail and remedy in found.remedy
    there = {"binding": "1.1", "loader": "1.1.0", "runtime": "R", "runtime_version": "25.0.0", "headset": "H"}
    found = doctor._openxr(there | {"call": "xrGetSystemProperties"})
    assert (found.state, found.remedy) == (OK, "") and "R 25.0.0, headset 'H'" in found.detail


def run(*options: str):
    app = typer.Typer()
    app.command()(command)
    return CliRunner().invoke(app, list(options))


@pytest.mark.parametrize("display", ["", ":987"])
def test_no_display_or_one_that_is_not_there_and_no_runtime(display, monkeypatch):
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.setenv("XR_RUNTIME_JSON", "nowhere.json")
    window, openxr = doctor._window(doctor.run_probe("window")), doctor._openxr(doctor.run_probe("openxr"))
    assert window.state == OPTIONAL and "xvfb" in window.remedy
    assert openxr.detail.startswith("no OpenXR runtime: XR_RUNTIME_JSON names nowhere.json")


def test_missing_package_is_named(monkeypatch):
    declared = ["typer>=0.1", "no-such.package-xyz>=2", 'pytest; extra == "test"']
    monkeypatch.setattr(doctor.importlib.metadata, "requires", lambda name: declared)
    finding = doctor._packages("packages")
    assert finding.state == MISSING
    assert finding.detail == "not installed: no-such.package-xyz"
    assert "typer" in finding.facts and "pytest" not in finding.facts


def test_this_machine_can_replay(gpu):
    done = run("--json")
    assert done.exit_code == 0, done.output
    told = json.loads(done.output)
    assert told["replay"] is True
    facts = next(f for f in told["findings"] if f["name"] == "OpenGL")["facts"]
    assert facts["renderer"] == gpu.renderer
    assert facts["max_texture_size"] == gpu.max_texture_size


def test_old_opengl_ends_with_3_and_the_line_to_type(monkeypatch):
    """Mesa pretends to know OpenGL 3.0 only."""
    monkeypatch.setenv("MESA_GL_VERSION_OVERRIDE", "3.0")
    if "error" not in doctor.run_probe("gl"):
        pytest.skip("this driver does not heed MESA_GL_VERSION_OVERRIDE")
    done = run()
    assert done.exit_code == 3
    assert "missing   OpenGL" in done.output
    assert "sudo apt-get install libegl1 libgl1 libgl1-mesa-dri" in done.output
    assert "cannot run here" in done.output


PROJECT = tomllib.loads((Path(__file__).resolve().parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
DECLARED = PROJECT["optional-dependencies"]


def test_a_missing_extra_is_reported(monkeypatch):
    there = {"pyarrow": "26.0.1"}

    def version(name: str) -> str:
        if name not in there:
            raise doctor.importlib.metadata.PackageNotFoundError(name)
        return there[name]

    monkeypatch.setattr(doctor.importlib.metadata, "version", version)
    study = doctor._packages("extra study", "study")
    assert study.state == OPTIONAL and ".[study]" in study.remedy
    assert "statsmodels" in study.detail and "pyarrow" not in study.detail
    there.update({re.split(r"[^\w.-]", line)[0]: "1.0" for line in DECLARED["study"]})
    assert [doctor._packages("", extra).state for extra in ("study", "feed")] == [OK, OPTIONAL]


def test_drivers_are_asked_at_the_same_time_and_a_folder_may_not_be_installed(probe, monkeypatch):
    """Each probe waits until all have begun: one after the other they would wait for ever."""

    def requires(name: str) -> list[str]:
        raise doctor.importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(doctor.importlib.metadata, "requires", requires)
    answer = '{"error": "seen", "message": "together"}'
    probe(f"""touch "$0.$4"; while [ "$(ls "$0".* | wc -l)" -lt 4 ]; do sleep 0.05; done; echo '{answer}'""")
    found = {finding.name: finding for finding in doctor.examine()}
    names = ("OpenGL", "EGL devices", "OpenXR", "desktop window")
    assert [found[name].detail for name in names] == ["together"] * 4
    assert set(found) == {"Python", "packages", *names}
    assert found["packages"].state == OPTIONAL and found["packages"].remedy == "make setup"


def test_the_devices_are_listed_with_what_draws_on_each():
    found = doctor._devices(doctor.run_probe("devices"))
    if found.state == OPTIONAL:
        pytest.skip(f"EGL lists no devices here: {found.detail}")
    assert found.detail.startswith("0: ") and "HMDWARP_EGL_DEVICE chooses another" in found.detail
    known = {"devices": [{"index": 0, "renderer": "Some GPU"}], **DIED}
    assert doctor._devices(known).detail == "0: Some GPU; ended with status -11"


def test_a_device_that_is_not_there_is_told_with_the_list(monkeypatch):
    monkeypatch.setenv("HMDWARP_EGL_DEVICE", "99")
    found = doctor._opengl(doctor.run_probe("gl"))
    assert found.state == MISSING
    assert "HMDWARP_EGL_DEVICE=99 names no device here, expected one of 0" in found.detail
    assert found.remedy.startswith("unset HMDWARP_EGL_DEVICE")
