"""Packets of coded data: pictures through video codecs frame by frame, and packed arrays."""

from __future__ import annotations

import functools
import math
import os
import struct
import zlib
from collections.abc import Mapping
from fractions import Fraction
from typing import Any, TypeVar

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import InputError, MachineError, linear_from_srgb, priority_kept, pyav, srgb8_from_linear, srgb_from_linear
from .codecs import LARGE, Codec, codecs
from .coding import Coding

Size = tuple[int, int]


class Undecodable(Exception):
    """A frame that cannot be decoded, because it is damaged or a frame it refers to is missing.

    No fault of program or user: such frames are counted.
    """


@attrs.frozen
class Packet:
    """One picture on the network."""

    number: int  # 0 for the first of its stream
    # Whether it can be decoded without those before it.
    key: bool
    data: bytes = attrs.field(repr=lambda data: f"<{len(data)} bytes>")


_CHECKED_FROM = 4  # what comes before is the checksum


def two_parts(header: struct.Struct, fields: tuple[Any, ...], first: bytes, second: bytes) -> bytes:
    """Return data of two parts after a header.

    header: CRC-32 of everything after it (a video decoder conceals what is damaged), the fields,
    and the bytes of the first part.
    """
    data = header.pack(0, *fields, len(first))[_CHECKED_FROM:] + first + second
    return zlib.crc32(data).to_bytes(_CHECKED_FROM, "little") + data


def from_two_parts(header: struct.Struct, data: bytes, what: str) -> tuple[list[Any], bytes, bytes]:
    """Return fields and parts of what `two_parts` made. Errors: Undecodable, naming what it is."""
    try:
        checksum, *fields, length = header.unpack_from(data)
    except struct.error as error:
        raise Undecodable(f"damaged {what} ({error})") from error
    start = header.size + length
    if zlib.crc32(data[_CHECKED_FROM:]) != checksum or len(data) < start:
        raise Undecodable(f"damaged {what} (its checksum or length is wrong)")
    return fields, data[header.size : start], data[start:]


_BT709, _SRGB, _LIMITED = 1, 13, 1  # FFmpeg's numbers: matrix and primaries, transfer, range
# Chroma lies in the middle of four pixels, as they are averaged. The stream says so: without a word
# every decoder takes the left two.
_CHROMA = "center"
_SMALLEST = 64  # x265 rejects pictures smaller than a block
# How many pictures' worth of bits the encoder may run ahead of its rate: this bounds the jitter.
_VBV_FRAMES = 4


def _coded_size(size: Size) -> Size:
    """Return an even (w, h), as chroma has half the resolution, and no smaller than a block."""
    width, height = (max(side + side % 2, _SMALLEST) for side in size)
    return width, height


def padded(picture: NDArray[Any], size: Size) -> NDArray[Any]:
    """Return the picture with its last row and column repeated up to `size` (w, h)."""
    height, width = picture.shape[:2]
    if (width, height) == size:
        return np.ascontiguousarray(picture)
    more = ((0, size[1] - height), (0, size[0] - width), *[(0, 0)] * (picture.ndim - 2))
    return np.pad(picture, more, mode="edge")


def one_packet(context: Any, encoder: str, frame: Any) -> Any:
    """Return the packet of a frame, from an encoder that is not to wait for others."""
    try:
        packets = context.encode(frame)
    except (OSError, pyav().FFmpegError) as error:
        raise MachineError(f"encoder '{encoder}' failed ({error})") from error
    if len(packets) != 1:
        raise MachineError(
            f"encoder '{encoder}' gave {len(packets)} packets for one picture: it does not run without delay"
        )
    return packets[0]


class VideoEncoder:
    """Encode frames of one size and pixel format, each before the next goes in.

    options: of the encoder, beside the codec's own. Errors: MachineError if the encoder is missing
    or does not open.
    """

    def __init__(self, codec: Codec, size: Size, rate_hz: float, pixels: str, options: Mapping[str, str]) -> None:
        av = pyav()
        codec.check()
        os.environ.setdefault("SVT_LOG", "0")  # SVT-AV1 writes to stderr directly, past every logger
        self.size, self._codec = _coded_size(size), codec
        context: Any = av.CodecContext.create(codec.encoder, "w")
        context.width, context.height = self.size
        context.pix_fmt = pixels
        rate = max(Fraction(rate_hz).limit_denominator(1001), Fraction(1, 1001))
        context.framerate, context.time_base = rate, 1 / rate
        context.gop_size = 2**30  # key frames come on request
        context.max_b_frames = 0
        context.thread_count = codec.threads
        context.color_range, context.color_trc = _LIMITED, _SRGB
        context.colorspace = context.color_primaries = _BT709
        large = codec.large if math.prod(self.size) > LARGE else {}
        context.options = {"chroma_sample_location": _CHROMA, **codec.options, **large, **options}
        try:
            with priority_kept():
                context.open()
        except (OSError, ValueError, av.FFmpegError) as error:
            found = f"encoder '{codec.encoder}' does not take pictures of {size[0]}x{size[1]} at {rate_hz:g} Hz"
            raise MachineError(f"{found} ({error}): use another size, rate or codec") from error
        self._context: Any = context
        self._pts = 0

    def encode(self, frame: Any, key: bool) -> tuple[bytes, bool]:
        """Return (bytes, whether it is a key frame) of a PyAV frame. key: force one."""
        from av.video.frame import PictureType

        frame.pts, frame.time_base = self._pts, self._context.time_base
        frame.pict_type = PictureType.I if key else PictureType.NONE
        self._pts += 1
        packet = one_packet(self._context, self._codec.encoder, frame)
        return bytes(packet), bool(packet.is_keyframe)


class VideoDecoder:
    """Decode the bytes of a VideoEncoder for pictures of `size`.

    what: what they are, for errors.
    """

    def __init__(self, codec: Codec, size: Size, what: str) -> None:
        codec.check()
        self._size, self._what = _coded_size(size), what
        context: Any = pyav().CodecContext.create(codec.decoder, "r")
        # Frame threads would delay pictures.
        context.thread_type, context.thread_count = "SLICE", 2
        # Whatever size hostile bytes claim, no more memory than whole blocks take.
        most_pixels = (self._size[0] + _SMALLEST) * (self._size[1] + _SMALLEST)
        context.options = {"max_pixels": str(most_pixels), "flags": "low_delay"}
        self._context = context
        # Of the next picture; None: wait for a key frame.
        self._next: int | None = None

    def begin(self, number: int, key: bool) -> None:
        """Prepare for picture `number` of the stream. Errors: Undecodable where one is missing."""
        if key:
            self._context.flush_buffers()
        elif number != self._next:
            self._next = None
            raise Undecodable(f"frame {number} builds on one that never came")

    def decode(self, data: bytes, number: int) -> Any:
        """Return picture `number` as PyAV's frame. Errors: Undecodable."""
        av = pyav()
        try:
            frames = self._context.decode(av.Packet(data))
        except (OSError, ValueError, av.FFmpegError) as error:
            raise Undecodable(f"damaged {self._what} ({error})") from error
        if len(frames) != 1 or (frames[0].width, frames[0].height) != self._size:
            raise Undecodable(f"damaged {self._what} (not one picture of the stream's size)")
        self._next = number + 1
        return frames[0]


class ColourEncoder:
    """Encode pictures of one size.

    crf: constant quality, lower is better; or bitrate_mbit: that many Mbit/s, kept to within 4
    pictures (av1 and vp9: about 20). Errors: as VideoEncoder.
    """

    def __init__(self, codec: Codec, size: Size, rate_hz: float, crf: int | None, bitrate_mbit: float | None) -> None:
        quality = {"crf": str(codec.crf if crf is None else max(crf, codec.best))}
        if bitrate_mbit is not None:
            bits = round(bitrate_mbit * 1e6)
            quality = dict.fromkeys(codec.rates, str(bits))
            quality["bufsize"] = str(max(1, round(_VBV_FRAMES * bits / rate_hz)))
        self._video = VideoEncoder(codec, size, rate_hz, "yuv420p", quality)

    def encode(self, picture: NDArray[np.uint8], key: bool) -> tuple[bytes, bool]:
        """Return (bytes, whether it is a key frame) of (h, w, 3) uint8 sRGB. key: force one."""
        frame = pyav().VideoFrame.from_ndarray(padded(picture, self._video.size), format="rgb24")
        return self._video.encode(_reformatted(frame, "yuv420p", "AREA", to_yuv=True), key)


class ColourDecoder:
    """Decode bytes into pictures of `size`."""

    def __init__(self, codec: Codec, size: Size) -> None:
        self.size, self._video = size, VideoDecoder(codec, size, "colour")
        self.begin = self._video.begin

    def decode(self, data: bytes, number: int) -> NDArray[np.uint8]:
        """Return (h, w, 3) sRGB of picture `number`. Errors: Undecodable."""
        from av.video.reformatter import Interpolation

        # Exact chroma interpolation is 1.8 dB better and takes 10 ms for 1280x800 instead of 5.
        # Without the two flags all colours come back 1 to 1.5 levels too dark. An older PyAV may
        # lack them.
        exact: Any = Interpolation.BICUBIC
        for name in ("FULL_CHR_H_INT", "ACCURATE_RND"):
            exact |= getattr(Interpolation, name, Interpolation.BICUBIC)
        picture = _reformatted(self._video.decode(data, number), "rgb24", exact, to_yuv=False).to_ndarray()
        return np.ascontiguousarray(picture[: self.size[1], : self.size[0]])


def _reformatted(frame: Any, form: str, interpolation: Any, *, to_yuv: bool) -> Any:
    from av.video.reformatter import ColorRange, Colorspace

    ranges = (ColorRange.JPEG, ColorRange.MPEG) if to_yuv else (ColorRange.MPEG, ColorRange.JPEG)
    spaces = {"src_colorspace": Colorspace.ITU709, "dst_colorspace": Colorspace.ITU709}
    return frame.reformat(
        format=form, interpolation=interpolation, src_color_range=ranges[0], dst_color_range=ranges[1], **spaces
    )


# See two_parts. The fields: powers of 2 beyond 1, the light of uncovered pixels as half floats; the
# parts: coverage (after a key frame XORed with the one before) and video.
_HEADER = struct.Struct("<IB6sI")
# A byte of coverage: 0 is nothing at all, 1 to 255 a coverage of 0 to 1.
_STEPS = 254
_COVERED = np.float16(1).view(np.uint16)


class Encoder:
    """Encode the pictures of one stream into packets: light as video, coverage without loss.

    After a key frame what changed of the coverage is packed, so that a headset's hidden area costs
    little.

    size: (w, h). crf: constant quality, 0 (best) to 51; or bitrate_mbit: Mbit/s of the video;
    neither: the codec's own crf. keeps_beyond_1: whether light above 1 is kept; a display clips it,
    but what is multiplied by less than 1 before it is shown needs it. Errors: InputError for
    numbers out of range, and codec "none"; as ColourEncoder.
    """

    def __init__(
        self,
        codec: str,
        size: Size,
        rate_hz: float,
        *,
        crf: int | None = None,
        bitrate_mbit: float | None = None,
        keeps_beyond_1: bool = False,
    ) -> None:
        Coding(codec=codec, crf=crf, bitrate_mbit=bitrate_mbit)  # refuses numbers out of range
        if (how := codecs.get(codec)).is_none:
            known = ", ".join(each.name for each in codecs if not each.is_none)
            raise InputError(f"codec '{codec}' encodes nothing: expected one of {known}")
        self._shape = (*size[::-1], 4)
        self._colour = ColourEncoder(how, size, rate_hz, crf, bitrate_mbit)
        self._number = self._stops = 0
        self._keeps_beyond_1, self._before = keeps_beyond_1, np.zeros(size[::-1], np.uint8)

    def encode(self, picture: NDArray[np.float16], key: bool = False) -> Packet:
        """Encode the next picture: (h, w, 4) linear light with coverage in alpha.

        Rows in either order. A pixel without coverage comes back exactly if all such pixels are the
        same, as where nothing was drawn; else within the codec's error, like any other. key: make
        it a key frame. Errors: ValueError.
        """
        if picture.shape != self._shape or picture.dtype != np.float16:
            raise ValueError(f"{picture.dtype} of shape {picture.shape}: expected float16 of shape {self._shape}")
        light, alpha = np.ascontiguousarray(picture[..., :3]), picture[..., 3]
        empty, coverage = np.zeros(3, np.float16), np.full(alpha.shape, 1 + _STEPS, np.uint8)
        if not (alpha.view(np.uint16) == _COVERED).all():
            coverage = (1.5 + _STEPS * np.clip(alpha.astype(np.float32), 0, 1)).astype(np.uint8)
            hole = alpha == 0
            if hole.any():
                empty = picture[hole][0, :3].copy()
                coverage[hole & (picture[..., :3] == empty).all(axis=-1)] = 0
        wants_key = key or not self._number
        if self._keeps_beyond_1:
            # It falls with a key frame only: another scale changes every block of the video.
            self._stops = max(stops_of(light), 0 if wants_key else self._stops)
        colour, is_key = self._colour.encode(covered(bytes_from_light(light, self._stops), coverage == 0), wants_key)
        packed = pack(coverage if is_key else coverage ^ self._before)
        data = two_parts(_HEADER, (self._stops, empty.tobytes()), packed, colour)
        number, self._number, self._before = self._number, self._number + 1, coverage
        return Packet(number, is_key, data)


class Decoder:
    """Decode the packets of an Encoder of that codec and size into pictures.

    They must come in the order of encoding; some may be missing.
    """

    def __init__(self, codec: str, size: Size) -> None:
        self._colour = ColourDecoder(codecs.get(codec), size)
        self._before = np.zeros(size[::-1], np.uint8)

    def decode(self, packet: Packet) -> NDArray[np.float16]:
        """Return the picture as the client sees it: as encoded, coverage within 1/508.

        Errors: Undecodable for damaged bytes, and for every picture from a missing one to the next
        key frame.
        """
        self._colour.begin(packet.number, packet.key)
        (stops, empty), packed, video = from_two_parts(_HEADER, packet.data, "picture")
        colour = self._colour.decode(video, packet.number)
        coverage = unpack(packed)
        if coverage.shape != self._before.shape or coverage.dtype != np.uint8:
            raise Undecodable("damaged picture (coverage of another size)")
        self._before = coverage = coverage if packet.key else coverage ^ self._before
        out = np.empty((*coverage.shape, 4), np.float16)
        out[..., :3] = light_from_bytes(colour, stops)
        out[..., 3] = np.maximum(coverage.astype(np.float32) - 1, 0) / _STEPS
        out[coverage == 0] = (*np.frombuffer(empty, np.float16), 0)
        return out


_LEVEL = 1  # level 6 takes 10 times as long to save another tenth
_MOST_AXES = 8


def pack(layer: NDArray[Any]) -> bytes:
    """Pack (n,), (h, w) or (h, w, channels) of any number type without loss.

    Each byte of a value is coded as its difference from that of the pixel before, equal bytes of
    all pixels together. zlib runs twice, because one run cannot make less than 1/1032 of its input
    and a mask is mostly one value.
    """
    layer = np.ascontiguousarray(layer)
    kind = layer.dtype.str.encode()
    head = struct.pack(f"<B{len(kind)}sB{layer.ndim}I", len(kind), kind, layer.ndim, *layer.shape)
    if layer.size == 0:
        return zlib.compress(head)
    pixels = layer.reshape(math.prod(layer.shape[:2]), -1).view(np.uint8)
    changes = pixels.copy()
    changes[1:] -= pixels[:-1]
    # Differences come in runs, and a few values dominate; a search for repeated patterns does not
    # pay.
    coder = zlib.compressobj(_LEVEL, zlib.DEFLATED, zlib.MAX_WBITS, 9, zlib.Z_RLE)
    once = coder.compress(np.ascontiguousarray(changes.T).data) + coder.flush()
    return zlib.compress(head + once, _LEVEL)


def unpack(data: bytes) -> NDArray[Any]:
    """Return what `pack` was given. Errors: Undecodable for damaged bytes."""
    try:
        whole = zlib.decompress(data)
        length = whole[0]
        kind, axes = np.dtype(whole[1 : 1 + length].decode()), whole[1 + length]
        if axes > _MOST_AXES:
            raise ValueError(f"{axes} axes")
        shape = struct.unpack_from(f"<{axes}I", whole, 2 + length)
        if math.prod(shape) == 0:
            return np.zeros(shape, kind)
        changes = np.frombuffer(zlib.decompress(whole[2 + length + 4 * axes :]), np.uint8)
        pixels = np.cumsum(changes.reshape(-1, math.prod(shape[:2])), axis=1, dtype=np.uint8)
        return np.ascontiguousarray(pixels.T).view(kind).reshape(shape)
    except (zlib.error, struct.error, IndexError, TypeError, ValueError) as error:
        raise Undecodable(f"damaged packed layer ({error})") from error


# Powers of 2 that light beyond 1 may reach; half floats end before the last.
STOPS = (0, 1, 2, 4, 8, 16)
# Of a picture with light beyond 1, the byte that 1 becomes: three quarters are left for what is
# below.
_ONE = 191


def stops_of(light: NDArray[np.float16]) -> int:
    """Return how many powers of 2 above 1 the bytes must reach for this light, one of STOPS."""
    largest = float(light.max(initial=0, where=np.isfinite(light)))
    return next(stops for stops in STOPS if largest <= 2.0**stops)


def bytes_from_light(light: NDArray[np.float16], stops: int) -> NDArray[np.uint8]:
    """Return the bytes of linear light: sRGB if stops is 0, and light beyond 1 is clipped.

    Else sRGB up to 1, in the lower three quarters of the bytes, and equal ratios from there to
    2^stops. Negative light and NaN become 0.
    """
    return srgb8_from_linear(light) if stops == 0 else _byte_of_half(stops)[light.view(np.uint16)]


def light_from_bytes(values: NDArray[np.uint8], stops: int) -> NDArray[np.float16]:
    """Return the linear light of bytes; the reverse of bytes_from_light."""
    return _half_of_byte(stops)[values]


@functools.cache
def _half_of_byte(stops: int) -> NDArray[np.float16]:
    values = np.arange(256)
    if stops == 0:
        return linear_from_srgb(values.astype(np.uint8)).astype(np.float16)
    below = linear_from_srgb(np.minimum(values / _ONE, 1))
    beyond = 2.0 ** (stops * (values - _ONE) / (255 - _ONE))
    return np.minimum(np.where(values <= _ONE, below, beyond), np.finfo(np.float16).max).astype(np.float16)


@functools.cache
def _byte_of_half(stops: int) -> NDArray[np.uint8]:
    with np.errstate(invalid="ignore"):  # the table's own NaN entries
        light = np.nan_to_num(np.arange(65536, dtype=np.uint16).view(np.float16).astype(np.float64), nan=0.0)
    beyond = _ONE + (255 - _ONE) * np.log2(np.clip(light, 1, 2.0**stops)) / stops
    return np.floor(np.where(light <= 1, _ONE * srgb_from_linear(light), beyond) + 0.5).astype(np.uint8)


T = TypeVar("T", np.uint8, np.uint16)


def covered(colour: NDArray[T], hole: NDArray[np.bool_]) -> NDArray[T]:
    """Return the picture with each hole coloured like the covered pixel before it in its row.

    At the start of a row, like the first covered one after it; a row of holes like the one before
    it, or the first that has any. A black hole would bleed into neighbouring pixels, through the
    codec's blocks and half-resolution chroma, and cost bytes. The decoder clears the holes again.
    Without holes, and with nothing else, the picture itself is returned.
    """
    if not hole.any() or hole.all():
        return colour
    across = np.take_along_axis(colour, _nearest(hole)[..., None], axis=1)
    rows: NDArray[np.bool_] = np.all(hole, axis=1)
    return across[_nearest(rows[None])[0]] if rows.any() else across


def _nearest(hole: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return the column that each pixel of (h, w) takes its colour from; 0 in a row of holes."""
    columns = np.where(hole, -1, np.arange(hole.shape[1], dtype=np.int32))
    before = np.maximum.accumulate(columns, axis=1)
    first = np.argmin(hole, axis=1)
    return np.where(before < 0, first[:, None], before)
