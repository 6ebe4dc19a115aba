"""Messages about an option name it as its user types it, whatever declares it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import attrs
from together import together

from hmdwarp.base import Declared, InputError, as_keys, option_of
from hmdwarp.cli._app import options_of_commands

WRONG = (math.nan, math.inf, -math.inf, "?", "?=?", "x:?", "", (), (math.nan,), b"?", 1j, [None], {}, object)

commands = options_of_commands()


def declarations(kind: type = Declared) -> Iterator[type]:
    for subclass in kind.__subclasses__():
        if attrs.has(subclass):  # attrs makes a class with slots beside the one that was written
            yield subclass
        yield from declarations(subclass)


def fields() -> dict[str, attrs.Attribute[Any]]:
    found = {}
    for kind in declarations():
        for field in attrs.fields(kind):
            if "options" in field.metadata:
                found[f"{kind.__name__}.{field.name}"] = field
    return found


FIELDS = fields()
OFFERED = {option.name for options in commands.values() for option in options}


def refusals(field: attrs.Attribute[Any]) -> list[str]:
    """What is said of values that the option cannot have, by its parser and its validator."""
    said, option = [], option_of(field)
    checks = (option.parse, field.validator and (lambda one: field.validator(None, field, one)))
    for value in WRONG:
        for check in filter(None, checks):
            try:
                check([value] if option.kind is list else value)
            except InputError as error:
                said.append(str(error))
            except AttributeError:
                pass  # of the object, which a validator of several fields looks at
            except (TypeError, ValueError):
                # A parser takes texts; a converter has made of them what the validator gets.
                if check is not option.parse and field.converter is None:
                    raise
    return said


def test_every_option_of_the_command_line_is_looked_at_here_or_has_no_limits_of_its_own():
    declared = {option_of(field).name for field in FIELDS.values()}
    limited = {option.name for options in commands.values() for option in options if option.limits or option.parse}
    assert limited <= declared


@together("where", FIELDS)
def test_a_refusal_begins_with_the_option_as_it_is_typed(where):
    field = FIELDS[where]
    option = option_of(field)
    said = refusals(field)
    assert said or not option.limits
    for message in said:
        # Names of registries are refused by the registry: "unknown warp 'x': known are ...".
        assert message.startswith((f"{option.flag} ", f"{option.flag}:", "unknown ")), message


def test_a_file_names_them_by_its_keys():
    assert as_keys("--link-seed -1: see --latency and --out", {"link_seed", "latency"}) == (
        "link_seed -1: see latency and --out"
    )
    assert {"link_seed", "latency"} <= OFFERED
