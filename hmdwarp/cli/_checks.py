"""Checks of this machine: what the program needs, what is missing, and how to get it.

Replay needs Python's packages and OpenGL 4.3; everything else is optional: a headset or a desktop
window for `live`, an encoder for `--video`. Drivers and runtimes may crash or hang, so each is
queried in a process of its own:

    python -m hmdwarp.cli._checks gl|devices|openxr|window

It prints one JSON object per line as knowledge grows; the last whole line counts, so a crash still
leaves what came before it.
"""

from __future__ import annotations

import importlib.metadata
import json
import os
import platform
import re
import subprocess
import sys
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from typing import Any

import attrs

from ..base import HmdwarpError, __version__, install_line
from ..display.openxr.diagnosis import A_BINDING, INSTALL, RESTART, load_binding
from ..gpu import HOW_TO_GET_GL, WANTED, Gpu, egl

_PROBE_SECONDS = 30.0  # a cold runtime may start its whole compositor before it answers
# Missing: replay cannot run without it. Optional: absent, and only some commands need it.
OK, MISSING, OPTIONAL = "ok", "missing", "optional"
Facts = Mapping[str, Any]  # of a probe, `error` is set where something is missing


@attrs.frozen
class Finding:
    """One line of the examination."""

    name: str
    state: str
    detail: str
    remedy: str = ""  # what to do; empty where nothing is needed
    facts: Facts = attrs.field(factory=dict)  # numbers for --json


def examine() -> list[Finding]:
    """Check everything, drivers side by side; takes up to half a minute if one hangs."""
    with ThreadPoolExecutor() as pool:
        gl, devices, openxr, window = pool.map(run_probe, ("gl", "devices", "openxr", "window"))
    installed = importlib.metadata.distributions(name="hmdwarp")
    names = {name for each in installed for name in each.metadata.get_all("Provides-Extra", ())} - {"test", "docs"}
    extras = [found for name in sorted(names) if (found := _packages(f"extra {name}", name)) is not None]
    machine = {"version": platform.python_version(), "cpu_count": os.cpu_count()}
    about = f"{machine['version']} on {platform.system()} {platform.machine()}, {machine['cpu_count']} processors"
    packages = _packages("packages") or Finding(
        "packages", OPTIONAL, "hmdwarp runs from a folder, not installed: its packages were not checked", "make setup"
    )
    python = Finding("Python", OK, about, facts=machine)
    return [python, packages, _opengl(gl), _devices(devices), _openxr(openxr), _window(window), *extras]


def run_probe(question: str, seconds: float = _PROBE_SECONDS) -> Facts:
    """Return the last words of a probe, with `error` where it crashed or hung."""
    # -P: a numpy.py in the user's folder must not be taken for the real one.
    command = [sys.executable, "-P", "-m", "hmdwarp.cli._checks", question]
    try:
        done = subprocess.run(command, check=False, stdin=subprocess.DEVNULL, capture_output=True, timeout=seconds)
        stdout, stderr = done.stdout, done.stderr
        failure = f"ended with status {done.returncode}" if done.returncode else ""
    except subprocess.TimeoutExpired as expired:
        stdout, stderr = expired.stdout or b"", expired.stderr or b""
        failure = f"gave no answer within {seconds:g} s"
    known: dict[str, Any] = {}
    for line in stdout.decode(errors="replace").splitlines():
        try:
            value = json.loads(line)
        except ValueError:  # the line that a crash cut off, or a driver's own chatter
            continue
        known = value if isinstance(value, dict) else known
    if failure or not known:
        output = stderr.decode(errors="replace").strip().splitlines()
        message = f"{failure or 'said nothing'}{f' ({output[-1]})' if output else ''}"
        return {**known, "error": "died", "message": message}
    return known


def _reason(known: Facts) -> str:
    return " ".join(str(known.get("message", known.get("error")) or "no reason given").split())


def _packages(title: str, extra: str = "") -> Finding | None:
    """Look at what the installed hmdwarp declares: its packages, or those of an extra."""
    try:
        declared = importlib.metadata.requires("hmdwarp") or []
    except importlib.metadata.PackageNotFoundError:
        return None
    wanted = rf"extra == ['\"]{extra}['\"]" if extra else "^((?!extra ==).)*$"
    versions, absent = {}, []
    for name in sorted(re.split(r"[^\w.-]", line)[0] for line in declared if re.search(wanted, line)):
        try:
            versions[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            absent.append(name)
    if absent:
        remedy = install_line(extra) if extra else f"pip install {' '.join(absent)}"
        return Finding(title, OPTIONAL if extra else MISSING, f"not installed: {', '.join(absent)}", remedy, versions)
    named = ", ".join(f"{name} {version}" for name, version in versions.items())
    return Finding(title, OK, named if extra else f"hmdwarp {__version__}; {named}", facts=versions)


def _opengl(known: Facts) -> Finding:
    if "error" in known:
        reason, remedy = _reason(known).removesuffix(f": {HOW_TO_GET_GL}"), HOW_TO_GET_GL.split(";")[0]
        if egl.VARIABLE in reason:
            remedy = f"unset {egl.VARIABLE}, or name one of those"
        return Finding("OpenGL", MISSING, reason, remedy, known)
    clocks = {"gpu": "GPU timer queries", "wall": "wall clock, as this driver's GPU timers are unusable"}
    detail = (
        f"{known['renderer']}, {known['version']} ({'software, on the CPU' if known['software'] else 'hardware'}); "
        f"textures up to {known['max_texture_size']} px a side; timers: {clocks[known['clock']]}"
    )
    return Finding("OpenGL", OK, detail, facts=known)


def _devices(known: Facts) -> Finding:
    """List the devices that EGL knows, of which HMDWARP_EGL_DEVICE chooses one."""
    listed = [f"{device['index']}: {device['renderer']}" for device in known.get("devices", [])]
    if "error" in known:
        return Finding("EGL devices", OPTIONAL, "; ".join([*listed, _reason(known)]), facts=known)
    wanted = os.environ.get(egl.VARIABLE, "").strip()
    chosen = f"{egl.VARIABLE}={wanted}" if wanted else f"the first that works is used; {egl.VARIABLE} chooses another"
    return Finding("EGL devices", OK, f"{'; '.join(listed) or 'none'} ({chosen})", facts=known)


def _openxr(known: Facts) -> Finding:
    if "error" not in known:
        loader = f"loader {known['loader']} of pyopenxr {known['binding']}"
        detail = f"{known['runtime']} {known['runtime_version']}, headset '{known['headset']}', {loader}"
        return Finding("OpenXR", OK, detail, facts=known)
    if known["error"] == "died":
        during, remedy = (f"in {known['call']}", RESTART) if "call" in known else ("as it was loaded", A_BINDING)
        return Finding("OpenXR", OPTIONAL, f"{_reason(known)} {during}", remedy, known)
    return Finding("OpenXR", OPTIONAL, _reason(known), facts=known)  # with its remedy


def _window(known: Facts) -> Finding:
    if "error" in known:
        remedy = f"run it in a desktop session, or with xvfb-run -a before the command ({INSTALL} xvfb)"
        return Finding("desktop window", OPTIONAL, _reason(known), remedy, known)
    size = "{}x{} at {} Hz".format(*known["size"], known["refresh_hz"] or "?") if known["size"] else "no monitor"
    return Finding("desktop window", OK, f"OpenGL 4.3 window opens, screen {size}", facts=known)


def _report(known: Mapping[str, object]) -> None:
    print(json.dumps(known), flush=True)


def _probe_gl() -> None:
    """Report the OpenGL context that replay would use: renderer, limits, timers that measure."""
    try:
        with Gpu() as gpu:
            about = {"renderer": gpu.renderer, "version": gpu.version, "software": gpu.is_software}
            _report(about | {"clock": gpu.timer.clock, "max_texture_size": gpu.gl.info["GL_MAX_TEXTURE_SIZE"]})
    except HmdwarpError as error:
        _report({"error": str(error)})


def _probe_devices() -> None:
    """Report the devices that EGL knows, one after the other, with what draws on each."""
    known: list[dict[str, object]] = []
    for index, device in enumerate(egl.devices()):
        known.append({"index": index, "renderer": egl.renderer_of(device, WANTED)})
        _report({"devices": known})


def _probe_openxr() -> None:
    """Report the runtime and its headset as live finds them, or what is missing."""
    known: dict[str, object] = {}

    def watching(call: str) -> AbstractContextManager[None]:
        _report(known | {"call": call})
        return nullcontext()

    try:
        load_binding()
        import xr

        from ..display.openxr.runtime import Calls, open_instance

        known |= {"binding": str(xr.PYOPENXR_VERSION), "loader": str(xr.version.XR_CURRENT_API_VERSION)}
        instance = open_instance(Calls(watching))
        _report(known | instance.about)
        instance.destroy()
    except HmdwarpError as error:
        _report(known | {"error": str(error)})


def _probe_window() -> None:
    """Report whether a desktop window with OpenGL 4.3 opens; it stays hidden."""
    from ..display.desktop.window import hidden_window
    from ..display.desktop.window_system import start

    try:
        glfw = start()
        hidden_window(glfw, "hmdwarp doctor", (64, 64))
    except HmdwarpError as error:
        _report({"error": str(error).partition(";")[0]})
        return
    mode = glfw.get_video_mode(monitor) if (monitor := glfw.get_primary_monitor()) else None
    _report({"size": list(mode.size) if mode else None, "refresh_hz": mode.refresh_rate if mode else None})


if __name__ == "__main__":
    globals()[f"_probe_{sys.argv[1]}"]()
