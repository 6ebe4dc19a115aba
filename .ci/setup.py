"""Makes .venv ready for `make`: the pinned Python packages, and Mesa where OpenGL is missing. Started by .ci/setup.

Quick and without a network when nothing changed; an interrupted run is repaired by the next one.
Options: --ci also installs what only CI needs (make, a browser, X and OpenXR for tests), where apt may.
Exit status: 0 ready; 3 the machine lacks something (the message holds the line to type); 1 a fault of ours.
"""

import contextlib
import ctypes
import fcntl
import hashlib
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
VENV = ROOT / ".venv"
PYTHON = VENV / "bin" / "python"
STATE = VENV / "hmdwarp-setup"  # HALF_MADE while something is being installed, afterwards the key of what was
LOG = VENV / "hmdwarp-setup.log"
HALF_MADE = "half-made"
CONSTRAINTS = ROOT / ".ci" / "constraints.txt"
VERSION = f"{sys.version_info.major}.{sys.version_info.minor}"
MESA = ["libegl1", "libgl1", "libgl1-mesa-dri"]
# (program, Debian package, whose): what CI needs beside a browser.
FOR_TESTS = [
    ("Xvfb", "xvfb", "the tests of windows"),
    ("xauth", "xauth", "the tests of windows"),
    ("xdotool", "xdotool", "the tests of windows"),
    ("mmdebstrap", "mmdebstrap", "the tests with an OpenXR runtime"),
]
GL_PROBE = "import moderngl; moderngl.create_context(standalone=True, backend='egl', require=430)"
NETWORK_TROUBLE = re.compile(
    r"NewConnectionError|NameResolutionError|Temporary failure in name resolution|ConnectTimeout|ReadTimeout|timed out|ProxyError|SSLError"
    r"|Connection (?:refused|reset|aborted)|Network is unreachable|IncompleteRead|ProtocolError"
)


class Lacking(Exception):
    """The machine lacks something; the message says what, and the line to type."""


def say(text: str) -> None:
    print(f"setup: {text}", flush=True)


def environment() -> dict[str, str]:
    """The user's own (proxy, PIP_*), less what would let packages from elsewhere pass for installed ones."""
    kept = {
        name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")
    }
    return {**kept, "PIP_USER": "0", "PIP_DISABLE_PIP_VERSION_CHECK": "1", "PIP_NO_INPUT": "1"}


def run(command: list[str | Path]) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(
            command,
            check=False,
            env=environment(),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
        )
    except OSError as error:  # a dead link or a foreign machine's binary
        return subprocess.CompletedProcess(command, 127, "", str(error))


def works(*command: str | Path) -> bool:
    return run(list(command)).returncode == 0


# --- system packages -------------------------------------------------------------------------------------------------


def line_to_type(packages: list[str]) -> str:
    names = " ".join(packages)
    if os.geteuid() == 0:
        return f"    apt-get update && apt-get install -y {names}"
    if shutil.which("sudo"):
        return f"    sudo apt-get update && sudo apt-get install -y {names}"
    return f"    su -c 'apt-get update && apt-get install -y {names}'"


def apt_install(packages: list[str], why: str) -> None:
    """Through apt as root or by passwordless sudo. Raises Lacking with the line to type where that cannot be."""
    if not shutil.which("apt-get"):
        raise Lacking(
            f"{why}, and there is no apt-get here: install what Debian calls {' '.join(packages)}, then run make again"
        )
    ask = f"{why}. Type this, then run make again:\n{line_to_type(packages)}"
    if os.geteuid() == 0:
        rights = []
    elif shutil.which("sudo") and works("sudo", "-n", "true"):
        rights = ["sudo", "-n"]
    else:
        raise Lacking(ask)
    say(f"{why}: installing {' '.join(packages)} through apt")
    apt = [*rights, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-q", "-o", "DPkg::Lock::Timeout=120"]
    install = [*apt, "install", "-y", "--no-install-recommends", *packages]
    # Lists may be absent (a fresh container) or stale (404): in both cases update once, then install.
    if any(Path("/var/lib/apt/lists").glob("*_Packages*")) and works(*install):
        return
    update, result = run([*apt, "update"]), run(install)
    if result.returncode:
        # Without a network `apt-get update` warns and ends with 0: its first warning is the reason worth showing.
        complaints = [x for x in (update.stderr + result.stderr).splitlines() if x.startswith(("W: Failed", "E:"))]
        reason = complaints[0] if complaints else f"apt-get ended with {result.returncode}"
        raise Lacking(
            f"{why}, and apt could not help ({reason}). When that is mended, run make again or type:\n{line_to_type(packages)}"
        )


def can_load(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def any_pip() -> list[str] | None:
    """A pip outside .venv that can work on .venv (`pip --python`, since pip 22.3)."""
    for command in ([sys._base_executable, "-m", "pip"], ["pip3"], ["pip"]):
        version = re.match(r"pip (\d+)\.(\d+)", run([*command, "--version"]).stdout)
        if version and (int(version[1]), int(version[2])) >= (22, 3):
            return command
    return None


def install_system_packages() -> None:
    """Everything that is missing in one go: a user without root gets one line to type, not three in a row."""
    packages, reasons = [], []
    if importlib.util.find_spec("ensurepip") is None and not works(PYTHON, "-m", "pip", "--version") and not any_pip():
        if not sys._base_executable.startswith("/usr/bin/"):
            raise Lacking(
                f"{sys._base_executable} has neither ensurepip nor pip: choose another, make PYTHON=/path/to/python3.12 setup"
            )
        packages.append(f"python{VERSION}-venv")
        reasons.append(f"Python {VERSION} here has no pip")
    if not (can_load("libEGL.so.1") and can_load("libGL.so.1")):
        packages += MESA
        reasons.append("there is no OpenGL (libEGL) here")
    headers = Path(sysconfig.get_path("include"), "Python.h").is_file()
    if sys.version_info >= (3, 14) and state() != wanted_state() and not (headers and shutil.which("c++")):
        packages += [
            "g++",
            f"python{VERSION}-dev",
        ]  # flip-evaluator 1.7 has wheels up to Python 3.13 and is compiled here
        reasons.append(f"one package has to be compiled for Python {VERSION}")
    if packages:
        apt_install(packages, " and ".join(reasons))


def install_for_ci() -> None:
    """make is needed; without the others only the tests that use them are skipped, which pytest then says."""
    if not shutil.which("make"):
        apt_install(["make"], "there is no make here")
    lacking = [
        (package, f"there is no {program} for {tests}")
        for program, package, tests in FOR_TESTS
        if not shutil.which(program)
    ]
    groups = [lacking] if lacking else []
    if not any(shutil.which(name) for name in ("chromium", "chromium-browser", "google-chrome")):
        groups.append([("chromium", "there is no browser for the report test")])
    for group in groups:
        try:
            apt_install([package for package, _ in group], " and ".join(why for _, why in group))
        except Lacking as error:
            say(f"going on without: {error}")


# --- the virtual environment ------------------------------------------------------------------------------------------


def wanted_state() -> str:
    """Changes when what is installed should: the pins, the project's table, this script, Python, or the checkout's place."""
    parts = [p.read_bytes() for p in (ROOT / "pyproject.toml", CONSTRAINTS, Path(__file__))]
    return hashlib.sha256(b"\0".join([*parts, VERSION.encode(), os.fsencode(ROOT)])).hexdigest()


def state() -> str:
    return STATE.read_text(encoding="utf-8") if STATE.is_file() else ""


def usable() -> bool:
    """Whether .venv is no half-made one of ours, runs, and has this Python."""
    same_python = f"import sys; sys.exit('%d.%d' % sys.version_info[:2] != '{VERSION}')"
    return state() != HALF_MADE and works(PYTHON, "-c", same_python)


def make_environment() -> None:
    if VENV.is_symlink() or (VENV.exists() and not VENV.is_dir()):
        raise Lacking(".venv is there but is no folder: move it away, then run make again")
    if VENV.exists():
        if any(VENV.iterdir()) and not (STATE.exists() or (VENV / "pyvenv.cfg").exists()):
            raise Lacking(".venv is there but is no virtual environment: move it away, then run make again")
        say("what is in .venv is half-made, broken or of another Python: making it anew")
        shutil.rmtree(VENV)
    VENV.mkdir()
    STATE.write_text(HALF_MADE, encoding="utf-8")
    say(f"making a virtual environment with Python {VERSION} in .venv")
    # Without pip it can be made even where Debian's python3-venv is missing. A fresh process: this one may be .venv's own Python.
    result = run([sys._base_executable, "-I", "-m", "venv", "--without-pip", VENV])
    if result.returncode:
        raise Lacking(
            f"no virtual environment could be made in .venv: {(result.stderr.strip().splitlines() or ['no message'])[-1]}"
        )


def get_pip() -> None:
    if not (works(PYTHON, "-m", "pip", "--version") or works(PYTHON, "-m", "ensurepip", "--default-pip")):
        pip([*(any_pip() or ["pip"]), "--python", PYTHON], "install", "pip")


def pip(command: list[str | Path], *arguments: str | Path) -> None:
    """Raises Lacking with one line when pip fails; all that it said, and more, is in LOG."""
    LOG.unlink(missing_ok=True)
    result = run([*command, "--log", LOG, *arguments])
    if result.returncode == 0:
        return
    # Without a network pip speaks of conflicting versions; only its log tells that it reached nobody.
    network = NETWORK_TROUBLE.search(LOG.read_text(encoding="utf-8", errors="replace") if LOG.exists() else "")
    if network:
        raise Lacking(
            f"cannot reach the package index ({network[0]}): check the network, proxy or PIP_INDEX_URL, then run make again"
        )
    lines = result.stderr.splitlines()
    errors = (
        [x for x in lines if x.startswith("ERROR")] or [x.strip() for x in lines[::-1] if "Error: " in x] or lines[-1:]
    )
    raise Lacking(f"pip failed: {errors[0] if errors else 'no message'} (all it said: {LOG.relative_to(ROOT)})")


def install_packages() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    wanted = [*project["dependencies"], *extras["test"], *extras["bench"], *extras["panel"], *extras["study"]]
    STATE.write_text(HALF_MADE, encoding="utf-8")
    say("installing the pinned packages into .venv (about 1 GB on disk; a few minutes the first time)")
    pip([PYTHON, "-m", "pip"], "install", "--constraint", CONSTRAINTS, *wanted)
    # Editable: a changed shader or module is used at once. No isolation: the pinned hatchling builds, offline too.
    pip([PYTHON, "-m", "pip"], "install", "--no-deps", "--no-build-isolation", "--editable", ROOT)
    whole = STATE.with_suffix(".new")
    whole.write_text(wanted_state(), encoding="utf-8")
    whole.replace(STATE)


def check_gl() -> None:
    """A context is made for real: libEGL may be there without any driver behind it."""
    if works(PYTHON, "-c", GL_PROBE):
        return
    if not works("dpkg", "-s", *MESA):
        apt_install(MESA, "OpenGL 4.3 does not start here")
    result = run([PYTHON, "-c", GL_PROBE])
    if result.returncode:
        last = (result.stderr.strip().splitlines() or [f"ended with status {result.returncode}"])[-1]
        raise Lacking(
            f"OpenGL 4.3 does not start here though {' '.join(MESA)} are installed ({last}); .venv/bin/hmdwarp doctor says more"
        )


def main(options: list[str]) -> None:
    with contextlib.suppress(OSError):  # some network file systems lock no folders
        fcntl.flock(
            os.open(ROOT, os.O_RDONLY), fcntl.LOCK_EX
        )  # two makes at once: the second waits and finds everything done
    install_system_packages()
    if not usable():
        make_environment()
    if state() != wanted_state():
        get_pip()
        install_packages()
        say("done")
    check_gl()
    if "--ci" in options:
        install_for_ci()


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except Lacking as lacking:
        print(f"setup: {lacking}", file=sys.stderr)
        sys.exit(3)
    except OSError as error:
        print(f"setup: cannot write {error.filename or '.venv'}: {error.strerror}", file=sys.stderr)
        sys.exit(3)
    except KeyboardInterrupt:
        print("\nsetup: interrupted; run make again to go on", file=sys.stderr)
        sys.exit(130)
