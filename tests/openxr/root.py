"""A Debian root with Monado, an actual OpenXR runtime, and hmdwarp's pinned packages.

For tests, without a headset or a GPU.

Built once (a minute; 1.4 GB) into the user's cache folder, from Debian's unmodified packages and
.ci/constraints.txt, and again when either list changes; one that nobody has entered for a month is
removed at the next build. `python tests/openxr/root.py` builds it and prints where it is; with a
command behind, it runs that in it; `with-monado` runs one beside Monado. HMDWARP_MONADO_ROOT names
another folder.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
ENTER = Path(__file__).with_name("enter.sh")
SUITE = "trixie"
PYTHON, GLIBC = "3.13", 41  # of that suite: glibc 2.41
DEBIAN = (
    "python3", "ca-certificates", "xvfb", "xdotool", "monado-service", "libopenxr1-monado",
    "mesa-vulkan-drivers", "libvulkan1", "libgl1", "libglx-mesa0", "libegl1", "libegl-mesa0", "libgl1-mesa-dri",
)  # fmt: skip
# Of the extra test, what checks code, files and figures elsewhere, with what it alone brings.
CHECKERS = ("mitsuba", "drjit", "mypy", "ast-serialize", "ruff", "scikit-image", "scikit-learn", "pingouin", "babel")
UNREAD = ("man", "doc", "locale", "info")  # below usr/share: left out
# What Python compiles and matplotlib looks up at its first start; kept in the root, it saves 5 s
# each time the root is entered.
FIRST_START = """
exec 3>&1 >&2
python3 -m hmdwarp doctor; python3 -m pytest -q -p no:cacheprovider --collect-only tests/openxr; \
python3 -c 'import matplotlib.pyplot'
tar -C /tmp --exclude=pycache/project -cf - pycache home >&3
"""
WARM = "var/cache/hmdwarp-warm.tar"
STALE_S = 30 * 86400

Say = Callable[[str], None]


class Lacking(Exception):
    """The machine lacks what a root is built or entered with; the message says what."""


def ready_root(say: Say = lambda text: None) -> Path:
    """The root, built first if there is none of this recipe.

    say: told before what takes long. Errors: Lacking.
    """
    _check_rights()
    place = _folder() / f"root-{recipe()}"
    place.parent.mkdir(parents=True, exist_ok=True)
    with _locked(place.with_suffix(".lock")) as waited:
        if not place.is_dir():
            if waited:
                raise Lacking("Monado's root could not be built by another process just now, which says why")
            say(f"building Monado's root in {place} (about a minute, 1.4 GB)")
            _remove_stale(place.parent)
            _build(place)
        os.utime(place)
    return place


def entered(root: Path, command: list[str], project: Path = PROJECT) -> list[str]:
    """The command line that runs `command` in the root, with process ids and a network of its own.

    It dies with whoever started it.

    `project` is seen as /project, read-only; the only place to write to is /tmp, which nobody
    shares. Leading NAME=VALUE words are its environment, which takes nothing else along.
    """
    apart = ["unshare", "--mount", "--pid", "--net", "--fork", "--kill-child", "--propagation", "private"]
    return ["setpriv", "--pdeathsig", "KILL", *apart, "bash", str(ENTER), str(root), str(project), *command]


def recipe() -> str:
    """A name for what goes into the root: changes when that does."""
    parts = [SUITE, PYTHON, platform.machine(), *DEBIAN, *UNREAD, FIRST_START, *_pins()]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:12]


def _folder() -> Path:
    given = os.environ.get("HMDWARP_MONADO_ROOT")
    if given:
        return Path(given).resolve()
    cache = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return (cache if cache.is_absolute() else Path.home() / ".cache") / "hmdwarp" / "monado"


def _pins() -> list[str]:
    """Return the pinned packages without those that no test here reads, a third of them by size."""
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    unread = [line for name in ("bench", "cluster", "docs", "exr", "jod", "reduce") for line in extras[name]]
    left_out = {*map(_name, unread), *CHECKERS}
    lines = (PROJECT / ".ci" / "constraints.txt").read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line and line[0] != "#" and _name(line) not in left_out]


def _name(requirement: str) -> str:
    return re.match(r"[\w.-]+", requirement)[0].lower().replace("_", "-")


def _check_rights() -> None:
    if not sys.platform.startswith("linux") or os.geteuid() != 0:
        raise Lacking(
            "Monado's root needs Linux and root's rights, to build it and to enter it (sudo make test-openxr)"
        )
    if not shutil.which("apt-get"):
        raise Lacking("Monado's root is built with apt, and there is no apt-get here")
    with tempfile.TemporaryDirectory() as place:
        done = _run(["unshare", "--mount", "--pid", "--net", "--fork", "mount", "-t", "tmpfs", "tmpfs", place])
    if done.returncode:
        raise Lacking(
            f"Monado's root cannot be entered: this machine or container does not let root mount ({_last(done.stderr)})"
        )


# --- building -----------------------------------------------------------------------------------


def _build(place: Path) -> None:
    """Under another name until it is whole."""
    part, packages = place.with_suffix(".part"), place.with_suffix(".packages")
    for folder in (part, packages):
        shutil.rmtree(folder, ignore_errors=True)
    try:
        # Both at once: apt and pip spend their time on waiting and unpacking.
        with subprocess.Popen(
            _pip(packages), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        ) as pip:
            try:
                _bootstrap(part)
                said, _ = pip.communicate()
            except BaseException:
                pip.kill()
                raise
        if pip.returncode:
            raise Lacking(f"Monado's root could not be built: pip failed ({_last(said)})")
        site = part / "usr" / "local" / "lib" / f"python{PYTHON}" / "dist-packages"
        shutil.rmtree(site, ignore_errors=True)
        site.parent.mkdir(parents=True, exist_ok=True)
        packages.rename(site)
        _warm(part)
        part.rename(place)
    finally:
        for folder in (part, packages):
            shutil.rmtree(folder, ignore_errors=True)


def _warm(place: Path) -> None:
    """Start everything once.

    Where that fails, tests are slower by it and say themselves what is wrong.
    """
    with (place / WARM).open("wb") as kept:
        command, none = entered(place, ["bash", "-c", FIRST_START]), subprocess.DEVNULL
        subprocess.run(command, check=False, stdin=none, stdout=kept, stderr=none)


def _pip(target: Path) -> list[str]:
    """The machine's own pip fills the folder, for the root's Python.

    So whatever index, proxy, certificate or folder of wheels it is set to is obeyed. Every package
    is pinned, those that others need too, so nothing is left to resolve.
    """
    wheels = [f"--platform=manylinux_2_{minor}_{platform.machine()}" for minor in range(GLIBC, 4, -1)]
    wheels += [f"--platform={old}_{platform.machine()}" for old in ("manylinux2014", "manylinux2010", "manylinux1")]
    fit = ["--python-version", PYTHON, "--implementation", "cp", *wheels, "--only-binary=:all:"]
    quiet = [
        "--quiet", "--no-input", "--disable-pip-version-check", "--root-user-action=ignore",
        "--no-warn-script-location",
    ]  # fmt: skip
    return [
        sys.executable, "-m", "pip", "install", *quiet, "--no-deps", "--no-compile", *fit, "--target", str(target),
        *_pins(),
    ]  # fmt: skip


def _bootstrap(place: Path) -> None:
    if not shutil.which("mmdebstrap"):
        for words in (["update"], ["install", "--yes", "--no-install-recommends", "mmdebstrap"]):
            done = _run(
                ["env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-q", "-o", "DPkg::Lock::Timeout=120", *words]
            )
        if not shutil.which("mmdebstrap"):
            raise Lacking(
                f"Monado's root is built with mmdebstrap, and apt could not install it ({_last(done.stderr)})"
            )
    with tempfile.NamedTemporaryFile("w", prefix="hmdwarp-", suffix=".conf") as settings:
        settings.write(_apt_settings())
        settings.flush()
        options = [
            "--variant=apt", "--mode=root", "--quiet", f"--aptopt={settings.name}", f"--include={','.join(DEBIAN)}",
        ]  # fmt: skip
        options += [f"--dpkgopt=path-exclude=/usr/share/{folder}/*" for folder in UNREAD]
        done = _run(["mmdebstrap", *options, SUITE, str(place), f"deb {_mirror()} {SUITE} main"])
    if done.returncode:
        raise Lacking(f"Monado's root could not be built: mmdebstrap failed ({_last(done.stderr)})")


def _apt_settings() -> str:
    """How this machine's apt reaches its mirrors (proxies, certificates, checks of dates), and no
    packages that are only recommended.
    """
    known = _run(["apt-config", "dump"]).stdout.splitlines()
    reach = [line for line in known if re.match(r"Acquire::(https?|ftp|ForceIP|Check|Max-?Future|Retries)", line)]
    return "\n".join([*reach, 'Acquire::Retries "3";', 'APT::Install-Recommends "false";', ""])


def _mirror() -> str:
    """The Debian mirror this machine uses. Errors: Lacking."""
    texts = [
        p.read_text(encoding="utf-8", errors="replace") for p in sorted(Path("/etc/apt").glob("sources.list*/*.[ls]*"))
    ]
    listed = Path("/etc/apt/sources.list")
    texts += [listed.read_text(encoding="utf-8", errors="replace")] if listed.is_file() else []
    found = re.findall(r"^(?:URIs:|deb(?: +\[[^]]*\])?) *(\S+/debian/?)(?=\s|$)", "\n".join(texts), re.MULTILINE)
    if not found:
        raise Lacking("apt's sources name no Debian mirror to build Monado's root from")
    return found[0].rstrip("/")


def _remove_stale(folder: Path) -> None:
    """Roots of older recipes that nobody has entered for a month."""
    for old in folder.glob("root-*"):
        if time.time() - old.stat().st_mtime > STALE_S:
            shutil.rmtree(old, ignore_errors=True) if old.is_dir() else old.unlink(missing_ok=True)


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[bool]:
    """One builds, the others wait for it. Gives whether that was so."""
    with path.open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            waited = False
        except BlockingIOError:
            fcntl.flock(file, fcntl.LOCK_EX)
            waited = True
        yield waited


def _run(command: list[str]) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(
            command, check=False, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace"
        )
    except OSError as error:
        return subprocess.CompletedProcess(command, 127, "", str(error))


def _last(said: str) -> str:
    """The line worth showing: the first that calls itself an error, else the last."""
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    return next((line for line in lines if re.match(r"(E|ERROR|error):", line)), (lines or ["it said nothing"])[-1])


def main(command: list[str]) -> None:
    root = ready_root(lambda text: print(text, file=sys.stderr))
    if not command:
        print(root)
        return
    kept = [
        f"{name}={value}"
        for name, value in os.environ.items()
        if re.match(r"XRT_|SIMULATED_|P_OVERRIDE_|HMDWARP_|DISPLAY$", name)
    ]
    words = entered(root, [*kept, *command])
    os.execvp(words[0], words)


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except Lacking as lacking:
        print(lacking, file=sys.stderr)
        sys.exit(3)
