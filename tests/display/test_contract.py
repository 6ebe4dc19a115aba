"""One contract for all displays: what each does, and which members each has.

The cases stand in contract.py and run in a program for each display: a window's context does not
mix with other tests', and OpenXR needs Monado's root.
"""

from __future__ import annotations

import ast
import functools
import json
import os
import subprocess
import sys
from collections import defaultdict
from contextlib import ExitStack
from pathlib import Path

import needs
import pytest
from openxr.inside import run_inside

from .contract import BACKENDS, CASES
from .programs import PATHS, ROOT
from .virtual_screen import VirtualScreen

DISPLAYS = ROOT / "hmdwarp" / "display"
# A window starts an X server, OpenXR a runtime.
MARKS = {"window": [pytest.mark.slow, needs.programs("Xvfb")], "openxr": pytest.mark.slow}


@pytest.fixture(scope="module")
def failures_of(tmp_path_factory):
    """failures_of(name) -> why each case failed on that display ("": it holds)."""

    @functools.cache
    def run(name: str) -> dict[str, str]:
        with ExitStack() as stack:
            if name == "openxr":
                done = run_inside(["python3", "-m", "display.contract", name])
            else:
                environment = dict(os.environ)
                if name == "window":
                    screen = VirtualScreen(tmp_path_factory.mktemp("screen"), (400, 300))
                    environment = stack.enter_context(screen).environment
                command = [sys.executable, "-W", "error", "-m", "display.contract", name]
                how = {"capture_output": True, "text": True}
                done = subprocess.run(command, check=False, env={**environment, "PYTHONPATH": PATHS}, **how)
        lines = [json.loads(line) for line in done.stdout.splitlines() if line.startswith('{"case"')]
        broken = f"not run: the program ended with {done.returncode}\n{done.stderr[-4000:]}"
        return defaultdict(lambda: broken) | {line["case"]: line["failure"] for line in lines}

    return run


@pytest.mark.parametrize(("name", "case"), [pytest.param(*each, marks=MARKS.get(each[0], ())) for each in CASES])
def test_a_display_keeps_the_contract(failures_of, name, case):
    if failure := failures_of(name)[case]:
        pytest.fail(failure, pytrace=False)


# --- members, by the source alone: also of displays whose library is not installed ---


def classes_of(path: Path) -> list[ast.ClassDef]:
    return [node for node in ast.parse(path.read_text(encoding="utf-8")).body if isinstance(node, ast.ClassDef)]


@functools.cache
def all_classes() -> dict[str, ast.ClassDef]:
    return {node.name: node for path in sorted(DISPLAYS.rglob("*.py")) for node in classes_of(path)}


def members_of(node: ast.ClassDef) -> dict[str, str]:
    """Public names of a class and of its bases in the package.

    Methods with names and defaults of their parameters, "" for data.
    """
    found: dict[str, str] = {}
    for base in node.bases:
        if isinstance(base, ast.Name) and base.id in all_classes():
            found |= members_of(all_classes()[base.id])
    for statement in ast.walk(node):
        if isinstance(statement, ast.FunctionDef):
            is_property = any(
                isinstance(decorator, ast.Name) and decorator.id == "property" for decorator in statement.decorator_list
            )
            if statement in node.body:  # not those inside one
                found[statement.name] = "" if is_property else parameters_of(statement)
        targets = statement.targets if isinstance(statement, ast.Assign) else []
        targets = [statement.target] if isinstance(statement, ast.AnnAssign) else targets
        for target in [part for assigned in targets for part in ast.walk(assigned)]:
            own = isinstance(target, ast.Attribute) and isinstance(target.value, ast.Name) and target.value.id == "self"
            if own:
                found[target.attr] = ""
            elif isinstance(target, ast.Name) and statement in node.body:
                found[target.id] = ""
    return {name: what for name, what in found.items() if not name.startswith("_")}


def parameters_of(function: ast.FunctionDef) -> str:
    bare = ast.parse(ast.unparse(function)).body[0]
    for argument in ast.walk(bare.args):
        if isinstance(argument, ast.arg):
            argument.annotation = None
    return f"({ast.unparse(bare.args)})"


PROTOCOL = members_of(next(node for node in classes_of(DISPLAYS / "_base.py") if node.name == "Display"))
FOUND = {name: node for name, node in all_classes().items() if name.endswith("Display") and name != "Display"}


def test_all_displays_are_found():
    assert set(FOUND) == {"DesktopDisplay", "OffscreenDisplay", "OpenXrDisplay"}
    assert len(BACKENDS) == len(FOUND), "a display without a contract test"


@pytest.mark.parametrize("name", FOUND)
def test_a_display_has_the_members_of_the_protocol_and_no_others(name):
    assert members_of(FOUND[name]) == PROTOCOL
