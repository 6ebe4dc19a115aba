"""Arrays in and out by one pass each: their bytes go up and come down as they are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..colour import linear_from_srgb, srgb8_from_linear
from ..gpu.context import Gpu
from ..gpu.raw_gl import clear_buffer, mapped
from ..gpu.textures import Canvas, allocate, release_all
from .picture_arrays import LINEAR, SRGB, SRGB8, RawPicture

Size = tuple[int, int]
Pair = tuple[moderngl.Texture, moderngl.Texture]
_RG32UI = 0x823C  # a rgba16f texture, as the bits of its halves
_TEXEL_BYTES = 16  # of given_colour and given_depth
# Words of `found` for each picture, as in shaders/image/take_in.comp, which counts ABOVE_ONE and
# says of the others whether.
_WRONG, _NEGATIVE, _POSITIVE, _LARGEST, _BRIGHT, _FRACTION, _ABOVE_ONE = range(7)
_WORDS = 8
_INVERSE, _METRES, _UINT16 = range(3)
_RESULTS = (SRGB8, SRGB, LINEAR)


class Found:
    """Words that the passes of one call write, and the host reads once after them."""

    def __init__(self, gpu: Gpu, pictures: int) -> None:
        self.buffer = gpu.gl.buffer(reserve=4 * _WORDS * (pictures + 1))
        # Where the pass that reads results counts holes.
        self.holes_slot = _WORDS * pictures
        self._words = np.zeros(_WORDS * (pictures + 1), np.uint32)

    def clear(self) -> None:
        """Set all words to 0."""
        clear_buffer(self.buffer, 0)

    def read(self) -> None:
        """Wait for the passes."""
        self.buffer.read_into(self._words)

    @property
    def holes(self) -> int:
        """Pixels without coverage after the warp."""
        return int(self._words[self.holes_slot])

    def has_largest(self, number: int) -> bool:
        """Return whether the depth of that picture has the largest integer of its type."""
        return bool(self._words[_WORDS * number + _LARGEST])

    def is_doubtful(self, number: int, size: Size) -> bool:
        """Return whether something of that picture may be wrong, which checked_picture knows."""
        words = self._words[_WORDS * number :][:_WORDS]
        half = 3 * size[0] * size[1] / 2  # of all numbers
        bright = words[_BRIGHT] and (not words[_FRACTION] or words[_ABOVE_ONE] >= half)
        return bool(words[_WRONG] or (words[_NEGATIVE] and not words[_POSITIVE]) or bright)

    def close(self) -> None:
        """Free the buffer."""
        self.buffer.release()


class TakeIn:
    """Takes pictures of one size over; what each kind of array needs is made at the first of it."""

    def __init__(self, gpu: Gpu, size: Size) -> None:
        self._gpu, self._size = gpu, size
        bits = linear_from_srgb(np.arange(256, dtype=np.uint8)).astype(np.float16).view(np.uint16)
        self._light_of_byte = allocate(gpu.gl, (256, 1), (1, "u2"))
        self._light_of_byte.write(bits.tobytes())
        self._staged: dict[tuple[str, int, int], tuple[moderngl.Texture, moderngl.Buffer]] = {}

    def send(self, picture: RawPicture) -> Pair:
        """Return the bytes of colour and depth as textures; the next picture overwrites them."""
        kind = np.dtype(np.uint16 if picture.depth.dtype.kind == "u" else np.float32)
        return (
            self._sent("colour", picture.colour, _sent_as(picture.colour)),
            self._sent("depth", picture.depth[..., None], kind, picture.hidden),
        )

    def run(self, picture: RawPicture, sent: Pair, into: Pair, found: Found, number: int) -> None:
        """Write rgba16f linear light with coverage and r32f inverse depth.

        sent: what `send` returns for the picture. number: which of the pictures of `found`.
        """
        kind, is_whole = _sent_as(picture.colour), picture.depth.dtype.kind == "u"
        form = _UINT16 if is_whole else _INVERSE if picture.is_inverse else _METRES
        program = self._gpu.shaders.compute(
            "image/take_in.comp",
            ITEM_BYTES=kind.itemsize,
            CHANNELS=picture.colour.shape[2],
            DEPTH=form,
            ENCODED=int(picture.encoding == SRGB),
            GUESSED=int(picture.is_guessed),
        )
        into[0].bind_to_image(0, read=False, write=True, format=_RG32UI)
        into[1].bind_to_image(1, read=False, write=True)
        for unit, texture in enumerate((*sent, self._light_of_byte), start=2):
            texture.bind_to_image(unit, read=True, write=False)
        found.buffer.bind_to_storage_buffer(0)
        program.uniforms.set(rendered_size=self._size, scale=picture.scale, slot=_WORDS * number)
        program.run(-(-self._size[0] * kind.itemsize // 16), self._size[1])
        self._gpu.barrier()

    def _sent(
        self, what: str, array: NDArray[Any], kind: np.dtype[Any], hidden: NDArray[np.bool_] | None = None
    ) -> moderngl.Texture:
        """Copy an array (h, w, c) into a texture of that type, 0 where it is hidden."""
        channels = array.shape[2]
        key = (what, channels, kind.itemsize)
        row = -(-self._size[0] // 16) * 16 * channels * kind.itemsize
        if key not in self._staged:
            texture = allocate(self._gpu.gl, (row // _TEXEL_BYTES, self._size[1]), (4, "u4"))
            self._staged[key] = texture, self._gpu.gl.buffer(reserve=row * self._size[1], dynamic=True)
        texture, buffer = self._staged[key]
        # What is beyond a float32 is infinite there.
        with mapped(buffer, write=True) as raw, np.errstate(over="ignore"):
            steps = row, channels * kind.itemsize, kind.itemsize
            into = np.ndarray(array.shape, kind, raw, strides=steps)
            np.copyto(into, array, casting="unsafe")
            if hidden is not None:
                into[hidden] = 0
        texture.write(buffer)
        return texture

    def close(self) -> None:
        """Free textures and buffers."""
        release_all(self._light_of_byte, *(thing for pair in self._staged.values() for thing in pair))


def _sent_as(colour: NDArray[Any]) -> np.dtype[Any]:
    return np.dtype(colour.dtype.type if colour.dtype.itemsize <= 2 else np.float32)


class GiveOut:
    """Makes arrays of what is shown; its buffers are made at the first result of each kind."""

    def __init__(self, gpu: Gpu, size: Size) -> None:
        self._gpu, self._size = gpu, size
        self._byte_of_half = allocate(gpu.gl, (256, 256), (1, "u1"))
        self._byte_of_half.write(srgb8_from_linear(np.arange(65536, dtype=np.uint16).view(np.float16)).tobytes())
        self._buffers: dict[tuple[str, int], moderngl.Buffer] = {}

    def run(
        self,
        shown: Canvas,
        warped: Canvas,
        inverse_depth: moderngl.Texture | None,
        confidence: Canvas | None,
        result: str,
        found: Found,
    ) -> dict[str, moderngl.Buffer]:
        """Return what `arrays` reads, by name; the holes of `warped` are counted in `found`."""
        program = self._gpu.shaders.compute(
            "image/give_out.comp",
            RESULT=_RESULTS.index(result),
            DEPTH=int(inverse_depth is not None),
            CONFIDENCE=int(confidence is not None),
        )
        for unit, canvas in enumerate((shown, warped)):
            canvas.texture.bind_to_image(unit, read=True, write=False, format=_RG32UI)
        if inverse_depth is not None:
            inverse_depth.bind_to_image(2, read=True, write=False)
        if confidence is not None:
            confidence.texture.bind_to_image(3, read=True, write=False)
        self._byte_of_half.bind_to_image(4, read=True, write=False)
        made = {
            "colour": self._buffer("colour", 3 if result == SRGB8 else 12),
            "coverage": self._buffer("coverage", 4),
            **({} if inverse_depth is None else {"depth_m": self._buffer("depth_m", 4)}),
        }
        for binding, buffer in enumerate((found.buffer, *made.values())):
            buffer.bind_to_storage_buffer(binding)
        program.uniforms.set(shown_size=self._size, slot=found.holes_slot)
        program.run(-(-self._size[0] // 4), self._size[1])
        self._gpu.barrier()
        return made

    def _buffer(self, name: str, pixel_bytes: int) -> moderngl.Buffer:
        if (name, pixel_bytes) not in self._buffers:
            filled_up = -(-self._size[0] // 4) * 4 * self._size[1]
            self._buffers[name, pixel_bytes] = self._gpu.gl.buffer(reserve=filled_up * pixel_bytes, dynamic=True)
        return self._buffers[name, pixel_bytes]

    def arrays(self, made: Mapping[str, moderngl.Buffer], out: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        """Return the arrays by name: those of `out`, and new ones for what it lacks."""
        wide, high = self._size
        filled_up = -(-wide // 4) * 4
        found = {}
        for name, buffer in made.items():
            pixel_bytes = buffer.size // (filled_up * high)
            kind = np.dtype(np.uint8 if pixel_bytes == 3 else np.float32)
            shape = (high, wide, 3) if name == "colour" else (high, wide)
            steps = (filled_up * pixel_bytes, pixel_bytes, kind.itemsize)[: len(shape)]
            found[name] = out[name] if name in out else np.empty(shape, kind)
            with mapped(buffer) as raw, np.errstate(over="ignore"):
                np.copyto(found[name], np.ndarray(shape, kind, raw, strides=steps), casting="same_kind")
        return found

    def close(self) -> None:
        """Free textures and buffers."""
        release_all(self._byte_of_half, *self._buffers.values())
