"""The messages of the feed, as docs/feed.md has them: little-endian, every length checked.

Whatever bytes come in, decoding returns a message or raises Malformed, and holds no more memory
than they do.
"""

from __future__ import annotations

import functools
import hashlib
import math
import struct
from collections.abc import Callable, Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from ..colour import linear_from_srgb
from ..errors import InputError, listed
from ..geometry import Fov, Pose, View

VERSION = 1
MAGIC = b"HWFD"
ASK, FRAME, REFUSAL = 1, 2, 3
RGBA16F, RGBA8 = 1, 2
INVERSE_DEPTH = 1
MOST_SIDE, MOST_EYES, MOST_TEXT = 8192, 2, 500
MOST_BYTES = 1 << 29
# Magic, version, kind, bytes of the whole message.
_HEAD = struct.Struct("<4sHHI")
# Id, when it was sent, instant to draw, instant of the head pose, newest frame received, token,
# width, height, eyes.
_ASK = struct.Struct("<QqqqQ32sIIB7x")
# Id, when the request was sent, received, and answered, ns of drawing, instant drawn, width,
# height, eyes, format of colour, format of depth.
_FRAME = struct.Struct("<QqqqqqIIBBB5x")
_REFUSAL = struct.Struct("<QI")
_POSE = struct.Struct("<7d")
# world_from_eye, head_from_eye, left, right, down, up.
_EYE = struct.Struct("<18d")
# Of each format of colour: how numbers are stored, four a pixel.
_COLOURS: dict[int, np.dtype] = {RGBA16F: np.dtype("<f2"), RGBA8: np.dtype("u1")}
_DEPTH_BYTES = 4
LARGEST_ASK = _HEAD.size + _ASK.size + _POSE.size + MOST_EYES * _EYE.size
_NO_TOKEN = bytes(32)
Size = tuple[int, int]


class Malformed(ValueError):
    """Bytes that are no message of this version; the text says what is wrong with them."""


@attrs.frozen(eq=False)
class Ask:
    """A head pose upstream: draw a frame for these eyes."""

    # Rises by at least 1 from one request to the next; 1 for the first.
    number: int
    # On the client's clock.
    sent_ns: int
    # Of the scene: what moves is drawn where it is then.
    time_ns: int
    # For which the head pose is; later than time_ns if it was predicted.
    head_ns: int
    # The newest frame that the client has, 0 for none.
    received: int
    # (w, h) of one eye.
    size: Size
    head: Pose
    views: tuple[View, ...]
    # SHA-256 of the shared secret; zeros for none.
    token: bytes = _NO_TOKEN


@attrs.frozen(eq=False)
class FrameMessage:
    """A frame downstream, with the exact views it was drawn for."""

    number: int
    # As the request had it, on the client's clock.
    asked_ns: int
    # On the server's clock.
    received_ns: int
    sent_ns: int
    render_ns: int
    time_ns: int
    views: tuple[View, ...]
    # Of each eye, top row first, (h, w, 4) with coverage in alpha: linear light as float16, or sRGB
    # as uint8.
    colours: tuple[NDArray[np.float16] | NDArray[np.uint8], ...]
    # (h, w) in 1/m, 0 for the sky, -1 where nothing was drawn.
    inverse_depths: tuple[NDArray[np.float32], ...]

    @property
    def size(self) -> Size:
        """(w, h) of one eye."""
        height, width = self.inverse_depths[0].shape
        return width, height

    def light(self, eye: int) -> NDArray[np.float16]:
        """Return one eye's colour as linear light."""
        colour = self.colours[eye]
        if colour.dtype != np.uint8:
            return colour.astype(np.float16, copy=False)
        light = _light_of_byte()[colour]
        light[..., 3] = colour[..., 3] > 0
        return light

    @property
    def bytes(self) -> int:
        """Bytes of the pictures."""
        return sum(one.nbytes for one in self.colours) + sum(one.nbytes for one in self.inverse_depths)


@attrs.frozen
class Refusal:
    """Why a request was not answered by a frame."""

    number: int
    text: str


Message = Ask | FrameMessage | Refusal


@functools.cache
def _light_of_byte() -> NDArray[np.float16]:
    return linear_from_srgb(np.arange(256, dtype=np.uint8)).astype(np.float16)


def token_of(secret: str) -> bytes:
    """Return what a request carries of a shared secret; zeros for an empty one."""
    return hashlib.sha256(secret.encode()).digest() if secret else _NO_TOKEN


def encode(message: Message) -> bytes:
    """Return the bytes of a message."""
    if isinstance(message, Ask):
        one = message
        stated = (one.number, one.sent_ns, one.time_ns, one.head_ns, one.received, one.token)
        body = [_ASK.pack(*stated, *one.size, len(one.views)), _packed(one.head), *map(_packed_eye, one.views)]
        return _framed(ASK, body)
    if isinstance(message, FrameMessage):
        it = message
        numbers = (it.number, it.asked_ns, it.received_ns, it.sent_ns, it.render_ns, it.time_ns)
        colour = RGBA8 if it.colours[0].dtype == np.uint8 else RGBA16F
        start = _FRAME.pack(*numbers, *it.size, len(it.views), colour, INVERSE_DEPTH)
        pictures = zip(it.colours, it.inverse_depths, strict=True)
        return _framed(FRAME, [start, *map(_packed_eye, it.views), *(p.tobytes() for pair in pictures for p in pair)])
    text = message.text.encode()[:MOST_TEXT]
    return _framed(REFUSAL, [_REFUSAL.pack(message.number, len(text)), text])


def _framed(kind: int, body: Sequence[bytes]) -> bytes:
    return b"".join([_HEAD.pack(MAGIC, VERSION, kind, _HEAD.size + sum(map(len, body))), *body])


def _packed(pose: Pose) -> bytes:
    return _POSE.pack(*pose.position_m.tolist(), *pose.orientation_xyzw.tolist())


def _packed_eye(view: View) -> bytes:
    fov = view.fov
    return _packed(view.pose) + _packed(view.head_from_eye) + struct.pack("<4d", fov.left, fov.right, fov.down, fov.up)


def decode(data: bytes) -> Message:
    """Return the message in these bytes. Errors: Malformed, whatever the bytes are."""
    if len(data) < _HEAD.size:
        raise Malformed(f"{len(data)} bytes: a message has {_HEAD.size} or more")
    magic, version, kind, length = _HEAD.unpack_from(data)
    if magic != MAGIC:
        raise Malformed(f"it begins with {magic!r}: expected {MAGIC!r}")
    if version != VERSION:
        raise Malformed(f"version {version}: this program speaks version {VERSION}")
    if length != len(data) or length > MOST_BYTES:
        raise Malformed(f"{len(data)} bytes, and it says {length}: expected the same, at most {MOST_BYTES}")
    readers: dict[int, Callable[[bytes], Message]] = {ASK: _ask, FRAME: _frame, REFUSAL: _refusal}
    if kind not in readers:
        raise Malformed(f"kind {kind}: expected {ASK}, {FRAME} or {REFUSAL}")
    try:
        return readers[kind](data)
    except (struct.error, InputError, UnicodeDecodeError) as error:
        raise Malformed(f"kind {kind}: {error}") from error


def _ask(data: bytes) -> Ask:
    number, sent_ns, time_ns, head_ns, received, token, width, height, eyes = _ASK.unpack_from(data, _HEAD.size)
    at = _HEAD.size + _ASK.size
    _check_format(width, height, eyes)
    _check_length(data, at + _POSE.size + eyes * _EYE.size)
    head, views = _pose(_POSE.unpack_from(data, at)), _views(data, at + _POSE.size, eyes)
    return Ask(number, sent_ns, time_ns, head_ns, received, (width, height), head, views, token)


def _frame(data: bytes) -> FrameMessage:
    number, asked_ns, received_ns, sent_ns, render_ns, time_ns, *form = _FRAME.unpack_from(data, _HEAD.size)
    width, height, eyes, colour, depth = form
    _check_format(width, height, eyes)
    if colour not in _COLOURS or depth != INVERSE_DEPTH:
        raise Malformed(
            f"formats {colour} and {depth}: expected {listed([*map(str, _COLOURS)], 'or')} for colour and "
            f"{INVERSE_DEPTH} for depth"
        )
    if render_ns < 0:
        raise Malformed(f"drawn in {render_ns} ns: expected 0 or more")
    at, pixels, of_colour = _HEAD.size + _FRAME.size, width * height, _COLOURS[colour]
    colour_bytes = 4 * of_colour.itemsize * pixels
    _check_length(data, at + eyes * (_EYE.size + colour_bytes + _DEPTH_BYTES * pixels))
    views, at = _views(data, at, eyes), at + eyes * _EYE.size
    colours, depths = [], []
    for _ in range(eyes):
        colours.append(np.frombuffer(data, of_colour, 4 * pixels, at).reshape(height, width, 4))
        at += colour_bytes
        depths.append(np.frombuffer(data, "<f4", pixels, at).reshape(height, width))
        at += _DEPTH_BYTES * pixels
    return FrameMessage(
        number, asked_ns, received_ns, sent_ns, render_ns, time_ns, views, tuple(colours), tuple(depths)
    )


def _refusal(data: bytes) -> Refusal:
    number, length = _REFUSAL.unpack_from(data, _HEAD.size)
    at = _HEAD.size + _REFUSAL.size
    if length > MOST_TEXT:
        raise Malformed(f"a text of {length} bytes: expected at most {MOST_TEXT}")
    _check_length(data, at + length)
    text = data[at:].decode()
    # A line of its own in a log, and no control of the terminal that shows it.
    return Refusal(number, "".join(one if one.isprintable() else " " for one in text))


def _check_format(width: int, height: int, eyes: int) -> None:
    if not (1 <= width <= MOST_SIDE and 1 <= height <= MOST_SIDE and 1 <= eyes <= MOST_EYES):
        raise Malformed(
            f"{eyes} eyes of {width}x{height} pixels: expected 1 to {MOST_EYES}, with sides of 1 to {MOST_SIDE}"
        )


def _check_length(data: bytes, length: int) -> None:
    if len(data) != length:
        raise Malformed(f"{len(data)} bytes: expected {length}")


def _pose(numbers: Sequence[float]) -> Pose:
    x, y, z, w = numbers[3:7]
    if not 0.999 < math.hypot(x, y, z, w) < 1.001:
        raise Malformed(f"a quaternion of length {math.hypot(x, y, z, w):g}: expected 1, within 0.001")
    return Pose(numbers[:3], numbers[3:7])


def _views(data: bytes, at: int, eyes: int) -> tuple[View, ...]:
    found = []
    for eye in range(eyes):
        numbers = _EYE.unpack_from(data, at + eye * _EYE.size)
        found.append(View(_pose(numbers[:7]), Fov(*numbers[14:]), _pose(numbers[7:14])))
    return tuple(found)
