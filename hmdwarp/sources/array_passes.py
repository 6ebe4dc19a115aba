"""Arrays in and out by one pass each: their bytes go up and come down as they are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ..base import linear_from_srgb, srgb8_from_linear
from ..gpu import Gpu
from ..gpu.egl import clear_buffer, mapped
from ..gpu.textures import SCALAR, Canvas, Owner, allocate, flip_rows, texture_bytes

# What colour may be: sRGB as bytes, sRGB or linear light as floats.
SRGB8, SRGB, LINEAR = "srgb8", "srgb", "linear"
Size = tuple[int, int]
Texture = moderngl.Texture
Pair = tuple[Texture, Texture]
_RG32UI = 0x823C  # a rgba16f texture, as the bits of its halves
_TEXEL_BYTES = 16  # of given_colour and given_depth
# Words of `found` for each picture, as in shaders/image/take_in.comp, which counts ABOVE_ONE and
# says of the others whether.
_WRONG, _NEGATIVE, _POSITIVE, _LARGEST, _BRIGHT, _FRACTION, _ABOVE_ONE = range(7)
_WORDS = 8
_INVERSE, _METRES, _UINT16, _UINT16_INVERSE = range(4)
_LARGEST_CODE = 65534  # of depth in 16 bits; 65535 is none
_RESULTS = (SRGB8, SRGB, LINEAR)


@attrs.frozen(eq=False)
class Scaling:
    """How the pass makes another size of sRGB bytes, see shaders/image/take_in.comp."""

    size: Size
    # Left, top, right and bottom of what becomes that size, in pixels of the arrays.
    box: tuple[float, float, float, float]
    seen_rows: NDArray[np.int32] | None = None  # (w, 2) of that size, as Hidden.rows has them; None where all is seen

    def spans(self) -> NDArray[np.uint32]:
        """Return (2, the longer side, 4): of columns, and of rows from the top."""
        found = np.zeros((2, max(self.size), 4), np.uint32)
        for spans, low, high, count in zip(found, self.box[:2], self.box[2:], self.size, strict=True):
            step = (high - low) / count
            centre, reach = low + (np.arange(count) + 0.5) * step, max(step, 1.0) / 2
            first, end = ((centre + side * reach + 0.5).astype(np.uint32) for side in (-1, 1))
            spans[:count, 0], spans[:count, 1] = first | end << 16, centre.astype(np.uint32)
        found[0, : self.size[0], 2:] = (0, self.size[1]) if self.seen_rows is None else self.seen_rows
        return found


@attrs.frozen(eq=False)
class Arrays:
    colour: NDArray[Any]  # (h, w, 3), or (h, w, 4) with coverage: uint8 sRGB, or floats
    encoding: str  # of `colour`: "srgb8", "srgb" or "linear"
    depth: NDArray[Any]  # (h, w) floats, or uint16 with the scale; below 0, NaN and 65535 are none
    scale: float = 1.0  # metres, or 1/m, per unit of `depth`
    is_inverse: bool = False  # whether `depth` is in 1/m instead
    is_guessed: bool = False  # whether floats are linear light only because nothing else was said
    is_apart: bool = False  # whether colour without depth stays, and depth without colour; else both are a hole
    hidden: NDArray[np.bool_] | None = None  # (h, w) where a mask hides colour or depth; None without one
    scaling: Scaling | None = None  # none for a picture of the size that the arrays have

    @property
    def size(self) -> Size:
        height, width = self.depth.shape
        return width, height

    @property
    def is_ready(self) -> bool:
        """Whether the bytes are those of textures: half floats with coverage, and 1/m."""
        kinds = self.colour.dtype.name, self.colour.shape[2], self.depth.dtype.name
        return kinds == ("float16", 4, "float32") and self.is_inverse and self.is_apart


class Found(Owner):
    """Words that the passes of one call write, and the host reads once after them."""

    def __init__(self, gpu: Gpu, pictures: int) -> None:
        self.buffer = self.own(gpu.gl.buffer(reserve=4 * _WORDS * (pictures + 1)))
        self.holes_slot = _WORDS * pictures  # where the pass that reads results counts holes
        self._words = np.zeros(_WORDS * (pictures + 1), np.uint32)

    def clear(self) -> None:
        clear_buffer(self.buffer, 0)

    def read(self) -> None:
        self.buffer.read_into(self._words)

    @property
    def holes(self) -> int:
        return int(self._words[self.holes_slot])

    def has_largest(self, number: int) -> bool:
        return bool(self._words[_WORDS * number + _LARGEST])

    def is_doubtful(self, number: int, size: Size) -> bool:
        """Return whether something of that picture may be wrong, as CallerPicture.checked knows."""
        words = self._words[_WORDS * number :][:_WORDS]
        half = 3 * size[0] * size[1] / 2  # of all numbers
        bright = words[_BRIGHT] and (not words[_FRACTION] or words[_ABOVE_ONE] >= half)
        return bool(words[_WRONG] or (words[_NEGATIVE] and not words[_POSITIVE]) or bright)


class PixelBuffers(Owner):
    """Found, and the buffers of one call in flight, each made when it is first needed."""

    def __init__(self, gpu: Gpu, pictures: int) -> None:
        self._gpu, self.found = gpu, self.own(Found(gpu, pictures))
        self._made: dict[tuple[str | int, ...], moderngl.Buffer] = {}

    def of(self, byte_count: int, *key: str | int) -> moderngl.Buffer:
        if (*key, byte_count) not in self._made:
            self._made[*key, byte_count] = self.own(self._gpu.gl.buffer(reserve=byte_count, dynamic=True))
        return self._made[*key, byte_count]

    @property
    def bytes(self) -> int:
        return sum(buffer.size for buffer in self._made.values())


class TakeIn(Owner):
    """Takes pictures of one size over; what each kind of array needs is made at the first of it."""

    def __init__(self, gpu: Gpu, size: Size) -> None:
        self._gpu, self._size = gpu, size
        bits = linear_from_srgb(np.arange(256, dtype=np.uint8)).astype(np.float16).view(np.uint16)
        self._light_of_byte = self.own(allocate(gpu.gl, (256, 1), (1, "u2")))
        self._light_of_byte.write(bits.tobytes())
        # What pictures of another size need: light in full, and Scaling.spans.
        self._light = self.own(allocate(gpu.gl, (256, 1), SCALAR))
        self._light.write(linear_from_srgb(np.arange(256, dtype=np.uint8)).tobytes())
        self._spans: dict[Size, moderngl.Texture] = {}
        self._staged: dict[tuple[str, int, int], moderngl.Texture] = {}

    @property
    def bytes(self) -> int:
        return sum(map(texture_bytes, self._staged.values()))

    def send(self, picture: Arrays, buffers: PixelBuffers, number: int = 0) -> Pair:
        """Return the bytes of colour and depth as textures; the next picture overwrites them."""
        sent = []
        for name, array in _arrays_of(picture).items():
            buffer, view = self._staging(name, array, buffers, number)
            # What is beyond a float32 is infinite there.
            with mapped(buffer, write=True) as raw, np.errstate(over="ignore"):
                np.copyto(view(raw), array, casting="unsafe")
                if name == "depth" and picture.hidden is not None:
                    view(raw)[picture.hidden] = 0
            key = (name, array.shape[2], _sent_as(name, array).itemsize)
            if key not in self._staged:
                texels = -(-self._size[0] // _TEXEL_BYTES) * key[1] * key[2]
                self._staged[key] = self.own(allocate(self._gpu.gl, (texels, self._size[1]), (4, "u4")))
            self._staged[key].write(buffer)
            sent.append(self._staged[key])
        return sent[0], sent[1]

    def run(self, picture: Arrays, sent: Pair, into: Pair, found: Found, number: int) -> None:
        """Write rgba16f light with coverage and r32f inverse depth, of what `send` returned."""
        size, light = self._size, self._light_of_byte
        if picture.scaling is not None:
            size, spans = picture.scaling.size, picture.scaling.spans()
            light, at = self._light, spans.shape[1::-1]
            if at not in self._spans:
                self._spans[at] = self.own(allocate(self._gpu.gl, at, (4, "u4")))
            self._spans[at].write(spans.tobytes())
            self._spans[at].bind_to_image(5, read=True, write=False)
        kind, is_whole = _sent_as("colour", picture.colour), picture.depth.dtype.kind == "u"
        form = (_UINT16_INVERSE if is_whole else _INVERSE) if picture.is_inverse else _UINT16 if is_whole else _METRES
        program = self._gpu.shaders.compute(
            "image/take_in.comp",
            **{"ITEM_BYTES": kind.itemsize, "CHANNELS": picture.colour.shape[2], "DEPTH": form},
            **{"ENCODED": int(picture.encoding == SRGB), "GUESSED": int(picture.is_guessed)},
            **{"APART": int(picture.is_apart), "SCALED": int(picture.scaling is not None)},
        )
        into[0].bind_to_image(0, read=False, write=True, format=_RG32UI)
        into[1].bind_to_image(1, read=False, write=True)
        for unit, texture in enumerate((*sent, light), start=2):
            texture.bind_to_image(unit, read=True, write=False)
        found.buffer.bind_to_storage_buffer(0)
        program.uniforms.set(rendered_size=size, scale=picture.scale, slot=_WORDS * number)
        columns = size[0] if picture.scaling is not None else -(-size[0] * kind.itemsize // 16)
        program.run(columns, size[1])
        self._gpu.barrier()

    def _staging(
        self, name: str, array: NDArray[Any], buffers: PixelBuffers, number: int
    ) -> tuple[moderngl.Buffer, Callable[[NDArray[np.uint8]], NDArray[Any]]]:
        kind = _sent_as(name, array)
        pixel_bytes = array.shape[2] * kind.itemsize
        steps = -(-self._size[0] // 16) * 16 * pixel_bytes, pixel_bytes, kind.itemsize
        buffer = buffers.of(steps[0] * self._size[1], name, number)
        return buffer, lambda raw: np.ndarray(array.shape, kind, raw, strides=steps)


class GiveCodes(Owner):
    """Makes the half form of the feed of pictures of one size: sRGB bytes, and depth in 16 bits."""

    def __init__(self, gpu: Gpu, size: Size) -> None:
        self._gpu, self._size = gpu, size
        self._byte_of_half = self.own(_byte_table(gpu))
        pixels = -(-size[0] // 2) * 2 * size[1]
        self._nearest, self._colours, self._codes = (
            self.own(gpu.gl.buffer(reserve=n)) for n in (4, 4 * pixels, 2 * pixels)
        )

    def run(self, pair: Pair) -> tuple[NDArray[np.uint8], NDArray[np.uint16], float]:
        """Return colour (h, w, 4), codes (h, w) within 0.55 steps, and their step in 1/m."""
        colour, inverse_depth = pair
        clear_buffer(self._nearest, 0)
        colour.bind_to_image(0, read=True, write=False, format=_RG32UI)
        inverse_depth.bind_to_image(1, read=True, write=False)
        self._byte_of_half.bind_to_image(2, read=True, write=False)
        for binding, buffer in enumerate((self._nearest, self._colours, self._codes)):
            buffer.bind_to_storage_buffer(binding)
        for step in (0, 1):
            program = self._gpu.shaders.compute("image/give_codes.comp", STEP=step)
            program.uniforms.set(rendered_size=self._size)
            program.run(-(-self._size[0] // 2), self._size[1])
            self._gpu.barrier()
        wide, high = self._size
        nearest = np.frombuffer(self._nearest.read(), np.float32)[0]
        with mapped(self._colours) as raw:
            colours = raw.reshape(high, -1, 4)[:, :wide].copy()
        with mapped(self._codes) as raw:
            codes = raw.view(np.uint16).reshape(high, -1)[:, :wide].copy()
        return colours, codes, float(nearest / np.float32(_LARGEST_CODE))

    @property
    def bytes(self) -> int:
        return self._colours.size + self._codes.size


class Upload(Owner):
    def __init__(self, gpu: Gpu, size: Size) -> None:
        self._taking, self._buffers = self.own(TakeIn(gpu, size)), self.own(PixelBuffers(gpu, 1))

    def run(self, picture: Arrays, into: Pair) -> None:
        if not picture.is_ready:
            sent = self._taking.send(picture, self._buffers)
            self._taking.run(picture, sent, into, self._buffers.found, 0)
            return
        for number, (array, texture) in enumerate(zip((picture.colour, picture.depth), into, strict=True)):
            buffer = self._buffers.of(array.nbytes, "ready", number)
            with mapped(buffer, write=True) as raw:
                np.copyto(raw.view(array.dtype).reshape(array.shape), flip_rows(array))
            texture.write(buffer, alignment=1)

    @property
    def bytes(self) -> int:
        return self._taking.bytes + self._buffers.bytes


def _arrays_of(picture: Arrays) -> dict[str, NDArray[Any]]:
    return {"colour": picture.colour, "depth": picture.depth[..., None]}


def _sent_as(name: str, array: NDArray[Any]) -> np.dtype[Any]:
    """Return the type that travels: integers, and halves of colour, as they are; else float32."""
    is_own = array.dtype.kind == "u" or (name == "colour" and array.dtype.itemsize == 2)
    return np.dtype(array.dtype.type if is_own else np.float32)


def _byte_table(gpu: Gpu) -> moderngl.Texture:
    table = allocate(gpu.gl, (256, 256), (1, "u1"))
    table.write(srgb8_from_linear(np.arange(65536, dtype=np.uint16).view(np.float16)).tobytes())
    return table


class GiveOut(Owner):
    def __init__(self, gpu: Gpu, size: Size) -> None:
        self._gpu, self._size = gpu, size
        self._byte_of_half = self.own(_byte_table(gpu))

    def run(
        self, shown: Canvas, warped: Canvas, depth: Texture | None, sure: Canvas | None, kind: str, call: PixelBuffers
    ) -> dict[str, moderngl.Buffer]:
        """Return what `arrays` reads, by name; holes of `warped` are counted in `call`."""
        # depth: inverse depth, in 1/m. sure: the confidence of what is shown.
        defines = {"DEPTH": int(depth is not None), "CONFIDENCE": int(sure is not None)}
        program = self._gpu.shaders.compute("image/give_out.comp", RESULT=_RESULTS.index(kind), **defines)
        for unit, canvas in enumerate((shown, warped)):
            canvas.texture.bind_to_image(unit, read=True, write=False, format=_RG32UI)
        if depth is not None:
            depth.bind_to_image(2, read=True, write=False)
        if sure is not None:
            sure.texture.bind_to_image(3, read=True, write=False)
        self._byte_of_half.bind_to_image(4, read=True, write=False)
        sizes = {"colour": 3 if kind == SRGB8 else 12, "coverage": 4}
        sizes |= {} if depth is None else {"depth_m": 4}
        filled_up, found = -(-self._size[0] // 4) * 4 * self._size[1], call.found
        made = {name: call.of(filled_up * pixel_bytes, name) for name, pixel_bytes in sizes.items()}
        for binding, buffer in enumerate((found.buffer, *made.values())):
            buffer.bind_to_storage_buffer(binding)
        program.uniforms.set(shown_size=self._size, slot=found.holes_slot)
        program.run(-(-self._size[0] // 4), self._size[1])
        self._gpu.barrier()
        return made

    def arrays(self, made: Mapping[str, moderngl.Buffer]) -> dict[str, NDArray[Any]]:
        wide, high = self._size
        filled_up = -(-wide // 4) * 4
        found = {}
        for name, buffer in made.items():
            pixel_bytes = buffer.size // (filled_up * high)
            kind = np.dtype(np.uint8 if pixel_bytes == 3 else np.float32)
            shape = (high, wide, 3) if name == "colour" else (high, wide)
            steps = (filled_up * pixel_bytes, pixel_bytes, kind.itemsize)[: len(shape)]
            with mapped(buffer) as raw:
                found[name] = np.ndarray(shape, kind, raw, strides=steps).copy("C")
        return found
