"""Options that take several values of what another command takes one of."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import attrs

from ..errors import InputError, listed
from .declared import Option, option, option_of

Split = Callable[[str], list[str]]


def split_values(text: str) -> list[str]:
    """Return what stands between commas; a text that names a file is one value."""
    try:
        is_file = Path(text).exists()
    except OSError:  # a list longer than a name can be
        is_file = False
    return [text] if is_file else [part.strip() for part in text.split(",")]


def split_names(text: str) -> list[str]:
    """Return what stands between commas; a name with settings, which hold commas, is one value."""
    return [text] if ":" in text else [part.strip() for part in text.split(",")]


def several(
    field: attrs.Attribute[Any],
    default: tuple[Any, ...],
    help: str = "",
    *,
    split: Split = split_values,
    each: Callable[[Any], Any] = lambda value: value,
    **about: Any,
) -> Any:
    """Return an attrs field that takes several values of another class' option, each once.

    Its name, unit, limits and parser are the option's. default: () if unset means all that
    there are. help: in place of its own. split: from one text of the command line to values.
    each: converter of one value. about: as for `option`.
    """
    one = option_of(field)
    said = (help or one.help).removesuffix(".")
    shown = f"; by default {listed([*map(_text, default)])}" if default else ""
    return option(
        default,
        f"{said}{shown}. For several, repeat it{' or use commas' if not about.get('positional') else ''}.",
        **{
            "name": one.name,
            "kind": list,
            "default": None,
            "unit": one.unit,
            "metavar": one.metavar or one.name.upper(),
            "limits": one.limits,
            "parse": lambda texts: [_value(one, part) for text in texts for part in split(text)],
            "convert": _distinct(each, may_be_none=not default),
            "valid": field.validator,
            **about,
        },
    )


def _text(value: Any) -> str:
    if isinstance(value, tuple):
        return "x".join(map(str, value))
    return f"{value:g}" if isinstance(value, float) else str(value)


def _value(one: Option, text: str) -> Any:
    if one.parse is not None:
        return one.parse(text)
    try:
        return one.kind(text)
    except ValueError as error:
        meaning = one.help[0].lower() + one.help[1:].removesuffix(".")
        raise InputError(f"{one.flag} '{text}': expected {one.limits or 'a number'}, {meaning}") from error


def _distinct(each: Callable[[Any], Any], *, may_be_none: bool) -> Any:
    """Return a converter to a tuple without repetitions; a text alone is one value.

    Errors: InputError where nothing is left.
    """

    def convert(values: Iterable[Any], field: attrs.Attribute[Any]) -> tuple[Any, ...]:
        found = tuple(dict.fromkeys(map(each, (values,) if isinstance(values, str) else values)))
        if not found and not may_be_none:
            raise InputError(f"{option_of(field).flag}: expected at least one value")
        return found

    return attrs.Converter(convert, takes_field=True)
