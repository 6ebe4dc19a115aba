"""Lines of keys in a TOML file, against files whose keys were written at known lines."""

from __future__ import annotations

import tomllib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.options.documents import line_of

TEXT = """\
# a comment with [brackets] and = signs
name = "x" # 2
[trial] # 3
seconds = 20
text = QQQ
[[not.a.table]]
order = "no" \\QQQ still
QQQ"
order = 'latin'
deep.er.still = 1

[[part]]
name = 'one ]] = # '
[[part.condition]]
name = "a" # 15
latency = 1979-05-27 07:32:00 # 16
[[part.condition]]
name = "b" # 18
limits = [ # 19
  { from = 1, "to it" = 2 }, # 20
  [3,
   '''[4]
   ''', 5], # 5 is in line 23
]
[[ part ]] # 25
name = "two"
[part.extra]
x = 1
[[part.condition]] # 29
name = "c"
""".replace("QQQ", 3 * '"')
LINES = [
    (("name",), 2), (("trial",), 3), (("trial", "seconds"), 4), (("trial", "text"), 5), (("trial", "order"), 9),
    (("trial", "deep", "er", "still"), 10), (("trial", "missing"), 3), (("part",), 12), (("part", 0), 12),
    (("part", 0, "name"), 13), (("part", 0, "condition", 0), 14), (("part", 0, "condition", 0, "name"), 15),
    (("part", 0, "condition", 0, "latency"), 16), (("part", 0, "condition", 1, "name"), 18),
    (("part", 0, "condition", 1, "limits", 0, "to it"), 20), (("part", 0, "condition", 1, "limits", 1), 21),
    (("part", 0, "condition", 1, "limits", 1, 1), 22), (("part", 0, "condition", 1, "limits", 1, 2), 23),
    (("part", 1), 25), (("part", 1, "name"), 26), (("part", 1, "extra"), 27), (("part", 1, "extra", "x"), 28),
    (("part", 1, "condition", 0), 29), (("part", 1, "condition", 0, "name"), 30), (("nowhere",), 1), ((), 1),
]  # fmt: skip


@pytest.mark.parametrize(("path", "line"), LINES, ids=str)
def test_every_key_is_found(path, line):
    value = tomllib.loads(TEXT)
    for key in path if not {"missing", "nowhere"} & {*path} else ():
        value = value[key]  # it is there
    assert line_of(TEXT, path) == line


KEYS = st.text("ab-", min_size=1, max_size=2)
MULTILINE = ["QQQ\na = [1\nQQQ".replace("Q", '"'), "QQQ\n[x]\nQQQ".replace("Q", "'")]
SCALARS = st.sampled_from(['"x"', '"]#\\""', "'='", "1", "-1.5e3", "true", "2001-01-01", *MULTILINE])
LISTS = st.lists(SCALARS, max_size=3).map(lambda values: "[\n" + ", # [\n".join(values) + "\n]")
VALUES = st.one_of(
    SCALARS, LISTS, LISTS.map(lambda inner: f"{{ a = 1, b = {inner} }}"), LISTS.map(lambda inner: f"[{inner}, {inner}]")
)
PAIRS = st.lists(st.tuples(KEYS, VALUES), max_size=4, unique_by=lambda pair: pair[0])


@settings(max_examples=200)
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
    assert line_of("a = " + "[" * 10_000, ("a",)) == 1
    assert line_of("a = { b = [\n" + "1,\n" * 40 + "2], c = 2 }", ("a", "c")) == 42
