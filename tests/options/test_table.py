"""Each key by its type, with a message that names it."""

from __future__ import annotations

import math

import pytest

from hmdwarp.base import InputError, KeyFault, Table, parsed

DATA = {
    "text": "x", "empty": " ", "lines": "a\nb", "number": 2.5, "whole": 3, "huge": 0x1 << 20_000, "nan": math.nan,
    "flag": True, "texts": ["a", "b"], "table": {"inner": 1}, "tables": [{"a": 1}, {"a": "x"}],
}  # fmt: skip


@pytest.mark.parametrize(
    ("ask", "says", "path"),
    [
        (lambda t: t.text("absent"), "the key absent is missing; some.toml has them all", ()),
        (lambda t: t.table("table").number("absent"), "the key table.absent is missing", ("table",)),
        (lambda t: t.text("number"), "number is 2.5: expected a text", ("number",)),
        (lambda t: t.text("empty"), "empty is ' ': expected a text", ("empty",)),
        (lambda t: t.line("lines"), r"lines is 'a\nb': expected a text of one line", ("lines",)),
        (lambda t: t.word("text", ("a", "b", "c")), "text is 'x': expected a, b or c", ("text",)),
        (lambda t: t.word("table", ("a",)), "table is {'inner': 1}: expected a", ("table",)),
        (lambda t: t.flag("whole"), "whole is 3: expected true or false", ("whole",)),
        (lambda t: t.number("flag"), "flag is True: expected a finite number", ("flag",)),
        (lambda t: t.number("huge"), "huge is a number beyond all bounds: expected a finite number", ("huge",)),
        (lambda t: t.within("number", 0, 2), "2.5: expected a number of at least 0 and at most 2", ("number",)),
        (lambda t: t.within("whole", 3, math.inf, above=True), "whole is 3: expected a number above 3", ("whole",)),
        (lambda t: t.whole("number", 0, 9), "2.5: expected a whole number of at least 0 and at most 9", ("number",)),
        (lambda t: t.whole("flag", 0, 9), "flag is True: expected a whole number", ("flag",)),
        (lambda t: t.whole("huge", 0, 9), "huge is a number beyond all bounds", ("huge",)),
        (lambda t: t.texts("text"), "text is 'x': expected a list of texts", ("text",)),
        (lambda t: t.tables("table"), "{'inner': 1}: expected tables, each beginning with [[table]]", ("table",)),
        (lambda t: t.table("texts"), "texts is ['a', 'b']: expected a table of keys", ("texts",)),
        (lambda t: t.tables("texts"), "texts is 'a': expected a table of keys", ("texts", 0)),
        (lambda t: t.tables("tables")[1].number("a"), "tables.a is 'x': expected a finite number", ("tables", 1, "a")),
    ],
)
def test_faults_are_named(ask, says, path):
    with pytest.raises(KeyFault) as caught:
        ask(Table(DATA, example="some.toml"))
    assert says in str(caught.value) and "\n" not in str(caught.value)
    assert caught.value.path == path


def test_omitted_keys_may_have_a_default():
    table = Table({})
    assert table.text("a", "b") == "b" and table.flag("c", False) is False and table.number("d", None) is None
    assert (table.whole("e", 0, 9, 5), table.texts("f", ()), table.tables("g")) == (5, (), ())
    assert table.within("h", 0, 1, 0.5) == 0.5


def test_a_key_nobody_asked_for_is_refused_with_the_nearest_known_one():
    table = Table({"seconds": 1, "part": [{"name": "x", "nmae": 2}]})
    assert "breaks" not in table
    table.number("seconds")
    (part,) = table.tables("part")
    part.text("name")
    nearest = r"unknown key part\.nmae: did you mean part\.name\? known are part\.name"
    with pytest.raises(KeyFault, match=nearest) as caught:
        table.refuse_unread()
    assert caught.value.path == ("part", 0, "nmae")
    table = Table({"braeks": 1})
    assert "breaks" not in table  # asked for, so it is one of the known
    with pytest.raises(KeyFault, match="did you mean breaks"):
        table.refuse_unread()

    with pytest.raises(KeyFault) as caught:
        Table({"a\nb": 1}).refuse_unread()
    assert str(caught.value).startswith(r"unknown key 'a\nb'")  # it stays on its line


def test_a_missing_key_points_at_the_one_that_was_meant():
    with pytest.raises(KeyFault, match="the key a.seconds is missing: is secnods meant to be seconds") as caught:
        Table({"a": {"secnods": 1}}).table("a").number("seconds")
    assert caught.value.path == ("a", "secnods")


@pytest.mark.parametrize(
    ("header", "wanted"), [("[condition]", "[[condition]]"), ('[part."my own"]', "[[part.my own]]")]
)
def test_a_table_twice_is_told_how_several_are_written(header, wanted):
    with pytest.raises(InputError) as caught:
        parsed(f"{header}\nx = 1\n{header}\nx = 2\n", "some.toml", lambda table: table.keys())
    assert str(caught.value).startswith("some.toml:3: this is no TOML: Cannot declare ")
    assert str(caught.value).endswith(f"; where a file may have several of them, each begins with {wanted}")
