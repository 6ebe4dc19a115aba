"""The messages of the feed, see docs/feed.md: any bytes decode to a message or raise Malformed."""

from __future__ import annotations

import hashlib
import math
import struct
from collections.abc import Callable, Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import InputError, linear_from_srgb
from ...geometry import AHEAD, Fovea, FoveaGrid, Pose, View, looking
from ...scenes import ACTIONS, InputEvent
from . import bounds, options, parts
from .parts import Layers, Wanted

VERSION = 3
MAGIC = b"HWFD"
ASK, FRAME, REFUSAL, UNCHANGED = 1, 2, 3, 5
# Formats of colour, and of depth; 0 in a request: the server's choice.
RGBA16F, RGBA8, H264, HEVC, VP9, AV1 = COLOURS = (1, 2, 3, 4, 5, 6)
BYTES = (RGBA8, H264, HEVC, VP9, AV1)  # those that are made of sRGB bytes
INVERSE_DEPTH, DEPTH_EXACT, DEPTH_VIDEO, DEPTH_VIDEO8, DEPTH_CODES = DEPTHS = (1, 2, 3, 4, 5)
ANY = 0
NONE = 255  # of a picture that is left out: neither wished nor sent
MOST_BYTES = int(bounds.MESSAGE.most)
_HEAD = struct.Struct("<4sHHI")  # magic, version, kind, bytes of the whole message
# Id, when it was sent, instant to draw, instant of the head pose, newest frame received, token,
# width, height, eyes, formats of colour and depth, 1 + quality, whether to begin anew,
# number of further layers, what follows, frames a second, Mbit/s of an eye's video, step of depth.
_ASK = struct.Struct("<QqqqQ32sIIBBBBBBxB3d")
# Id, when the request was sent, received, and answered, ns of drawing, instant drawn, width,
# height, eyes, format of colour, format of depth, whether the stream begins here, place in it,
# number of parts of further layers, what requests may have, where the session began.
_FRAME = struct.Struct("<QqqqqqIIBBBBIBBH")
# Bits of what requests have, and of what frames say that they may have.
_HIDES, _SESSION, _FOVEA, _INPUTS = 1, 2, 4, 8
# Number of the session, age of a frame when it is seen, whether to leave out what has not changed,
# number of frames whose fate is told.
_SESSION_HEAD = struct.Struct("<IqBxH")
_FATE = struct.Struct("<QBq")  # id of a frame, whether it arrived, the instant from which the server may know
# The gaze in the head's axes, degrees across that are sharp, pixels that one beyond holds.
_LOOK = struct.Struct("<4dI")
_COUNT = struct.Struct("<H")  # how many inputs; of each its instant, action, target, and the hand's ray
_INPUT = struct.Struct("<qB16s6d")
MOST_OF_TARGET = 16
_LENGTHS = struct.Struct("<II")  # bytes of one eye's colour and depth
_REFUSAL = struct.Struct("<QI")
_ID = struct.Struct("<Q")
_POSE = struct.Struct("<7d")
_EYE = struct.Struct("<18d")  # world_from_eye, head_from_eye, left, right, down, up
# Of each format that is not coded: how numbers are stored, four a pixel of colour and one of depth.
_COLOURS: dict[int, np.dtype] = {RGBA16F: np.dtype("<f2"), RGBA8: np.dtype("u1")}
_DEPTHS: dict[int, np.dtype] = {INVERSE_DEPTH: np.dtype("<f4")}
_STEP = struct.Struct("<f")  # what comes before the codes of a DepthCodes: its step
_CODE = np.dtype("<u2")
_NO_TOKEN = bytes(32)
Size = tuple[int, int]
Data = bytes | memoryview  # of a whole message


@attrs.frozen
class Wish:
    colour: int = ANY
    depth: int = ANY
    crf: int | None = None  # CRF of the video, 0 (best) to 51; None for the codec's own
    rate_hz: float = 60.0  # frames a second that are requested; the rate control of a video reads it
    bitrate_mbit: float = 0.0  # of one eye's video in place of a quality; 0 for none
    depth_step: float = 0.0  # 1/m, of coded depth; 0 for the server's choice


# The two forms that are not coded: 12 bytes a pixel as drawn, and 6.
FULL, HALF = Wish(), Wish(RGBA8, DEPTH_CODES)
RAW = {options.FULL: FULL, options.HALF: HALF}


@attrs.frozen
class Fate:
    number: int
    arrived: bool
    heard_ns: int


@attrs.frozen
class Session:
    """What a client has of layers that build on the frames before."""

    number: int  # of another number than in the request before, the server begins them anew
    age_ns: int = 0  # from drawing a frame to showing it, as far as that is known
    only_changes: bool = False  # whether a frame in which nothing has moved is left out
    fates: tuple[Fate, ...] = ()  # of frames of this session, each told until a later request has been answered


MOST_FATES, MOST_INPUTS = int(bounds.FATES.most), int(bounds.INPUTS.most)


class Malformed(ValueError):
    """Bytes that are no message of this version; the text says what is wrong with them."""


class BadRequest(Malformed):
    """A request that cannot be read, or in another version; its id is in the same place."""

    def __init__(self, text: str, data: Data) -> None:
        super().__init__(text)
        self.number = int.from_bytes(data[_HEAD.size : _HEAD.size + 8], "little")


@attrs.frozen(eq=False)
class Ask:
    number: int  # rises by at least 1 from one request to the next; 1 for the first
    sent_ns: int  # on the client's clock
    time_ns: int  # of the scene: what moves is drawn where it is then
    head_ns: int  # for which the head pose is; later than time_ns if it was predicted
    received: int  # the newest frame that the client has, 0 for none
    size: Size  # (w, h) of one eye
    head: Pose
    views: tuple[View, ...]
    token: bytes = _NO_TOKEN  # SHA-256 of the shared secret; zeros for none
    wish: Wish = Wish()
    anew: bool = False  # whether the pictures must be decodable without any before
    wanted: Wanted | None = None  # layers that the client reads besides colour and depth; None for nothing
    session: Session | None = None  # only where the server's frames have said that they may have it
    fovea: Fovea | None = None  # likewise: coarser away from the views' gaze, on the grid in layer "foveated"
    inputs: tuple[InputEvent, ...] = ()  # what people did until the instant to draw; likewise


@attrs.frozen(eq=False)
class DepthCodes:
    """Inverse depth in 16 bits: a code times the step, in 1/m; 65535 where nothing was drawn."""

    codes: NDArray[np.uint16]  # (h, w) uint16, top row first; 0 is infinitely far
    step: float

    @property
    def shape(self) -> tuple[int, ...]:
        return self.codes.shape

    @property
    def nbytes(self) -> int:
        return _STEP.size + self.codes.nbytes

    def numbers(self) -> NDArray[np.float32]:
        """Return inverse depth, -1 where nothing was drawn."""
        inverse = self.codes * np.float32(self.step)
        inverse[self.codes == _NO_CODE] = -1
        return inverse


_NO_CODE = 65535
Picture = NDArray[Any] | DepthCodes | bytes


@attrs.frozen(eq=False)
class FrameMessage:
    number: int
    asked_ns: int  # as the request had it, on the client's clock
    received_ns: int  # on the server's clock, as the next
    sent_ns: int
    render_ns: int
    time_ns: int
    views: tuple[View, ...]
    # Of each eye, top row first, (h, w, 4) with coverage in alpha: linear light as float16, or sRGB
    # as uint8; bytes where it is coded.
    colours: tuple[NDArray[np.float16] | NDArray[np.uint8] | bytes, ...]
    # (h, w) in 1/m, 0 for the sky, -1 where nothing was drawn; bytes where it is coded.
    inverse_depths: tuple[NDArray[np.float32] | DepthCodes | bytes, ...]
    # Formats of those that are bytes, and (w, h) of one eye where both are.
    colour: int = RGBA16F
    depth: int = INVERSE_DEPTH
    coded_size: Size = (0, 0)
    begins: bool = True  # of coded pictures: whether this one can be decoded without those before
    place: int = 0  # the next one's is 1 more
    layers: tuple[Layers, ...] = ()  # further layers of each eye; () for none
    takes_hidden: bool = False  # whether the server leaves out what requests say is hidden of their views
    takes_session: bool = False  # whether requests may have a session
    began: int = 0  # the last 16 bits of the id that it began with
    takes_fovea: bool = False  # whether requests may have a fovea
    grids: tuple[FoveaGrid, ...] = ()  # the client's, of each eye's foveated pictures
    takes_inputs: bool = False  # whether requests may have inputs: what is drawn reacts to them

    @property
    def is_coded(self) -> bool:
        return any(isinstance(picture, bytes) for picture in (*self.colours, *self.inverse_depths))

    @property
    def size(self) -> Size:
        for picture in (self.inverse_depths[0], self.colours[0]):
            if not isinstance(picture, bytes):
                return picture.shape[1], picture.shape[0]
        return self.coded_size

    def light(self, eye: int) -> NDArray[np.float16]:
        """Return one eye's decoded colour as linear light, for programs without a GPU."""
        colour = self.colours[eye]
        assert not isinstance(colour, bytes)
        if colour.dtype != np.uint8:
            return colour.astype(np.float16, copy=False)
        light = linear_from_srgb(colour).astype(np.float16)
        light[..., 3] = colour[..., 3] > 0
        return light

    def inverse_depth(self, eye: int) -> NDArray[np.float32]:
        """Return one eye's decoded depth in 1/m, likewise."""
        depth = self.inverse_depths[eye]
        assert not isinstance(depth, bytes)
        return depth.numbers() if isinstance(depth, DepthCodes) else depth

    @property
    def bytes(self) -> int:
        """Bytes of the pictures, further layers included."""
        further = (part for of_eye in self.layers for several in of_eye.values() for part in several)
        return sum(map(length_of, (*self.colours, *self.inverse_depths))) + sum(map(parts.length_of, further))

    @property
    def is_finite(self) -> bool:
        return all(
            not isinstance(picture, np.ndarray) or _is_finite(picture)
            for picture in (*self.colours, *self.inverse_depths)
        )


@attrs.frozen
class Refusal:
    number: int
    text: str


@attrs.frozen
class Unchanged:
    number: int


Message = Ask | FrameMessage | Refusal | Unchanged
Piece = bytes | NDArray[Any]  # of a message: bytes, or an array whose bytes follow in the order of its indices


def request_bytes(eyes: int) -> int:
    return _HEAD.size + _ASK.size + _POSE.size + eyes * _EYE.size


_MOST_EYES = int(bounds.EYES.most)
LARGEST_ASK = request_bytes(_MOST_EYES) + parts.most_wanted_bytes(int(bounds.LAYERS.most), _MOST_EYES)
LARGEST_ASK += parts.AREA_BYTES * _MOST_EYES + _SESSION_HEAD.size + _FATE.size * MOST_FATES
LARGEST_ASK += _LOOK.size + _COUNT.size + _INPUT.size * MOST_INPUTS


def length_of(piece: Picture) -> int:
    return len(piece) if isinstance(piece, bytes) else piece.nbytes


def _is_finite(picture: NDArray[Any]) -> bool:
    # By extremes alone, which take no other picture; of halves by their bits: np.isfinite takes
    # 41 ms for 1344x1600. What is above infinity's bits is no number.
    if picture.dtype == np.float16:
        most = picture.view(np.int16).max(initial=0), picture.view(np.uint16).max(initial=0)
        return bool(most[0] < _HALF_INFINITE and most[1] < 0x8000 + _HALF_INFINITE)
    return picture.dtype.kind != "f" or bool(
        np.isfinite(picture.max(initial=0)) and np.isfinite(picture.min(initial=0))
    )


_HALF_INFINITE = 0x7C00


def token_of(secret: str) -> bytes:
    return hashlib.sha256(secret.encode()).digest() if secret else _NO_TOKEN


def encode(message: Message) -> bytes:
    return b"".join(piece if isinstance(piece, bytes) else piece.tobytes() for piece in pieces_of(message))


def copied(message: Message) -> memoryview:
    """Return the bytes of a message in memory of its own; each picture is copied once."""
    pieces = pieces_of(message)
    whole, at = np.empty(sum(map(length_of, pieces)), np.uint8), 0
    for piece in pieces:
        to = whole[at : at + length_of(piece)]
        if isinstance(piece, np.ndarray):
            # In one go, whatever the order of its rows is in memory.
            to.view(piece.dtype).reshape(piece.shape)[...] = piece
        else:
            to[...] = np.frombuffer(piece, np.uint8)
        at += len(to)
    return whole.data


def pieces_of(message: Message) -> list[Piece]:
    kind, body = _PACKERS[type(message)](message)
    return [_HEAD.pack(MAGIC, VERSION, kind, _HEAD.size + sum(map(length_of, body))), *body]


def _packed_ask(ask: Ask) -> tuple[int, list[Piece]]:
    hides, wish = any(view.hidden is not None for view in ask.views), ask.wish
    layers, quality = 0 if ask.wanted is None else len(ask.wanted.layers), 0 if wish.crf is None else 1 + wish.crf
    has = _HIDES * hides + _SESSION * (ask.session is not None)
    has += _FOVEA * (ask.fovea is not None) + _INPUTS * bool(ask.inputs)
    stated = (ask.number, ask.sent_ns, ask.time_ns, ask.head_ns, ask.received, ask.token, *ask.size, len(ask.views))
    wished = (wish.colour, wish.depth, quality, ask.anew, layers, has)
    body: list[Piece] = [
        _ASK.pack(*stated, *wished, wish.rate_hz, wish.bitrate_mbit, wish.depth_step),
        *(_packed_pose(ask.head), *map(_packed_eye, ask.views)),
    ]
    if ask.wanted is not None:
        body.append(parts.packed_wanted(ask.wanted))
    if hides:
        body += [parts.packed_area(view.hidden, view.fov) for view in ask.views]
    if (own := ask.session) is not None:
        body.append(_SESSION_HEAD.pack(own.number, own.age_ns, own.only_changes, len(own.fates)))
        body += [_FATE.pack(fate.number, fate.arrived, fate.heard_ns) for fate in own.fates]
    if ask.fovea is not None:
        body.append(_LOOK.pack(*(ask.views[0].gaze or AHEAD), ask.fovea.degrees, ask.fovea.rim))
    if ask.inputs:
        body.append(_COUNT.pack(len(ask.inputs)))
    for event in ask.inputs:
        target = event.target.encode("ascii")
        if len(target) > MOST_OF_TARGET:
            raise InputError(f"'{event.target}': expected a name of at most {MOST_OF_TARGET} letters for a network")
        ray = (*event.origin_m, *event.direction)
        body.append(_INPUT.pack(event.time_ns, 1 + ACTIONS.index(event.action), target, *ray))
    return ASK, body


def _packed_frame(it: FrameMessage) -> tuple[int, list[Piece]]:
    numbers = (it.number, it.asked_ns, it.received_ns, it.sent_ns, it.render_ns, it.time_ns)
    heads, contents = parts.packed_layers(it.layers)
    takes = _HIDES * it.takes_hidden + _SESSION * it.takes_session
    takes += _FOVEA * it.takes_fovea + _INPUTS * it.takes_inputs
    formats = _format_of(it.colours[0], it.colour), _format_of(it.inverse_depths[0], it.depth)
    form = (*it.size, len(it.views), *formats, it.begins, it.place, len(heads), takes, it.began)
    pairs = list(zip(it.colours, it.inverse_depths, strict=True))
    lengths = [_LENGTHS.pack(*map(length_of, pair)) for pair in pairs]
    pictures: list[Piece] = []
    for picture in (each for pair in pairs for each in pair):
        pictures += [_STEP.pack(picture.step), picture.codes] if isinstance(picture, DepthCodes) else [picture]
    return FRAME, [_FRAME.pack(*numbers, *form), *map(_packed_eye, it.views), *lengths, *heads, *pictures, *contents]


def _format_of(picture: Picture, coded: int) -> int:
    if isinstance(picture, bytes):
        return coded
    if isinstance(picture, DepthCodes):
        return DEPTH_CODES
    formats: dict[str, int] = {"float16": RGBA16F, "uint8": RGBA8, "float32": INVERSE_DEPTH}
    return formats[picture.dtype.name]


def _packed_refusal(message: Refusal) -> tuple[int, list[Piece]]:
    # Whole letters of it.
    text = message.text.encode(errors="replace")[: int(bounds.TEXT.most)].decode(errors="ignore").encode()
    return REFUSAL, [_REFUSAL.pack(message.number, len(text)), text]


_PACKERS: dict[type, Callable[[Any], tuple[int, list[Piece]]]] = {
    Ask: _packed_ask,
    FrameMessage: _packed_frame,
    Refusal: _packed_refusal,
    Unchanged: lambda message: (UNCHANGED, [_ID.pack(message.number)]),
}


def _packed_pose(pose: Pose) -> bytes:
    return _POSE.pack(*pose.position_m.tolist(), *pose.orientation_xyzw.tolist())


def _packed_eye(view: View) -> bytes:
    fov = view.fov
    angles = struct.pack("<4d", fov.left, fov.right, fov.down, fov.up)
    return _packed_pose(view.pose) + _packed_pose(view.head_from_eye) + angles


def decode(data: Data) -> Message:
    """Return the message in these bytes. Errors: Malformed; BadRequest for a request."""
    if len(data) < _HEAD.size:
        raise Malformed(f"{len(data)} bytes: a message has {_HEAD.size} or more")
    magic, version, kind, length = _HEAD.unpack_from(data)
    if magic != MAGIC:
        raise Malformed(f"it begins with {magic!r}: expected {MAGIC!r}")
    if version != VERSION and kind != REFUSAL:
        raise BadRequest(f"version {version}: take programs of the same version, here {VERSION}", data)
    if kind not in _KINDS:
        raise Malformed(f"kind {kind}: expected {', '.join(map(str, _KINDS))}")
    name, read = _KINDS[kind]
    try:
        bounds.MESSAGE.check(length)
        _check_length(data, length)
        return read(data)
    except (struct.error, InputError, ValueError) as error:
        why = f"{name}: {error}"
        raise (BadRequest(why, data) if kind == ASK else Malformed(why)) from error


def _ask(data: Data) -> Ask:
    values = _ASK.unpack_from(data, _HEAD.size)
    number, sent_ns, time_ns, head_ns, received, token, width, height, eyes = values[:9]
    colour, depth, quality, anew, layers, has, rate_hz, mbit, step = values[9:]
    at = _HEAD.size + _ASK.size
    _check_format(number, width, height, eyes)
    bounds.INSTANT.check(sent_ns, time_ns, head_ns)
    bounds.LAYERS.check(layers)
    wanted, end = parts.wanted_from(data, at + _POSE.size + eyes * _EYE.size, layers, eyes)
    hidden_at, session, gaze, fovea, inputs = end, None, None, None, []
    if has & _HIDES:
        end += eyes * parts.AREA_BYTES
    if has & _SESSION:
        of_session, age_ns, only_changes, count = _SESSION_HEAD.unpack_from(data, end)
        bounds.DRAWING.check(age_ns)
        bounds.FATES.check(count)
        begin = end + _SESSION_HEAD.size
        end = begin + count * _FATE.size
        fates = [Fate(of, arrived != 0, heard_ns) for of, arrived, heard_ns in _FATE.iter_unpack(data[begin:end])]
        bounds.INSTANT.check(*(one.heard_ns for one in fates))
        session = Session(of_session, age_ns, only_changes != 0, tuple(fates))
    if has & _FOVEA:
        x, y, z, degrees, rim = _LOOK.unpack_from(data, end)
        bounds.GAZE.check(math.hypot(x, y, z))
        gaze, fovea, end = (x, y, z), Fovea(degrees, rim), end + _LOOK.size
    if has & _INPUTS:
        (count,) = _COUNT.unpack_from(data, end)
        bounds.INPUTS.check(count)
        begin = end + _COUNT.size
        end = begin + count * _INPUT.size
        inputs = [_input(*values) for values in _INPUT.iter_unpack(data[begin:end])]
    _check_length(data, end)
    head, views = _pose(_POSE.unpack_from(data, at)), _views(data, at + _POSE.size, eyes)
    if has & _HIDES:
        areas = [
            bytes(data[begin : begin + parts.AREA_BYTES]) for begin in range(hidden_at, len(data), parts.AREA_BYTES)
        ]
        pairs = zip(views, areas, strict=False)
        views = tuple(attrs.evolve(view, hidden=parts.area_from(area, view.fov)) for view, area in pairs)
    for bound, value in (
        (bounds.QUALITY, quality),
        (bounds.RATE, rate_hz),
        (bounds.BITRATE, mbit),
        (bounds.STEP, step),
    ):
        bound.check(value)
    wish = Wish(colour, depth, quality - 1 if quality else None, rate_hz, mbit, step)
    times = (number, sent_ns, time_ns, head_ns, received)
    asked = (*times, (width, height), head, tuple(looking(views, gaze)), token, wish, anew != 0, wanted, session)
    return Ask(*asked, fovea, tuple(inputs))


def _input(time_ns: int, action: int, target: bytes, *ray: float) -> InputEvent:
    bounds.INSTANT.check(time_ns)
    bounds.ACTION.check(action)
    bounds.COORDINATE.check(*ray[:3])
    bounds.WAY.check(math.hypot(*ray[3:]))
    name = target.rstrip(b"\0").decode("ascii")
    return InputEvent(time_ns, ACTIONS[action - 1], name, (ray[0], ray[1], ray[2]), (ray[3], ray[4], ray[5]))


def _frame(data: Data) -> FrameMessage:
    number, asked_ns, received_ns, sent_ns, render_ns, time_ns, *form = _FRAME.unpack_from(data, _HEAD.size)
    width, height, eyes, colour, depth, begins, place, count, takes, began = form
    _check_format(number, width, height, eyes)
    bounds.INSTANT.check(asked_ns, received_ns, sent_ns, time_ns)
    bounds.DRAWING.check(render_ns)
    if colour not in (*COLOURS, NONE) or depth not in (*DEPTHS, NONE):
        why = f"{INVERSE_DEPTH} to {DEPTHS[-1]} for depth, {NONE} for none"
        raise Malformed(f"formats {colour} and {depth}: expected {RGBA16F} to {COLOURS[-1]} for colour, {why}")
    at = _HEAD.size + _FRAME.size
    views, at = _views(data, at, eyes), at + eyes * _EYE.size
    lengths = [_LENGTHS.unpack_from(data, at + eye * _LENGTHS.size) for eye in range(eyes)]
    heads_at = at + eyes * _LENGTHS.size
    at = heads_at + count * parts.HEAD.size
    layers, end = parts.layers_from(data, heads_at, count, at + sum(map(sum, lengths)), eyes)
    _check_length(data, end)
    bounds.UNPACKED.check(parts.unpacked_bytes(layers))
    colours: list[NDArray[Any] | bytes] = []
    depths: list[Picture] = []
    for of_colour, of_depth in lengths:
        if (colour == NONE and of_colour) or (depth == NONE and of_depth):
            raise Malformed(f"pictures of {of_colour} and {of_depth} bytes in formats {colour} and {depth}: expected 0")
        colours.append(_picture(data, at, of_colour, _COLOURS.get(colour), (height, width, 4)))
        read = _codes if depth == DEPTH_CODES else _picture
        depths.append(read(data, at + of_colour, of_depth, _DEPTHS.get(depth), (height, width)))
        at += of_colour + of_depth
    times = (number, asked_ns, received_ns, sent_ns, render_ns, time_ns)
    rest = (colour, depth, (width, height), begins != 0, place, layers if count else ())
    says = takes & _HIDES != 0, takes & _SESSION != 0, began, takes & _FOVEA != 0, ()
    return FrameMessage(*times, views, tuple(colours), tuple(depths), *rest, *says, takes & _INPUTS != 0)


def _picture(data: Data, at: int, length: int, kind: np.dtype | None, shape: tuple[int, ...]) -> NDArray[Any] | bytes:
    if kind is None:
        return bytes(data[at : at + length])
    count = math.prod(shape)
    if length != count * kind.itemsize:
        raise Malformed(f"a picture of {length} bytes: expected {count * kind.itemsize}")
    return np.frombuffer(data, kind, count, at).reshape(shape)


def _codes(data: Data, at: int, length: int, _: object, shape: tuple[int, ...]) -> DepthCodes:
    if length < _STEP.size:
        raise Malformed(f"a picture of {length} bytes: expected a step before its codes")
    (step,) = _STEP.unpack_from(data, at)
    bounds.CODE_STEP.check(step)
    codes = _picture(data, at + _STEP.size, length - _STEP.size, _CODE, shape)
    assert not isinstance(codes, bytes)
    return DepthCodes(codes, step)


def _refusal(data: Data) -> Refusal:
    number, length = _REFUSAL.unpack_from(data, _HEAD.size)
    at = _HEAD.size + _REFUSAL.size
    bounds.TEXT.check(length)
    _check_length(data, at + length)
    text = bytes(data[at:]).decode()
    # A line of its own in a log, and no control of the terminal that shows it.
    return Refusal(number, "".join(character if character.isprintable() else " " for character in text))


def _unchanged(data: Data) -> Unchanged:
    _check_length(data, _HEAD.size + _ID.size)
    (number,) = _ID.unpack_from(data, _HEAD.size)
    bounds.NUMBER.check(number)
    return Unchanged(number)


_KINDS: dict[int, tuple[str, Callable[[Data], Message]]] = {
    ASK: ("request", _ask),
    FRAME: ("frame", _frame),
    REFUSAL: ("refusal", _refusal),
    UNCHANGED: ("no change", _unchanged),
}


def _check_format(number: int, width: int, height: int, eyes: int) -> None:
    bounds.NUMBER.check(number)
    bounds.SIDE.check(width, height)
    bounds.EYES.check(eyes)


def _check_length(data: Data, length: int) -> None:
    if len(data) != length:
        raise Malformed(f"{len(data)} bytes: expected {length}")


def _pose(numbers: Sequence[float]) -> Pose:
    bounds.COORDINATE.check(*numbers[:3])
    bounds.LENGTH.check(math.hypot(*numbers[3:7]))
    return Pose(numbers[:3], numbers[3:7])


def _views(data: Data, at: int, eyes: int) -> tuple[View, ...]:
    found = []
    for eye in range(eyes):
        numbers = _EYE.unpack_from(data, at + eye * _EYE.size)
        found.append(View(_pose(numbers[:7]), parts.fov_of(*numbers[14:]), _pose(numbers[7:14])))
    return tuple(found)
