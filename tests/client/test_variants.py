"""`name:key=value`. What is printed is read back as it was, and what cannot be meant is refused in
one line that says what can."""

from __future__ import annotations

import typing
from itertools import product

import attrs
import pytest
from hypothesis import given
from hypothesis import strategies as st
from together import together

from hmdwarp.base import Choice, InputError
from hmdwarp.client import parse_fills, parse_warp
from hmdwarp.client.fills import fills
from hmdwarp.client.warps import warps


def fields_of(warp: type) -> list[tuple[str, typing.Any, typing.Any]]:
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
    """Any warp with settings of which any may differ from its default. Those that do not go
    together are passed over."""
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


ODD_NUMBERS = ("", "x", "1,5", "--1", "1e", "0x1g", "nan", "inf", "-inf", "-1")


@together(
    "read, name, field, value",
    [
        (read, entry.name, field, value)
        for read, entries in ((parse_warp, warps), (parse_fills, fills))
        for entry in entries
        for field, kind, _ in fields_of(entry)
        for value in (ODD_NUMBERS if kind in (int, float) else ["no-such-word"])
    ],
)
def test_a_value_that_cannot_be_meant_is_refused(read, name, field, value):
    """A negative tolerance would make a picture that looks like a fault of the method."""
    with pytest.raises(InputError) as refused:
        read(f"{name}:{field}={value}")
    if value == "no-such-word" and read is parse_warp and field in ("cut", "eye", "fringe", "path", "seed", "sheets"):
        with pytest.raises(ValueError, match=field):
            warps.get(name).Settings(**{field: value})
    message = str(refused.value)
    assert field in message and (value if value in ("no-such-word", "x") else "") in message and "\n" not in message


# Of each warp and fill, what is refused beside that, and words of why.
SHARE = "expected more than 0 and at most 1"
REFUSED = (
    (parse_warp, "iterative", "iterative", "steps=0 steps=2,slanted=3"),
    (parse_warp, "layered", "layers is", "layers=1 layers=5 layers=-2 layers=three"),
    (parse_warp, "mesh", "mesh", "steepest_deg=90 grid=1 grid=2000 grid=64,cut=vertex grid=64,ring=0.6 ring=0.1"),
    (parse_warp, "mesh_adaptive", "mesh_adaptive", "block=3"),
    (parse_warp, "model", SHARE, "share=0 share=1.5 share=-0.2 texture=0 texture=1.5 texture=-0.2"),
    (parse_warp, "multi", "warp 'multi:", "frames=9 views=5"),
    (parse_warp, "none", "no setting of", "resample=catmull-rom"),
    (parse_warp, "environment", "no setting of", "resample=catmull-rom"),
    (parse_warp, "iterative", "resample is 'cubic': expected bilinear or catmull-rom", "resample=cubic"),
    (parse_warp, "splat", "warp 'splat:", "reach=0 reach=1000 overlap=0.7"),
    (parse_fills, "composite", "expected", "samples=0 samples=257 radius=0 radius=3 normal=181"),
    (parse_fills, "interpolate", "size is '.*': expected 3 or 5 or 7", "size=0 size=1 size=2 size=4 size=9 size=3.0"),
    (parse_fills, "memory", "memory", "frames=0 use=0 age=0 frames=65"),
    (parse_fills, "model", "expected", "share=0 share=1.1 texture=0 texture=2"),
    (parse_fills, "pyramid", "expected more than 0", "holes=0"),
    (parse_fills, "pyramid", "expected 0 or more", "tolerance=-1"),
    (parse_fills, "relight", "expected", "samples=0 reach=0"),
    (parse_fills, "stretch", "expected 0 or more", "spread=-1"),
)


@pytest.mark.parametrize(("read", "name", "why", "settings"), REFUSED)
def test_what_one_of_them_refuses(read, name, why, settings):
    for setting in settings.split():
        with pytest.raises(InputError, match=why):
            read(f"{name}:{setting}")
