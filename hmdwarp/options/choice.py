"""A registry's entry with settings, as text: `mesh:cut=slope`."""

from __future__ import annotations

import math
import typing
from typing import Any, ClassVar, Generic, Protocol, TypeVar, get_type_hints

import attrs

from ..errors import InputError, in_brief
from ..registry import Registry

_WANTED = {int: "a whole number", float: "a number"}


@attrs.frozen
class NoSettings:
    """No settings."""


class HasSettings(Protocol):
    """An entry of a registry that can be set."""

    name: ClassVar[str]
    Settings: ClassVar[type]  # An attrs class; each field has a default.


Entry = TypeVar("Entry", bound=HasSettings)


@attrs.frozen
class Choice(Generic[Entry]):
    """An entry and its settings.

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


def parse_choice(registry: Registry[type[Entry]], text: str) -> Choice[Entry]:
    """Parse 'name' or 'name:key=value,key=value'.

    Errors: UnknownNameError for the name; InputError for a setting that it lacks, or a bad value.
    """
    if not isinstance(text, str):
        raise InputError(f"{registry.kind} {in_brief(text)}: expected a name: {', '.join(registry.names())}")
    name, _, rest = text.partition(":")
    entry = registry.get(name)
    return Choice(entry, parse_settings(entry.Settings, entry.name, f"{registry.kind} '{text}'", rest))


def parse_settings(kind: type, name: str, named: str, text: str) -> Any:
    """Return the settings of a kind from 'key=value,key=value'.

    name: of what they belong to. named: that with its settings, as messages call it. Errors:
    InputError for a setting that it lacks, or a bad value.
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
        number = kind(value.encode("ascii") if kind in (int, float) else value)
    except ValueError as error:
        raise InputError(f"{named}: {key} is '{value}': expected {_WANTED.get(kind, kind.__name__)}") from error
    if kind is float and not math.isfinite(number):
        raise InputError(f"{named}: {key} is '{value}': expected a finite number")
    return number
