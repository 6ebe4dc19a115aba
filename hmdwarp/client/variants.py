"""Warps and fills with settings as text: `mesh:cut=slope`, `memory+model:share=0.1`."""

from __future__ import annotations

import math
import typing
from typing import Any, Generic, TypeVar, get_type_hints

import attrs

from ..errors import InputError
from ..frames.layers.voxels import VoxelLight
from ..registry import Registry, unknown_name
from .fills import Fill, fills
from .settings import NoSettings
from .warps import Warp, warps

# How the server finds the light between surfaces where lamps move.
CONVERGED, VOXELS = "converged", "voxels"
_WANTED = {int: "a whole number", float: "a number"}


Entry = TypeVar("Entry", bound=Warp | Fill)


@attrs.frozen
class Choice(Generic[Entry]):
    """A warp or fill and its settings.

    str() is the shortest equivalent text: settings at their defaults are left out.
    """

    entry: type[Entry]
    settings: Any

    def __str__(self) -> str:
        default = self.entry.Settings()
        changed = [
            f"{field.name}={getattr(self.settings, field.name)}"
            for field in attrs.fields(self.entry.Settings)
            if getattr(self.settings, field.name) != getattr(default, field.name)
        ]
        return f"{self.entry.name}:{','.join(changed)}" if changed else self.entry.name


def parse_warp(text: str) -> Choice[Warp]:
    """Parse 'name' or 'name:key=value,key=value'.

    Errors: UnknownNameError for the name; InputError for a setting that it lacks, or a bad value.
    """
    return _parsed(warps, text)


def parse_fills(text: str) -> tuple[Choice[Fill], ...]:
    """Parse 'memory+pyramid': a chain of fills, each written like a warp; () for 'none'.

    Errors: as parse_warp; InputError for 'none' in a chain, and for the same fill twice.
    """
    chain = tuple(_parsed(fills, part.strip()) for part in text.split("+"))
    if len(chain) > 1 and not all(choice.entry.is_pass for choice in chain):
        raise InputError(f"fill '{text}': 'none' in a chain means nothing; leave it out")
    names = [choice.entry.name for choice in chain]
    if len(set(names)) < len(names):
        raise InputError(f"fill '{text}': the same fill twice; each takes all it can at its first turn")
    return tuple(choice for choice in chain if choice.entry.is_pass)


def parse_indirect(text: str) -> VoxelLight | None:
    """Parse how the server finds indirect light: 'converged' (None), or 'voxels:key=value'.

    Errors: UnknownNameError for another name; InputError for a setting that it lacks, or a bad
    value.
    """
    name, _, rest = text.partition(":")
    if name not in (CONVERGED, VOXELS):
        raise unknown_name("indirect light", name, [CONVERGED, VOXELS])
    kind = NoSettings if name == CONVERGED else VoxelLight
    settings = _settings(kind, name, f"indirect light '{text}'", rest)
    return settings if isinstance(settings, VoxelLight) else None


def fill_text(chain: tuple[Choice[Fill], ...]) -> str:
    """Return the shortest text equivalent to the chain."""
    return "+".join(map(str, chain)) or "none"


def every_warp() -> list[str]:
    """Return all registered warps, each followed by its variants for comparison."""
    return _every(warps)


def every_baseline() -> dict[str, str]:
    """Return the warps that do what a published or shipped system does, and which one."""
    return {
        str(parse_warp(f"{entry.name}:{settings}")): system
        for entry in warps
        for settings, system in entry.baselines.items()
    }


def every_fill() -> list[str]:
    """Return all registered fills, each followed by its variants for comparison."""
    return _every(fills)


def _every(registry: Registry[type[Entry]]) -> list[str]:
    texts = []
    for entry in registry:
        texts += [entry.name, *(f"{entry.name}:{variant}" for variant in entry.variants)]
    return texts


def _parsed(registry: Registry[type[Entry]], text: str) -> Choice[Entry]:
    name, _, rest = text.partition(":")
    entry = registry.get(name)
    return Choice(entry, _settings(entry.Settings, entry.name, f"{registry.kind} '{text}'", rest))


def _settings(kind: type, name: str, named: str, text: str) -> Any:
    """Return the settings of a kind from 'key=value,key=value'.

    name: of what they belong to. named: that with its settings, as messages call it.
    """
    fields = {field.name: field for field in attrs.fields(kind)}
    kinds = get_type_hints(kind)
    values = {}
    for part in filter(None, (piece.strip() for piece in text.split(","))):
        key, equals, value = (piece.strip() for piece in part.partition("="))
        if key not in fields or not equals:
            known = ", ".join(f"{field.name}={field.default}" for field in fields.values()) or "none"
            raise InputError(f"{named}: '{part}' is no setting of '{name}'; its settings and their defaults: {known}")
        if key in values:
            raise InputError(f"{named}: {key} is given twice; give it once")
        values[key] = _converted(named, key, value, kinds[key])
    try:
        return kind(**values)
    except (ValueError, TypeError) as error:
        raise InputError(f"{named}: {error}") from error


def _converted(named: str, key: str, value: str, kind: Any) -> Any:
    if typing.get_origin(kind) is typing.Literal:
        words = {str(word): word for word in typing.get_args(kind)}
        if value not in words:
            raise InputError(f"{named}: {key} is '{value}': expected {' or '.join(words)}")
        return words[value]
    try:
        number = kind(value)
    except ValueError as error:
        raise InputError(f"{named}: {key} is '{value}': expected {_WANTED.get(kind, kind.__name__)}") from error
    if kind is float and not math.isfinite(number):
        raise InputError(f"{named}: {key} is '{value}': expected a finite number")
    return number
