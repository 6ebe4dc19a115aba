"""Registries: names to things, one file per entry, found by its name and imported on first use.

Every entry registers itself by `@warps.register`, as a class or as an object with a `name`. Where a
module declares several small entries, its registry names it for each (`modules`). An entry that is
data alone is a table, NAME.toml, in the registries that say what to make of one.

Other packages add entries through entry points of the group `hmdwarp.<registry>`, such as
`hmdwarp.warps`; packages of hmdwarp itself that nothing imports through their entry_points.toml.
"""

from __future__ import annotations

import functools
import importlib
import pkgutil
import sys
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import attrs

from .errors import InputError, unknown_name

if TYPE_CHECKING:
    import importlib.metadata

T = TypeVar("T")
E = TypeVar("E")
Row = dict[str, str]


def describe(entries: Iterable[Any], columns: str = "", more: Callable[[Any], Row] = lambda entry: {}) -> list[Row]:
    """Return a row of texts for each entry: its name, its summary, `columns`, and what `more` adds.

    columns: names of attributes; KEY=ATTRIBUTE for one under another name.
    """
    named = [each.partition("=") for each in columns.split()]
    return [
        {name: getattr(entry, name, "") for name in ("name", "summary")}
        | {key: _text(attrgetter(attribute or key)(entry)) for key, _, attribute in named}
        | more(entry)
        for entry in entries
    ]


def _text(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, type):  # an attrs class of settings
        value = [f"{field.name}={field.default}" for field in attrs.fields(value)]
    return (value if isinstance(value, str) else ", ".join(value) if isinstance(value, Iterable) else "") or "none"


@attrs.define(eq=False, slots=False)
class Registry(Generic[T]):
    """Entries of one kind: one per public file of `package`, if any, plus those of other packages.

    File names give the names, so listing them imports no entry; those with an underscore are none.
    """

    kind: str  # singular, for messages: "warp"
    package: str  # dotted name of the package that holds the entries
    group: str = ""  # of the entry points, by default the last part of the package's name
    _of_table: Callable[[str, dict[str, Any]], T] | None = None  # makes an entry of its name and its table
    _holds_objects: bool = attrs.field(default=False, kw_only=True)  # a class that registers is made
    columns: str = attrs.field(default="", kw_only=True)  # of describe()
    _modules: Mapping[str, str] = attrs.field(factory=dict, kw_only=True)  # by entry, what declares it with others
    _entries: dict[str, T] = attrs.field(factory=dict, init=False)

    def __attrs_post_init__(self) -> None:
        self.group = f"hmdwarp.{self.group or self.package.rpartition('.')[2]}"

    def register(self, entry: E) -> E:
        """Add `entry` under its `name`; works as a class decorator. Refuse a second one."""
        name: str = entry.name  # type: ignore[attr-defined]
        if name in self._entries:
            raise ValueError(f"{self.kind} '{name}' is registered already: choose another name")
        self._entries[name] = entry() if self._holds_objects and isinstance(entry, type) else entry  # type: ignore[assignment]
        return entry

    def names(self) -> list[str]:
        """Return all known names, sorted, without importing an entry."""
        return sorted({*self._shipped, *_entry_points(self.group), *self._entries})

    def get(self, name: str) -> T:
        """Return the entry called `name`.

        Errors: UnknownNameError with the nearest known name; InputError for an entry point of
        another package that cannot be loaded or registers something else.
        """
        if name not in self._entries:
            table = self._shipped.get(name)
            if table is not None and self._of_table is not None:
                self._entries[name] = self._of_table(name, tomllib.loads(table.read_text("utf-8")))
            elif name in self._shipped:
                importlib.import_module(f"{self.package}.{self._modules.get(name, name)}")
            elif name in (foreign := _entry_points(self.group)):
                point = foreign[name]
                try:
                    point.load()
                except Exception as error:  # another package's code may raise anything
                    origin = f"package '{point.dist.name}'" if point.dist is not None else f"'{point.value}'"
                    raise InputError(
                        f"{self.kind} '{name}' of {origin} cannot be loaded ({type(error).__name__}: {error}): "
                        "update or uninstall that package"
                    ) from error
            else:
                raise unknown_name(self.kind, name, self.names())
            if name not in self._entries:
                raise InputError(f"no {self.kind} '{name}' is registered by the module or entry point of that name")
        return self._entries[name]

    def __iter__(self) -> Iterator[T]:
        return (self.get(name) for name in self.names())

    def __contains__(self, name: object) -> bool:
        return name in self.names()

    @functools.cached_property
    def _shipped(self) -> dict[str, Path | None]:
        """By name the file of a table, None for a module."""
        folders = [*importlib.import_module(self.package).__path__] if self.package else []
        files = {m.name for m in pkgutil.iter_modules(folders) if not m.name.startswith("_")}
        tables = [path for folder in folders for path in Path(folder).glob("*.toml")] if self._of_table else []
        entries = (files - {*self._modules.values()}) | {*self._modules}
        return dict.fromkeys(entries) | {path.stem: path for path in tables}


_installed = functools.cache(lambda folders: importlib.metadata.entry_points())  # of packages there: 15 ms


@functools.cache
def _entry_points(group: str) -> dict[str, importlib.metadata.EntryPoint]:
    from importlib.metadata import EntryPoint  # --help, which asks for no entry, does not wait for it

    own = (EntryPoint(name, module, group) for name, module in own_entries(group).items())
    return {point.name: point for point in (*own, *_installed(tuple(sys.path)).select(group=group))}


@functools.cache
def own_entries(group: str) -> dict[str, str]:
    """Return the modules of entries that packages of hmdwarp add to others' registries, by name."""
    tables = [tomllib.loads(path.read_text("utf-8")) for path in Path(__file__).parents[1].glob("*/entry_points.toml")]
    return {name: module for table in tables for name, module in table.get(group.removeprefix("hmdwarp."), {}).items()}
