"""Forward warping by points: every rendered pixel moves, and the nearest wins."""

from __future__ import annotations

from typing import Literal

import attrs

from ...errors import InputError, MachineError
from ...geometry import WarpMap
from ...gpu.shaders import Compute
from ...gpu.textures import Canvas
from ..inputs import PassInputs
from ..warp_kinds import ScatterWarp, check_room
from . import KEY_BYTES, warps

MOST_PIXELS = 2**27 - 2  # the keys of infinitely far pixels are indices below 2^27, see shaders/lib/scatter_depth.glsl
_TIE_HEADER = 16  # bytes before the winners: three work-group counts and one spare
ATOMIC64 = ("GL_NV_shader_atomic_int64", "GL_ARB_gpu_shader_int64")  # extensions of the one-pass path


@attrs.frozen
class ForwardSettings:
    """Which atomics to use; the pictures are bit-identical."""

    # portable: two 32-bit atomic passes. atomic64: one pass with a 64-bit key. auto: atomic64 where
    # the driver has it.
    path: Literal["auto", "portable", "atomic64"] = attrs.field(
        default="auto", validator=attrs.validators.in_(("auto", "portable", "atomic64"))
    )


@warps.register
class Forward(ScatterWarp):
    """Scatters pixels with an exact depth test by atomics.

    Of equal depths the lower (row mod 4, column mod 4) wins.
    """

    name = "forward"
    summary = "moves each pixel by its own depth, nearest wins; leaves cracks and holes"
    exact_when = "the eye does not move; else each pixel is right to half a pixel"
    gets_wrong = "surfaces that come closer crack; what was hidden is a hole; soft edges travel with their depth"
    source = "the 2014 thesis's forward warp; atomics as in Schuetz et al. 2021 (arXiv 2104.07526)"
    Settings = ForwardSettings

    def prepare(self) -> None:
        if self.rendered_size[0] * self.rendered_size[1] > MOST_PIXELS:
            raise InputError(
                f"a rendered picture of {self.rendered_size[0]}x{self.rendered_size[1]}: 'forward' takes at most "
                f"{MOST_PIXELS} pixels"
            )
        path, missing = self.settings.path, [name for name in ATOMIC64 if name not in self.gpu.gl.extensions]
        if path == "atomic64" and missing:
            raise MachineError(
                f"warp 'forward:path=atomic64' needs {' and '.join(missing)}, which {self.gpu.renderer} lacks: use "
                "path=auto"
            )
        self._path: _OnePass | _Portable = (_Portable if path == "portable" or missing else _OnePass)(self)

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        self.bind(inputs, into)
        self._path.run(self.forward_map(inputs), into)

    def depth_pass(self, words: int) -> Compute | None:
        """Return the pass that reads the shown depth out of keys, if it is needed."""
        if not self.output.depth:
            return None
        return self.gpu.shaders.compute("warps/forward_depth.comp", grid="shown", WORDS=words)

    def close(self) -> None:
        super().close()
        self._path.close()


class _Portable:
    """Two 32-bit atomic passes, and three more, dispatched indirectly, where keys tie."""

    def __init__(self, warp: Forward) -> None:
        shaders, gl = warp.gpu.shaders, warp.gpu.gl
        self._warp = warp
        self._clear = shaders.compute("warps/forward_clear.comp")
        self._nearest, self._colour, *self._settle = (
            shaders.compute("warps/forward.comp", grid="rendered", PASS=k) for k in range(5)
        )
        check_room(warp.gpu, warp.name, warp.shown_size, KEY_BYTES, _TIE_HEADER)
        self._quads = -(-warp.shown_size[0] * warp.shown_size[1] // 4)
        self._keys = gl.buffer(reserve=16 * self._quads)
        self._depth = warp.depth_pass(1)
        self._ties = gl.buffer(bytes(_TIE_HEADER) + b"\xff" * (16 * self._quads))

    def run(self, forward: WarpMap, into: Canvas) -> None:
        self._keys.bind_to_storage_buffer(0)
        self._ties.bind_to_storage_buffer(1)
        into.clear()
        groups = self._nearest.groups(*self._warp.rendered_size)
        self._clear.uniforms.set(quads=self._quads, tie_dispatch=groups)
        self._clear.run(self._quads)
        for program in (self._nearest, self._colour, *self._settle):
            self._warp.gpu.barrier()
            self._warp.set(program, H=forward.H, e=forward.e)
            if program in self._settle:
                program.program.run_indirect(self._ties)
            else:
                program.program.run(*groups)
        if self._depth is not None:
            self._warp.set(self._depth)
            self._depth.run(*self._warp.shown_size)

    def close(self) -> None:
        self._keys.release()
        self._ties.release()


class _OnePass:
    """One 64-bit atomic pass; the pass that copies the colours clears the keys again."""

    def __init__(self, warp: Forward) -> None:
        self._warp = warp
        shaders = warp.gpu.shaders
        self._nearest = shaders.compute("warps/forward_atomic64.comp", grid="rendered", PASS=0)
        self._resolve = shaders.compute("warps/forward_atomic64.comp", PASS=1)
        self._keys, self._depth = warp.empty_keys(words=2), warp.depth_pass(2)

    def run(self, forward: WarpMap, into: Canvas) -> None:
        self._keys.bind_to_storage_buffer(0)
        warp = self._warp
        passes = [(self._nearest, warp.rendered_size), (self._resolve, warp.shown_size)]
        if self._depth is not None:
            passes.insert(1, (self._depth, warp.shown_size))
        for program, size in passes:
            warp.gpu.barrier()
            warp.set(program, H=forward.H, e=forward.e)
            program.run(*size)

    def close(self) -> None:
        self._keys.release()
