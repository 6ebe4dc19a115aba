"""Flattening of includes: each file once, and every line remembers where it came from."""

from __future__ import annotations

from pathlib import Path

import pytest

from hmdwarp.errors import ShaderError
from hmdwarp.gpu import VERSION, flatten


def tree(root: Path, **files: str) -> Path:
    """Files by name, __ for / and the first _ for the dot: a__b_glsl is a/b.glsl."""
    for name, text in files.items():
        path = root / name.replace("__", "/").replace("_", ".", 1)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return root


def test_nested_includes_come_in_place_and_once(tmp_path):
    root = tree(
        tmp_path,
        main_comp='// main\n#include "lib/a.glsl"\n#include "lib/b.glsl"\nvoid main() {}\n',
        lib__a_glsl='int a1;\n#include "lib/c.glsl"\nint a2;\n',
        lib__b_glsl='#include "lib/c.glsl"\nint b1;\n#include "lib/a.glsl"\n',
        lib__c_glsl="int c1;\n",
    )
    flat = flatten("main.comp", root=root)
    assert flat.lines == [VERSION, "// main", "int a1;", "int c1;", "int a2;", "int b1;", "void main() {}"]
    assert flat.origins[1:] == [
        ("main.comp", 1), ("lib/a.glsl", 1), ("lib/c.glsl", 1), ("lib/a.glsl", 3), ("lib/b.glsl", 2), ("main.comp", 4),
    ]  # fmt: skip
    assert flat.text == "\n".join(flat.lines) + "\n"


def test_defines_come_first_and_the_version_before_them(tmp_path):
    root = tree(tmp_path, main_comp="#version 460\nint m;\n")
    flat = flatten("main.comp", {"PASS": 2, "COLOUR": 1}, root=root)
    assert flat.lines == [VERSION, "#define PASS 2", "#define COLOUR 1", "int m;"]
    assert flat.origins[-1] == ("main.comp", 2), "the file's own #version is dropped, its line numbers are kept"


def test_a_missing_include_names_the_line_that_wanted_it(tmp_path):
    root = tree(tmp_path, main_comp='int m;\n#include "lib/a.glsl"\n', lib__a_glsl='\n\n#include "lib/gone.glsl"\n')
    with pytest.raises(
        ShaderError, match=r"shader file 'lib/gone\.glsl' included by lib/a\.glsl:3: No such file"
    ) as caught:
        flatten("main.comp", root=root)
    assert "\n" not in str(caught.value)
    with pytest.raises(ShaderError, match=r"'other\.comp' included by the program"):
        flatten("other.comp", root=root)


def test_messages_of_several_compilers_are_translated(tmp_path):
    root = tree(tmp_path, main_comp='int m;\n#include "a.glsl"\nint n;\n', a_glsl="int a;\nint b;\n")
    flat = flatten("main.comp", root=root)  # lines: version, m, a, b, n
    for message, wanted in [
        ("0:4(14): error: `foo' undeclared", "a.glsl:2(14): error: `foo' undeclared"),  # Mesa
        (
            '0(5) : error C1503: undefined variable "foo"',
            'main.comp:3: error C1503: undefined variable "foo"',
        ),  # NVIDIA
        (
            "ERROR: 0:2: 'foo' : undeclared identifier",
            "ERROR: main.comp:1: 'foo' : undeclared identifier",
        ),  # Apple, Intel, ANGLE
        ("0:3(1): error\n0:5(2): error", "a.glsl:1(1): error\nmain.comp:3(2): error"),
        ("0:99(1): error", "0:99(1): error"),  # beyond the text: left alone
        ("error: linking failed", "error: linking failed"),
        ("10:4 and 20(4)", "10:4 and 20(4)"),  # not a position in string 0
        ("0(3) : error C7011: implicit cast from 0(4) to 0:4", "a.glsl:1: error C7011: implicit cast from 0(4) to 0:4"),
        ("(0) : error C5145: must write to gl_Position", "(0) : error C5145: must write to gl_Position"),
    ]:
        assert flat.translate(message) == wanted
