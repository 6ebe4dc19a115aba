"""Compile shader files: flatten includes, add defines, map compiler messages to file and line.

moderngl's own includes go one level deep and keep no line map, and `#line` cannot name a file on
Mesa. So the text is flattened here, every file at most once, and the line map is kept beside it.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Protocol, TypeVar, cast

import moderngl
import numpy as np

from ..errors import InputError, ShaderError
from ..resources import folder
from .hidden import WHOLE, Grid, HiddenAreas

VERSION = "#version 430"
_INCLUDE = re.compile(r'^\s*#include\s+(?:"([^"]+)"|(\w+))\s*$')
# Where a compiler's line says what it is about. Mesa: "0:14(3): error", NVIDIA: "0(14) : error",
# AMD, Apple, Intel: "ERROR: 0:14:"
_PLACE = re.compile(r"^((?:ERROR: |WARNING: )?)0(?::(\d+)((?:\(\d+\))?)|\((\d+)\) ):", re.MULTILINE)
# What opens a stage's part of a message. moderngl, when compiling: "vertex_shader", NVIDIA, when
# linking: "Vertex info"
_STAGE = re.compile(r"^(?=(vertex|fragment)(?:_shader| info)$)", re.MULTILINE | re.IGNORECASE)
_DTYPES = {"f": np.float32, "i": np.int32, "I": np.uint32}  # by moderngl's letter for a uniform's type


@dataclass
class Flattened:
    """A shader's whole text and the origin of each line."""

    lines: list[str] = field(default_factory=list)
    origins: list[tuple[str, int]] = field(default_factory=list)

    @property
    def text(self) -> str:
        return "\n".join(self.lines) + "\n"

    def translate(self, message: str) -> str:
        """Return a compiler message with `0:14` or `0(14) ` replaced by `warps/forward.comp:9`."""

        def origin(match: re.Match[str]) -> str:
            severity, line, column, line_alone = match.groups(default="")
            number = int(line or line_alone) - 1
            if not 0 <= number < len(self.origins):
                return match.group(0)
            return "{}{}:{}{}:".format(severity, *self.origins[number], column)

        return _PLACE.sub(origin, message)


def flatten(path: str, defines: Mapping[str, object] | None = None, root: Path | None = None) -> Flattened:
    """Return the text of shader `path` with its includes, each file once, and `defines` on top.

    path: relative to shaders/, or absolute for a shader of another package. `#include NAME`
    includes the file that the define NAME holds; such a define does not appear in the text.
    Errors: ShaderError for a missing file or include, naming the including line.
    """
    defines = dict(defines or {})
    root = root or folder("shaders")
    out, seen = Flattened(), set()

    def add(line: str, origin: tuple[str, int]) -> None:
        out.lines.append(line)
        out.origins.append(origin)

    def named(define: str, wanted_by: str) -> str:
        if define not in defines:
            raise ShaderError(f"{wanted_by} includes {define}, which no define gives a file")
        return str(defines[define])

    def visit(name: str, wanted_by: str) -> None:
        if name in seen:
            return
        seen.add(name)
        try:
            text = (root / name).read_text(encoding="utf-8")
        except OSError as error:
            raise ShaderError(f"shader file '{name}' included by {wanted_by}: {error.strerror}") from error
        for number, line in enumerate(text.splitlines(), start=1):
            include = _INCLUDE.match(line)
            if include:
                visit(include.group(1) or named(include.group(2), f"{name}:{number}"), f"{name}:{number}")
            elif not line.startswith("#version"):
                add(line, (name, number))

    add(VERSION, ("(version)", 1))
    for key, value in defines.items():
        if not str(value).endswith(".glsl"):
            add(f"#define {key} {value}", ("(defines)", 1))
    visit(path, "the program")
    return out


class Member(Protocol):
    """A uniform of a linked program; moderngl publishes no types for `fmt` and `matrix`."""

    fmt: str  # its last letter is the scalar's type
    matrix: bool
    value: object

    def write(self, data: bytes) -> None:
        """Set the value as GLSL stores it."""


class Uniforms:
    """Strict setter of uniforms by name.

    A name that the shader text does not declare is an error; a uniform that the compiler optimised
    away is fine.
    """

    _DECLARED = re.compile(r"uniform\s+\w+\s+([^;]+);")

    def __init__(self, program: moderngl.Program | moderngl.ComputeShader, texts: list[str], name: str) -> None:
        self._program, self._name = program, name
        declared = " ".join(line.partition("//")[0] for line in texts)
        names = {
            re.sub(r"[\[=].*", "", part).strip()
            for match in self._DECLARED.finditer(declared)
            for part in match.group(1).split(",")
        }
        self._members: dict[str, Member | None] = {
            name: cast("Member | None", program.get(name, None)) for name in names
        }
        self._written: dict[
            str, object
        ] = {}  # values that cannot have changed, compared by identity, which costs nothing
        self._last: dict[str, bytes] = {}
        self._settled: dict[str, object] | None = None
        # Called with a name, says whether the shader's text declares a uniform of that name.
        self.declares = self._members.__contains__

    def set(self, **values: object) -> None:
        """Set numbers, vectors and matrices; float64 is rounded here, once.

        Matrices are row-major NumPy, as written in the formulas. The same number, tuple or
        read-only array as the last time is not written again; a tuple holds numbers.
        Errors: ShaderError for a name the shader's text lacks, and for a value that does not fit.
        """
        # One function, as a refresh sets 130 uniforms: calls within it took longer than the writes.
        written, last, members = self._written, self._last, self._members
        for name, value in values.items():
            if written.get(name, written) is value:
                continue
            member = members.get(name)
            if member is None:
                if name not in members:
                    raise ShaderError(f"{self._name} has no uniform '{name}'; it has {', '.join(sorted(members))}")
                continue
            written.pop(name, None)
            if self._settled is not None and name in self._settled:
                self._settled = None
            try:
                if isinstance(value, np.ndarray):
                    constant = not value.flags.writeable and value.base is None
                    array = np.swapaxes(value, -1, -2) if member.matrix else value  # columns, as GLSL has them
                    data = np.ascontiguousarray(array, dtype=_DTYPES[member.fmt[-1]]).tobytes()
                    if last.get(name) != data:
                        member.write(data)
                        last[name] = data
                else:
                    constant = type(value) in (int, float, tuple)
                    last.pop(name, None)
                    member.value = value
            except (moderngl.Error, struct.error, TypeError, ValueError) as error:
                raise ShaderError(f"{self._name}: uniform '{name}' cannot take {value!r}: {error}") from error
            if constant:
                written[name] = value

    def set_declared(self, **values: object) -> None:
        """Set the uniforms that the shader's text declares and ignore the rest.

        For shaders that share one set of values.
        """
        self.set(**{name: value for name, value in values.items() if name in self._members})

    def settle(self, values: dict[str, object]) -> None:
        """Set constant values like `set_declared`.

        The same, unchanged dict as the last time is skipped.
        """
        if self._settled is not values:
            self.set_declared(**values)
            self._settled = values


class Inputs(Protocol):
    """Textures and uniforms that belong together."""

    def use(self, uniforms: Uniforms, unit: int) -> None:
        """Bind the textures from that unit on, and set the uniforms."""


class Compute:
    """A compute shader with strict uniforms.

    run() covers a grid of pixels, rounding the work groups up. Made with HIDES, for a view's grid
    and its strips, it leaves out what the lens hides of that view.
    """

    def __init__(
        self,
        gl: moderngl.Context,
        path: str,
        defines: Mapping[str, object],
        grid: Grid | None = None,
        hidden: HiddenAreas | None = None,
    ) -> None:
        flat = flatten(path, defines)
        self.path = path
        try:
            self.program = gl.compute_shader(flat.text)
        except moderngl.Error as error:
            raise ShaderError(f"{path}: {flat.translate(str(error))}") from error
        self.uniforms = Uniforms(self.program, flat.lines, path)
        sizes = dict(re.findall(r"local_size_([xyz])\s*=\s*(\w+)", flat.text))
        numbers = dict(re.findall(r"#define\s+(\w+)\s+(\d+)", flat.text))
        across, down = (str(sizes.get(axis, "1")) for axis in "xy")
        self.group = int(numbers.get(across, across)), int(numbers.get(down, down))
        self._most_groups = tuple(gl.info["GL_MAX_COMPUTE_WORK_GROUP_COUNT"][:2])
        self.rows = int((re.findall(r"#define\s+ROWS\s+(\d+)", flat.text) or [1])[0])
        self._grid, self._hidden, self.skips = grid, hidden, hidden is not None
        self._last: tuple[int, int, int] | None = None
        self._groups = 0, 0

    def run(self, width: int, height: int = 1, cell: int = 1) -> None:
        """Dispatch enough work groups for width x height pixels.

        cell: pixels on each axis for which it has one invocation, or row of one.
        """
        if self._last != (width, height, cell):
            self._groups = self.groups(width, height, cell)
            self._last = None if self.skips else (width, height, cell)  # a list is bound each time
        self.program.run(*self._groups)

    def over(self, width: int, height: int = 1, cell: int = 1) -> Callable[[], object]:
        """Return what runs over that grid, its work groups counted once. Errors: as groups."""
        if self.skips:
            return partial(self.run, width, height, cell)
        return partial(self.program.run, *self.groups(width, height, cell))

    def groups(self, width: int, height: int = 1, cell: int = 1) -> tuple[int, int]:
        """Return the work groups of such a run; fewer for a shader with ROWS. Binds a list of them.

        Errors: InputError beyond the GL limit, where a dispatch would be dropped silently.
        """
        if self._hidden is not None and self._grid is not None:
            view = self._hidden.views.get(self._grid, WHOLE)
            return self._hidden.bind(view, (width, height), self.group[0], self.rows, cell), 1
        across, down = self.group[0] * cell, self.group[1] * self.rows * cell
        groups = -(-width // across), -(-height // down)
        if groups[0] > self._most_groups[0] or groups[1] > self._most_groups[1]:
            most = " x ".join(map(str, self._most_groups))
            raise InputError(
                f"{self.path} needs {groups[0]} x {groups[1]} work groups, this GPU takes {most}: use smaller pictures"
            )
        return groups


class Draw:
    """A vertex and fragment shader pair with strict uniforms."""

    def __init__(self, gl: moderngl.Context, vertex: str, fragment: str, defines: Mapping[str, object]) -> None:
        flats = {"vertex": flatten(vertex, defines), "fragment": flatten(fragment, defines)}
        try:
            self.program = gl.program(vertex_shader=flats["vertex"].text, fragment_shader=flats["fragment"].text)
        except moderngl.Error as error:
            # What comes before any stage, then a stage and its part by turns: each line is of the
            # stage that it stands under. The linker may name none.
            before, *parts = _STAGE.split(str(error))
            stages = [stage.lower() for stage in parts[::2]]
            told = [flats[stage].translate(part) for stage, part in zip(stages, parts[1::2], strict=True)]
            path = vertex if stages[:1] == ["vertex"] else fragment
            raise ShaderError(f"{path}: {before}{''.join(told)}") from error
        self.uniforms = Uniforms(self.program, [*flats["vertex"].lines, *flats["fragment"].lines], fragment)


Program = TypeVar("Program", Compute, Draw)


class ShaderLibrary:
    """Compiled programs of one context, each (path, defines) compiled once."""

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        self._cache: dict[tuple[object, ...], Any] = {}
        self.hidden = HiddenAreas(gl, self)

    @property
    def compiled(self) -> int:
        """How many were compiled, for the tests."""
        return len(self._cache)

    def compute(self, path: str, *, grid: Any = None, **defines: object) -> Compute:
        """Return the compute shader `path`: relative to shaders/, or absolute.

        grid: the view (Grid) whose pixels it runs over, if it may leave out those that are hidden;
        inside hidden.skipping(True) it does. Any type, as callers hand on dicts of defines.
        """
        hidden = self.hidden if grid is not None and self.hidden.skips else None
        defines |= {} if hidden is None else {"HIDES": 1}
        return self._get((path,), defines, lambda: Compute(self._gl, path, defines, grid, hidden), hidden and grid)

    def draw(self, vertex: str, fragment: str, **defines: object) -> Draw:
        """Return the vertex and fragment program of the two paths."""
        return self._get((vertex, fragment), defines, lambda: Draw(self._gl, vertex, fragment, defines))

    def _get(
        self, paths: tuple[str, ...], defines: Mapping[str, object], make: Callable[[], Program], *over: object
    ) -> Program:
        key = (*paths, *sorted(defines.items()), *over)
        program: Program = self._cache.get(key) or self._cache.setdefault(key, make())
        return program
