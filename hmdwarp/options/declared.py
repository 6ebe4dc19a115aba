"""Declaration of options, and construction of objects from the texts that users write."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any, ClassVar, Self

import attrs

from .limits import Number

_KEY, _GROUP = "options", "group"
# Fields that say where results go and how they are made, but not what they are.
HOW = ("out", "force", "command", "workers", "parquet", "sweep", "trace_events")
# Where a study's file may set an option: for the display of a whole session, for how the scene
# looks, or for one condition. Otherwise a sentence says why it may not.
DISPLAY, PICTURE, CONDITION = "display", "picture", "condition"


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

    def named(self, field: str) -> Option:
        """Return the option with a name: its own, or that of its field."""
        return self if self.name else attrs.evolve(self, name=field.removesuffix(f"_{self.unit.lower()}"))


def option(
    value: Any, help: str, /, *, valid: Any = None, convert: Any = None, beside: tuple[Option, ...] = (), **about: Any
) -> Any:
    """Return an attrs field that is an option.

    value: default of the field. valid, convert: validator and converter of the field. beside:
    options that affect the same field, see Declared.values_of. about: attributes of Option; kind
    and default are those of the field's default unless they say otherwise.
    """
    required = value is attrs.NOTHING
    kind = str if value is None or required else type(value)
    number = "a whole number" if about.get("kind", kind) is int else "a number"
    limits = f"{number} {valid.words()}" if isinstance(valid, Number) else ""
    about = {"kind": kind, "default": None if required else value, "required": required, "limits": limits, **about}
    return attrs.field(
        default=value, validator=valid, converter=convert, metadata={_KEY: (Option(help, **about), *beside)}
    )


def group(kind: type[Declared]) -> Any:
    """Return an attrs field that holds the options of another class."""
    return attrs.field(factory=kind, metadata={_GROUP: kind})


def option_of(field: attrs.Attribute[Any]) -> Option:
    """Return the option that an attrs field is, with its name."""
    first: Option = field.metadata[_KEY][0]
    return first.named(field.name)


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


def options_of(kind: type[Declared]) -> tuple[Option, ...]:
    """Return the options of a class in the order of its fields, those of its groups included."""
    return tuple(found for found in _all_of(kind) if found.name not in kind.not_offered)


def _all_of(kind: type) -> Iterator[Option]:
    for field in attrs.fields(kind):
        if _GROUP in field.metadata:
            inner = field.metadata[_GROUP]
            yield from (
                attrs.evolve(inner_option, heading=inner_option.heading or inner.heading)
                for inner_option in _all_of(inner)
            )
        yield from (declared.named(field.name) for declared in field.metadata.get(_KEY, ()))


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
