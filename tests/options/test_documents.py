"""JSON and TOML: whatever the text, what it holds or one line, at once and in little memory.

`make fuzz` damages what their readers read.
"""

from __future__ import annotations

import pytest

from hmdwarp.base.documents import MOST_DEPTH, DocumentError, parse_json, parse_toml

HUGE = 200_000

JSON = {
    "lists in each other": "[" * HUGE,
    "lists that end": "[" * HUGE + "]" * HUGE,
    "objects in each other": '{"a":' * HUGE,
    "one more than allowed": "[" * (MOST_DEPTH + 1) + "]" * (MOST_DEPTH + 1),
    "a long key": '{"' + "k" * HUGE + '": 1}',
    "a key twice": '{"a": 1, "b": {"c": 1, "c": 2}}',
    "half a character": r'{"a": "\ud800"}',
    "UTF-16": '{"a": 1}'.encode("utf-16"),
    "Latin-1": '{"a": "é"}'.encode("latin-1"),
    "nothing": "",
}
TOML = {  # tomllib alone takes minutes for a dotted key
    "lists in each other": "a = " + "[" * HUGE,
    "lists that end": "a = " + "[" * 500 + "]" * 500,
    "tables in each other": "a = " + "{a = " * HUGE,
    "a dotted key": ".".join("a" * HUGE) + " = 1",
    "a dotted key with blanks": " . ".join(['"a"'] * HUGE) + " = 1",
    "a dotted heading": "[" + ".".join("a" * HUGE) + "]",
    "a long key": "k" * HUGE + " = 1",
    "a key twice": "a = 1\na = 2",
    "a number of many digits": "a = " + "1" * HUGE,
}


REFUSED = [(parse_json, what, text) for what, text in JSON.items()]
REFUSED += [(parse_toml, what, text) for what, text in TOML.items()]


@pytest.mark.parametrize(
    ("parse", "what", "text"), REFUSED, ids=[f"{parse.__name__}-{what}" for parse, what, _ in REFUSED]
)
def test_what_is_refused_is_so_in_a_line(parse, what, text):
    with pytest.raises(DocumentError) as caught:
        parse(text)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 300


def test_json_keeps_what_it_holds_and_whole_numbers_fit_a_float():
    deep = "[" * MOST_DEPTH + "]" * MOST_DEPTH
    assert parse_json(deep) == eval(deep)
    values = {"a": [1, -(2**63), 1.5, True, None], "\U0001f600": ""}
    assert (
        parse_json('\ufeff{"a": [1, -9223372036854775808, 1.5, true, null], "\\ud83d\\ude00": ""}'.encode()) == values
    )
    assert parse_json(f"[{10**30}, -{10**400}, {'9' * HUGE}]") == [1e30, float("-inf"), float("inf")]
