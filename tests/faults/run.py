"""Plant small faults in a copy of this tree, one at a time, and see which the tests catch.

    .venv/bin/python tests/faults/run.py --room poses
    .venv/bin/python tests/faults/run.py --list                      what is known so far

The faults are in faults.toml. What was found is kept in out/faults.json, so that a run goes on
where the last one ended.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import tomllib
from collections import Counter
from contextlib import suppress
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Where a room's lines may have moved to. The folders of others are their names.
FOLDERS = {
    "run": ("hmdwarp/run", "hmdwarp/pipeline"),
    "metrics": ("hmdwarp/metrics", "hmdwarp/report"),
    "image": ("hmdwarp/image", "hmdwarp/check"),
    "link": ("hmdwarp/link", "hmdwarp/frames"),
    "headsets": ("hmdwarp/headsets", "hmdwarp/geometry"),
    "shaders": ("shaders",),
}
VERDICTS = ("caught", "survived", "line has changed", "tests fail without it", "not run")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--room", help="only those of this room")
    options.add_argument("--only", type=int, help="only this one, counted from 1 (in its room with --room)")
    options.add_argument("--again", action="store_true", help="also those that were run before")
    options.add_argument("--list", action="store_true", help="run nothing, print what is known")
    options.add_argument("--results", type=Path, default=ROOT / "out/faults.json", help="default: out/faults.json")
    chosen = options.parse_args()
    rooms = tomllib.loads((ROOT / "tests/faults/faults.toml").read_text(encoding="utf-8"))
    faults = [{**fault, "room": room} for room in rooms for fault in rooms[room] if chosen.room in (None, room)]
    faults = faults[chosen.only - 1 : chosen.only] if chosen.only else faults
    if not faults:
        options.error(f"no such fault; rooms are {', '.join(rooms)}")
    known = json.loads(chosen.results.read_text(encoding="utf-8")) if chosen.results.exists() else {}
    chosen.results.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="hmdwarp-faults-") as folder:
        tree = Path(folder) / "tree"
        if not chosen.list:
            copy_to(tree)
        for number, fault in enumerate(faults, chosen.only or 1):
            key = " | ".join((fault["room"], fault["before"], fault["after"], *fault["tests"]))
            path = file_of(fault)
            if path is None:
                fault["verdict"] = "line has changed"
            elif chosen.list or (known.get(key, "").startswith(VERDICTS[:2]) and not chosen.again):
                fault["verdict"] = known.get(key, "not run")
            else:
                fault["verdict"] = known[key] = plant(fault, tree / path, tree)
                chosen.results.write_text(json.dumps(known, indent=1), encoding="utf-8")
            verdict, _, by = fault["verdict"].partition(":")
            named = f"{number:3} {fault['room']:9} {verdict:9} {fault['file']}: {fault['wrong']}"
            print(named, f"\n{'':14}{by}" if by else "", flush=True)
    print_table(faults)


def copy_to(tree: Path) -> None:
    """Copy what git knows of, and what it would: no caches, no results."""
    git = ["git", "-C", str(ROOT), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    for name in sorted(set(subprocess.run(git, capture_output=True, text=True, check=True).stdout.split("\0")) - {""}):
        if (ROOT / name).is_file():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, tree / name, follow_symlinks=False)
    if (ROOT / "build/npm").is_dir():  # without it tests of a headset's browser are skipped, and see nothing
        shutil.copytree(ROOT / "build/npm", tree / "build/npm")


def file_of(fault: dict) -> Path | None:
    """Return the file that has this line once: its own, or the only one in its room."""
    own = ROOT / fault["file"]
    others = [ROOT / folder for folder in FOLDERS.get(fault["room"], (f"hmdwarp/{fault['room']}",))]
    texts = {path: path.read_bytes() for folder in others for path in folder.rglob("*.*") if path.is_file()}
    counts = {path: text.count(fault["before"].encode()) for path, text in texts.items()}
    found = [own] if counts.get(own) else [path for path in counts if counts[path]]
    return found[0].relative_to(ROOT) if len(found) == 1 and counts[found[0]] == 1 else None


def plant(fault: dict, path: Path, tree: Path) -> str:
    """Return whether a test fails with the fault, and which: one that passes without it."""
    tests = [f"tests/{name}" for name in fault["tests"]]
    text, times = path.read_text(encoding="utf-8"), path.stat()
    path.write_text(text.replace(fault["before"], fault["after"]), encoding="utf-8")
    try:
        failed = failing(tests, tree)
    finally:  # its time as well: Python looks at it to see whether a module is to be compiled again
        path.write_text(text, encoding="utf-8")
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
    if not failed:
        return "survived"
    _, is_named, test = failed.partition(" tests/")
    without = failing(["tests/" + test] if is_named else tests, tree)
    return f"tests fail without it: {without}" if without else f"caught: {failed}"


def failing(tests: list[str], tree: Path) -> str:
    """Return the first test that fails, "" if none does."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "--tb=no", "-rfE"]
    command += ["-o", "faulthandler_timeout=1800", *tests]  # of one test: a low priority beside other work takes long
    log = tree.with_name("log")
    with log.open("wb") as stream:
        env = os.environ | {"PYTHONPATH": str(tree), "QUICK_FIRST": "1"}
        process = subprocess.Popen(command, cwd=tree, env=env, stdout=stream, stderr=stream, start_new_session=True)
        try:
            status = process.wait()
        finally:  # with what its tests may have left behind
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    named = [line for line in lines if line.startswith(("FAILED ", "ERROR "))] or lines[-1:]
    return (named[0].split(" - ")[0] if named else f"status {status}") if status else ""


def print_table(faults: list[dict]) -> None:
    print(f"\n{'':10}" + "".join(f"{verdict:>23}" for verdict in VERDICTS))
    for room in [*dict.fromkeys(fault["room"] for fault in faults), "all"]:
        count = Counter(fault["verdict"].partition(":")[0] for fault in faults if room in ("all", fault["room"]))
        print(f"{room:10}" + "".join(f"{count[verdict]:23}" for verdict in VERDICTS))


if __name__ == "__main__":
    main()
