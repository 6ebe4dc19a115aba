"""Make .venv ready for `make`: the pinned Python packages, and Mesa where OpenGL is missing.

Started by .ci/setup. Quick and without a network when nothing changed; the next run repairs an
interrupted one. Options: --base installs no extras; --tests also installs what only tests start
(.ci/tools.toml), where apt may.
Exit status: 0 ready; 3 the machine lacks something (the message holds the line to type); 1 an
internal error.
"""

import base64
import contextlib
import ctypes
import fcntl
import glob
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
# Extras that are left to those who want them: torch is several GB; `make test-jod` has its tests.
TOO_LARGE = {"jod"}
MESA = ["libegl1", "libgl1", "libgl1-mesa-dri"]
TOOLS = ROOT / ".ci" / "tools.toml"
NPM = ROOT / "build" / "npm"  # packages as npm packs them
GL_PROBE = "import moderngl; moderngl.create_context(standalone=True, backend='egl', require=430)"
NETWORK_TROUBLE = re.compile(
    r"NewConnectionError|NameResolutionError|Temporary failure in name resolution|ConnectTimeout|ReadTimeout"
    r"|timed out|ProxyError|SSLError|Connection (?:refused|reset|aborted)|Network is unreachable|IncompleteRead"
    r"|ProtocolError"
)


class Lacking(Exception):
    """The machine lacks something; the message says what, and the line to type."""


def say(text: str) -> None:
    print(f"setup: {text}", flush=True)


def environment() -> dict[str, str]:
    """Return the user's own variables (proxy, PIP_*) without those of other environments.

    With them, packages from elsewhere would pass for installed ones.
    """
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


# --- system packages ---------------------------------------------------------------------------


def line_to_type(packages: list[str]) -> str:
    names = " ".join(packages)
    if os.geteuid() == 0:
        return f"    apt-get update && apt-get install -y {names}"
    if shutil.which("sudo"):
        return f"    sudo apt-get update && sudo apt-get install -y {names}"
    return f"    su -c 'apt-get update && apt-get install -y {names}'"


def apt_install(packages: list[str], why: str) -> None:
    """Install through apt, as root or by passwordless sudo.

    Errors: Lacking, with the line to type, where that cannot be.
    """
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
    # Lists may be absent (a fresh container) or stale (404): then update once, and install.
    if any(Path("/var/lib/apt/lists").glob("*_Packages*")) and works(*install):
        return
    update, result = run([*apt, "update"]), run(install)
    if result.returncode:
        # Without a network `apt-get update` warns and ends with 0: its first warning is the reason.
        complaints = [x for x in (update.stderr + result.stderr).splitlines() if x.startswith(("W: Failed", "E:"))]
        reason = complaints[0] if complaints else f"apt-get ended with {result.returncode}"
        raise Lacking(
            f"{why}, and apt could not help ({reason}). When that is mended, run make again or type:\n"
            f"{line_to_type(packages)}"
        )


def can_load(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def any_pip() -> list[str] | None:
    """Return a pip outside .venv that can work on .venv (`pip --python`, since pip 22.3)."""
    for command in ([sys._base_executable, "-m", "pip"], ["pip3"], ["pip"]):
        version = re.match(r"pip (\d+)\.(\d+)", run([*command, "--version"]).stdout)
        if version and (int(version[1]), int(version[2])) >= (22, 3):
            return command
    return None


def install_system_packages(base: bool) -> None:
    """Install all that is missing in one go: without root, one line to type instead of three."""
    packages, reasons = [], []
    if importlib.util.find_spec("ensurepip") is None and not works(PYTHON, "-m", "pip", "--version") and not any_pip():
        if not sys._base_executable.startswith("/usr/bin/"):
            raise Lacking(
                f"{sys._base_executable} has neither ensurepip nor pip: choose another, "
                "make PYTHON=/path/to/python3.12 setup"
            )
        packages.append(f"python{VERSION}-venv")
        reasons.append(f"Python {VERSION} here has no pip")
    if not (can_load("libEGL.so.1") and can_load("libGL.so.1")):
        packages += MESA
        reasons.append("there is no OpenGL (libEGL) here")
    headers = Path(sysconfig.get_path("include"), "Python.h").is_file()
    compiles = not base or sys.version_info >= (3, 14)
    if compiles and not is_ready(base) and not (headers and shutil.which("c++")):
        # meshoptimizer 0.2.30 has no wheels, flip-evaluator 1.7 has them up to Python 3.13.
        packages += ["g++", f"python{VERSION}-dev"]
        reasons.append(f"one package has to be compiled for Python {VERSION}")
    if packages:
        apt_install(packages, " and ".join(reasons))


def missing_tools() -> dict[str, str]:
    """Return what tests start and this machine lacks, with the package of each."""
    tools = tomllib.loads(TOOLS.read_text(encoding="utf-8"))

    def is_here(name: str) -> bool:
        files = tools.get("files", {}).get(name)
        if files is not None:
            return any(map(glob.glob, files))
        return any(map(shutil.which, (name, *tools["other_names"].get(name, []))))

    return {name: package for name, package in tools["packages"].items() if not is_here(name)}


def install_for_tests() -> None:
    """Install what tests start; those that lack a program or driver are skipped."""
    missing = missing_tools()
    packages = sorted(set(missing.values()))
    # One unknown package (Ubuntu has Chromium as a snap alone) would stop all the others.
    known = [package for package in packages if works("apt-cache", "show", package)]
    try:
        if packages:
            apt_install(known or packages, f"the tests lack {', '.join(missing)}")
    except Lacking as lacking:
        if not known and any(works("apt-cache", "show", package) for package in packages):
            install_for_tests()  # the package lists came only now
            return
        say(f"{lacking}")
    left = missing_tools()
    if left:
        say(f"going on without {', '.join(left)}; the tests say at their end what they left out")
    fetch_from_npm()


def fetch_from_npm() -> None:
    """Bring what tests give to a browser; those that lack it are skipped."""
    for name, (version, digest) in tomllib.loads(TOOLS.read_text(encoding="utf-8")).get("npm", {}).items():
        file = NPM / f"{name}-{version}.tgz"
        if not file.exists():
            NPM.mkdir(parents=True, exist_ok=True)
            run(["npm", "pack", f"{name}@{version}", "--pack-destination", NPM, "--fetch-retries=0"])
        found = base64.b64encode(hashlib.sha512(file.read_bytes()).digest()).decode() if file.exists() else ""
        if f"sha512-{found}" != digest:
            file.unlink(missing_ok=True)
            why = "it is not the pinned one" if found else "npm, or its registry, is not there"
            say(f"going on without {name} {version}: {why}")


# --- the virtual environment -------------------------------------------------------------------


def wanted_state(base: bool) -> str:
    """Return a key of what decides: pins, pyproject.toml, this script, Python, checkout's place."""
    parts = [p.read_bytes() for p in (ROOT / "pyproject.toml", CONSTRAINTS, Path(__file__))]
    key = hashlib.sha256(b"\0".join([*parts, VERSION.encode(), os.fsencode(ROOT)])).hexdigest()
    return f"{key} base" if base else key


def is_ready(base: bool) -> bool:
    """Return whether all is installed; without extras, where base."""
    return state() in {wanted_state(False), wanted_state(base)}


def state() -> str:
    return STATE.read_text(encoding="utf-8") if STATE.is_file() else ""


def usable() -> bool:
    """Return whether .venv is complete, runs, and has this Python."""
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
    # Without pip it can be made even where Debian's python3-venv is missing. A fresh process: this
    # one may be .venv's own Python.
    result = run([sys._base_executable, "-I", "-m", "venv", "--without-pip", VENV])
    if result.returncode:
        last = (result.stderr.strip().splitlines() or ["no message"])[-1]
        raise Lacking(f"no virtual environment could be made in .venv: {last}")


def get_pip() -> None:
    if not (works(PYTHON, "-m", "pip", "--version") or works(PYTHON, "-m", "ensurepip", "--default-pip")):
        pip([*(any_pip() or ["pip"]), "--python", PYTHON], "install", "pip")


def pip(command: list[str | Path], *arguments: str | Path) -> None:
    """Run pip. Errors: Lacking, in one line; LOG has all that pip said, and more."""
    LOG.unlink(missing_ok=True)
    result = run([*command, "--log", LOG, *arguments])
    if result.returncode == 0:
        return
    # Without a network pip speaks of conflicting versions; only its log names the network.
    network = NETWORK_TROUBLE.search(LOG.read_text(encoding="utf-8", errors="replace") if LOG.exists() else "")
    if network:
        raise Lacking(
            f"cannot reach the package index ({network[0]}): "
            "check the network, proxy or PIP_INDEX_URL, then run make again"
        )
    lines = result.stderr.splitlines()
    errors = (
        [x for x in lines if x.startswith("ERROR")] or [x.strip() for x in lines[::-1] if "Error: " in x] or lines[-1:]
    )
    raise Lacking(f"pip failed: {errors[0] if errors else 'no message'} (all it said: {LOG.relative_to(ROOT)})")


def install_packages(base: bool) -> None:
    said = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    extras = {name: lines for name, lines in said["project"]["optional-dependencies"].items() if name not in TOO_LARGE}
    # Without extras hatchling, which is one of the tests', still builds.
    more = [said["build-system"]["requires"]] if base else extras.values()
    wanted = [*said["project"]["dependencies"], *(line for lines in more for line in lines)]
    STATE.write_text(HALF_MADE, encoding="utf-8")
    size = "about 0.3 GB on disk" if base else "about 1 GB on disk; a few minutes the first time"
    say(f"installing the pinned packages into .venv ({size})")
    pip([PYTHON, "-m", "pip"], "install", "--constraint", CONSTRAINTS, *wanted)
    # Editable: a changed shader or module is used at once. No isolation: the pinned hatchling
    # builds, offline too.
    pip([PYTHON, "-m", "pip"], "install", "--no-deps", "--no-build-isolation", "--editable", ROOT)
    whole = STATE.with_suffix(".new")
    whole.write_text(wanted_state(base), encoding="utf-8")
    whole.replace(STATE)


def check_gl() -> None:
    """Make a context for real: libEGL may be there without any driver behind it."""
    if works(PYTHON, "-c", GL_PROBE):
        return
    if not works("dpkg", "-s", *MESA):
        apt_install(MESA, "OpenGL 4.3 does not start here")
    result = run([PYTHON, "-c", GL_PROBE])
    if result.returncode:
        last = (result.stderr.strip().splitlines() or [f"ended with status {result.returncode}"])[-1]
        raise Lacking(
            f"OpenGL 4.3 does not start here though {' '.join(MESA)} are installed ({last}); "
            ".venv/bin/hmdwarp doctor says more"
        )


def main(options: list[str]) -> None:
    with contextlib.suppress(OSError):  # some network file systems lock no folders
        # Two makes at once: the second waits and finds everything done.
        fcntl.flock(os.open(ROOT, os.O_RDONLY), fcntl.LOCK_EX)
    base = "--base" in options
    install_system_packages(base)
    if not usable():
        make_environment()
    if not is_ready(base):
        get_pip()
        install_packages(base)
        say("done")
    check_gl()
    if "--tests" in options:
        install_for_tests()


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
