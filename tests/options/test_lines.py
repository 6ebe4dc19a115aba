"""Lines of keys in a TOML file, against files whose keys were written at known lines."""

from __future__ import annotations

import tomllib

from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.base.documents import line_of

KEYS = st.text("ab-", min_size=1, max_size=2)
MULTILINE = ["QQQ\na = [1\nQQQ".replace("Q", '"'), "QQQ\n[x]\nQQQ".replace("Q", "'")]
SCALARS = st.sampled_from(['"x"', '"]#\\""', "'='", "1", "-1.5e3", "true", "2001-01-01", *MULTILINE])
LISTS = st.lists(SCALARS, max_size=3).map(lambda values: "[\n" + ", # [\n".join(values) + "\n]")
VALUES = st.one_of(
    SCALARS, LISTS, LISTS.map(lambda inner: f"{{ a = 1, b = {inner} }}"), LISTS.map(lambda inner: f"[{inner}, {inner}]")
)
PAIRS = st.lists(st.tuples(KEYS, VALUES), max_size=4, unique_by=lambda pair: pair[0])


@given(st.lists(st.tuples(st.sampled_from(["[", "[["]), KEYS, PAIRS), max_size=5))
def test_files_whose_lines_are_known(tables):
    """Written line by line here, so each key's line is the count of the lines before it."""
    lines, wanted, counts = [], {}, {}
    for bracket, name, pairs in tables:
        if (name in counts) and (bracket == "[" or counts[name] is None):
            continue  # a table is written once
        path = (name,)
        if bracket == "[[":
            counts[name] = counts.get(name, 0) + 1
            path = (name, counts[name] - 1)
        else:
            counts[name] = None
        wanted[path] = len(lines) + 1
        lines.append(f"{bracket}{name}{']' * len(bracket)}")
        for key, value in pairs:
            wanted[(*path, key)] = len(lines) + 1
            lines += f"{key} = {value}".split("\n")
    text = "\n".join(lines)
    tomllib.loads(text)
    assert {path: line_of(text, path) for path in wanted} == wanted


@settings(max_examples=300)
@given(st.text("[]{}=\"'#\n ,.ab\\", max_size=40))
def test_texts_that_are_no_toml_are_survived(text):
    assert line_of(text, ("a", 0, "b")) >= 1


def test_values_that_no_end_closes_or_of_many_lines():
    assert line_of("a = " + "[" * 10_000, ("a",)) == 1
    assert line_of("a = { b = [\n" + "1,\n" * 40 + "2], c = 2 }", ("a", "c")) == 42
