"""Messages: what is encoded comes back bit for bit; whatever else comes in is refused."""

import importlib
import math
import random
import struct
import tracemalloc
import zlib
from pathlib import Path

import attrs
import numpy as np
import pytest

from hmdwarp.base import InputError, srgb8_from_linear
from hmdwarp.geometry import Fov, Fovea, FoveaGrid, Hidden, Pose, looking
from hmdwarp.link.codec import Undecodable
from hmdwarp.pipeline.feed_coding import FeedDecoder, FeedEncoder, depth_error, grids_of
from hmdwarp.scenes import InputEvent
from hmdwarp.sources.feed.bounds import BOUNDS
from hmdwarp.sources.feed.message import (
    AV1,
    DEPTH_CODES,
    DEPTH_EXACT,
    DEPTH_VIDEO,
    H264,
    HEVC,
    INVERSE_DEPTH,
    MOST_BYTES,
    NONE,
    RGBA8,
    VP9,
    BadRequest,
    DepthCodes,
    Fate,
    FrameMessage,
    Malformed,
    Refusal,
    Session,
    Wish,
    decode,
    encode,
)
from hmdwarp.sources.feed.parts import BadPart, Packed, Wanted, packed

from . import foreign
from .exchange import ASK, BYTES, CODED, FRAME, HEAD, LAYERED, RNG, VIEWS, WANTED


def flat(value):
    """Everything in a message, to be compared to the last bit."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, tuple | list):
        return tuple(map(flat, value))
    if isinstance(value, dict):
        return {name: flat(one) for name, one in value.items()}
    if attrs.has(type(value)):
        # Of raw pictures these say what the arrays do.
        derived = {"colour", "depth", "coded_size"}
        names = {field.name for field in attrs.fields(type(value))} - derived
        return type(value).__name__, {name: flat(getattr(value, name)) for name in names}
    return value


GAZE = (0.48, -0.6, -0.64)
INPUTS = (
    InputEvent(-(2**62), "push", "ball", (1e-300, -1e9, 0.1), (0.1 + 0.2, 1e-9, 0.0)),
    InputEvent(2**62, "release", "a" * 16, direction=(0.0, 3e8, -1.0)),
    InputEvent(0, "switch"),
)
ROWS = ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0))
OF_ROWS = Wanted(
    (("points", ROWS), ("peeled", 2), ("difference", ((0.25,),))), (5, 2), (VIEWS[0].fov, Fov(-0.5, 0.9, -0.4, 0.3))
)
STEPS = RNG.integers(0, 65536, (3, 4), np.uint16)
WISH = Wish(H264, DEPTH_VIDEO, 0, 72.0, 12.5, 2.0**-10)
MOST = attrs.evolve(WANTED, layers=(("peeled", 16),))
REQUESTS = {
    "plain": {},
    "coded": {"wish": WISH, "anew": True},
    "any quality": {"wish": attrs.evolve(WISH, crf=None)},
    "layers": {"wanted": WANTED},
    "layers of rows": {"wanted": OF_ROWS},
    "inputs": {"inputs": INPUTS},
    "inputs and fates": {"inputs": INPUTS, "session": Session(3, fates=(Fate(1, True, 5),))},
    "gaze": {"views": tuple(looking(VIEWS, GAZE)), "fovea": Fovea(30.5, 8)},
    "at their bounds": {"size": (8192, 1), "time_ns": 2**62, "sent_ns": -(2**62), "wanted": MOST},
}
NEITHER = attrs.evolve(CODED, colours=(b"", b""), inverse_depths=(b"", b""), colour=NONE, depth=NONE)
IN_STEPS = attrs.evolve(BYTES, inverse_depths=(DepthCodes(STEPS, 0.25), DepthCodes(STEPS[::-1].copy(), 0.0)))
# With the formats that are told.
FRAMES = {
    "halves": (FRAME, 1, INVERSE_DEPTH),
    "bytes": (BYTES, RGBA8, INVERSE_DEPTH),
    "depth in 16 bits": (IN_STEPS, RGBA8, DEPTH_CODES),
    "coded": (CODED, HEVC, DEPTH_EXACT),
    "neither": (NEITHER, NONE, NONE),
    # An engine with a video encoder and raw depth.
    "coded colour": (attrs.evolve(CODED, inverse_depths=FRAME.inverse_depths), HEVC, INVERSE_DEPTH),
    "no depth": (attrs.evolve(NEITHER, colours=FRAME.colours), 1, NONE),
    "layers": (LAYERED, 1, INVERSE_DEPTH),
    "inputs": (attrs.evolve(FRAME, takes_inputs=True), 1, INVERSE_DEPTH),
    "fovea": (attrs.evolve(FRAME, takes_fovea=True), 1, INVERSE_DEPTH),
    "session": (attrs.evolve(FRAME, takes_session=True), 1, INVERSE_DEPTH),
}


@pytest.mark.parametrize("kind", REQUESTS)
def test_a_request_comes_back_bit_for_bit(kind):
    asked = attrs.evolve(ASK, **REQUESTS[kind])
    back = decode(encode(asked))
    assert flat(back) == flat(asked) and back.wish == asked.wish
    assert (kind == "gaze") == (back.fovea is not None) == (back.views[0].gaze is not None)


@pytest.mark.parametrize("kind", FRAMES)
def test_a_frame_comes_back_bit_for_bit(kind):
    sent, colour, depth = FRAMES[kind]
    back = decode(encode(sent))
    assert flat(back) == flat(sent) and (back.colour, back.depth, back.size) == (colour, depth, (4, 3))
    assert back.bytes == sent.bytes and (back.bytes == 0) == (kind == "neither")


def test_colour_and_depth_of_a_frame_are_light_and_inverse_depth():
    codes = np.array([[0, 65534, 65535, 1]] * 3, np.uint16)
    colours = (BYTES.colours[0].copy(), BYTES.colours[1])
    colours[0][0, :2, 3] = 0, 1
    sent = attrs.evolve(BYTES, colours=colours, inverse_depths=(DepthCodes(codes, 0.25), DepthCodes(codes, 0.0)))
    data = encode(sent)
    back = decode(data)
    np.testing.assert_array_equal(srgb8_from_linear(back.light(0)[..., :3]), colours[0][..., :3])
    assert back.light(0)[0, :2, 3].tolist() == [0, 1] and (back.light(1)[..., 3] == (colours[1][..., 3] > 0)).all()
    assert back.inverse_depth(0)[0, :3].tolist() == [0, 0.25 * 65534, -1] and back.inverse_depth(1).max() == 0
    assert back.bytes == 2 * (4 * 12 + 4 + 2 * 12) and back.is_finite
    at = data.index(struct.pack("<f", 0.25))
    for step in (-1.0, np.nan, np.inf, 2.0**112):
        with pytest.raises(Malformed, match="step of depth in 16 bits"):
            decode(data[:at] + struct.pack("<f", step) + data[at + 4 :])


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("name", ["colours", "inverse_depths"])
def test_numbers_that_are_not_finite_show(name, bad):
    pictures = [picture.copy() for picture in getattr(FRAME, name)]
    extremes = attrs.evolve(FRAME, **{name: (pictures[0], pictures[1] * 0 + np.finfo(pictures[1].dtype).max)})
    assert extremes.is_finite and attrs.evolve(extremes, **{name: [-one for one in getattr(extremes, name)]}).is_finite
    pictures[1][2, 1] = bad
    assert not attrs.evolve(FRAME, **{name: pictures}).is_finite


def test_packed_parts_are_what_they_were_or_refused():
    for kind, shape in ((np.float16, (3, 5, 4)), (np.float32, (5, 3)), (np.uint8, (1, 7))):
        numbers = RNG.integers(0, 200, shape).astype(kind)
        back = packed(numbers)
        assert back.size == shape[1::-1] and flat(back.numbers()) == flat(numbers)
    whole = packed(np.zeros((3, 4), np.uint16))
    for data in (whole.data[:-1], whole.data + b"0", b"", zlib.compress(bytes(1 << 20)), zlib.compress(bytes(8))):
        tracemalloc.start()
        with pytest.raises(BadPart):
            attrs.evolve(whole, data=data).numbers()
        assert tracemalloc.get_traced_memory()[1] < 1 << 16
        tracemalloc.stop()


def test_a_hidden_area_comes_back_and_hides_nothing_that_is_seen():
    wide, size = VIEWS[0].fov.guarded(1.2, (640, 400))
    circle = [(0.6 * np.cos(a), 0.5 * np.sin(a)) for a in np.linspace(0, 2 * np.pi, 90)]
    around = tuple((3 * x, 3 * y) for x, y in circle) + tuple(reversed(circle))
    view = attrs.evolve(VIEWS[0], pose=HEAD, hidden=Hidden((around,), VIEWS[0].fov)).within(wide)
    asked = attrs.evolve(ASK, views=(view, VIEWS[1]))
    back = decode(encode(asked))
    wanted, found = view.seen(size), back.views[0].seen(size)
    assert 0.3 < wanted.mean() < 0.9 and found[wanted].all()
    # A column of 64 has the rows that any part of it sees, to a 255th.
    assert found.mean() < wanted.mean() + 0.04
    assert back.views[1].hidden is None
    # The rows of an area are found once.
    assert decode(encode(attrs.evolve(asked, number=8))).views[0].hidden is back.views[0].hidden
    assert len(encode(asked)) == len(encode(ASK)) + 256 and decode(encode(ASK)).views[0].hidden is None


SMALL = FoveaGrid((13, 9), 4, (2, 1), (1, 1))  # of which 4 x 3 pixels come


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({0: 14}, "sharp rectangle"),  # columns more than come
        *((wrong, "sharp rectangle") for wrong in ({3: 3, 4: 0}, {3: -1}, {2: 0.5}, {2: 2**40}, {5: float("nan")})),
        (None, "0 grids"),
    ],
)
def test_a_grid_that_does_not_fit_its_pictures_is_left_out(changed, says):
    numbers = SMALL.numbers()
    frame = attrs.evolve(FRAME, layers=tuple({"foveated": [numbers]} for _ in VIEWS))
    assert grids_of(decode(encode(frame)), SMALL.size) == (SMALL, SMALL)
    with pytest.raises(Undecodable, match=r"expected \(16, 16\)"):
        grids_of(frame, (16, 16))
    for place, value in (changed or {}).items():
        numbers[0, place] = value
    with pytest.raises(Undecodable, match=says):
        grids_of(decode(encode(frame if changed else FRAME)), SMALL.size)


def test_a_refusal_is_one_printable_line_in_any_version():
    back = decode(encode(Refusal(3, "no\n\x1b[31m room" + "é" * 10)))
    assert back == Refusal(3, "no  [31m room" + "é" * 10)
    # Too long a one ends with a whole letter.
    assert decode(encode(Refusal(3, "a" + "é" * 300))) == Refusal(3, "a" + "é" * 249)
    assert decode(put(encode(Refusal(7, "no")), 4, struct.pack("<H", 4))) == Refusal(7, "no")


# --- what is refused ---


def put(data: bytes, at: int, value: bytes) -> bytes:
    return data[:at] + value + data[at % len(data) + len(value) :]


def placed(*place: float):
    return tuple(attrs.evolve(view, pose=Pose(place)) for view in VIEWS)


def looks(*look: float) -> bytes:
    return put(encode(attrs.evolve(ASK, fovea=Fovea())), -36, struct.pack("<4dI", *look))


def hiding(*rows: int) -> bytes:
    view = attrs.evolve(VIEWS[0], hidden=Hidden((((-1, -1), (0, -1), (-1, 0)),), VIEWS[0].fov))
    return encode(attrs.evolve(ASK, views=(view, view)))[:-128] + bytes(rows) * 64


def acted(**wrong) -> bytes:
    return foreign.request(ASK.number, inputs=(foreign.acted(), foreign.acted(**wrong)))


NARROW = tuple(attrs.evolve(view, fov=Fov(0.5, 0.5 + 9e-5, -0.6, 0.6)) for view in VIEWS)
FAR = tuple(attrs.evolve(view, head_from_eye=Pose((0, 0, 1e300))) for view in VIEWS)
NAN = float("nan")
# A request, by what is wrong with it or as bytes, and words of its refusal.
REFUSED = [
    ({"number": 0}, "id 0"),
    ({"sent_ns": -(2**62) - 1}, "instant"),
    ({"time_ns": 2**63 - 1}, "instant"),
    ({"size": (8193, 1)}, "width or height"),
    ({"head": Pose((0, 1e19, 0))}, "coordinate of a position 1e.19: expected -1e.09 to 1e.09 m"),
    ({"views": placed(-1.1e9, 0, 0)}, "coordinate"),
    ({"views": FAR}, "coordinate"),
    ({"views": NARROW}, "field of view from left to right"),
    ({"wanted": attrs.evolve(WANTED, layers=(("peeled", 60_000_000),))}, "layer 60000000: expected 0, or 1 to 16"),
    ({"wanted": attrs.evolve(WANTED, layers=(("peeled", ((1.0,) * 9,)),))}, "settings 9: expected 1 to 8"),
    ({"wanted": attrs.evolve(WANTED, size=(8193, 8))}, "width or height"),
    ({"wanted": attrs.evolve(WANTED, fovs=tuple(view.fov for view in NARROW))}, "field of view"),
    ({"wish": Wish(rate_hz=0.5)}, "frames a second 0.5: expected 1 to 1000 Hz"),
    ({"wish": Wish(bitrate_mbit=np.inf)}, "bit rate"),
    ({"wish": Wish(depth_step=np.nan)}, "step"),
    (put(encode(ASK), 4, struct.pack("<H", 4)), "version 4"),
    (looks(0, 0, 0, 40, 4), "length of a gaze"),
    (looks(1e200, 0, -1, 40, 4), "length of a gaze"),
    (looks(NAN, 0, -1, 40, 4), "length of a gaze"),
    (looks(*GAZE, 0, 4), "sharp region of 0 degrees"),
    (looks(*GAZE, NAN, 4), "sharp region of nan degrees"),
    (looks(*GAZE, 180, 4), "sharp region of 180 degrees"),
    (looks(*GAZE, 40, 1), "rim of 1 pixels"),
    (looks(*GAZE, 40, 2**32 - 1), "rim of 4294967295 pixels"),
    (hiding(0, 0), "leaves nothing to see"),
    (hiding(200, 100), "leaves nothing to see"),
    (acted(action=0), "action of an input 0"),
    (acted(action=5), "action of an input 5"),
    (acted(time_ns=2**62 + 1), "instant"),
    (acted(place=(math.nan, 0, 0)), "coordinate"),
    (acted(way=(0.0, 0.0, 0.0)), "direction of an input 0"),
    (acted(way=(math.inf, 0.0, 0.0)), "direction of an input inf"),
    (acted(name=b"\xff"), "ascii"),
]


@pytest.mark.parametrize(("wrong", "told"), REFUSED, ids=lambda value: value if isinstance(value, str) else "")
def test_a_request_that_cannot_be_is_refused_by_its_id(wrong, told):
    with pytest.raises(BadRequest, match=told) as found:
        decode(wrong if isinstance(wrong, bytes) else encode(attrs.evolve(ASK, **wrong)))
    assert found.value.number == (wrong.get("number", ASK.number) if isinstance(wrong, dict) else ASK.number)


LARGER = encode(FRAME).replace(struct.pack("<II", 4, 3), struct.pack("<II", 8192, 8192), 1)
MALFORMED = [
    (LARGER, "expected"),
    (put(encode(ASK), 0, b"NOPE"), "begins with"),
    (put(encode(ASK), 4, struct.pack("<H", 2)), "version 2"),
    (put(encode(ASK), 6, struct.pack("<H", 9)), "kind 9"),
    (put(encode(ASK), 8, struct.pack("<I", 12)), "expected 12"),
    (put(encode(ASK), 8, struct.pack("<I", MOST_BYTES + 1)), "expected 12 to 2.29 bytes"),
    (looks(*GAZE, 40, 4)[:-1], "bytes"),
    ({"views": placed(0, 1e300, 0)}, "expected"),
    ({"views": NARROW}, "expected"),
    ({"sent_ns": 2**63 - 1}, "expected"),
    ({"render_ns": -1}, "expected"),
    (encode(FRAME)[:-1], "expected"),
    ({"layers": ({"peeled": [Packed(1, (8192, 8192), b"")] * 2}, {})}, "as numbers"),
    (encode(attrs.evolve(NEITHER, colours=CODED.colours)), "6 and 0 bytes in formats 255"),
    (encode(attrs.evolve(NEITHER, depth=6)), "formats 255 and 6"),
]


@pytest.mark.parametrize(("wrong", "told"), MALFORMED, ids=lambda value: value if isinstance(value, str) else "")
def test_a_message_that_cannot_be_is_malformed(wrong, told):
    data = wrong if isinstance(wrong, bytes) else encode(attrs.evolve(FRAME, **wrong))
    tracemalloc.start()
    with pytest.raises(Malformed, match=told):
        decode(data)
    assert tracemalloc.get_traced_memory()[1] < 1 << 20, "it takes the memory that it claims"
    tracemalloc.stop()


def test_a_name_that_no_message_holds_is_not_sent():
    with pytest.raises(InputError, match="at most 16 letters"):
        encode(attrs.evolve(ASK, inputs=(InputEvent(0, "push", "a" * 17),)))


def test_the_bounds_are_those_that_the_documentation_lists(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[3] / "docs")
    listed = importlib.import_module("pages").text_of("bounds").splitlines()
    assert listed == [f"- {bound.what}: {bound.text}" for bound in BOUNDS]


def test_broken_messages_are_read_or_refused():
    rng = random.Random(19)
    asks = [encode(ASK), encode(attrs.evolve(ASK, wanted=WANTED))]
    whole = [*asks, *map(encode, (FRAME, BYTES, CODED, LAYERED)), encode(Refusal(1, "why"))]
    refused = 0
    for _ in range(40_000):
        data = bytearray(rng.choice(whole))
        for _ in range(rng.randint(1, 4)):
            data[rng.randrange(len(data))] = rng.choice((0, 1, 127, 128, 255, rng.randrange(256)))
        if rng.random() < 0.3:
            del data[rng.randrange(len(data)) :]
        elif rng.random() < 0.2:
            data += bytes(rng.randrange(20))
        if rng.random() < 0.5 and len(data) >= 12:
            data[8:12] = struct.pack("<I", len(data))
        try:
            decode(bytes(data))
        except Malformed:
            refused += 1
    assert refused > 4_000


SIZE = (96, 80)
STEP = 2.0**-10


def drawn(number: int, *, light: bool = False) -> FrameMessage:
    """A smooth picture that moves, with sky at its top, in bytes unless in light."""
    x, y = np.meshgrid(np.arange(SIZE[0]) / SIZE[0], np.arange(SIZE[1]) / SIZE[1])
    colour = np.stack([(x + number / 50) % 1, y, 0.5 + 0 * x, np.ones_like(x)], axis=-1).astype(np.float16)
    if not light:
        colour = np.dstack([srgb8_from_linear(colour[..., :3]), np.full_like(x, 255, np.uint8)])
    inverse = np.where(y < 0.2, 0, 0.2 + y / 2).astype(np.float32)
    return attrs.evolve(FRAME, number=1 + number, colours=(colour,) * 2, inverse_depths=(inverse,) * 2)


def asked(colour: int, depth: int) -> FeedEncoder:
    return FeedEncoder(attrs.evolve(ASK, size=SIZE, wish=Wish(colour, depth, rate_hz=60.0, depth_step=STEP)))


@pytest.mark.parametrize("colour", [H264, HEVC, VP9, AV1, RGBA8])
@pytest.mark.parametrize("depth", [DEPTH_EXACT, DEPTH_VIDEO, INVERSE_DEPTH])
def test_coded_frames_come_back_in_fewer_bytes(colour, depth):
    encoder, decoder = asked(colour, depth), FeedDecoder()
    for number in range(3):
        frame = drawn(number)
        crossed = encode(encoder.encode(frame))
        of_bytes, both = colour == RGBA8, colour == RGBA8 and depth == INVERSE_DEPTH
        assert len(crossed) <= len(encode(frame)) / (1 if both else 1.5 if of_bytes or depth == INVERSE_DEPTH else 2)
        back = decoder.decode(decode(crossed))
        off = np.abs(back.light(1).astype(float) - frame.light(1))
        # The codecs' own quality, 40 dB and more on a smooth picture; bytes are within half a step.
        assert off.mean() < 0.02
        # Half a step; as video a third on average, and two are rare.
        depth_off = np.abs(back.inverse_depths[0] - frame.inverse_depths[0])
        # What `depth_error` tells the warps is a bound, but for the few of a video.
        assert depth == DEPTH_VIDEO or depth_off.max() <= depth_error(back, encoder.wish) <= STEP
        assert depth_off.mean() <= STEP and (back.inverse_depths[0] == 0).sum() == (frame.inverse_depths[0] == 0).sum()


@pytest.mark.parametrize("largest", [0.9, 3.0, 300.0])
@pytest.mark.parametrize("wished", [H264, RGBA8])
def test_light_beyond_1_is_kept_where_the_picture_is_light_alone(wished, largest):
    """A byte beyond 1 is a 64th of the powers of 2 that it reaches: of 16 a ratio of 2^(1/4)."""
    frame = drawn(0, light=True)
    colour = (frame.colours[0] * (largest, largest, largest, 1)).astype(np.float16)
    of_eye = {"light": [np.zeros((0, 0))]}
    frame = attrs.evolve(frame, colours=(colour,) * 2, layers=(of_eye,) * 2)
    wish = Wish(wished, INVERSE_DEPTH, crf=0 if wished == H264 else None, rate_hz=60.0)
    back = FeedDecoder().decode(decode(encode(FeedEncoder(attrs.evolve(ASK, size=SIZE, wish=wish)).encode(frame))))
    for eye in (0, 1):
        bright, found = frame.light(eye).astype(float)[..., :3] > 1, back.light(eye).astype(float)
        assert (found[..., 3] == 1).all() and bright.any() == (largest > 1)
        if bright.any():
            ratio = found[..., :3][bright] / frame.light(eye)[..., :3].astype(float)[bright]
            # The rounding of a byte and the codec's at its best are half of that each.
            assert np.median(np.abs(np.log2(ratio))) < 1 / 4 and found.max() > largest / 2
        assert np.median(np.abs(found[..., :3] - frame.light(eye)[..., :3])[~bright]) < 0.02


@pytest.mark.parametrize(("colour", "depth"), [(H264, DEPTH_VIDEO), (RGBA8, DEPTH_EXACT)])
def test_a_stream_is_decoded_from_its_beginning_and_again_after_a_lost_frame(colour, depth):
    encoder, decoder = asked(colour, depth), FeedDecoder()
    first, second, _, third = (encoder.encode(drawn(number)) for number in range(4))
    assert len(encode(second)) < len(encode(first)) or colour == RGBA8, "each frame was coded by itself"
    with pytest.raises(Undecodable):
        decoder.decode(second)
    assert decoder.wants_anew and decoder.decode(first)
    if colour == H264:  # whose frames need those before them
        with pytest.raises(Undecodable):
            decoder.decode(third)
        assert decoder.wants_anew
    assert decoder.decode(asked(colour, depth).encode(drawn(4)))
    assert not decoder.wants_anew
