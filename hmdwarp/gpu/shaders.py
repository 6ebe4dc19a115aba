"""Compile shader files: flatten includes, add defines, map compiler messages to file and line.

moderngl's own includes go one level deep, without a line map; Mesa's `#line` cannot name a file.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any, TypeVar

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..base import InputError, ShaderError, folder
from .hidden import WHOLE, Grid, HiddenAreas

VERSION = "#version 430"
_INCLUDE = re.compile(r'^\s*#include\s+(?:"([^"]+)"|(\w+))\s*$')
# Of a compiler's line. Mesa: "0:14(3): error", NVIDIA: "0(14) : error", others: "ERROR: 0:14:"
_PLACE = re.compile(r"^((?:ERROR: |WARNING: )?)0(?::(\d+)((?:\(\d+\))?)|\((\d+)\) ):", re.MULTILINE)
# What opens a stage's part: "vertex_shader" of moderngl, or "Vertex info" of NVIDIA's linker
_STAGE = re.compile(r"^(?=(vertex|fragment)(?:_shader| info)$)", re.MULTILINE | re.IGNORECASE)
_DTYPES = {"f": np.float32, "i": np.int32, "I": np.uint32}  # by moderngl's letter for a uniform's type


@dataclass
class _Flattened:
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


def flatten(path: str, defines: Mapping[str, object] | None = None) -> _Flattened:
    """Return the text of shader `path` with its includes, each file once, and `defines` on top.

    path: relative to shaders/, or absolute for a shader of another package. `#include NAME`
    includes the file that the define NAME holds; such a define does not appear in the text.
    Errors: ShaderError for a missing file or include, naming the including line.
    """
    known = {key: str(value) for key, value in (defines or {}).items()}
    told = [f"#define {key} {value}" for key, value in known.items() if not value.endswith(".glsl")]
    out, seen, root = _Flattened([VERSION, *told], [("(defines)", 1)] * (1 + len(told))), set[str](), folder("shaders")

    def visit(name: str, wanted_by: str) -> None:
        if name in seen:
            return
        seen.add(name)
        try:
            text = (root / name).read_text(encoding="utf-8")
        except OSError as error:
            raise ShaderError(f"shader file '{name}' included by {wanted_by}: {error.strerror}") from error
        for number, line in enumerate(text.splitlines(), start=1):
            if include := _INCLUDE.match(line):
                file, define = include.groups()
                if define and define not in known:
                    raise ShaderError(f"{name}:{number} includes {define}, which no define gives a file")
                visit(file or known[define], f"{name}:{number}")
            elif not line.startswith("#version"):
                out.lines.append(line)
                out.origins.append((name, number))

    visit(path, "the program")
    return out


_UNIFORM = re.compile(r"\s*uniform\s+(float|u?int|bool|[iu]?vec[234]|mat[234](?:x[234])?)\s+([^=;]+);\s*")
_NAME = re.compile(r"\s*(\w+)\s*(?:\[\s*(\w+)\s*\])?\s*")
_NUMBER = re.compile(r"\s*#\s*define\s+(\w+)\s+(\d+)\s*")
Defines = Mapping[str, object]
Flats = Sequence[_Flattened]
_MOST_BYTES = 16384  # of a block, for every driver
_BLOCK = "Uniforms_"


class Block:
    """The plain uniforms of a program's stages as one block of layout std140, in their texts.

    Those with a default, of a size other than a number or its define, and lines that hold more than
    a declaration stay outside; all do where one name has two types.
    """

    def __init__(self, flats: Flats) -> None:
        self.views: dict[str, NDArray[Any]] = {}  # where each is written, as NumPy has it
        self.packs: dict[str, Callable[..., None]] = {}  # of numbers and vectors: a third of NumPy's time
        self.data, self.texts = bytearray(_MOST_BYTES), list[str]()
        self._declared, self._numbers, self._end = dict[str, str](), dict[str, str](), 0
        stages: list[list[str]] = []
        for flat in flats:
            stages.append([])
            for line in flat.lines:
                code = line.partition("//")[0]
                if constant := _NUMBER.fullmatch(code):
                    self._numbers[constant.group(1)] = constant.group(2)
                uniform = _UNIFORM.fullmatch(code)
                stages[-1].append("" if uniform and self._takes(*uniform.groups()) else line)
        for lines in stages:
            last = max(number for number, line in enumerate(lines) if line.startswith(("#version", "#extension")))
            lines.insert(last + 1, f"layout(std140) uniform {_BLOCK} {{ {'; '.join(self._declared.values())}; }};")
            self.texts.append("\n".join(lines) + "\n")
        self.size = self._end + -self._end % 16

    def _takes(self, kind: str, names: str) -> bool:
        """Lay out what is declared together; return False for what stays outside."""
        parts = [found.groups("") for part in names.split(",") if (found := _NAME.fullmatch(part))]
        counts = [self._numbers.get(size, size or "0") for _, size in parts]
        if len(parts) <= names.count(",") or not all(map(str.isdecimal, counts)):
            return False
        axes, letter = re.findall(r"\d", kind), {"i": "i", "b": "i", "u": "I"}.get(kind[0], "f")
        rows, columns = int(axes[-1]) if axes else 1, int(axes[0]) if kind[0] == "m" else 1
        for (name, _), count in zip(parts, map(int, counts), strict=True):
            text = f"{kind} {name}" + f"[{count}]" * (count > 0)
            if (before := self._declared.setdefault(name, text)) != text:
                self._end += _MOST_BYTES
            if name in self.views or before != text:
                continue
            apart = columns > 1 or count > 0  # columns and elements are 16 bytes apart
            at = self._end + -self._end % (16 if apart or rows > 2 else 4 * rows)
            self._end = at + (16 * columns * max(count, 1) if apart else 4 * rows)
            if self._end <= _MOST_BYTES:
                shape = (count,) * (count > 0) + (rows,) * (rows > 1) + (columns,) * (columns > 1)
                strides = (16 * columns,) * (count > 0) + (4,) * (rows > 1) + (16,) * (columns > 1)
                self.views[name] = np.ndarray(shape, _DTYPES[letter], self.data, at, strides)
                if not apart:
                    self.packs[name] = partial(struct.Struct(f"{rows}{letter}").pack_into, self.data, at)
        return True


Program = TypeVar("Program", moderngl.Program, moderngl.ComputeShader)


@dataclass
class Room:
    """Where a context has the blocks of its programs; each has a binding, which none exchanges."""

    buffer: moderngl.Buffer
    bindings: Iterator[int]
    end: int = 0


def built(gl: moderngl.Context, flats: Flats, build: Callable[..., Program], name: str) -> tuple[Program, Uniforms]:
    """Return the program that `build` makes of the stages' texts, and its uniforms.

    They are in a block, unless the context has no room left, or the text does not compile with it:
    another stage may have another meaning for a name. Errors: moderngl.Error.
    """
    block, room = Block(flats), getattr(gl, "extra", None)
    if room is not None and 0 < block.size <= min(_MOST_BYTES, room.buffer.size - room.end):
        with suppress(moderngl.Error, StopIteration):
            binding, program = next(room.bindings), build(*block.texts)
            return program, Uniforms(program, flats, name, block, room, binding)
    program = build(*(flat.text for flat in flats))
    return program, Uniforms(program, flats, name)


class Uniforms:
    """Strict setter of uniforms by name.

    A name that the shader text lacks is an error; a uniform that the compiler removed is fine.
    """

    def __init__(self, program: Any, flats: Flats, name: str, block: Block | None = None, *place: Any) -> None:
        self._name = name
        declared = " ".join(line.partition("//")[0] for flat in flats for line in flat.lines)
        names = {
            re.sub(r"[\[=].*", "", part).strip()
            for match in re.finditer(r"uniform\s+\w+\s+([^;]+);", declared)
            for part in match.group(1).split(",")
        }
        self._members: dict[str, Any] = {name: program.get(name, None) for name in names}
        block = block if block is not None and _BLOCK in program else Block([])
        self._views, self._packs = block.views, block.packs
        self._data, self._sent = memoryview(block.data)[: block.size], bytearray(block.size)
        if block.size:
            room, program[_BLOCK].binding = place
            self._buffer, self._at = room.buffer, room.end
            self._buffer.bind_to_uniform_block(place[1], offset=self._at, size=block.size)
            room.end += block.size + -block.size % 256  # no driver wants a larger alignment
        # Values that cannot have changed, compared by identity, which costs nothing.
        self._written: dict[str, object] = {}
        self._settled: dict[str, object] | None = None
        self.declares = self._members.__contains__  # of a name: whether the text declares a uniform of it

    def set(self, **values: Any) -> None:
        """Set numbers, vectors and matrices, those as written in the formulas, rounded once.

        The same number, tuple (of numbers) or read-only array as the last time is not taken again.
        What is in the block goes to the GPU in one write, if it has changed.
        Errors: ShaderError for a name the shader's text lacks, and for a value that does not fit.
        """
        # One function, as a refresh sets 130 uniforms: calls within it took longer than the writes.
        written, members, views, packs = self._written, self._members, self._views, self._packs
        for name, value in values.items():
            if written.get(name, written) is value:
                continue
            view = views.get(name)
            if view is None and members.get(name, members) is None:
                continue
            written.pop(name, None)
            if self._settled is not None and name in self._settled:
                self._settled = None
            try:
                if view is None:
                    self._set_outside(name, value)
                elif not isinstance(value, np.ndarray) and name in packs:
                    packs[name](*value) if view.ndim else packs[name](value)
                elif np.shape(value) == view.shape:
                    view[...] = value
                elif view.ndim > 1 and view.strides[-1] != 4:  # a matrix, whose last axis is across its columns
                    raise ValueError(f"expected an array of {view.shape}")
                else:
                    view[...] = np.reshape(value, view.shape)
            except (moderngl.Error, struct.error, TypeError, ValueError, OverflowError) as error:
                raise ShaderError(f"{self._name}: uniform '{name}' cannot take {value!r}: {error}") from error
            if type(value) in (int, float, tuple) or (
                isinstance(value, np.ndarray) and not value.flags.writeable and value.base is None
            ):
                written[name] = value
        if self._data != self._sent:
            self._buffer.write(self._data, offset=self._at)
            self._sent[:] = self._data

    def _set_outside(self, name: str, value: Any) -> None:
        if name not in self._members:
            raise ShaderError(f"{self._name} has no uniform '{name}'; it has {', '.join(sorted(self._members))}")
        member = self._members[name]
        if isinstance(value, np.ndarray):
            array = np.swapaxes(value, -1, -2) if member.matrix else value  # columns, as GLSL has them
            member.write(np.ascontiguousarray(array, dtype=_DTYPES[member.fmt[-1]]).tobytes())
        else:
            member.value = value

    def set_declared(self, **values: object) -> None:
        """Set the uniforms that the shader's text declares; shaders may share one set of values."""
        self.set(**{name: value for name, value in values.items() if name in self._members})

    def settle(self, values: dict[str, object]) -> None:
        """Set constant values like `set_declared`; the same dict as the last time is skipped."""
        if self._settled is not values:
            self.set_declared(**values)
            self._settled = values


class Compute:
    """A compute shader over a grid of pixels; with HIDES it leaves out what the lens hides."""

    def __init__(
        self, gl: moderngl.Context, path: str, defines: Defines, over: tuple[Grid, HiddenAreas] | None = None
    ) -> None:
        flat = flatten(path, defines)
        self.path = path
        try:
            self.program, self.uniforms = built(gl, [flat], gl.compute_shader, path)
        except moderngl.Error as error:
            raise ShaderError(f"{path}: {flat.translate(str(error))}") from error
        sizes = dict(re.findall(r"local_size_([xyz])\s*=\s*(\w+)", flat.text))
        numbers = dict(reversed(re.findall(r"#define\s+(\w+)\s+(\d+)", flat.text)))  # the first of each
        across, down = (sizes.get(axis, "1") for axis in "xy")
        self.group = int(numbers.get(across, across)), int(numbers.get(down, down))
        self._most_groups = tuple(gl.info["GL_MAX_COMPUTE_WORK_GROUP_COUNT"][:2])
        self.rows = int(numbers.get("ROWS", 1))
        self._over, self.skips = over, over is not None
        self._last: tuple[int, int, int] | None = None
        self._groups = 0, 0

    def run(self, width: int, height: int = 1, cell: int = 1) -> None:
        """Run over width x height pixels. cell: pixels a side for one invocation, or row of one."""
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
        """Return the work groups of such a run; bind a list of them where it leaves out some.

        Errors: InputError beyond the GL limit, where GL would drop a dispatch silently.
        """
        if self._over is not None:
            grid, areas = self._over
            return areas.bind(areas.views.get(grid, WHOLE), (width, height), self.group[0], self.rows, cell), 1
        across, down = self.group[0] * cell, self.group[1] * self.rows * cell
        groups = -(-width // across), -(-height // down)
        if groups[0] > self._most_groups[0] or groups[1] > self._most_groups[1]:
            most = " x ".join(map(str, self._most_groups))
            found = f"{self.path} needs {groups[0]} x {groups[1]} work groups"
            raise InputError(f"{found}, this GPU takes {most}: use smaller pictures")
        return groups


class Draw:
    """A vertex and fragment shader pair with strict uniforms."""

    def __init__(self, gl: moderngl.Context, vertex: str, fragment: str, defines: Defines) -> None:
        flats = {"vertex": flatten(vertex, defines), "fragment": flatten(fragment, defines)}
        both = list(flats.values())
        try:
            self.program, self.uniforms = built(
                gl, both, lambda vert, frag: gl.program(vertex_shader=vert, fragment_shader=frag), fragment
            )
        except moderngl.Error as error:
            # What comes before any stage, of which a linker may name none; then each and its part.
            told, *parts = _STAGE.split(str(error))
            stages = [stage.lower() for stage in parts[::2]]
            for stage, part in zip(stages, parts[1::2], strict=True):
                told += flats[stage].translate(part)
            raise ShaderError(f"{vertex if stages[:1] == ['vertex'] else fragment}: {told}") from error


Made = TypeVar("Made", Compute, Draw)


class ShaderLibrary:
    """Compiled programs of one context, each (path, defines) compiled once."""

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        self._cache: dict[tuple[object, ...], Any] = {}
        self.hidden = HiddenAreas(gl, self)
        if gl.extra is None:
            gl.extra = Room(gl.buffer(bytes(1 << 16)), iter(range(gl.info["GL_MAX_UNIFORM_BUFFER_BINDINGS"])))

    def __len__(self) -> int:
        return len(self._cache)

    def compute(self, path: str, *, grid: Any = None, **defines: object) -> Compute:
        """Return the compute shader `path`: relative to shaders/, or absolute.

        grid: the view (Grid) over whose pixels it runs, if inside hidden.skipping(True) it may
        leave out those that are hidden. Any type, as callers hand on dicts of defines.
        """
        over = (grid, self.hidden) if grid is not None and self.hidden.skips else None
        defines |= {} if over is None else {"HIDES": 1}
        return self._get((path,), defines, lambda: Compute(self._gl, path, defines, over), over and grid)

    def draw(self, vertex: str, fragment: str, **defines: object) -> Draw:
        """Return the vertex and fragment program of the two paths."""
        return self._get((vertex, fragment), defines, lambda: Draw(self._gl, vertex, fragment, defines))

    def _get(self, paths: tuple[str, ...], defines: Defines, make: Callable[[], Made], *over: object) -> Made:
        key = (*paths, *sorted(defines.items()), *over)
        program: Made = self._cache.get(key) or self._cache.setdefault(key, make())
        return program
