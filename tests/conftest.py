"""Fixtures that every test may use, the order of tests, and what a run says at its end."""

from __future__ import annotations

import functools
import gc
import os
import signal
import sys
from pathlib import Path

sys.path += [str(Path(__file__).resolve().parents[1] / part) for part in ("docs", "docs/measure")]

import attrs
import contexts
import needs
import properties  # noqa: F401 (loads the profile of Hypothesis before any test is read)
import pytest

# Two workers share two cores, and pictures are small: threads of llvmpipe, BLAS and OpenMP (FLIP)
# cost more in waiting for each other than they do. Set before any of them is loaded.
for _name, _value in {"LP_NUM_THREADS": "0", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}.items():
    os.environ.setdefault(_name, _value)
# Without compiled modules each program that a test starts compiles 900 files, 1.6 s of a
# replay's 7.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False
FREEZE_AT = 20_000  # objects, which take the collector about 12 ms
COUNT_FROZEN = gc.get_freeze_count
USUALLY_SLOW_S = 10.0  # of a test that is marked slow without a number
# What `make test-quick` runs: what needs no other process, and of the GPU's passes the contracts.
QUICK = (
    "client/classes", "client/test_contract", "client/test_forward.py", "client/test_fills.py",
    "client/test_plan", "client/test_variants.py", "client/test_warps.py", "experiments/bench/test_cases.py",
    "frames/", "geometry/", "gpu/test_shader_files.py", "hard_cases/", "headsets/", "link/", "metrics/", "options/",
    "pipeline/auto", "poses/", "sources/server/test_visibility.py", "study/design/", "study/scales/",
    "study/statistics/", "test_colour.py", "test_glossary.py", "test_house.py", "test_public.py", "test_registry.py",
)  # fmt: skip
DEVELOPMENT_TRACES = Path(__file__).resolve().parents[2] / "shared" / "traces"


@pytest.fixture(scope="module")
def gpu():
    """One OpenGL context for the tests of a module (llvmpipe where there is no GPU)."""
    from hmdwarp.gpu import Gpu

    with Gpu() as made:
        yield made


def pytest_sessionstart() -> None:
    """Build each shipped scene once in a session, read recordings once, use OpenGL contexts again.

    Nobody writes to them; `room` takes 1.5 s, a recording 0.1 s of each small run.

    Before tests are collected, because lists of cases read scenes.
    `scenes.get(name).build.__wrapped__()` builds it afresh.
    """
    from hmdwarp.base import recording_names
    from hmdwarp.poses import TraceOptions, formats
    from hmdwarp.scenes import scenes

    read, once = formats.load_trace, functools.cache(formats.load_trace)

    @functools.wraps(read)
    def load_trace(name_or_path, options=None):
        shipped = (
            isinstance(name_or_path, str)
            and name_or_path in recording_names()
            and isinstance(options, TraceOptions | None)
        )
        return (once if shipped else read)(name_or_path, options)

    formats.load_trace = load_trace
    gc.disable()  # what collecting the tests makes stays
    contexts.install()
    found = scenes.get
    scenes.get = functools.cache(lambda name: attrs.evolve(found(name), build=functools.cache(found(name).build)))


def pytest_collection_finish() -> None:
    """Keep the garbage collector from scanning modules, shaders and 12,000 tests again and again.

    Each run of `live` collects first: 0.4 s among all these objects, and a study's session has 35.
    """
    _freeze()
    gc.enable()


@pytest.fixture(scope="module", autouse=True)
def what_modules_leave_is_frozen_or_freed():
    """Freeze what a module's tests have imported and keep; free textures that none of them has."""
    yield
    if len(gc.get_objects(generation=2)) > FREEZE_AT:
        _freeze()
    if (shared := _current_gpu()) is not None:
        gc.collect()
        shared.forget_released()
        shared.give_back_memory()
    contexts.shrink()


@pytest.fixture(autouse=True)
def what_a_test_drew_with_is_closed():
    """Close the scenes of clients that a test made, and free what it dropped on the GPU."""
    made = sys.modules.get("client_scene")
    before = len(made.ClientScene.open_ones) if made else 0
    yield
    if made := sys.modules.get("client_scene"):
        for one in made.ClientScene.open_ones[before:]:
            one.close()
    if (shared := _current_gpu()) is not None:
        shared.forget_released()


def _freeze() -> None:
    """Freeze what there is, and let nobody count it: 60 ms at each beginning of `live`."""
    gc.collect()
    gc.freeze()
    gc.get_freeze_count = functools.wraps(COUNT_FROZEN)(lambda: 1)


@pytest.fixture(autouse=True)
def no_context_is_left_behind():
    """Fail the test that leaves an OpenGL context open.

    Every later test would draw there: black pictures, far from the cause.
    """
    before = _current_gpu()
    yield
    assert _current_gpu() is before, "this test left an OpenGL context open: close it"
    was_on = gc.isenabled()
    gc.enable()
    assert was_on, "this test left garbage collection off: memory of later ones would grow"


def _current_gpu():
    context = sys.modules.get("hmdwarp.gpu.context")
    return context and getattr(context._thread, "gpu", None)


@pytest.fixture(scope="session")
def real_traces() -> Path:
    """The folder of real recorded head motion used in development; no part of the project."""
    if not DEVELOPMENT_TRACES.is_dir():
        pytest.skip(f"no real head traces at {DEVELOPMENT_TRACES} (they lie beside the development checkout only)")
    return DEVELOPMENT_TRACES


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--quick", action="store_true", help="Run one case of each test of the quick parts: see QUICK.")


def pytest_configure() -> None:
    """Take signals as under a terminal.

    Under nohup, or in the background of a script, they are ignored, and so they would be in every
    program that a test starts and then interrupts.
    """
    for number, usual in ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, signal.SIG_DFL)):
        if signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, usual)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Run slow tests first, the longest first of all: at the end none keeps one worker busy alone.

    Many of them wait more than they work, and the quick ones of the other worker fill that time.
    Last with QUICK_FIRST, for who stops at the first failure.
    """

    def order(item: pytest.Item) -> float:
        slow = item.get_closest_marker("slow")
        return -(slow.args[0] if slow.args else USUALLY_SLOW_S) if slow is not None else 0.0

    items.sort(key=order, reverse="QUICK_FIRST" in os.environ)
    if config.option.quick:
        chosen = _quick(items)
        config.hook.pytest_deselected(items=[item for item in items if item not in chosen])
        items[:] = chosen


def _quick(items: list[pytest.Item]) -> list[pytest.Item]:
    """Return the first case of each test of the quick parts that is not marked slow."""
    root = Path(__file__).parent
    first: dict[tuple[Path, str], pytest.Item] = {}
    for item in items:
        name = item.path.relative_to(root).as_posix()
        if name.startswith(QUICK) and item.get_closest_marker("slow") is None:
            first.setdefault((item.path, item.name.partition("[")[0]), item)
    return list(first.values())


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Tell what tests have to tell and name what was left out.

    Before pytest's closing line, or where LEFT_OUT=last after it.
    """
    stats = terminalreporter.stats
    told = [what for report in stats.get("passed", []) for name, what in report.user_properties if name == needs.TOLD]
    skipped = stats.get("skipped", [])
    left_out = needs.left_out((report.nodeid, report.longrepr[2]) for report in skipped)
    lines = [*told, *([left_out] if left_out else [])]
    if os.environ.get("LEFT_OUT") == "last":
        config.add_cleanup(lambda: print(*lines, sep="\n") if lines else None)
    else:
        for line in lines:
            terminalreporter.write_line(line)
