"""Compiled programs: errors with file and line, strict uniforms, group counts, includes."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import contexts
import moderngl
import numpy as np
import pytest

import hmdwarp.gpu.shaders
from hmdwarp.base import InputError, ShaderError
from hmdwarp.gpu import VERSION, Compute, Draw, Gpu, ShaderLibrary, flatten


@pytest.fixture(scope="module")
def gpu():
    """A context of its own, which has room for the blocks of these programs."""
    with contexts.as_shipped(), Gpu() as own:
        yield own


@pytest.fixture
def shaders(tmp_path, monkeypatch) -> Path:
    """An empty folder that the program takes for its shaders/."""
    monkeypatch.setattr(hmdwarp.gpu.shaders, "folder", lambda name: tmp_path)
    return tmp_path


def tree(root: Path, **files: str) -> None:
    """Write files by name, __ for / and the first _ for the dot: a__b_glsl is a/b.glsl."""
    for name, text in files.items():
        path = root / name.replace("__", "/").replace("_", ".", 1)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def compute(gpu, root: Path, text: str, **defines: object) -> Compute:
    tree(root, test_comp=text)
    return Compute(gpu.gl, "test.comp", defines)


def results(gpu, program: Compute, count: int) -> np.ndarray:
    """What the shader leaves in its float buffer 0."""
    buffer = gpu.gl.buffer(np.full(count, np.nan, np.float32).tobytes())
    buffer.bind_to_storage_buffer(0)
    program.run(1)
    gpu.gl.memory_barrier()
    out = np.frombuffer(buffer.read(), np.float32)
    buffer.release()
    return out


HEAD = "layout(local_size_x = 1) in;\nlayout(std430, binding = 0) buffer Out { float o[]; };\n"


# --- errors -------------------------------------------------------------------------------------


def test_a_compile_error_names_the_file_and_line_it_is_in(gpu, shaders):
    tree(shaders, lib__broken_glsl="// one\nfloat good() { return 1.0; }\nfloat bad() { return missing; }\n")
    with pytest.raises(ShaderError, match=r"lib/broken\.glsl:3\b.*missing") as caught:
        compute(gpu, shaders, f'{HEAD}\n#include "lib/broken.glsl"\nvoid main() {{ o[0] = bad(); }}\n', UNUSED=1)
    assert str(caught.value).startswith("test.comp: ")
    with pytest.raises(ShaderError, match=r"test\.comp:4\b.*nowhere"):
        compute(gpu, shaders, f"{HEAD}\nvoid main() {{ o[0] = nowhere; }}\n")


@pytest.mark.parametrize("guilty", ["vertex", "fragment"])
def test_a_draw_names_the_stage_that_is_broken(gpu, shaders, guilty):
    texts = {
        "vertex": "//\nvoid main() { gl_Position = vec4(0.0); }\n",
        "fragment": "//\n//\nout vec4 c;\nvoid main() { c = vec4(1.0); }\n",
    }
    texts[guilty] += "float broken() { return missing; }\n"
    tree(shaders, a_vert=texts["vertex"], a_frag=texts["fragment"])
    line = texts[guilty].count("\n")
    with pytest.raises(ShaderError, match=rf"^a\.{guilty[:4]}: (.|\n)*a\.{guilty[:4]}:{line}\b(.|\n)*missing"):
        Draw(gpu.gl, "a.vert", "a.frag", {})


LINKER = {  # recorded: what is said, the stage that the error begins with, and its lines as translated
    "NVIDIA, which finds undefined functions when it links, in both stages": (
        'GLSL Linker failed\n\nVertex info\n-----------\n0(3) : error C3002: call to undefined function "a"\n'
        'Fragment info\n-------------\n0(3) : error C3002: call to undefined function "b"\n',
        "a.vert", ['a.vert:2: error C3002: call to undefined function "a"', "a.frag:2: error C3002: call to undefined"],
    ),
    "NVIDIA, without a line": (
        "Vertex info\n-----------\n(0) : error C5145: must write to gl_Position\n", "a.vert", ["(0) : error C5145"],
    ),
    "Mesa, which names no stage": ("GLSL Linker failed\n\nProgram\n=======\nerror: v\n", "a.frag", ["error: v"]),
}  # fmt: skip


@pytest.mark.parametrize("driver", LINKER)
def test_linker_messages_are_translated_by_their_stage(shaders, driver):
    message, first, told = LINKER[driver]
    tree(shaders, a_vert="//\n//\nvoid main() {}\n", a_frag="//\n//\nvoid main() {}\n")
    context = SimpleNamespace(program=Mock(side_effect=moderngl.Error(message)))
    with pytest.raises(ShaderError) as caught:
        Draw(context, "a.vert", "a.frag", {})
    assert str(caught.value).startswith(f"{first}: ")
    assert all(line in str(caught.value) for line in told)


# --- uniforms -----------------------------------------------------------------------------------

UNIFORMS = """
uniform float scalar;
uniform int whole;  // uniform float not_one;
uniform vec2 pair, other_pair;
uniform float list[3];
uniform vec3 vectors[2];
uniform mat3 square, unused_square;
uniform mat3x2 tall; // GLSL: 3 columns, 2 rows
uniform mat2 squares[2];
uniform ivec2 whole_pair;
uniform uint big;
uniform float preset = 7.0;
#define COUNT 2
uniform vec2 counted[COUNT];
#if COUNT > 1
uniform float guarded; /* beside */ uniform vec2 both;
#endif
"""


def test_unknown_names_are_refused_and_unused_ones_are_not(gpu, shaders):
    program = compute(gpu, shaders, f"{HEAD}{UNIFORMS}void main() {{ o[0] = scalar; }}")
    with pytest.raises(
        ShaderError, match=r"test\.comp has no uniform 'scaler'; it has big, both, counted, guarded, list, "
    ):
        program.uniforms.set(scaler=1.0)
    # All but `scalar` are optimised away, and may still be set.
    program.uniforms.set(scalar=2.0, whole=1, other_pair=(3, 4), list=np.zeros(3), unused_square=np.eye(3))
    assert results(gpu, program, 1) == [2.0]
    for name in ("scalar", "other_pair", "unused_square", "list", "preset"):
        assert program.uniforms.declares(name)
    for name in ("Out", "o", "float", "main", "gl_Position", ""):
        assert not program.uniforms.declares(name)


# A uniform whose name means something else in the branch that is taken.
@pytest.mark.parametrize("other", ["", "#if 0\nuniform float steady;\n#else\nconst float steady = 0.0;\n#endif\n"])
def test_arrays_and_matrices_are_written_as_the_formulas_have_them(gpu, shaders, other):
    """M[row, column] in NumPy is M[column][row] in GLSL; vectors and matrices keep their order."""
    body = """
    o[0] = square[1][0]; o[1] = square[0][2];
    o[2] = tall[2][0]; o[3] = tall[0][1];
    o[4] = vectors[0].z; o[5] = vectors[1].x;
    o[6] = squares[1][0][1]; o[7] = squares[0][1][0];
    o[8] = list[2]; o[9] = pair.y; o[10] = float(whole_pair.y); o[11] = float(whole); o[12] = float(big);
    o[13] = preset; o[14] = counted[1].y; o[15] = guarded + both.x;
    """
    program = compute(gpu, shaders, f"{HEAD}{UNIFORMS}{other}void main() {{ {body} }}")
    square, tall, vectors = np.arange(9.0).reshape(3, 3), np.arange(6.0).reshape(2, 3), np.arange(6.0).reshape(2, 3)
    squares = np.arange(8.0).reshape(2, 2, 2)
    program.uniforms.set(
        square=square, tall=tall, vectors=vectors, squares=squares, list=np.array([5, 6, 7]), pair=np.array([8, 9])
    )
    program.uniforms.set(whole_pair=np.array([-3, -4]), whole=-5, big=np.uint32(2**31))
    program.uniforms.set(counted=[(0, 0), (1, 10)], guarded=5, both=(6, 0))
    wanted = [
        square[0, 1], square[2, 0], tall[0, 2], tall[1, 0], 2, 3, squares[1, 1, 0], squares[0, 0, 1], 7, 9, -4, -5,
        2.0**31,
        *(7, 10, 11),
    ]  # fmt: skip
    assert results(gpu, program, 16).tolist() == wanted


def test_values_that_do_not_fit_are_refused(gpu, shaders):
    used = "o[0] = square[1][1] + pair.x + list[1] + float(whole) + scalar;"
    program = compute(gpu, shaders, f"{HEAD}{UNIFORMS}void main() {{ {used} }}")
    unfit = {"square": (np.eye(2), np.zeros(9)), "pair": [(1, 2, 3)], "list": [1.0], "whole": [1.5], "scalar": ["1"]}
    for name, values in unfit.items():
        for value in values:
            with pytest.raises(ShaderError, match=rf"test\.comp: uniform '{name}' cannot take "):
                program.uniforms.set(**{name: value})


def read_only(values: list[float]) -> np.ndarray:
    array = np.array(values)
    array.flags.writeable = False
    return array


def test_only_uniforms_that_may_have_changed_are_written(gpu, shaders, monkeypatch):
    """The same array may hold other numbers, and so may a view of it; the same tuple may not."""
    program = compute(gpu, shaders, f"{HEAD}uniform vec2 v;\nvoid main() {{ o[0] = v.x; o[1] = v.y; }}")
    array = np.array([1.0, 2.0])
    view = array[:]
    view.flags.writeable = False
    for value in (array, view):
        for number in (3.0, 4.0):
            array[0] = number
            program.uniforms.set(v=value)
            assert results(gpu, program, 2).tolist() == [number, 2.0]
    written, write = [], moderngl.Buffer.write
    monkeypatch.setattr(
        moderngl.Buffer, "write", lambda self, data, **at: (written.append(len(data)), write(self, data, **at))
    )
    constant, other = (5.0, 6.0), read_only([7.0, 8.0])
    for value in (constant, constant, other, other, constant):
        program.uniforms.set(v=value)
        assert results(gpu, program, 2).tolist() == list(value)
    assert written == [16] * 3


def test_shared_values_go_where_they_are_declared_and_settled_ones_come_back_after_others(gpu, shaders):
    """Two users of one program, and one who sets what was settled."""
    program = compute(gpu, shaders, f"{HEAD}uniform float a, b;\nvoid main() {{ o[0] = a; o[1] = b; }}")
    one, other = {"a": 1.0, "b": 2.0, "elsewhere": 3.0}, {"a": 4.0}
    for values, wanted in ((one, [1, 2]), (one, [1, 2]), (other, [4, 2]), (one, [1, 2])):
        program.uniforms.settle(values)
        assert results(gpu, program, 2).tolist() == wanted
    program.uniforms.set_declared(b=7.0, elsewhere=3.0)
    assert results(gpu, program, 2).tolist() == [1, 7]
    program.uniforms.settle(one)
    assert results(gpu, program, 2).tolist() == [1, 2]
    with pytest.raises(ShaderError, match="cannot take"):
        program.uniforms.set_declared(a="2")


# --- group counts -------------------------------------------------------------------------------

MARK = """
layout(std430, binding = 0) buffer Out { float o[]; };
uniform ivec2 size;
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (p.x < size.x && p.y < size.y) o[p.y * size.x + p.x] += 1.0;
}
"""


@pytest.mark.parametrize("group", [(8, 8), (16, 2), (1, 1)])
@pytest.mark.parametrize("size", [(1, 1), (8, 8), (9, 8), (7, 17), (33, 1)])
def test_every_pixel_is_visited_once(gpu, shaders, group, size):
    text = f"#define GROUP_X {group[0]}\nlayout(local_size_x = GROUP_X, local_size_y = {group[1]}) in;\n{MARK}"
    program = compute(gpu, shaders, text)
    assert program.group == group
    assert program.rows == 1
    assert program.groups(*size) == (-(-size[0] // group[0]), -(-size[1] // group[1]))
    buffer = gpu.gl.buffer(np.zeros(size[0] * size[1], np.float32).tobytes())
    buffer.bind_to_storage_buffer(0)
    program.uniforms.set(size=size)
    program.run(*size)
    gpu.gl.memory_barrier()
    assert (np.frombuffer(buffer.read(), np.float32) == 1).all()
    buffer.release()


def test_rows_an_invocation_does_need_fewer_groups(gpu, shaders):
    text = "#ifndef ROWS\n#define ROWS 4\n#endif\nlayout(local_size_x = 8, local_size_y = 8) in;\nvoid main() {}"
    program = compute(gpu, shaders, text)
    assert program.groups(64, 64) == (8, 2) and program.groups(65, 65) == (9, 3)
    assert compute(gpu, shaders, text, ROWS=2).rows == 2


def test_more_groups_than_the_gpu_takes_are_refused(gpu, shaders):
    """GL drops such a dispatch silently: the picture would be an old one."""
    program = compute(gpu, shaders, "layout(local_size_x = 1) in;\nvoid main() {}")
    most = gpu.gl.info["GL_MAX_COMPUTE_WORK_GROUP_COUNT"]
    assert program.groups(most[0], most[1]) == (most[0], most[1])
    for size in ((most[0] + 1, 1), (1, most[1] + 1)):
        with pytest.raises(InputError, match=r"test\.comp needs \d+ x \d+ work groups, this GPU takes \d+ x \d+"):
            program.run(*size)


# --- the cache ----------------------------------------------------------------------------------


def test_the_library_compiles_each_combination_once(gpu, shaders):
    tree(
        shaders,
        a_comp="layout(local_size_x = 1) in;\nvoid main() {}",
        a_frag="out vec4 c;\nvoid main() { c = vec4(1.0); }",
    )
    tree(shaders, a_vert="void main() { gl_Position = vec4(0.0); }")
    library = ShaderLibrary(gpu.gl)
    plain, ordered = library.compute("a.comp"), library.compute("a.comp", A=1, B=2)
    assert library.compute("a.comp") is plain and library.compute("a.comp", B=2, A=1) is ordered
    assert library.compute("a.comp", A=1) is not ordered
    assert library.draw("a.vert", "a.frag") is library.draw("a.vert", "a.frag")
    assert len(library) == 4


# --- includes: each file once, and every line remembers where it came from ------------------------


def test_nested_includes_come_in_place_and_once(shaders):
    tree(
        shaders,
        main_comp='// main\n#include "lib/a.glsl"\n#include "lib/b.glsl"\nvoid main() {}\n',
        lib__a_glsl='int a1;\n#include "lib/c.glsl"\nint a2;\n',
        lib__b_glsl='#include "lib/c.glsl"\nint b1;\n#include "lib/a.glsl"\n',
        lib__c_glsl="int c1;\n",
    )
    flat = flatten("main.comp")
    assert flat.lines == [VERSION, "// main", "int a1;", "int c1;", "int a2;", "int b1;", "void main() {}"]
    assert flat.origins[1:] == [
        ("main.comp", 1), ("lib/a.glsl", 1), ("lib/c.glsl", 1), ("lib/a.glsl", 3), ("lib/b.glsl", 2), ("main.comp", 4),
    ]  # fmt: skip
    assert flat.text == "\n".join(flat.lines) + "\n"
    tree(shaders, main_comp="#version 460\nint m;\n")
    flat = flatten("main.comp", {"PASS": 2, "COLOUR": 1})
    assert flat.lines == [VERSION, "#define PASS 2", "#define COLOUR 1", "int m;"]
    assert flat.origins[-1] == ("main.comp", 2), "the file's own #version is dropped, its line numbers are kept"


def test_a_missing_include_names_the_line_that_wanted_it(shaders):
    tree(shaders, main_comp='int m;\n#include "lib/a.glsl"\n', lib__a_glsl='\n\n#include "lib/gone.glsl"\n')
    tree(shaders, by_comp="int m;\n#include LENS\n")
    for name, said in {
        "main": r"^shader file 'lib/gone\.glsl' included by lib/a\.glsl:3: No such file",
        "other": r"'other\.comp' included by the program", "by": r"^by\.comp:2 includes LENS, which no define",
    }.items():  # fmt: skip
        with pytest.raises(ShaderError, match=said):
            flatten(f"{name}.comp")


MESSAGES = {  # the lines: version, m, a, b, n
    "0:4(14): error: `foo' undeclared": "a.glsl:2(14): error: `foo' undeclared",  # Mesa
    '0(5) : error C1503: undefined variable "foo"': 'main.comp:3: error C1503: undefined variable "foo"',  # NVIDIA
    "ERROR: 0:2: 'foo' : undeclared": "ERROR: main.comp:1: 'foo' : undeclared",  # Apple, Intel, ANGLE
    "0:3(1): error\n0:5(2): error": "a.glsl:1(1): error\nmain.comp:3(2): error",
    "0(3) : error C7011: cast from 0(4) to 0:4": "a.glsl:1: error C7011: cast from 0(4) to 0:4",
    # Beyond the text, without a line, and not in string 0.
    **{same: same for same in ("0:99(1): error", "error: linking failed", "10:4 and 20(4)", "(0) : error C5145: must")},
}


def test_messages_of_several_compilers_are_translated(shaders):
    tree(shaders, main_comp='int m;\n#include "a.glsl"\nint n;\n', a_glsl="int a;\nint b;\n")
    flat = flatten("main.comp")
    assert {message: flat.translate(message) for message in MESSAGES} == MESSAGES
