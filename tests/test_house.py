"""The rules of the house that a machine can check.

Who may import whom, where shader text, clocks and row flips live.

A new module at the top of hmdwarp/ gets its place in FLOORS; a test here says so if it has none.
"""

from __future__ import annotations

import ast
import functools
import gc
import graphlib
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from together import together

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "hmdwarp"

# From the ground up; a module imports from floors below its own, or from its own unit.
FLOORS = [
    {"base"},
    {"geometry"},
    {"gpu", "poses", "headsets"},
    {"scenes"},
    {"frames"},
    {"link"},
    {"sources"},
    {"client"},
    {"cloudlight"},
    {"metrics"},
    {"report"},
    {"pipeline"},
    {"image"},
    {"check"},
    {"display", "web"},
    {"run"},
    {"experiments"},
    {"study"},
    {"cli"},
    {"__main__"},
]
# What the order of the floors alone would allow, and the house does not.
APART = {
    "gpu": {"geometry"},
    "scenes": {"poses", "headsets"},
    "sources": {"headsets", "link"},
    "frames": {"gpu"},
    "link": {"gpu", "headsets", "scenes", "poses", "frames"},
    "client": {"link", "poses"},
    "metrics": {"client", "sources", "link"},
    "report": {"client", "link", "gpu"},
}
CLOCK_READERS = {
    "client/client_scene.py",
    "gpu/timers.py",
    "pipeline/channel.py",
    "pipeline/loop.py",
    "pipeline/remote.py",
    "cli/doctor.py",
    "study/session/markers.py",
    "study/store/store.py",
}
# Display: its clock is the one all live times are on.
CLOCK_FOLDERS = ("cli/", "sources/feed/", "run/", "experiments/", "display/")
HEAVY = (
    "scipy",
    "moderngl",
    "trimesh",
    "matplotlib",
    "skimage",
    "av",
    "flip_evaluator",
    "xr",
    "glfw",
    "PIL",
    "jinja2",
    "rich",
)


def modules() -> list[Path]:
    return sorted(p for p in PACKAGE.rglob("*.py") if "_data" not in p.parts)


def name_of(path: Path) -> str:
    return path.relative_to(PACKAGE).as_posix()


@pytest.fixture(scope="module", autouse=True)
def trees_are_dropped():
    """Two million objects, not to be collected now, and which later tests would carry along."""
    before = gc.get_threshold()
    gc.set_threshold(100_000)
    yield
    gc.set_threshold(*before)
    tree_of.cache_clear()
    nodes_of.cache_clear()


@functools.cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"), str(path))


@functools.cache
def nodes_of(path: Path) -> list[ast.AST]:
    return list(ast.walk(tree_of(path)))


def unit_of(path: Path) -> str:
    """The part of the house a file belongs to: its top folder, or its own stem at the top.

    "" for hmdwarp/__init__.py.
    """
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return "" if parts == ("__init__",) else parts[0]


def imports_of(path: Path) -> set[str]:
    return {unit_of(other) for other in files_imported(path)} - {unit_of(path)}


def floor_of(unit: str) -> int | None:
    return next((number for number, units in enumerate(FLOORS) if unit in units), None)


def forbidden(unit: str, imported: set[str]) -> set[str]:
    """Those of `imported` that a module of `unit` may not use."""
    level = floor_of(unit)
    return {other for other in imported if other == "" or floor_of(other) >= level or other in APART.get(unit, set())}


def test_every_part_has_its_place():
    homeless = {unit_of(path) for path in modules()} - {""} - set().union(*FLOORS)
    assert not homeless, f"say in FLOORS of this file where {sorted(homeless)} stands"


# Lines of Python in each room: today's bound, and the budget that the room is to reach. A room
# that is done has its budget as its bound. Bounds go down alone.
ROOMS = {
    "sources": (8500, 8500),
    "run": (5400, 5400),
    "client": (6500, 6500),
    "cloudlight": (3600, 3600),  # done
    "scenes": (4600, 4600),
    "poses": (4500, 4500),
    "pipeline": (3700, 3700),
    "link frames": (3100, 3100),
    "image check": (3200, 3200),
    "gpu geometry headsets": (3100, 3100),
    "report": (4200, 4200),
    "experiments": (3200, 3200),
    "metrics base": (3085, 3085),
    "cli": (2400, 2400),
    "display web": (4000, 4000),
    "study": (10000, 10000),
    "": (15, 15),  # the modules beside the packages
}
TEST_LINES = (58000, 58000)
DOC_WORDS = (55000, 55000)  # of docs/*.md as `wc -w` counts them


def lines_of(paths: list[Path]) -> int:
    return sum(path.read_text(encoding="utf-8").count("\n") for path in paths)


def units_of_room(path: Path) -> str:
    """The folder that a file lies in, "" for those at the top."""
    parts = path.relative_to(PACKAGE).parts
    return parts[0] if len(parts) > 1 else ""


def test_every_package_is_in_a_room():
    rooms = {unit for room in ROOMS for unit in room.split() or [""]}
    assert {units_of_room(path) for path in modules()} <= rooms


@pytest.mark.parametrize("room", ROOMS, ids=lambda room: room.replace(" ", "+") or "top")
def test_a_room_keeps_within_its_bound(room):
    bound, budget = ROOMS[room]
    lines = lines_of([path for path in modules() if units_of_room(path) in (room.split() or [""])])
    assert lines <= bound, (
        f"{room or 'hmdwarp/*.py'} has {lines:,} lines, bound {bound:,} (to become {budget:,}): "
        "a feature in, a feature out. Take something out of this room; do not raise its bound"
    )


def test_the_tests_keep_within_their_bound():
    bound, budget = TEST_LINES
    lines = lines_of([*(ROOT / "tests").rglob("*.py")])
    assert lines <= bound, f"tests have {lines:,} lines, bound {bound:,} (to become {budget:,}): a test in, a test out"


def test_the_docs_keep_within_their_bound():
    bound, budget = DOC_WORDS
    words = sum(len(page.read_text(encoding="utf-8").split()) for page in (ROOT / "docs").glob("*.md"))
    assert words <= bound, f"docs have {words:,} words, bound {bound:,} (to become {budget:,}): say it once"


def test_imports_point_one_way():
    assert "cli" not in imports_of(PACKAGE / "__init__.py")  # the public names come from below the command line
    wrong = {name_of(path): forbidden(unit, imports_of(path)) for path in modules() if (unit := unit_of(path))}
    found = {name: sorted(units) for name, units in wrong.items() if units}
    assert not found, f"these import what their part of the house may not know: {found}"


def test_the_client_draws_by_passes_of_the_server_and_knows_no_other_source():
    found = {other for path in modules() if unit_of(path) == "client" for other in files_imported(path)}
    assert {name_of(path) for path in found if unit_of(path) == "sources"} == {"sources/server/__init__.py"}


def test_the_core_does_not_know_cloudlight():
    """It is found as another package is: nothing imports it, not for annotations, or names it."""
    others = [path for path in modules() if unit_of(path) != "cloudlight"]
    users = {name_of(path) for path in others if any(unit_of(other) == "cloudlight" for other in files_imported(path))}
    users |= {name_of(path) for path in others if any("cloudlight." in text for _, text in strings_of(path))}
    assert not users, f"these know cloudlight: {users}"


def strings_of(path: Path) -> list[tuple[int, str]]:
    return [(n.lineno, n.value) for n in nodes_of(path) if isinstance(n, ast.Constant) and isinstance(n.value, str)]


def test_no_shader_text_in_python():
    """Shaders lie in shaders/, where tools find them and compiler messages point.

    Only the loader writes a version line.
    """
    marks = ("void main", "gl_Position", "layout(local_size", "imageStore(", "#version ")
    found = [
        f"{name_of(path)}:{line}: {mark}"
        for path in modules()
        for line, text in strings_of(path)
        for mark in marks
        if mark in text and (name_of(path), mark) != ("gpu/shaders.py", "#version ")
    ]
    assert not found, f"shader text: {found}"


PICTURES = re.compile(
    r"image|picture|colour|depth|truth|shown|rendered|late|coverage|mask|pixels|rgb|error", re.IGNORECASE
)


def row_flips(tree: ast.AST) -> list[int]:
    """Lines that turn a picture upside down.

    Flipud, np.flip, FLIP_TOP_BOTTOM, or [::-1] first in what is named like a picture.
    """
    lines = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            guilty = node.attr in ("flipud", "FLIP_TOP_BOTTOM") or ast.unparse(node) in ("np.flip", "ImageOps.flip")
            lines += [node.lineno] if guilty else []
        elif isinstance(node, ast.Subscript):
            first = node.slice.elts[0] if isinstance(node.slice, ast.Tuple) and node.slice.elts else node.slice
            backwards = isinstance(first, ast.Slice) and first.step is not None and ast.unparse(first) == "::-1"
            operand = ast.unparse(node.value)
            if backwards and PICTURES.search(operand) and not re.search(r"(size|shape)\b", operand):
                lines.append(node.lineno)
    return lines


def test_rows_flip_in_one_module_only():
    others = [path for path in modules() if name_of(path) != "gpu/textures.py"]
    found = [f"{name_of(path)}:{line}" for path in others for line in row_flips(tree_of(path))]
    assert not found, f"use gpu.textures (upload, download, flip_rows) in place of {found}"


def clock_reads(tree: ast.AST) -> list[int]:
    lines = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            lines += [node.lineno for alias in node.names if alias.name == "time"]
        elif isinstance(node, ast.ImportFrom):
            lines += [node.lineno] if node.module == "time" and not node.level else []
        elif (
            isinstance(node, ast.Attribute)
            and node.attr in ("now", "utcnow", "today")
            and "date" in ast.unparse(node.value)
        ):
            lines.append(node.lineno)
    return lines


def test_no_pass_reads_a_clock():
    """Time comes in as an argument, so that a replay is the same twice."""
    others = [path for path in modules() if name_of(path) not in CLOCK_READERS]
    others = [path for path in others if not name_of(path).startswith(CLOCK_FOLDERS)]
    found = [f"{name_of(path)}:{line}" for path in others for line in clock_reads(tree_of(path))]
    assert not found, f"only the drivers, the displays, the timers and the command line may read a clock: {found}"


def files_imported(path: Path) -> set[Path]:
    """The files of the package that `path` takes names from, annotations included."""
    package, found = ("hmdwarp", *path.relative_to(PACKAGE).parent.parts), set()
    for node in nodes_of(path):
        absolute = [a.name for a in node.names] if isinstance(node, ast.Import) else []
        assert not any(name.partition(".")[0] == "hmdwarp" for name in absolute), f"{path}: from . import what it needs"
        if not isinstance(node, ast.ImportFrom) or not node.level:
            continue
        base = PACKAGE.parent.joinpath(*package[: len(package) - node.level + 1], *(node.module or "").split("."))
        for alias in node.names:
            places = (
                base / f"{alias.name}.py",
                base / alias.name / "__init__.py",
                base.with_suffix(".py"),
                base / "__init__.py",
            )
            found |= set([place for place in places if place.is_file()][:1])
    return found - {path}


# What stands before a library that loads late: commands, for help; glfw, whose windowing system
# start() chooses first; Dear ImGui and OpenXR, which a machine may lack; SciPy, for files, skins.
LATE = ("cli/", "display/desktop/", "display/openxr/", "scenes/_load.py", "scenes/library/", "report/image_result.py")


def late_imports(source: str, *, functions: bool = True) -> list[int]:
    """Lines that import from the house itself for annotations alone, or in a function."""
    nodes = list(ast.walk(ast.parse(source)))
    late = [node for node in nodes if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"]
    late += [node for node in nodes if functions and isinstance(node, ast.FunctionDef)]
    return sorted({n.lineno for block in late for n in ast.walk(block) if isinstance(n, ast.ImportFrom) and n.level})


def test_only_a_face_loads_late():
    """Our own modules are imported at the top; what loads later is reached through its package."""
    texts = {name_of(path): path.read_text(encoding="utf-8") for path in modules()}
    found = [f"{name}:{n}" for name, text in texts.items() if not name.startswith(LATE) for n in late_imports(text)]
    assert not found, f"import these at the top: {found}"
    found = [name for name, text in texts.items() if name.startswith("cli/") and late_imports(text, functions=False)]
    assert not found, f"annotate by the package, such as poses.PoseTrack: {found}"


def test_no_private_module_is_imported_by_another_package():
    wrong = {
        f"{name_of(path)} -> {name_of(other)}"
        for path in modules()
        for other in files_imported(path)
        if other.stem.startswith("_") and other.stem != "__init__" and other.parent not in (path.parent, *path.parents)
    }
    assert not wrong, f"export what they need from the package's face: {sorted(wrong)}"


def exported_by(package: Path) -> dict[str, str]:
    """The names that a package's face defines or re-exports, each with the module it comes from."""
    stub, face = package / "__init__.pyi", package / "__init__.py"
    body = tree_of(stub if stub.is_file() else face).body
    imports = [node for node in body if isinstance(node, ast.ImportFrom) and node.level == 1 and node.module]
    own = [node.name for node in body if isinstance(node, ast.ClassDef | ast.FunctionDef)]
    return {alias.name: node.module for node in imports for alias in node.names} | dict.fromkeys(own, "__init__")


def private_names(source: str, package: tuple[str, ...], part: str) -> set[str]:
    """What `source`, lying in `package`, takes from outside of `part` that no face exports.

    A file beside the packages, such as __main__.py, is its own face.
    """
    found = set()
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.ImportFrom) or not node.level:
            continue
        parts = (*package[: len(package) - node.level + 1], *(node.module or "").split("."))
        if parts[1:2] == (part,) or len(parts) < 2:
            continue
        place = PACKAGE.parent.joinpath(*parts)
        if place.is_dir():
            known = exported_by(place)
            found |= {".".join((*parts[1:], alias.name)) for alias in node.names if alias.name not in known}
        elif len(parts) > 2:
            found.add(".".join(parts[1:]))
    return found


@together("path", [p for p in modules() if unit_of(p) == "study"])
def test_study_takes_public_names_alone(path):
    package = ("hmdwarp", *path.relative_to(PACKAGE).parent.parts)
    wrong = private_names(path.read_text(encoding="utf-8"), package, "study")
    assert not wrong, f"{name_of(path)}: take these from a package's face: {sorted(wrong)}"


def test_study_stands_apart():
    """Only the command line knows of studies."""
    users = {unit_of(path) for path in modules() if "study" in imports_of(path)}
    assert users == {"cli"}


def test_no_files_import_each_other_in_a_circle():
    """Two files that need each other are one idea.

    A package's face counts as any other file where it imports plainly; a lazy one imports nothing.
    """
    order = graphlib.TopologicalSorter({path: files_imported(path) for path in modules()})
    try:
        order.prepare()
    except graphlib.CycleError as error:
        pytest.fail(" -> ".join(name_of(path) for path in error.args[1]))


def loaded_by(code: str) -> set[str]:
    """The top-level modules in sys.modules of a fresh Python after `code`."""
    done = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys; print(*{{name.partition('.')[0] for name in sys.modules}})"],
        check=True,
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    return set(done.stdout.split())


def test_importing_the_package_loads_nothing_heavy():
    assert not loaded_by("import hmdwarp") & set(HEAVY)


def test_every_module_says_what_it_is_for():
    written = [path for path in modules() if path.read_text(encoding="utf-8").strip()]
    silent = [name_of(path) for path in written if not ast.get_docstring(tree_of(path))]
    assert not silent, f"these have no docstring: {silent}"


# --- what must not be in any file ---------------------------------------------------------------


def tracked_texts() -> list[tuple[str, str]]:
    """(path, text) of every text file that git tracks."""
    if not shutil.which("git") or not (ROOT / ".git").exists():
        pytest.skip("not a git checkout, so nobody knows which files belong to the project")
    names = subprocess.run(
        ["git", "-c", "safe.directory=*", "ls-files", "-z"], check=True, capture_output=True, text=True, cwd=ROOT
    ).stdout
    out = []
    for name in filter(None, names.split("\0")):
        data = (ROOT / name).read_bytes() if (ROOT / name).is_file() else b""
        if b"\0" not in data:
            out.append((name, data.decode(errors="replace")))
    return out


FORBIDDEN = {
    "a path of somebody's machine": re.compile(r"(?<![\w./~-])/(?:home|root|work|Users|mnt|tmp)/\w"),
    "the address of a package index": re.compile(
        r"https?://\S*(?:py[p]i|python[h]osted|/simple\b)|--(?:extra-)?index-url|--find-(?:links)"
    ),
}


@together("what", FORBIDDEN)
def test_no_file_holds(what):
    hits = [
        f"{name}:{number}"
        for name, text in tracked_texts()
        for number, line in enumerate(text.splitlines(), start=1)
        if FORBIDDEN[what].search(line)
    ]
    assert not hits, f"{what} in {', '.join(hits)}"


def test_the_pins_name_every_dependency():
    """Set-up installs from .ci/constraints.txt.

    A dependency without a line there would not be reproducible.
    """
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [
        *project["dependencies"],
        *(line for extra in project["optional-dependencies"].values() for line in extra),
    ]
    pins = [
        line
        for line in (ROOT / ".ci" / "constraints.txt").read_text(encoding="utf-8").splitlines()
        if line and line[0] != "#"
    ]
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", pin) for pin in pins)
    pinned = {pin.partition("==")[0].lower().replace("_", "-") for pin in pins}
    assert {re.match(r"[\w-]+", line)[0].lower().replace("_", "-") for line in wanted} <= pinned
