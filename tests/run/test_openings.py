"""Which display a run gets.

The real loader with runtimes that are not there, and no screen or a virtual one.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import needs
import pytest
from display.virtual_screen import VirtualScreen

from hmdwarp.base import MachineError
from hmdwarp.display import desktop
from hmdwarp.pipeline import source_of
from hmdwarp.run import LiveOptions, open_display

ROOT = Path(__file__).resolve().parents[2]
PATIENCE_S = 120


def opened(**options):
    said: list[str] = []
    asked = LiveOptions(**options)
    return open_display(asked, source_of(asked), lambda what: nullcontext(), said.append), said


@pytest.fixture(autouse=True)
def no_screen(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)


MANIFESTS = {
    "nowhere": (None, "no such file"),
    "no json": ("{", "which is no runtime manifest"),
    "another json": ('{"file_format_version": "1.0.0"}', "which is no runtime manifest"),
    "a library that is not there": (
        json.dumps({"file_format_version": "1.0.0", "runtime": {"library_path": "./libnowhere.so"}}),
        "library ./libnowhere.so",
    ),
    "a library that is no runtime": (
        json.dumps({"file_format_version": "1.0.0", "runtime": {"library_path": "libm.so.6"}}),
        "library libm.so.6",
    ),
}


@pytest.mark.parametrize("case", MANIFESTS)
def test_why_there_is_no_headset_and_no_window_is_told(case, monkeypatch, tmp_path):
    text, told = MANIFESTS[case]
    path = tmp_path / "runtime.json"
    if text is not None:
        path.write_text(text, encoding="utf-8")
    monkeypatch.setenv("XR_RUNTIME_JSON", str(path))
    no_window = "and no window: neither DISPLAY nor WAYLAND_DISPLAY is set"
    for source, begins, more, ends in (
        ("openxr", "", "", "--source desktop"),
        ("auto", "neither headset nor window: ", no_window, "or show it nowhere: --source offscreen"),
    ):
        with pytest.raises(MachineError) as caught:
            opened(source=source)
        said = str(caught.value)
        assert said.startswith(f"{begins}no OpenXR runtime: XR_RUNTIME_JSON names ") and said.endswith(ends)
        assert told in said and more in said and caught.value.exit_status == 3


def test_a_display_is_told_what_it_must_know(monkeypatch):
    monkeypatch.setattr(desktop, "DesktopDisplay", lambda wanted: wanted)
    inputs, _ = opened(
        source="desktop", headset="cardboard-v2", view="flat", size=(96, 120), full_screen=True, vsync=False,
        panel=False, depth_layer=False,
    )  # fmt: skip
    assert (inputs.headset, inputs.view, inputs.size) == ("cardboard-v2", "flat", (96, 120))
    assert (inputs.full_screen, inputs.vsync, inputs.control_panel, inputs.depth_layer) == (True, False, False, False)


def live(*arguments: str, screen: bool, tmp_path: Path) -> subprocess.CompletedProcess[str]:
    """hmdwarp live as a program, without any runtime, before a virtual screen or without any."""
    kept = tmp_path / "screen"
    kept.mkdir()
    with VirtualScreen(kept) if screen else nullcontext() as shown:
        environment = shown.environment if shown is not None else os.environ
        environment = {**environment, "PYTHONPATH": str(ROOT), "XR_RUNTIME_JSON": str(tmp_path / "nowhere.json")}
        command = [sys.executable, "-m", "hmdwarp", "live", *arguments]
        return subprocess.run(
            command, check=False, capture_output=True, text=True, env=environment, cwd=tmp_path, timeout=PATIENCE_S
        )


def test_the_program_ends_with_3_and_one_line(tmp_path):
    """The loader's own five lines are not to be seen."""
    done = live("--quiet", screen=False, tmp_path=tmp_path)
    assert done.returncode == 3
    assert done.stderr.count("\n") == 1
    assert "no OpenXR runtime" in done.stderr and "no window" in done.stderr and "xvfb-run" in done.stderr


@needs.programs("Xvfb")
def test_without_a_headset_the_window_is_taken_and_why_is_said(tmp_path):
    done = live(
        "--scene", "planes", "--size", "96x120", "--latency", "0", "--pictures", "2", screen=True, tmp_path=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr.startswith("a window, as there is no headset: no OpenXR runtime: XR_RUNTIME_JSON names ")
