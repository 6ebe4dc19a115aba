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
from hmdwarp.cli._checks import MISSING, OK, OPTIONAL, Finding
from hmdwarp.cli.catalogue import doctor as command
from hmdwarp.resources import EXTRAS


@pytest.fixture
def probe(tmp_path, monkeypatch):
    """Makes every probe a shell script of the test's choosing."""

    def use(script: str) -> None:
        path = tmp_path / "python"
        path.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setattr(doctor.sys, "executable", str(path))

    return use


def looked(*names: str, **known) -> list[Finding]:
    """What the checks of these names find, where each probe answers that."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(doctor, "CHECKS", [check for check in doctor.CHECKS if check.name in names])
        if known:
            patch.setattr(doctor, "run_probe", lambda question: known)
        return doctor.examine()


def live(*findings: Finding) -> Finding:
    """What is told of live after these findings."""
    with pytest.MonkeyPatch.context() as patch:
        (check,) = (check for check in doctor.CHECKS if check.name == "live")
        known = [doctor.Check(found.name, lambda ask, _, found=found: told(found)) for found in findings]
        patch.setattr(doctor, "CHECKS", [*known, check])
        patch.setattr(doctor, "run_probe", lambda question: {})
        return doctor.examine()[-1]


def told(found: Finding):
    if found.state != OK:
        raise doctor.Lack(found.detail)
    return found.detail, {}


# --- asking -------------------------------------------------------------------------------------


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


# --- OpenXR -------------------------------------------------------------------------------------

OPENXR = ("OpenXR loader", "OpenXR runtime")
AT = {"binding": "1.1", "loader": "1.1.0"}
NAMED = {**AT, "runtime": "Runtime", "runtime_version": "25.0.0"}
NAMED |= {"extensions": ["XR_KHR_opengl_enable", "XR_KHR_convert_timespec_time"]}


@pytest.mark.parametrize(
    ("known", "stage", "error", "message", "words"),
    [
        (AT, "runtime", "RuntimeUnavailableError", "", "no OpenXR runtime: "),
        (AT, "instance", "RuntimeUnavailableError", "", "no OpenXR runtime: "),
        (AT, "instance", "RuntimeFailureError", "", "service does not answer"),
        (AT, "instance", "died", "gave no answer", "gave no answer when an instance was made"),
        (NAMED, "headset", "FormFactorUnavailableError", "", "Runtime 25.0.0 sees no headset"),
        (NAMED, "headset", "FormFactorUnsupportedError", "", "Runtime 25.0.0 sees no headset"),
        (NAMED, "headset", "died", "ended with status -11", "status -11 when asked for a headset"),
        (NAMED, "headset", "OutOfMemoryError", "no\nmemory", "OutOfMemoryError: no memory"),
        ({"extensions": ["XR_KHR_convert_timespec_time"]}, "done", "", "", "lacks XR_KHR_opengl_enable or"),
        ({"extensions": ["XR_MNDX_egl_enable"]}, "done", "", "", "lacks XR_KHR_convert_timespec_time"),
    ],
)
def test_each_openxr_lack_is_told_apart(known, stage, error, message, words):
    failed = {"error": error, "message": message} if error else {**NAMED, "headset": "H"}
    loader, runtime = looked(*OPENXR, **{**failed, **known, "stage": stage})
    assert loader.state == OK
    assert runtime.state == OPTIONAL  # never what keeps replay from running
    assert words in runtime.detail
    assert runtime.remedy


@pytest.mark.parametrize(
    "known",
    [
        {"stage": "binding", "error": "AttributeError: 'NoneType' object has no attribute 'glXGetCurrentContext'"},
        {"stage": "binding", "error": "died", "message": "ended with status -6"},
        {"stage": "start", "error": "died", "message": "said nothing"},
    ],
)
def test_openxr_binding_that_does_not_load(known):
    (loader,) = looked(*OPENXR, **known)
    assert loader.state == OPTIONAL and "libgl1" in loader.remedy


# --- live ---------------------------------------------------------------------------------------

HEADSET = [Finding("OpenXR loader", OK, "there"), Finding("OpenXR runtime", OK, "Runtime 1, headset 'H'")]
NO_LOADER = [Finding("OpenXR loader", OPTIONAL, "no libGL", "get it")]
NO_RUNTIME = [HEADSET[0], Finding("OpenXR runtime", OPTIONAL, "its service is down", "start it")]
WINDOW, NO_WINDOW = (Finding("desktop window", OK, "opens"), Finding("desktop window", OPTIONAL, "no display", "xvfb"))


@pytest.mark.parametrize(("headset", "why"), [(NO_LOADER, "no libGL"), (NO_RUNTIME, "its service is down")])
def test_live_takes_the_window_else_and_says_why(headset, why):
    finding = live(*headset, WINDOW)
    assert (finding.state, finding.facts["source"]) == (OK, "desktop")
    assert why in finding.detail
    nothing = live(*headset, NO_WINDOW)
    assert (nothing.state, nothing.facts["source"]) == (OPTIONAL, None)  # replay can run all the same
    assert why in nothing.detail and "no display" in nothing.detail and nothing.remedy


def test_the_doctor_says_what_live_would_take(monkeypatch):
    """On this machine, with no runtime and no screen: asked for real."""
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("XR_RUNTIME_JSON", "nowhere.json")
    found = {finding.name: finding for finding in doctor.examine()}
    assert found["live"].facts["source"] is None
    assert found["live"].detail.startswith(
        "no display: no headset (no OpenXR runtime: XR_RUNTIME_JSON names nowhere.json"
    )


# --- the rest, and the command ------------------------------------------------------------------


def run(*options: str):
    app = typer.Typer()
    app.command()(command)
    return CliRunner().invoke(app, list(options))


@pytest.mark.parametrize("display", ["", ":987"])
def test_no_display_or_one_that_is_not_there(display, monkeypatch):
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setenv("DISPLAY", display)
    (finding,) = looked("desktop window")
    assert finding.state == OPTIONAL and "xvfb" in finding.remedy


def test_missing_package_is_named(monkeypatch):
    declared = ["typer>=0.1", "no-such.package-xyz>=2", 'pytest; extra == "test"']
    monkeypatch.setattr(doctor.importlib.metadata, "requires", lambda name: declared)
    (finding,) = looked("packages", error="")
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
    assert facts["max_work_group_invocations"] >= 1024  # what OpenGL 4.3 promises


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


def test_every_extra_says_what_it_is_for():
    """Those for work on hmdwarp itself are no user's."""
    assert set(EXTRAS) == set(DECLARED) - {"test", "docs"}


def extras() -> list[Finding]:
    return looked(*(f"extra {name}" for name in EXTRAS), error="")


def test_a_missing_extra_is_reported_with_its_use(monkeypatch):
    there = {"pyarrow": "26.0.1"}

    def version(name: str) -> str:
        if name not in there:
            raise doctor.importlib.metadata.PackageNotFoundError(name)
        return there[name]

    monkeypatch.setattr(doctor.importlib.metadata, "version", version)
    found = {extra.name: extra for extra in extras()}
    assert list(found) == [f"extra {name}" for name in EXTRAS]
    study = found["extra study"]
    assert study.state == OPTIONAL and ".[study]" in study.remedy
    assert "statsmodels" in study.detail and "pyarrow" not in study.detail
    assert EXTRAS["study"] in study.detail
    there.update({re.split(r"[^\w.-]", line)[0]: "1.0" for line in DECLARED["study"]})
    states = {extra.name: extra.state for extra in extras()}
    assert states["extra study"] == OK and states["extra feed"] == OPTIONAL


def test_a_folder_that_is_not_installed_is_no_lack_of_replay(monkeypatch):
    def requires(name: str) -> list[str]:
        raise doctor.importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(doctor.importlib.metadata, "requires", requires)
    (found,) = looked("packages", error="")
    assert found.state == OPTIONAL and "not installed" in found.detail and found.remedy == "make setup"
    assert extras() == []


def test_drivers_are_asked_at_the_same_time(probe, monkeypatch):
    """Each probe waits until all three have begun: one after the other they would wait for ever."""
    monkeypatch.setenv("DISPLAY", ":0")
    answer = '{"stage": "binding", "error": "seen", "message": "together"}'
    probe(f"""touch "$0.$4"; while [ "$(ls "$0".* | wc -l)" -lt 3 ]; do sleep 0.05; done; echo '{answer}'""")
    found = {finding.name: finding.detail for finding in doctor.examine()}
    assert [found[name] for name in ("OpenGL", "OpenXR loader", "desktop window")] == ["together"] * 3


# --- devices ------------------------------------------------------------------------------------


def test_the_devices_are_listed_with_what_draws_on_each():
    (found,) = looked("EGL devices")
    if found.state == OPTIONAL:
        pytest.skip(f"EGL lists no devices here: {found.detail}")
    assert found.detail.startswith("0: ") and "HMDWARP_EGL_DEVICE chooses another" in found.detail
    assert [device["index"] for device in found.facts["devices"]] == list(range(len(found.facts["devices"])))


def test_a_device_that_crashes_is_named_after_those_that_did_not():
    good = {"index": 0, "file": "/dev/dri/card0", "renderer": "Some GPU"}
    known = {"stage": "device 1", "devices": [good], "error": "died", "message": "ended with status -11"}
    (found,) = looked("EGL devices", **known)
    assert found.state == OPTIONAL
    assert found.detail == "0: Some GPU at /dev/dri/card0; ended with status -11, at device 1"


def test_a_device_that_is_not_there_is_told_with_the_list(monkeypatch):
    monkeypatch.setenv("HMDWARP_EGL_DEVICE", "99")
    (found,) = looked("OpenGL")
    assert found.state == MISSING
    assert "HMDWARP_EGL_DEVICE=99 names no device here, expected one of 0: " in found.detail
    assert found.remedy.startswith("unset HMDWARP_EGL_DEVICE")
