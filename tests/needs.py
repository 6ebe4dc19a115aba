"""What tests need from the machine beside Python: programs and rights.

A test that lacks one is skipped for a reason of one form, so that a run can end by naming all that
it left out, and how to get it.
"""

from __future__ import annotations

import re
import shutil
import tomllib
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

import pytest

TOOLS = tomllib.loads((Path(__file__).parents[1] / ".ci" / "tools.toml").read_text(encoding="utf-8"))
MISSING = re.compile(r"no (?P<what>.+?) here \((?P<remedy>.+)\)$", re.DOTALL)
APT = "Debian, Ubuntu: sudo apt-get install "
AS_ROOT = "sudo make test"  # remedy of what only root may do
TOLD = "told at the end"  # a property of a test: a line that the run ends with


def program(name: str) -> str | None:
    """Return the path of a program that .ci/tools.toml lists, also under its other names."""
    names = [name, *TOOLS["other_names"].get(name, [])]
    return next(filter(None, map(shutil.which, names)), None)


def missing(what: str, remedy: str) -> str:
    """Return the reason to skip a test for what `make test` could have with the remedy."""
    return f"no {what} here ({remedy})"


def programs(*names: str) -> pytest.MarkDecorator:
    """Mark what needs these programs: it is skipped without the first that is missing."""
    reason = _without(names)
    return pytest.mark.skipif(reason is not None, reason=reason or "")


def _without(names: Iterable[str]) -> str | None:
    lacking = next((name for name in names if program(name) is None), None)
    return lacking and missing(lacking, APT + TOOLS["packages"][lacking])


def packed(name: str) -> Path:
    """Return the package of npm that .ci/setup.py brings."""
    return Path(__file__).parents[1] / "build" / "npm" / f"{name}-{TOOLS['npm'][name][0]}.tgz"


def from_npm(name: str) -> pytest.MarkDecorator:
    """Mark what needs a package of npm."""
    return pytest.mark.skipif(not packed(name).exists(), reason=missing(name, "npm, then make test"))


def left_out(skipped: Iterable[tuple[str, str]]) -> str | None:
    """Return one line that names what a run left out, for lack of what, and the remedy.

    skipped: (test, reason) of each. None where nothing is missing that can be had.
    """
    tests: dict[str, set[str]] = defaultdict(set)
    lacking: dict[str, set[str]] = defaultdict(set)
    for test, reason in skipped:
        found = MISSING.search(reason)
        if found:
            remedy = APT if found["remedy"].startswith(APT) else " ".join(found["remedy"].split())
            tests[remedy].add(test)
            lacking[remedy].add(found["what"])
    parts = []
    for remedy, names in sorted(lacking.items()):
        packages = sorted({TOOLS["packages"][name] for name in names}) if remedy == APT else []
        how = remedy + " ".join(packages)
        parts.append(f"{len(tests[remedy])} for lack of {', '.join(sorted(names))} ({how})")
    return f"left out: {'; '.join(parts)}" if parts else None
