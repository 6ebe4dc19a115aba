"""Declaration of options and their limits; fields that several commands share."""

from __future__ import annotations

import errno
import hashlib
import math
import os
import re
import typing
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache
from numbers import Integral, Real
from pathlib import Path
from typing import Any, ClassVar, Generic, Self, TypeVar, get_type_hints

import attrs

from .errors import InputError, in_brief, listed
from .registry import Registry, own_entries

_PACKAGE = Path(__file__).resolve().parent.parent
_FAMILY = re.compile(r'dict\.fromkeys\(\s*\(([^)]*)\),\s*"(\w+)"')


def names_in(folder: str, pattern: str = "*", without: Collection[str] = (), *, added: bool = True) -> str:
    """Return a registry's entries for help, without imports; added: with those of packages."""
    names = {p.stem for p in (_PACKAGE / folder).glob(pattern) if p.suffix in (".py", ".toml")}
    for entries, module in _FAMILY.findall((_PACKAGE / folder / "__init__.py").read_text(encoding="utf-8")):
        names = (names - {module}) | set(re.findall(r"\w+", entries))
    names |= own_entries(folder.rpartition("/")[2]).keys() if added else set()
    return ", ".join(sorted(name for name in names if not name.startswith("_") and name not in without))


@attrs.frozen
class Number:
    """Check that a value, or each of a tuple, is None, or finite and within the limits."""

    least: float = 0.0
    most: float = math.inf
    above: bool = False  # whether the lower limit is exclusive

    def words(self, unit: str = "") -> str:
        """Return the limits in words, for errors and tables."""
        least = f"{'above' if self.above else 'of at least'} {self.least:g}{unit}"
        return f"{least} and at most {self.most:g}{unit}" if math.isfinite(self.most) else least

    def __call__(self, _: object, field: attrs.Attribute[Any], value: Any) -> None:
        _of_its_kind(_, field, value)
        for number in value if isinstance(value, tuple) else (value,):
            try:
                # A text of digits is no number: what a caller typed into Python is used as it is.
                found = float(number) if isinstance(number, Real) else math.nan
            except OverflowError:
                found = math.inf if number > 0 else -math.inf
            least_met = found > self.least if self.above else found >= self.least
            if number is not None and not (math.isfinite(found) and found <= self.most and least_met):
                name, unit = _name_of(field)
                shown = f"{found:g}{unit}" if isinstance(number, Real) else in_brief(number)
                kind = "a number" if math.isfinite(self.most) else "a finite number"
                if _KEY in field.metadata and option_of(field).kind is int:
                    kind = "a whole number"
                raise InputError(f"{name} {shown}: expected {kind} {self.words(unit)}")


def _name_of(field: attrs.Attribute[Any]) -> tuple[str, str]:
    """Return the name and unit (" ms") by which the user knows a field."""
    declared = option_of(field) if _KEY in field.metadata else None
    return (declared.flag, f" {declared.unit}".rstrip()) if declared else (field.name, "")


def one_of(*known: str) -> Callable[[object, attrs.Attribute[Any], str | None], None]:
    """Return a validator that raises InputError for any text not in the list; None is left out."""

    def check(_: object, field: attrs.Attribute[Any], value: str | None) -> None:
        if value is not None and not (isinstance(value, str) and value in known):
            shown = f"'{value}'" if isinstance(value, str) else in_brief(value)
            raise InputError(f"{_name_of(field)[0]} {shown}: expected {listed(known, 'or')}")

    return check


# What a field of one of these annotations holds, and how messages call it.
_HELD: dict[str, tuple[tuple[type, ...], str]] = {
    "str": ((str,), "a text"),
    "float": ((Real,), "a number"),
    "int": ((Integral,), "a whole number"),
    "Path": ((str, os.PathLike), "a path"),
    "bool": ((bool,), "True or False"),
}


def _of_its_kind(_: object, field: attrs.Attribute[Any], value: Any) -> None:
    """Raise InputError for a value that the field's annotation excludes, where that is simple."""
    words = [word for word in str(field.type).split(" | ") if word != "None"]
    is_none = value is None and "| None" in str(field.type)
    if is_none or any(word not in _HELD for word in words) or type(value).__name__ == "bool_":
        return
    if not any(isinstance(value, _HELD[word][0]) for word in words):
        expected = listed([_HELD[word][1] for word in words], "or")
        raise InputError(f"{_name_of(field)[0]} {in_brief(value)}: expected {expected}")


def as_path(value: str | os.PathLike[str]) -> Path:
    """Return a path. Errors: InputError for what is none, and for a name that no file can have."""
    if not isinstance(value, str | os.PathLike):
        raise InputError(f"expected a path, found {in_brief(value)}")
    try:
        os.lstat(value)
    except (OSError, ValueError) as error:
        if isinstance(error, ValueError) or error.errno == errno.ENAMETOOLONG:
            raise InputError(f"{in_brief(str(value))}: no file can have this name: expected another") from error
    return Path(value)


_KEY, _GROUP = "options", "group"
_UNITS = ("ms", "s", "Hz", "deg", "mm")  # at the end of a field's name
_KINDS = {kind.__name__: kind for kind in (str, float, int, bool, Path)}
_NO_KIND = (type(None), type(attrs.NOTHING))  # of a default: the field's annotation names it
# Fields that say where results go and how they are made, but not what they are.
HOW = ("out", "force", "command", "workers", "parquet", "paper", "sweep")
# Where a study's file may set an option: for the display of a whole session, for how the scene
# looks, or for one condition. Otherwise a sentence says why it may not.
DISPLAY, PICTURE, CONDITION = "display", "picture", "condition"


@attrs.frozen
class Option:
    """One option: a flag of the command line, a key of a study's file, a row of the docs."""

    help: str
    kind: type = str  # type that the command line reads: str, float, int, bool, Path, or list for several texts
    default: Any = None  # value of an option that is not set; None where the help says what happens then
    required: bool = False
    name: str = ""  # in Python and in a study's file; "" for the field's own name without its unit
    unit: str = ""
    limits: str = ""  # allowed values in words; "" for any
    metavar: str | None = None
    off: str = ""  # flag that turns a switch off; "" for none
    positional: bool = False  # whether it is a positional argument rather than a flag
    # Whether an empty text is a value; otherwise it is refused, as of a shell's variable not set.
    may_be_empty: bool = False
    numeric: bool = False  # whether a study's file may give a number in place of a text
    study: str = CONDITION  # DISPLAY, PICTURE, CONDITION, or why a study's file may not set it
    names_files: bool = False  # whether the file or folder that it names may name other files; see named_files
    parse: Callable[[Any], Any] | None = None  # converts the written text to the field's value
    # Heading under which a command's help lists it; "" for the first, of what matters most.
    heading: str = attrs.field(default="", eq=False)

    @property
    def flag(self) -> str:
        """What a user types for it on the command line, and by which messages name it."""
        return (self.metavar or self.name.upper()) if self.positional else f"--{self.name.replace('_', '-')}"

    @property
    def in_study(self) -> bool:
        """Whether a study's file may set it."""
        return self.study in (DISPLAY, PICTURE, CONDITION)


def option(
    value: Any, help: str, /, *, valid: Any = None, convert: Any = None, beside: tuple[Option, ...] = (), **about: Any
) -> Any:
    """Return an attrs field that is an option.

    value, valid, convert: default, validator and converter of the field. beside: options that
    affect the same field, see Declared.values_of. about: attributes of Option; by default kind and
    default are those of the value (without one, the kind of the annotation), the unit that at the
    end of the name, the limits those of `valid`.
    """
    required = value is attrs.NOTHING
    about = {"kind": type(value), "default": None if required else value, "required": required, **about}
    # Number looks at the kind itself, and option_of at its limits.
    check = valid if isinstance(valid, Number) else [_of_its_kind, *([] if valid is None else [valid])]
    metadata = {_KEY: (Option(help, **about), *beside)}
    return attrs.field(default=value, validator=check, converter=convert, metadata=metadata)


def group(kind: type[Declared]) -> Any:
    """Return an attrs field that holds the options of another class."""

    def check(_: object, field: attrs.Attribute[Any], value: object) -> None:
        if not isinstance(value, kind):
            raise InputError(f"{field.name} {in_brief(value)}: expected a {kind.__name__}")

    return attrs.field(factory=kind, validator=check, metadata={_GROUP: kind})


def option_of(field: attrs.Attribute[Any]) -> Option:
    """Return the option that an attrs field is, with what it leaves out; see `option`."""
    found: Option = field.metadata[_KEY][0]
    kind = _KINDS.get(str(field.type).partition(" ")[0], str) if found.kind in _NO_KIND else found.kind
    ends = [unit for unit in _UNITS if kind in (int, float) and field.name.endswith(f"_{unit.lower()}")]
    unit = found.unit or "".join(ends)
    number = "a whole number" if kind is int else "a number"
    words = f"{number} {field.validator.words()}" if isinstance(field.validator, Number) else ""
    name = found.name or field.name.removesuffix(f"_{unit.lower()}")
    return attrs.evolve(found, kind=kind, unit=unit, limits=found.limits or words, name=name)


def as_keys(text: str, known: Collection[str]) -> str:
    """Return a message that names options as keys of a file; known: those that it may set."""
    flags = {name.replace("_", "-"): name for name in known}
    return re.sub(r"--([a-z][a-z-]*)", lambda found: flags.get(found[1], found[0]), text)


def same_as(field: attrs.Attribute[Any], default: Any = None, **about: Any) -> Any:
    """Return an attrs field that is the option of another class.

    default: in place of its own. about: attributes of Option that differ.
    """
    about = about if default is None else {"default": default, **about}
    value, metadata = field.default if default is None else default, field.metadata[_KEY]
    metadata = {_KEY: (attrs.evolve(option_of(field), **about), *metadata[1:])}
    return attrs.field(default=value, validator=field.validator, converter=field.converter, metadata=metadata)


_KNOWN: dict[type[Declared], tuple[Option, ...]] = {}


def options_of(kind: type[Declared]) -> tuple[Option, ...]:
    """Return the options of a class in the order of its fields, those of its groups included."""
    if kind not in _KNOWN:
        _KNOWN[kind] = tuple(found for found in _all_of(kind) if found.name not in kind.not_offered)
    return _KNOWN[kind]


def _all_of(kind: type) -> Iterator[Option]:
    for field in attrs.fields(kind):
        if inner := field.metadata.get(_GROUP):
            yield from (attrs.evolve(one, heading=one.heading or inner.heading) for one in _all_of(inner))
        if _KEY in field.metadata:
            yield from (option_of(field), *field.metadata[_KEY][1:])


class Declared:
    """Base of classes whose fields are options."""

    not_offered: ClassVar[tuple[str, ...]] = ()  # options of a base class that do not apply to this one
    heading: ClassVar[str] = ""  # heading of its options in help, where the class is a group of another's options

    def digest(self) -> str:
        """Return a hash of what these options say, HOW left out; files count by their names."""
        said = {field.name: repr(getattr(self, field.name)) for field in attrs.fields(type(self))}  # type: ignore[arg-type]
        text = "\n".join(f"{name}={value}" for name, value in said.items() if name not in HOW)
        return hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()[:16]

    @classmethod
    def of(cls, said: Mapping[str, Any], **fields: Any) -> Self:
        """Return the object for the options that were set; the others keep their defaults.

        said: values by option name, as the command line or a study's file reads them. fields: by
        field name, overriding `said`. Errors: InputError.
        """
        return cls(**{**cls.values_of(said), **fields})

    @classmethod
    def checked(cls, options: Self | None, *, optional: bool = False) -> Self:
        """Return the options. optional: the defaults for None. Errors: InputError for others."""
        if options is None and optional:
            return cls()
        if not isinstance(options, cls):
            raise InputError(f"options are {in_brief(options)}: expected a {cls.__name__}")
        return options

    @classmethod
    def values_of(cls, said: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields whose options were set, by name."""
        values: dict[str, Any] = {}
        for name, own in _own_of(cls):  # type: ignore[arg-type]
            if not isinstance(own, Option):
                values[name] = own.of(said)
            elif (value := said.get(own.name)) is not None:
                values[name] = value if own.parse is None else own.parse(value)
        return values


@cache  # a class's fields stay as they are, and a study's file reads them a thousand times
def _own_of(kind: type) -> list[tuple[str, Option | type[Declared]]]:
    """Return the fields that are a group of options or an option, by name."""
    fields = [field for field in attrs.fields(kind) if {_GROUP, _KEY} & {*field.metadata}]
    return [(field.name, field.metadata.get(_GROUP) or option_of(field)) for field in fields]


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


def _split_values(text: str) -> list[str]:
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
    split: Callable[[str], list[str]] = _split_values,
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

    def value_of(text: str) -> Any:
        try:
            return one.kind(text) if one.parse is None else one.parse(text)
        except ValueError as error:
            meaning = one.help[0].lower() + one.help[1:].removesuffix(".")
            raise InputError(f"{one.flag} '{text}': expected {one.limits or 'a number'}, {meaning}") from error

    usual = {"name": one.name, "kind": list, "default": None, "unit": one.unit, "limits": one.limits}
    usual |= {"metavar": one.metavar or one.name.upper(), "valid": field.validator}
    usual |= {"parse": lambda texts: [value_of(part) for text in texts for part in split(text)]}
    usual |= {"convert": attrs.Converter(distinct, takes_field=True)}
    commas = "" if about.get("positional") else " or use commas"
    return option(default, f"{said}{shown}. For several, repeat it{commas}.", **{**usual, **about})


def _text(value: Any) -> str:
    if isinstance(value, tuple):
        return "x".join(map(str, value))
    return f"{value:g}" if isinstance(value, float) else str(value)


AUTO = "auto"
DEFAULT_GUARD = 1.5  # of a run and a bench; with prediction auto gains hardly more at 200 ms, and draws more
Size = tuple[int, int]
Guard = float | tuple[float, float]
_FACTORS = "one factor of at least 1 (1.5) or one for each axis (1.25x1.125)"
_HELP = (
    "Overscan: ask the server for this many times the pixels on each axis, and so of the field of view in tangents: "
    "1.5 makes 2.25 times the pixels; 1.25x1.125 has a factor for each axis."
)


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
        x, *others = map(float, re.split(b"[xX]", text.encode("ascii")))
        (y,) = others or [x]
    except ValueError as error:
        raise InputError(f"--guard '{text}': expected {_FACTORS}, or {AUTO}") from error
    return x if x == y else (x, y)


def guard_field(default: Any, more: str = "", /, **about: Any) -> Any:
    """Return the field of `--guard`.

    default: a factor, or an attrs.Factory, which `more` explains: added to the help that all share.
    """

    def check(instance: object, field: attrs.Attribute[Any], value: Guard | str) -> None:
        if not isinstance(value, str) or value != AUTO:
            Number(least=1.0)(instance, field, value)

    # No default on the command line, to tell a guard that was set from one that was not.
    about = {"kind": str, "default": None, "numeric": True, "parse": parse_guard, "limits": _FACTORS, **about}
    said = f" [default: {default:g}]" if isinstance(default, float) else ""
    return option(default, f"{_HELP}{more}{said}", valid=check, **about)


PAPER_TABLES, PLOTS = {"latex": "tex", "markdown": "md"}, ("svg", "pdf")
PAPER = ("paper/*.tex", "paper/*.md", "paper/*.svg", "paper/*.pdf")


def _kinds(known: Sequence[str], flag: str) -> Any:
    def each(_: object, field: attrs.Attribute[Any], value: tuple[str, ...]) -> None:
        for kind in value if isinstance(value, tuple | list) else (value,):
            one_of(*known)(None, field, kind)

    help = f"Also write the page's {flag} as files for a paper, into paper/: {listed(known)}, with commas."
    about: dict[str, Any] = {"kind": str, "default": None, "name": flag, "metavar": "KIND,.."}
    return option(
        (), help, valid=each, parse=lambda text: tuple(filter(None, map(str.strip, text.split(",")))), **about
    )


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


@attrs.frozen
class NoSettings:
    """No settings."""


# A class of a registry with a `name` and `Settings`, an attrs class; each field has a default.
Entry = TypeVar("Entry", bound=Any)


@attrs.frozen
class Choice(Generic[Entry]):
    """An entry and its settings; str() leaves out those at their defaults."""

    entry: type[Entry]
    settings: Any

    def __str__(self) -> str:
        default = self.entry.Settings()
        said = {field.name: getattr(self.settings, field.name) for field in attrs.fields(self.entry.Settings)}
        changed = [f"{name}={value}" for name, value in said.items() if value != getattr(default, name)]
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
    """Return the settings of a kind from 'key=value,key=value'. Errors: InputError.

    name: of what they belong to. named: that with its settings, as messages call it.
    """
    fields = {field.name: field for field in attrs.fields(kind)}
    kinds = get_type_hints(kind) if text else {}
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
            if kind_of is float and not math.isfinite(values[key]):
                raise ValueError
        except ValueError as error:
            wanted = {int: "a whole number", float: "a finite number"}.get(kind_of, kind_of.__name__)
            raise InputError(f"{named}: {key} is '{value}': expected {wanted}") from error
    try:
        return kind(**values)
    except (ValueError, TypeError) as error:
        raise InputError(f"{named}: {error}") from error
