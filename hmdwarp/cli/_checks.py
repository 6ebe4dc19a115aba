"""Checks of this machine: what the program needs, what is missing, and how to get it.

Replay needs Python's packages and OpenGL 4.3; everything else is optional: a headset or a desktop
window for `live`, an encoder for `--video`. Drivers and runtimes are queried in processes of their
own (see _probes), because they may crash or hang.
"""

from __future__ import annotations

import enum
import importlib.metadata
import json
import os
import platform
import re
import subprocess
import sys
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import attrs

from ..display.openxr import INSTALL, diagnose, manifest_text, missing_extensions
from ..gpu import egl
from ..gpu.context import HOW_TO_GET_GL
from ..resources import EXTRAS, __version__, install_line, pyav

Answer = dict[str, Any]  # the JSON object of a probe; `error` is set where something is missing

PROBE_SECONDS = 30.0  # a cold runtime may start its whole compositor before it answers


class State(enum.StrEnum):
    """OK: present.

    MISSING: replay cannot run without it. OPTIONAL: absent, and only some commands need it.
    """

    OK = "ok"
    MISSING = "missing"
    OPTIONAL = "optional"


@attrs.frozen
class Finding:
    """One line of the examination."""

    name: str
    state: State
    detail: str
    remedy: str = ""  # what to do; empty where nothing is needed
    facts: Mapping[str, object] = attrs.field(factory=dict)  # numbers for --json


def examine() -> list[Finding]:
    """Check everything; takes a second, and up to half a minute if a driver hangs.

    The processes that query drivers run at the same time.
    """
    with ThreadPoolExecutor() as asked:
        graphics, known = asked.submit(opengl), asked.submit(devices)
        runtime, screen = asked.submit(openxr), asked.submit(window)
        here = [python(), packages(), video(), codecs(), *extras()]
        headset, desktop = runtime.result(), screen.result()
    return [*here[:2], *graphics.result(), known.result(), *headset, desktop, live(headset, desktop), *here[2:]]


def replay_can_run(findings: list[Finding]) -> bool:
    """Return whether nothing that replay needs is missing."""
    return all(finding.state is not State.MISSING for finding in findings)


def run_probe(question: str, seconds: float = PROBE_SECONDS) -> Answer:
    """Return the last words of the probe `question` (gl, devices, openxr, window).

    `error` is set where it crashed, hung or printed nothing.
    """
    # -P: a numpy.py in the user's folder must not be taken for the real one.
    command = [sys.executable, "-P", "-m", "hmdwarp.cli._probes", question]
    try:
        done = subprocess.run(command, check=False, stdin=subprocess.DEVNULL, capture_output=True, timeout=seconds)
        stdout, stderr = done.stdout, done.stderr
        failure = f"ended with status {done.returncode}" if done.returncode else ""
    except subprocess.TimeoutExpired as expired:
        stdout, stderr = expired.stdout or b"", expired.stderr or b""
        failure = f"gave no answer within {seconds:g} s"
    known = _last_object(stdout.decode(errors="replace"))
    if failure or not known:
        output = stderr.decode(errors="replace").strip().splitlines()
        return {
            "stage": "start",
            **known,
            "error": "died",
            "message": f"{failure or 'said nothing'}{f' ({output[-1]})' if output else ''}",
        }
    return known


def _last_object(text: str) -> Answer:
    for line in reversed(text.splitlines()):
        try:
            value = json.loads(line)
        except ValueError:  # the line that a crash cut off, or a driver's own chatter
            continue
        if isinstance(value, dict):
            return value
    return {}


def python() -> Finding:
    """Check the interpreter and the machine it runs on."""
    detail = f"{platform.python_version()} on {platform.system()} {platform.machine()}, {os.cpu_count()} processors"
    return Finding(
        "Python", State.OK, detail, facts={"version": platform.python_version(), "cpu_count": os.cpu_count()}
    )


def packages() -> Finding:
    """Check the packages that the installed hmdwarp declares, with their versions."""
    try:
        declared = importlib.metadata.requires("hmdwarp") or []
    except importlib.metadata.PackageNotFoundError:
        return Finding(
            "packages",
            State.OPTIONAL,
            "hmdwarp runs from a folder, not installed: its packages were not checked",
            "make setup",
        )
    found, absent = _versions(line for line in declared if "extra ==" not in line)
    if absent:
        return Finding(
            "packages", State.MISSING, f"not installed: {', '.join(absent)}", f"pip install {' '.join(absent)}", found
        )
    return Finding("packages", State.OK, f"hmdwarp {__version__}; {_named(found)}", facts=found)


def opengl() -> list[Finding]:
    """Check that a context with compute shaders starts; report driver, limits and stage clock."""
    known = run_probe("gl")
    if "error" in known:
        reason = _one_line(known.get("message", known["error"])).removesuffix(f": {HOW_TO_GET_GL}")
        remedy = (
            f"unset {egl.VARIABLE}, or name one of those" if egl.VARIABLE in reason else HOW_TO_GET_GL.split(";")[0]
        )
        return [Finding("OpenGL", State.MISSING, reason, remedy, known)]
    detail = (
        f"{known['renderer']}, {known['version']} "
        f"({'software, on the CPU' if known['software'] else 'hardware'}); "
        f"textures up to {known['max_texture_size']} px a side, work groups up to "
        f"{known['max_work_group_invocations']}, "
        f"storage blocks up to {known['max_storage_block_bytes'] // 2**20} MiB, 64-bit atomics "
        f"{'yes' if known['atomic_int64'] else 'no'}"
    )
    timers = "GPU timer queries" if known["clock"] == "gpu" else "wall clock: this driver's GPU timers are unusable"
    return [
        Finding("OpenGL", State.OK, detail, facts=known),
        Finding("timers", State.OK, timers, facts={"clock": known["clock"]}),
    ]


def devices() -> Finding:
    """List the devices that EGL knows, of which HMDWARP_EGL_DEVICE chooses one."""
    known = run_probe("devices")
    listed = [
        f"{device['index']}: {device['renderer']}{' at ' + device['file'] if device['file'] else ''}"
        for device in known.get("devices", [])
    ]
    if "error" in known:
        at = f", at {known['stage']}" if known["stage"].startswith("device") else ""
        reason = _one_line(known.get("message", known["error"]))
        return Finding("EGL devices", State.OPTIONAL, "; ".join([*listed, f"{reason}{at}"]), facts=known)
    wanted = os.environ.get(egl.VARIABLE, "").strip()
    chosen = f"{egl.VARIABLE}={wanted}" if wanted else f"the first that works is used; {egl.VARIABLE} chooses another"
    return Finding("EGL devices", State.OK, f"{'; '.join(listed) or 'none'} ({chosen})", facts=known)


def openxr() -> list[Finding]:
    """Check loader and runtime, up to the headset; optional, replay needs none of them."""
    known = run_probe("openxr")
    if known["stage"] in ("start", "binding"):
        reason = _one_line(known.get("message", known.get("error")))
        _, remedy = diagnose("binding", known.get("error", "").partition(":")[0])
        return [Finding("OpenXR loader", State.OPTIONAL, reason, remedy, known)]
    loader = Finding(
        "OpenXR loader", State.OK, f"pyopenxr {known['binding']}, its own loader for OpenXR {known['loader']}"
    )
    return [loader, _runtime(known)]


def _runtime(known: Answer) -> Finding:
    parts = (known["runtime"], known["runtime_version"]) if "runtime" in known else ("the runtime", "")
    name = parts[0] if parts[1] in parts[0] else " ".join(parts)  # Monado's name says it
    detail, remedy = (
        _runtime_failure(name, known) if "error" in known else missing_extensions(name, known["extensions"])
    )
    if detail:
        return Finding("OpenXR runtime", State.OPTIONAL, detail, remedy, known)
    return Finding("OpenXR runtime", State.OK, f"{name}, headset '{known['headset']}'", facts=known)


def _runtime_failure(name: str, known: Answer) -> tuple[str, str]:
    return diagnose(known["stage"], known["error"], known.get("message"), name, manifest_text(os.environ))


def window() -> Finding:
    """Check that a desktop window opens; optional, replay needs none."""
    remedy = (
        f"run in a desktop session, or under a virtual one: {INSTALL} xvfb, then put xvfb-run -a before the command"
    )
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return Finding(
            "desktop window", State.OPTIONAL, "no display: neither DISPLAY nor WAYLAND_DISPLAY is set", remedy
        )
    known = run_probe("window")
    if "error" in known:
        return Finding("desktop window", State.OPTIONAL, _one_line(known.get("message", known["error"])), remedy, known)
    size = "{}x{} at {} Hz".format(*known["size"], known["refresh_hz"] or "?") if known["size"] else "no monitor"
    return Finding("desktop window", State.OK, f"OpenGL 4.3 window opens, screen {size}", facts=known)


def live(headset: list[Finding], desktop: Finding) -> Finding:
    """Report which display `hmdwarp live` takes by default: the headset, else the window."""
    lack = next((finding for finding in headset if finding.state is not State.OK), None)
    if lack is None:
        return Finding("live", State.OK, f"takes the headset: {headset[-1].detail}", facts={"source": "openxr"})
    if desktop.state is State.OK:
        return Finding(
            "live", State.OK, f"takes the window, as there is no headset: {lack.detail}", facts={"source": "desktop"}
        )
    why = f"no display: no headset ({lack.detail}), no window ({desktop.detail})"
    return Finding("live", State.OPTIONAL, why, "either remedy above makes one", {"source": None})


def extras() -> list[Finding]:
    """Check the optional packages, one finding for each extra; none if hmdwarp is not installed."""
    try:
        declared = importlib.metadata.requires("hmdwarp") or []
    except importlib.metadata.PackageNotFoundError:
        return []
    return [_extra(name, [line for line in declared if _is_of(line, name)]) for name in EXTRAS]


def _is_of(requirement: str, extra: str) -> bool:
    return re.search(rf"extra == ['\"]{extra}['\"]", requirement) is not None


def _extra(name: str, requirements: list[str]) -> Finding:
    found, absent = _versions(requirements)
    if absent:
        detail = f"not installed: {', '.join(absent)} (for {EXTRAS[name]})"
        return Finding(f"extra {name}", State.OPTIONAL, detail, install_line(name), found)
    return Finding(f"extra {name}", State.OK, _named(found), facts=found)


def _versions(requirements: Iterable[str]) -> tuple[dict[str, str], list[str]]:
    """Return the versions of the packages that are there, and the names of the others."""
    found, absent = {}, []
    for name in sorted(re.split(r"[^\w.-]", line)[0] for line in requirements):
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            absent.append(name)
    return found, absent


def _named(versions: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {version}" for name, version in versions.items())


A_PYAV = f"{install_line('video')}, or where it is broken pip install --force-reinstall av"


def video() -> Finding:
    """Check the H.264 encoder behind `replay --video`."""
    try:
        av = pyav()
        encoder = av.codec.Codec("h264", "w")
    except Exception as error:  # av's own errors, and loader errors of its libraries
        return Finding(
            "H.264 encoder",
            State.OPTIONAL,
            f"none in PyAV ({type(error.__cause__ or error).__name__})",
            A_PYAV,
        )
    return Finding(
        "H.264 encoder", State.OK, f"{encoder.name} in PyAV {av.__version__}", facts={"encoder": encoder.name}
    )


def codecs() -> Finding:
    """Check the codecs of `replay --codec`."""
    from ..link.codec import codecs

    works, missing = [], []
    for codec in codecs:
        if codec.is_none:
            continue
        try:
            codec.check()
            works.append(f"{codec.name} by {codec.encoder}")
        except Exception as error:  # MachineError, and loader errors of av's libraries
            missing.append(f"{codec.name} is missing ({type(error).__name__})")
    state = State.OPTIONAL if missing else State.OK
    return Finding("codecs", state, ", ".join([*works, *missing]), A_PYAV if missing else "")


def _one_line(text: object) -> str:
    return " ".join(str(text or "no reason given").split())
