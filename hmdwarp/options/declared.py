"""Declaration of options, their limits, and objects made from the texts that users write."""

from __future__ import annotations

import errno
import hashlib
import math
import os
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from numbers import Integral, Real
from pathlib import Path
from typing import Any, ClassVar, Self

import attrs

from ..errors import InputError, in_brief, listed
from ..registry import own_entries

_PACKAGE = Path(__file__).resolve().parent.parent
_FAMILY = re.compile(r'dict\.fromkeys\(\s*\(([^)]*)\),\s*"(\w+)"')


def names_in(folder: str, pattern: str = "*", without: Collection[str] = (), *, added: bool = True) -> str:
    """Return a registry's entries for help, without imports; added: with those of packages."""
    names = {p.stem for p in (_PACKAGE / folder).glob(pattern) if p.suffix in (".py", ".toml")}
    for entries, module in _FAMILY.findall((_PACKAGE / folder / "__init__.py").read_text(encoding="utf-8")):
        names = (names - {module}) | set(re.findall(r"\w+", entries))
    names |= own_entries(folder.rpartition("/")[2]).keys() if added else set()
    return ", ".join(sorted(name for name in names if not name.startswith("_") and name not in without))


def _as_float(value: Any) -> float:
    """Return infinity for a whole number that is too large."""
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


@attrs.frozen
class Number:
    """Check that a value, or each of a tuple, is None, or finite and within the limits.

    Errors: InputError.
    """

    least: float = 0.0
    most: float = math.inf
    # Whether the lower limit is exclusive.
    above: bool = False

    def words(self, unit: str = "") -> str:
        """Return the limits in words, for errors and tables."""
        least = f"{'above' if self.above else 'of at least'} {self.least:g}{unit}"
        return f"{least} and at most {self.most:g}{unit}" if math.isfinite(self.most) else least

    def __call__(self, _: object, field: attrs.Attribute[Any], value: Any) -> None:
        _of_its_kind(_, field, value)
        for number in value if isinstance(value, tuple) else (value,):
            if number is None:
                continue
            # A text of digits is no number: what a caller typed into Python is used as it is.
            found = _as_float(number) if isinstance(number, Real) else math.nan
            least_met = found > self.least if self.above else found >= self.least
            if not (math.isfinite(found) and found <= self.most and least_met):
                name, unit = _name_of(field)
                shown = f"{found:g}{unit}" if isinstance(number, Real) else in_brief(number)
                kind = "a number" if math.isfinite(self.most) else "a finite number"
                if _KEY in field.metadata and option_of(field).kind is int:
                    kind = "a whole number"
                raise InputError(f"{name} {shown}: expected {kind} {self.words(unit)}")


def _name_of(field: attrs.Attribute[Any]) -> tuple[str, str]:
    """Return the name and unit (" ms") by which the user knows a field."""
    if _KEY not in field.metadata:
        return field.name, ""
    declared = option_of(field)
    return declared.flag, f" {declared.unit}" if declared.unit else ""


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
# Fields that say where results go and how they are made, but not what they are.
HOW = ("out", "force", "command", "workers", "parquet", "paper", "sweep")
# Where a study's file may set an option: for the display of a whole session, for how the scene
# looks, or for one condition. Otherwise a sentence says why it may not.
DISPLAY, PICTURE, CONDITION = "display", "picture", "condition"


class _Annotated:
    """Stands for the kind that a field's annotation names."""


@attrs.frozen
class Option:
    """One option: a flag of the command line, a key of a study's file, a row of the docs."""

    help: str
    # Type that the command line reads: str, float, int, bool, Path, or list for several texts.
    kind: type = str
    # Value of an option that is not set; None where the help says what happens then.
    default: Any = None
    required: bool = False
    # In Python and in a study's file; "" for the field's own name without its unit.
    name: str = ""
    unit: str = ""
    # Allowed values in words; "" for any.
    limits: str = ""
    metavar: str | None = None
    # Flag that turns a switch off; "" for none.
    off: str = ""
    # Whether it is a positional argument rather than a flag.
    positional: bool = False
    # Whether an empty text is a value; otherwise it is refused, as of a shell's variable not set.
    may_be_empty: bool = False
    # Whether a study's file may give a number in place of a text.
    numeric: bool = False
    # DISPLAY, PICTURE, CONDITION, or why a study's file may not set it.
    study: str = CONDITION
    # Whether the file or folder that it names may name other files; see named_files.
    names_files: bool = False
    # Converts the written text to the field's value.
    parse: Callable[[Any], Any] | None = None
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

    value: default of the field. valid, convert: validator and converter of the field. beside:
    options that affect the same field, see Declared.values_of. about: attributes of Option; what
    they leave out is that of the field: kind and default of its default (without one, the kind of
    its annotation), the unit at the end of its name, the limits of `valid`.
    """
    required = value is attrs.NOTHING
    kind = _Annotated if value is None or required else type(value)
    about = {"kind": kind, "default": None if required else value, "required": required, **about}

    def check(instance: object, field: attrs.Attribute[Any], value: Any) -> None:
        _of_its_kind(instance, field, value)
        if valid is not None:
            valid(instance, field, value)

    return attrs.field(
        default=value,
        validator=valid if isinstance(valid, Number) else check,  # Number looks at the kind itself
        converter=convert,
        metadata={_KEY: (Option(help, **about), *beside)},
    )


def group(kind: type[Declared]) -> Any:
    """Return an attrs field that holds the options of another class."""

    def check(_: object, field: attrs.Attribute[Any], value: object) -> None:
        if not isinstance(value, kind):
            raise InputError(f"{field.name} {in_brief(value)}: expected a {kind.__name__}")

    return attrs.field(factory=kind, validator=check, metadata={_GROUP: kind})


def option_of(field: attrs.Attribute[Any]) -> Option:
    """Return the option that an attrs field is, with what it leaves out; see `option`."""
    found: Option = field.metadata[_KEY][0]
    kind = _KINDS.get(str(field.type).partition(" ")[0], str) if found.kind is _Annotated else found.kind
    ends = [unit for unit in _UNITS if kind in (int, float) and field.name.endswith(f"_{unit.lower()}")]
    unit = found.unit or "".join(ends)
    number = "a whole number" if kind is int else "a number"
    words = f"{number} {field.validator.words()}" if isinstance(field.validator, Number) else ""
    name = found.name or field.name.removesuffix(f"_{unit.lower()}")
    return attrs.evolve(found, kind=kind, unit=unit, limits=found.limits or words, name=name)


def as_keys(text: str, known: Collection[str]) -> str:
    """Return a message that names options as keys of a file; known: those that it may set."""

    def key(match: re.Match[str]) -> str:
        name = match[1].replace("-", "_")
        return name if name in known else match[0]

    return re.sub(r"--([a-z][a-z-]*)", key, text)


def same_as(field: attrs.Attribute[Any], default: Any = None, **about: Any) -> Any:
    """Return an attrs field that is the option of another class.

    default: in place of its own. about: attributes of Option that differ.
    """
    if default is not None:
        about = {"default": default, **about}
    return attrs.field(
        default=field.default if default is None else default,
        validator=field.validator,
        converter=field.converter,
        metadata={_KEY: (attrs.evolve(option_of(field), **about), *field.metadata[_KEY][1:])},
    )


_KNOWN: dict[type[Declared], tuple[Option, ...]] = {}


def options_of(kind: type[Declared]) -> tuple[Option, ...]:
    """Return the options of a class in the order of its fields, those of its groups included."""
    if kind not in _KNOWN:
        _KNOWN[kind] = tuple(found for found in _all_of(kind) if found.name not in kind.not_offered)
    return _KNOWN[kind]


def _all_of(kind: type) -> Iterator[Option]:
    for field in attrs.fields(kind):
        if _GROUP in field.metadata:
            inner = field.metadata[_GROUP]
            yield from (
                attrs.evolve(inner_option, heading=inner_option.heading or inner.heading)
                for inner_option in _all_of(inner)
            )
        if _KEY in field.metadata:
            yield from (option_of(field), *field.metadata[_KEY][1:])


class Declared:
    """Base of classes whose fields are options."""

    # Options of a base class that do not apply to this one.
    not_offered: ClassVar[tuple[str, ...]] = ()
    # Heading of its options in help, where the class is a group of another's options.
    heading: ClassVar[str] = ""

    def digest(self) -> str:
        """Return a hash of what these options say, HOW left out; files count by their names."""
        said = {field.name: repr(getattr(self, field.name)) for field in attrs.fields(type(self))}  # type: ignore[arg-type]
        text = "\n".join(f"{name}={value}" for name, value in said.items() if name not in HOW)
        return hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()[:16]

    @classmethod
    def of(cls, said: Mapping[str, Any], **fields: Any) -> Self:
        """Return the object for the options that were set; the others keep their defaults.

        said: values by option name, as the command line or a study's file reads them. fields: by
        field name, overriding `said`. Errors: InputError for a value out of range.
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
        for field in attrs.fields(cls):  # type: ignore[arg-type]
            if _GROUP in field.metadata:
                values[field.name] = field.metadata[_GROUP].of(said)
            elif _KEY in field.metadata:
                own = option_of(field)
                value = said.get(own.name)
                if value is not None:
                    values[field.name] = value if own.parse is None else own.parse(value)
        return values
