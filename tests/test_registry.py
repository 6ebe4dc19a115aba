"""Registries: found by file name, one idiom, open to other packages through entry points."""

from __future__ import annotations

import importlib
import pkgutil
import sys
from pathlib import Path

import pytest

import hmdwarp
from hmdwarp.base import InputError, Registry, UnknownNameError, _entry_points, unknown_name


def registries() -> dict[str, Registry]:
    """Every registry of the package, by the module and the name it is bound to."""
    found = {}
    for module in pkgutil.walk_packages(hmdwarp.__path__, "hmdwarp."):
        if module.name.endswith("__main__"):
            continue
        loaded = importlib.import_module(module.name)
        for name, value in vars(loaded).items():
            if isinstance(value, Registry) and not any(value is known for known in found.values()):
                found[f"{module.name}.{name}"] = value
    return found


REGISTRIES = registries()


@pytest.mark.parametrize("where", REGISTRIES)
def test_a_registry_is_a_lower_case_plural_and_every_file_registers_its_own_name(where):
    registry = REGISTRIES[where]
    bound = where.rpartition(".")[2]
    assert bound == bound.lower() and registry.group.startswith("hmdwarp.")
    assert [entry.name for entry in registry] == registry.names() != []


def test_no_two_registries_share_an_entry_point_group():
    groups = [registry.group for registry in REGISTRIES.values()]
    assert len(groups) == len(set(groups))


@pytest.mark.parametrize("where", REGISTRIES)
def test_an_unknown_name_offers_the_nearest(where):
    registry = REGISTRIES[where]
    known = registry.names()[0]
    with pytest.raises(UnknownNameError, match=f"unknown {registry.kind} '{known}x'.*{known}"):
        registry.get(f"{known}x")


def test_a_second_entry_of_a_name_is_refused():
    from hmdwarp.client.fills import fills

    with pytest.raises(ValueError, match="fill 'none' is registered already: choose another name"):
        fills.register(fills.get("none"))


def plugin(folder: Path, code: str, group: str = "hmdwarp.fills", name: str = "plugged_in") -> None:
    """A package as pip installs it: its module and the metadata that names its entry point."""
    (folder / "my_fills.py").write_text(code, encoding="utf-8")
    info = folder / "my_fills-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: my-fills\nVersion: 1.0\n", encoding="utf-8")
    (info / "entry_points.txt").write_text(f"[{group}]\n{name} = my_fills\n", encoding="utf-8")


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("import a_package_that_is_not_here", "cannot be loaded .*ModuleNotFoundError.*update or uninstall"),
        ("", "no fill 'plugged_in' is registered"),
    ],
)
def test_a_broken_plugin_is_named(tmp_path, monkeypatch, code, message):
    plugin(tmp_path, code)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "my_fills", raising=False)
    _entry_points.cache_clear()
    registry: Registry = Registry("fill", "hmdwarp.client.fills")
    try:
        with pytest.raises(InputError, match=f"my-fills.*{message}|{message}"):
            registry.get("plugged_in")
    finally:
        _entry_points.cache_clear()
        sys.modules.pop("my_fills", None)


@pytest.mark.parametrize(
    ("name", "near"),
    [("foward", "forward"), ("Forward", "forward"), ("rift", "rift-dk1"), ("auto", ""), ("nosuch", ""), ("", "")],
)
def test_a_suggestion_is_near_or_there_is_none(name, near):
    known = ["forward", "rift-dk1", "splat", "workshop", "rotation"]
    said = str(unknown_name("warp", name, known))
    assert f"did you mean '{near}'?" in said if near else "did you mean" not in said
