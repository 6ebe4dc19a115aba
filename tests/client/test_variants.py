"""`name:key=value`.

What is printed is read back as it was, and what cannot be meant is refused in one line that says
what can.
"""

from __future__ import annotations

import math
import typing
from itertools import product

import attrs
import pytest
from hypothesis import given
from hypothesis import strategies as st
from together import together

from hmdwarp.client import parse_warp
from hmdwarp.client.warps import Warp, warps
from hmdwarp.errors import InputError, UnknownNameError
from hmdwarp.options import Choice


def fields_of(warp: type[Warp]) -> list[tuple[str, typing.Any, typing.Any]]:
    """(name, type, default) of each setting."""
    kinds = typing.get_type_hints(warp.Settings)
    return [(field.name, kinds[field.name], field.default) for field in attrs.fields(warp.Settings)]


def values_of(kind: typing.Any, default: typing.Any) -> st.SearchStrategy:
    """Settings that may be meant: each word, and numbers near the default."""
    if words := typing.get_args(kind):
        return st.sampled_from(words)
    if kind is int:
        return st.just(default) | st.integers(max(default - 1, 1), default + 2)
    return st.just(default) | st.floats(default * 0.5, default, exclude_min=True)


@st.composite
def choices(draw: st.DrawFn) -> Choice:
    """Any warp with settings of which any may differ from its default.

    Those that do not go together are passed over.
    """
    warp = draw(st.sampled_from(sorted(warps, key=lambda one: one.name)))
    chosen = {name: draw(values_of(kind, default)) for name, kind, default in fields_of(warp) if draw(st.booleans())}
    try:
        return Choice(warp, warp.Settings(**chosen))
    except (InputError, ValueError):
        return Choice(warp, warp.Settings())


@given(choices())
def test_printed_texts_are_read_back(choice):
    again = parse_warp(str(choice))
    assert again == choice
    assert str(again) == str(choice)


@given(choices())
def test_the_text_is_the_shortest(choice):
    """Settings at their defaults are not told, so two texts that differ mean two settings."""
    _, _, told = str(choice).partition(":")
    default = choice.entry.Settings()
    for part in filter(None, told.split(",")):
        name = part.partition("=")[0]
        assert getattr(choice.settings, name) != getattr(default, name)


@given(choices(), st.data())
def test_blanks_and_order_do_not_matter(choice, data):
    name, _, told = str(choice).partition(":")
    parts = data.draw(st.permutations(told.split(",")))
    assert parse_warp(f"{name}: " + " , ".join(part.replace("=", " = ") for part in parts)) == choice


@together("name", warps.names())
def test_a_name_alone_means_the_defaults(name):
    choice = parse_warp(name)
    assert choice.entry is warps.get(name)
    assert choice.settings == choice.entry.Settings()
    assert str(choice) == name
    assert parse_warp(f"{name}:") == choice


@together("name, setting", product(warps.names(), ["no_such_setting=1", "no_such_setting", "=", "=3"]))
def test_a_setting_it_has_not_is_refused_with_those_it_has(name, setting):
    with pytest.raises(InputError) as refused:
        parse_warp(f"{name}:{setting}")
    message = str(refused.value)
    assert "\n" not in message
    assert setting in message
    assert f"'{name}'" in message
    for known, _, default in fields_of(warps.get(name)):
        assert f"{known}={default}" in message


def numbers() -> list[tuple[str, str]]:
    return [(warp.name, field) for warp in warps for field, kind, _ in fields_of(warp) if kind in (int, float)]


@together("number, value", product(numbers(), ["", "x", "1,5", "--1", "1e", "0x1g"]))
def test_a_number_that_is_none_is_refused(number, value):
    name, field = number
    with pytest.raises(InputError) as refused:
        parse_warp(f"{name}:{field}={value}")
    assert "\n" not in str(refused.value)
    assert f"{name}:{field}" in str(refused.value)


@together("number, value", product(numbers(), ["nan", "inf", "-inf", "-1"]))
def test_a_number_that_cannot_be_meant_is_refused(number, value):
    """A negative tolerance or a step count that is not a number would make a picture that looks
    like a fault of the method.
    """
    name, field = number
    with pytest.raises(InputError) as refused:
        parse_warp(f"{name}:{field}={value}")
    assert field in str(refused.value)
    assert "\n" not in str(refused.value)


@together(
    "name, field",
    [(warp.name, field) for warp in warps for field, kind, _ in fields_of(warp) if typing.get_args(kind)],
)
def test_a_word_it_does_not_know_is_refused(name, field):
    with pytest.raises(InputError) as refused:
        parse_warp(f"{name}:{field}=no-such-word")
    assert "no-such-word" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_an_unknown_warp_is_refused_with_a_guess():
    with pytest.raises(UnknownNameError, match="rotation"):
        parse_warp("rotaton:tolerance=1")


def test_backwards_settings_are_read():
    settings = parse_warp("backward:tolerance=0.5,floor=1e-3").settings
    assert settings.tolerance == 0.5
    assert settings.floor == 1e-3
    assert math.isclose(parse_warp("backward:floor=.25").settings.floor, 0.25)
