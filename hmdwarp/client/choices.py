"""`mesh` or `mesh:cut=slope`: which warp is asked for, and with which settings."""

from __future__ import annotations

import math
import typing
from typing import Any, get_type_hints

import attrs

from ..errors import InputError
from .warps import Warp, warps

_WANTED = {int: "a whole number", float: "a number"}


@attrs.frozen
class Choice:
    """A warp and its settings. str() is the shortest text that means it: settings at their defaults are left out."""

    warp: type[Warp]
    settings: Any

    def __str__(self) -> str:
        default = self.warp.Settings()
        told = [
            f"{field.name}={getattr(self.settings, field.name)}"
            for field in attrs.fields(self.warp.Settings)
            if getattr(self.settings, field.name) != getattr(default, field.name)
        ]
        return f"{self.warp.name}:{','.join(told)}" if told else self.warp.name


def parse_warp(text: str) -> Choice:
    """'name' or 'name:key=value,key=value'. Errors: UnknownNameError for the name; InputError for a setting it has not, or a bad value."""
    name, _, rest = text.partition(":")
    warp = warps.get(name)
    fields = {field.name: field for field in attrs.fields(warp.Settings)}
    kinds = get_type_hints(warp.Settings)
    values = {}
    for part in filter(None, (piece.strip() for piece in rest.split(","))):
        key, equals, value = (piece.strip() for piece in part.partition("="))
        if key not in fields or not equals:
            known = ", ".join(f"{field.name}={field.default}" for field in fields.values()) or "none"
            raise InputError(f"warp '{text}': '{part}' is no setting of '{warp.name}'; its settings and their defaults: {known}")
        values[key] = _converted(text, key, value, kinds[key])
    try:
        return Choice(warp, warp.Settings(**values))
    except (ValueError, TypeError) as error:
        raise InputError(f"warp '{text}': {error}") from error


def every_warp() -> list[str]:
    """All registered warps, each followed by the variants that are worth a comparison."""
    return [text for warp in warps for text in (warp.name, *(f"{warp.name}:{variant}" for variant in warp.variants))]


def _converted(text: str, key: str, value: str, kind: Any) -> Any:
    if typing.get_origin(kind) is typing.Literal:
        words = typing.get_args(kind)
        if value not in words:
            raise InputError(f"warp '{text}': {key} is '{value}': wanted {' or '.join(map(str, words))}")
        return value
    try:
        number = kind(value)
    except ValueError as error:
        raise InputError(f"warp '{text}': {key} is '{value}': wanted {_WANTED.get(kind, kind.__name__)}") from error
    if kind is float and not math.isfinite(number):
        raise InputError(f"warp '{text}': {key} is '{value}': wanted a finite number")
    return number
