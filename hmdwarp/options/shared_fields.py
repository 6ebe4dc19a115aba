"""Fields that several commands share: what is written, several values, the guard band."""

from __future__ import annotations

import math
import os
import re
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, Generic, Protocol, TypeVar, get_type_hints

import attrs

from .. import geometry
from ..errors import InputError, in_brief, listed
from ..registry import Registry
from .declared import CONDITION, Declared, Number, Option, as_path, one_of, option, option_of

FORCE = Option("Overwrite files that are in the way, also those that another program wrote.", bool, False, name="force")


def path_of(value: str | os.PathLike[str], flag: str = "--out") -> Path:
    """Return a path. Errors: InputError for an empty text, which would be the working folder."""
    if isinstance(value, str) and not value.strip():
        raise InputError(f"{flag} '{value}': expected a name; '.' is the working folder")
    try:
        return as_path(value)
    except InputError as error:
        raise InputError(f"{flag} {error}") from error


def out_field(value: Any, help: str, /, **about: Any) -> Any:
    """Return the field of a file or folder to write; value: its default, as `option` takes it."""
    optional = value is None
    return option(value, help, kind=Path, convert=attrs.converters.optional(path_of) if optional else path_of, **about)


def force_field(study: str = CONDITION) -> Any:
    """Return the field of `--force`. study: why a study's file may not set it."""
    return option(False, FORCE.help, study=study)


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

    def distinct(values: Iterable[Any], field: attrs.Attribute[Any]) -> tuple[Any, ...]:
        found = tuple(dict.fromkeys(map(each, (values,) if isinstance(values, str) else values)))
        if not found and default:
            raise InputError(f"{option_of(field).flag}: expected at least one value")
        return found

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
            "convert": attrs.Converter(distinct, takes_field=True),
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


AUTO = "auto"
# Of a run and a bench; with prediction auto gains hardly more at 200 ms, and draws more.
DEFAULT_GUARD = 1.5
Size = tuple[int, int]
Guard = float | tuple[float, float]
_FACTORS = "one factor of at least 1 (1.5) or one for each axis (1.25x1.125)"
_HELP = (
    "Overscan: ask the server for this many times the pixels on each axis, and so of the field of view in tangents: "
    "1.5 makes 2.25 times the pixels; 1.25x1.125 has a factor for each axis."
)
_BOTH = "--guard and --rendered-size both say how much the server draws: leave one of them out"


def parse_size(text: str, flag: str = "--size") -> Size:
    """Return (640, 400) for '640x400'. Errors: InputError."""
    match = re.fullmatch(r"([0-9]{1,6})\s*[xX]\s*([0-9]{1,6})", text.strip())
    if not match or 0 in map(int, match.groups()):
        raise InputError(f"{flag} '{text}': expected WIDTHxHEIGHT in pixels of one eye, like 640x800")
    return int(match.group(1)), int(match.group(2))


def parse_guard(text: str) -> Guard | str:
    """Return 'auto', a factor, or one for each axis. Errors: InputError."""
    if text.strip() == AUTO:
        return AUTO
    try:
        x, *y = map(float, re.split(b"[xX]", text.encode("ascii")))
    except ValueError as error:
        raise InputError(f"--guard '{text}': expected {_FACTORS}, or {AUTO}; pixels are --rendered-size") from error
    if len(y) > 1:
        raise InputError(f"--guard '{text}': expected {_FACTORS}, or {AUTO}")
    return (x, y[0]) if y and y[0] != x else x


def _check_guard(instance: object, field: attrs.Attribute[Any], value: Guard | str) -> None:
    if not isinstance(value, str) or value != AUTO:
        Number(least=1.0)(instance, field, value)


def _check_rendered(instance: Any, _: attrs.Attribute[Any], value: Size | None) -> None:
    # The guard band of recorded frames is what the display leaves of their own pixels.
    is_recorded = getattr(instance, "frames", None) is not None
    if value is not None and instance.guard not in (1.0, DEFAULT_GUARD) and not is_recorded:
        raise InputError(_BOTH)


def guard_field(default: Any, more: str = "", /, **about: Any) -> Any:
    """Return the field of `--guard`. It stands before that of `--rendered-size`.

    default: a factor, or an attrs.Factory; then `more` says what it makes. more: what only some
    commands take, added to the help that all share.
    """
    # No default on the command line, to tell a guard that was set from one that was not.
    about = {"kind": str, "default": None, "numeric": True, "parse": parse_guard, "limits": _FACTORS, **about}
    said = f" [default: {default:g}]" if isinstance(default, float) else ""
    return option(default, f"{_HELP}{more}{said}", valid=_check_guard, **about)


def rendered_size_field(heading: str = "") -> Any:
    """Return the field of `--rendered-size`. heading: as of Option."""
    return option(
        None,
        "Pixels of one eye that the server draws, in place of a guard: 1600x900 for a display of 1280x800 is guard "
        "1.25x1.125, and 1.41 times the pixels.",
        metavar="WxH",
        heading=heading,
        parse=partial(parse_size, flag="--rendered-size"),
        valid=_check_rendered,
    )


def check_one_guard(said: Mapping[str, Any]) -> None:
    """Raise InputError if both options were set."""
    if said.get("guard") is not None and said.get("rendered_size") is not None:
        raise InputError(_BOTH)


def guard_band(options: Any) -> geometry.GuardBand:
    """Return the guard band of the options. Errors: InputError while it is "auto"."""
    if isinstance(options.guard, str):
        raise InputError("--guard auto looks at a whole trace first: give a number, or replay a recording")
    if options.rendered_size is not None:
        return geometry.GuardBand(size=options.rendered_size)
    return geometry.GuardBand.of(options.guard)


PAPER_TABLES, PLOTS = {"latex": "tex", "csv": "csv", "markdown": "md"}, ("svg", "pdf")
PAPER = ("paper/*.tex", "paper/*.csv", "paper/*.md", "paper/*.svg", "paper/*.pdf")


def _kinds(known: Sequence[str], flag: str) -> Any:
    check = one_of(*known)

    def each(_: object, field: attrs.Attribute[Any], value: tuple[str, ...]) -> None:
        for kind in value if isinstance(value, tuple | list) else (value,):
            check(None, field, kind)

    names = " and ".join(filter(None, (", ".join(known[:-1]), known[-1])))
    return option(
        (), f"Also write the page's {flag} as files for a paper, into paper/: {names}, with commas.", kind=str,
        default=None, valid=each, parse=lambda text: tuple(filter(None, map(str.strip, text.split(",")))), name=flag,
        metavar="KIND,..",
    )  # fmt: skip


@attrs.frozen
class PaperOptions(Declared):
    """What to write for a paper. Errors: InputError for an unknown kind."""

    tables: tuple[str, ...] = _kinds(tuple(PAPER_TABLES), "tables")
    plots: tuple[str, ...] = _kinds(PLOTS, "plots")
    columns: int = option(1, "Columns of the paper that a plot spans: 1 or 2.", valid=Number(1, 2), name="plot_columns")

    @property
    def is_wanted(self) -> bool:
        """Whether anything is."""
        return bool(self.tables or self.plots)


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
    values: dict[str, Any] = {}
    for part in filter(None, (piece.strip() for piece in text.split(","))):
        key, equals, value = (piece.strip() for piece in part.partition("="))
        if key not in fields or not equals:
            known = ", ".join(f"{field.name}={field.default}" for field in fields.values()) or "none"
            raise InputError(f"{named}: '{part}' is no setting of '{name}'; its settings and their defaults: {known}")
        if key in values:
            raise InputError(f"{named}: {key} is given twice; give it once")
        kind_of = kinds[key]
        if typing.get_origin(kind_of) is typing.Literal:
            words = {str(word): word for word in typing.get_args(kind_of)}
            if value not in words:
                raise InputError(f"{named}: {key} is '{value}': expected {' or '.join(words)}")
            values[key] = words[value]
            continue
        try:
            values[key] = kind_of(value.encode("ascii") if kind_of in (int, float) else value)
        except ValueError as error:
            wanted = _WANTED.get(kind_of, kind_of.__name__)
            raise InputError(f"{named}: {key} is '{value}': expected {wanted}") from error
        if kind_of is float and not math.isfinite(values[key]):
            raise InputError(f"{named}: {key} is '{value}': expected a finite number")
    try:
        return kind(**values)
    except (ValueError, TypeError) as error:
        raise InputError(f"{named}: {error}") from error
