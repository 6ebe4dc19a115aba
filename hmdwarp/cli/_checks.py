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
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import attrs

from ..display.openxr import INSTALL, diagnose, manifest_text, missing_extensions
from ..errors import HmdwarpError
from ..gpu import WANTED, Gpu, egl
from ..gpu.context import HOW_TO_GET_GL
from ..resources import EXTRAS, __version__, install_line, pyav

PROBE_SECONDS = 30.0  # a cold runtime may start its whole compositor before it answers
# Missing: replay cannot run without it. Optional: absent, and only some commands need it.
OK, MISSING, OPTIONAL = "ok", "missing", "optional"
Facts = Mapping[str, Any]  # of a probe, `error` is set where something is missing
Ask = Callable[[str], Facts]


@attrs.frozen
class Finding:
    """One line of the examination."""

    name: str
    state: str
    detail: str
    remedy: str = ""  # what to do; empty where nothing is needed
    facts: Facts = attrs.field(factory=dict)  # numbers for --json


@attrs.frozen
class Lack(Exception):
    """What is not there. remedy, state: in place of the check's own."""

    detail: str
    facts: Facts = attrs.field(factory=dict)
    remedy: str | None = None
    state: str | None = None


@attrs.frozen
class Check:
    """One line to find out."""

    name: str
    # look(ask, found): returns detail and facts, None for no line. ask: a probe. found: the lines
    # before, by name. Errors: Lack.
    look: Callable[[Ask, dict[str, Finding]], tuple[str, Facts] | None]
    remedy: str = ""
    state: str = OPTIONAL  # where it finds a lack


def examine() -> list[Finding]:
    """Check everything, drivers side by side; takes up to half a minute if one hangs."""
    found: dict[str, Finding] = {}
    with ThreadPoolExecutor() as pool:
        questions = ("gl", "devices", "openxr", *(["window"] if _has_display() else []))
        asked = {question: pool.submit(run_probe, question) for question in questions}
        for check in CHECKS:
            try:
                said = check.look(lambda question: asked[question].result(), found)
                found |= {check.name: Finding(check.name, OK, said[0], facts=said[1])} if said else {}
            except Lack as lack:
                remedy = check.remedy if lack.remedy is None else lack.remedy
                state = lack.state or check.state
                found[check.name] = Finding(check.name, state, lack.detail, remedy, lack.facts)
    return [*found.values()]


def run_probe(question: str, seconds: float = PROBE_SECONDS) -> Facts:
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
        return {"stage": "start", **known, "error": "died", "message": message}
    return known


def _reason(known: Facts) -> str:
    return " ".join(str(known.get("message", known.get("error")) or "no reason given").split())


def _python(ask: Ask, found: dict[str, Finding]) -> tuple[str, Facts]:
    facts = {"version": platform.python_version(), "cpu_count": os.cpu_count()}
    machine = f"{platform.system()} {platform.machine()}"
    return f"{facts['version']} on {machine}, {facts['cpu_count']} processors", facts


def _packages(extra: str, ask: Ask, found: dict[str, Finding]) -> tuple[str, Facts] | None:
    """Look at what the installed hmdwarp declares: its packages, or those of an extra."""
    try:
        declared = importlib.metadata.requires("hmdwarp") or []
    except importlib.metadata.PackageNotFoundError:
        why = "hmdwarp runs from a folder, not installed: its packages were not checked"
        if extra:
            return None
        raise Lack(why, {}, "make setup", OPTIONAL) from None
    wanted = rf"extra == ['\"]{extra}['\"]" if extra else "^((?!extra ==).)*$"
    versions, absent = {}, []
    for name in sorted(re.split(r"[^\w.-]", line)[0] for line in declared if re.search(wanted, line)):
        try:
            versions[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            absent.append(name)
    if absent:
        remedy = install_line(extra) if extra else f"pip install {' '.join(absent)}"
        raise Lack(f"not installed: {', '.join(absent)}{f' (for {EXTRAS[extra]})' if extra else ''}", versions, remedy)
    named = ", ".join(f"{name} {version}" for name, version in versions.items())
    return named if extra else f"hmdwarp {__version__}; {named}", versions


def _opengl(ask: Ask, found: dict[str, Finding]) -> tuple[str, Facts]:
    known = ask("gl")
    if "error" in known:
        reason = _reason(known).removesuffix(f": {HOW_TO_GET_GL}")
        remedy = f"unset {egl.VARIABLE}, or name one of those" if egl.VARIABLE in reason else None
        raise Lack(reason, known, remedy)
    detail = (
        f"{known['renderer']}, {known['version']} ({'software, on the CPU' if known['software'] else 'hardware'}); "
        f"textures up to {known['max_texture_size']} px a side, work groups up to "
        f"{known['max_work_group_invocations']}, storage blocks up to {known['max_storage_block_bytes'] // 2**20} MiB, "
        f"64-bit atomics {'yes' if known['atomic_int64'] else 'no'}"
    )
    return detail, known


def _timers(ask: Ask, found: dict[str, Finding]) -> tuple[str, Facts] | None:
    told = {"gpu": "GPU timer queries", "wall": "wall clock: this driver's GPU timers are unusable"}
    clock = found["OpenGL"].facts.get("clock")
    return None if clock is None else (told[clock], {"clock": clock})


def _devices(ask: Ask, found: dict[str, Finding]) -> tuple[str, Facts]:
    """List the devices that EGL knows, of which HMDWARP_EGL_DEVICE chooses one."""
    known = ask("devices")
    listed = [
        f"{device['index']}: {device['renderer']}{' at ' + device['file'] if device['file'] else ''}"
        for device in known.get("devices", [])
    ]
    if "error" in known:
        at = f", at {known['stage']}" if known["stage"].startswith("device") else ""
        raise Lack("; ".join([*listed, f"{_reason(known)}{at}"]), known)
    wanted = os.environ.get(egl.VARIABLE, "").strip()
    chosen = f"{egl.VARIABLE}={wanted}" if wanted else f"the first that works is used; {egl.VARIABLE} chooses another"
    return f"{'; '.join(listed) or 'none'} ({chosen})", known


def _loader(ask: Ask, found: dict[str, Finding]) -> tuple[str, Facts]:
    known = ask("openxr")
    if known["stage"] in ("start", "binding"):
        _, remedy = diagnose("binding", known.get("error", "").partition(":")[0])
        raise Lack(_reason(known), known, remedy)
    return f"pyopenxr {known['binding']}, its own loader for OpenXR {known['loader']}", {}


def _runtime(ask: Ask, found: dict[str, Finding]) -> tuple[str, Facts] | None:
    known = ask("openxr")
    if found["OpenXR loader"].state != OK:
        return None
    runtime, version = known.get("runtime", "the runtime"), known.get("runtime_version", "")
    name = runtime if version in runtime else f"{runtime} {version}"  # Monado's name says it
    if "error" in known:
        manifest = manifest_text(os.environ)
        detail, remedy = diagnose(known["stage"], known["error"], known.get("message"), name, manifest)
    else:
        detail, remedy = missing_extensions(name, known["extensions"])
    if detail:
        raise Lack(detail, known, remedy)
    return f"{name}, headset '{known['headset']}'", known


def _has_display() -> bool:
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _window(ask: Ask, found: dict[str, Finding]) -> tuple[str, Facts]:
    if not _has_display():
        raise Lack("no display: neither DISPLAY nor WAYLAND_DISPLAY is set")
    known = ask("window")
    if "error" in known:
        raise Lack(_reason(known), known)
    size = "{}x{} at {} Hz".format(*known["size"], known["refresh_hz"] or "?") if known["size"] else "no monitor"
    return f"OpenGL 4.3 window opens, screen {size}", known


def _live(ask: Ask, found: dict[str, Finding]) -> tuple[str, Facts]:
    """Tell which display `hmdwarp live` takes by default: the headset, else the window."""
    headset, desktop = found.get("OpenXR runtime", found["OpenXR loader"]), found["desktop window"]
    if headset.state == OK:
        return f"takes the headset: {headset.detail}", {"source": "openxr"}
    if desktop.state == OK:
        return f"takes the window, as there is no headset: {headset.detail}", {"source": "desktop"}
    raise Lack(f"no display: no headset ({headset.detail}), no window ({desktop.detail})", {"source": None})


def _video(ask: Ask, found: dict[str, Finding]) -> tuple[str, Facts]:
    try:
        av = pyav()
        encoder = av.codec.Codec("h264", "w")
    except Exception as error:  # av's own errors, and loader errors of its libraries
        raise Lack(f"none in PyAV ({type(error.__cause__ or error).__name__})") from error
    return f"{encoder.name} in PyAV {av.__version__}", {"encoder": encoder.name}


def _codecs(ask: Ask, found: dict[str, Finding]) -> tuple[str, Facts]:
    from ..link.codec import codecs

    works, missing = [], []
    for codec in (codec for codec in codecs if not codec.is_none):
        try:
            codec.check()
            works.append(f"{codec.name} by {codec.encoder}")
        except Exception as error:  # MachineError, and loader errors of av's libraries
            missing.append(f"{codec.name} is missing ({type(error).__name__})")
    if missing:
        raise Lack(", ".join([*works, *missing]))
    return ", ".join(works), {}


_PYAV = f"{install_line('video')}, or where it is broken pip install --force-reinstall av"
_VIRTUAL = f"run in a desktop session, or under a virtual one: {INSTALL} xvfb, then put xvfb-run -a before the command"
# In the order in which they are told.
CHECKS = (
    Check("Python", _python),
    Check("packages", partial(_packages, ""), state=MISSING),
    Check("OpenGL", _opengl, HOW_TO_GET_GL.split(";")[0], MISSING),
    Check("timers", _timers),
    Check("EGL devices", _devices),
    Check("OpenXR loader", _loader),
    Check("OpenXR runtime", _runtime),
    Check("desktop window", _window, _VIRTUAL),
    Check("live", _live, "either remedy above makes one"),
    Check("H.264 encoder", _video, _PYAV),
    Check("codecs", _codecs, _PYAV),
    *(Check(f"extra {name}", partial(_packages, name)) for name in EXTRAS),
)


GL_LIMITS = {
    "max_texture_size": "GL_MAX_TEXTURE_SIZE",
    "max_work_group_invocations": "GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS",
    "max_work_group_size": "GL_MAX_COMPUTE_WORK_GROUP_SIZE",
    "max_work_groups": "GL_MAX_COMPUTE_WORK_GROUP_COUNT",
    "max_storage_block_bytes": "GL_MAX_SHADER_STORAGE_BLOCK_SIZE",
    "max_storage_blocks": "GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS",
}
# Both are needed for a 64-bit depth test in one pass; there is a 32-bit path for everything.
INT64_EXTENSIONS = {"GL_ARB_gpu_shader_int64", "GL_NV_shader_atomic_int64"}


def _report(known: Mapping[str, object]) -> None:
    print(json.dumps(known), flush=True)


def _probe_gl() -> None:
    """Report the OpenGL context that replay would use: renderer, limits, timers that measure."""
    try:
        with Gpu() as gpu:
            about = {"renderer": gpu.renderer, "version": gpu.version, "software": gpu.is_software}
            about |= {"clock": gpu.timer.clock, "atomic_int64": gpu.gl.extensions >= INT64_EXTENSIONS}
            _report({"stage": "done", **about, **{name: gpu.gl.info[key] for name, key in GL_LIMITS.items()}})
    except HmdwarpError as error:
        _report({"stage": "context", "error": str(error)})


def _probe_devices() -> None:
    """Report the devices that EGL knows, one after the other, with what draws on each."""
    known: list[dict[str, object]] = []
    try:
        found = egl.devices()
    except OSError as error:
        _report({"stage": "list", "error": str(error)})
        return
    for device in found:
        _report({"stage": f"device {device.index}", "devices": known})
        known.append({"index": device.index, "file": device.file, "renderer": egl.renderer_of(device, WANTED)})
    _report({"stage": "done", "devices": known})


def _probe_openxr() -> None:
    """Report each step on the way to a headset: binding, runtime, service, headset."""
    known: dict[str, object] = {"stage": "binding"}
    _report(known)
    try:
        # Without libGL this is an AttributeError, with a foreign loader an OSError.
        import xr
    except Exception as error:
        _report({**known, "error": f"{type(error).__name__}: {error}"})
        return
    known |= {"binding": str(xr.PYOPENXR_VERSION), "loader": str(xr.version.XR_CURRENT_API_VERSION)}

    def advance(stage: str) -> None:
        known["stage"] = stage
        _report(known)

    try:
        advance("runtime")
        names = [_text(entry.extension_name) for entry in xr.enumerate_instance_extension_properties()]
        known["extensions"] = sorted(names)
        advance("instance")
        application = xr.ApplicationInfo(application_name="hmdwarp doctor", api_version=xr.Version(1, 0, 0))
        instance = xr.create_instance(xr.InstanceCreateInfo(application_info=application, enabled_extension_names=[]))
        try:
            properties = xr.get_instance_properties(instance)
            known["runtime"] = _text(properties.runtime_name)
            known["runtime_version"] = str(xr.Version(properties.runtime_version))
            advance("headset")
            system = xr.get_system(instance, xr.SystemGetInfo(xr.FormFactor.HEAD_MOUNTED_DISPLAY))
            known["headset"] = _text(xr.get_system_properties(instance, system).system_name)
            advance("done")
        finally:
            xr.destroy_instance(instance)
    except Exception as error:
        _report({**known, "error": type(error).__name__, "message": str(error)})


def _probe_window() -> None:
    """Report whether a desktop window with OpenGL 4.3 opens; it stays hidden."""
    import warnings

    from ..display.desktop import choose_library

    choose_library()
    import glfw

    warnings.simplefilter("ignore", glfw.GLFWError)
    if not glfw.init():
        _report({"stage": "display", "error": _text(glfw.get_error()[1] or "no display")})
        return
    try:
        glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
        glfw.window_hint(glfw.CONTEXT_VERSION_MAJOR, 4)
        glfw.window_hint(glfw.CONTEXT_VERSION_MINOR, 3)
        glfw.window_hint(glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE)
        if not glfw.create_window(64, 64, "hmdwarp doctor", None, None):
            _report({"stage": "window", "error": _text(glfw.get_error()[1] or "no window")})
            return
        monitor = glfw.get_primary_monitor()
        mode = glfw.get_video_mode(monitor) if monitor else None
        size, refresh_hz = (list(mode.size), mode.refresh_rate) if mode else (None, None)
        _report({"stage": "done", "size": size, "refresh_hz": refresh_hz})
    finally:
        glfw.terminate()


def _text(value: bytes | str) -> str:
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)


if __name__ == "__main__":
    globals()[f"_probe_{sys.argv[1]}"]()
