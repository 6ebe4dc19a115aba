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

from hmdwarp.colour import srgb8_from_linear
from hmdwarp.errors import InputError
from hmdwarp.geometry import Fov, Fovea, FoveaGrid, Hidden, Pose, View, looking
from hmdwarp.link.codec import Undecodable
from hmdwarp.pipeline.feed_layers import grids_of
from hmdwarp.scenes import InputEvent
from hmdwarp.sources.feed.bounds import BOUNDS
from hmdwarp.sources.feed.message import (
    DEPTH_CODES,
    DEPTH_EXACT,
    DEPTH_VIDEO,
    H264,
    HEVC,
    INVERSE_DEPTH,
    MOST_BYTES,
    NONE,
    Ask,
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
    token_of,
)
from hmdwarp.sources.feed.parts import BadPart, Packed, Wanted, packed

from . import foreign

HEAD = Pose((0.1, 1.6, -1e-9), (0.1, 0.2, 0.3, 0.9))
VIEWS = tuple(View(HEAD @ Pose((x, 0, 0)), Fov(-0.8, 0.7, -0.6, 0.65), Pose((x, 0, 0))) for x in (-0.03, 0.03))
ASK = Ask(7, -5, 2**62, 12, 6, (4, 3), HEAD, VIEWS, token_of("secret"))
RNG = np.random.default_rng(1)
FRAME = FrameMessage(
    7,
    1,
    2,
    3,
    4,
    5,
    VIEWS,
    tuple(RNG.random((3, 4, 4)).astype(np.float16) for _ in VIEWS),
    tuple(RNG.random((3, 4)).astype(np.float32) for _ in VIEWS),
)

BYTES = attrs.evolve(FRAME, colours=tuple(RNG.integers(0, 256, (3, 4, 4), np.uint8) for _ in VIEWS))

CODED = attrs.evolve(
    FRAME,
    colours=(b"colour", b"of two"),
    inverse_depths=(b"depth", b""),
    colour=HEVC,
    depth=DEPTH_EXACT,
    coded_size=(4, 3),
    begins=False,
    place=9,
)

WANTED = Wanted((("velocity", 1), ("peeled", 2)), (4, 2), tuple(view.fov for view in VIEWS))
OF_EYE = {
    "velocity": [RNG.random((3, 4, 4)).astype(np.float16)],
    "ids": [RNG.integers(0, 9, (3, 4), np.uint16), RNG.random((9, 16))],
    "peeled": [packed(RNG.random((3, 4, 4)).astype(np.float16)), packed(RNG.random((3, 4)).astype(np.float32))],
}
LAYERED = attrs.evolve(FRAME, layers=(OF_EYE, {name: OF_EYE[name] for name in ("ids",)}))


def same_view(a: View, b: View) -> bool:
    poses = ((a.pose, b.pose), (a.head_from_eye, b.head_from_eye))
    exact = all(
        (p.position_m == q.position_m).all() and (p.orientation_xyzw == q.orientation_xyzw).all() for p, q in poses
    )
    return exact and a.fov == b.fov


def test_a_request_comes_back_bit_for_bit():
    back = decode(encode(ASK))
    assert isinstance(back, Ask)
    plain = ("number", "sent_ns", "time_ns", "head_ns", "received", "size", "token")
    assert [getattr(back, name) for name in plain] == [getattr(ASK, name) for name in plain]
    assert all(map(same_view, back.views, VIEWS))


def test_a_wish_comes_back_with_the_field_of_each_eye_and_every_row_of_settings():
    rows = ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0))
    fovs = (VIEWS[0].fov, Fov(-0.5, 0.9, -0.4, 0.3))
    wanted = Wanted((("points", rows), ("peeled", 2), ("difference", ((0.25,),))), (5, 2), fovs)
    assert decode(encode(attrs.evolve(ASK, wanted=wanted))).wanted == wanted


def test_a_packed_part_is_as_wide_and_high_as_it_was():
    for kind, shape in ((np.float16, (3, 5, 4)), (np.float32, (5, 3)), (np.uint8, (1, 7))):
        numbers = RNG.integers(0, 200, shape).astype(kind)
        back = packed(numbers)
        assert back.size == shape[1::-1] and back.numbers().dtype == kind
        np.testing.assert_array_equal(back.numbers(), numbers)


def test_inputs_come_back_bit_for_bit_behind_whatever_else_there_is():
    inputs = (
        InputEvent(-(2**62), "push", "ball", (1e-300, -1e9, 0.1), (0.1 + 0.2, 1e-9, 0.0)),
        InputEvent(2**62, "release", "a" * 16, direction=(0.0, 3e8, -1.0)),
        InputEvent(0, "switch"),
    )
    for session in (None, Session(3, fates=(Fate(1, True, 5),))):
        back = decode(encode(attrs.evolve(ASK, session=session, inputs=inputs)))
        assert (back.inputs, back.session) == (inputs, session)
    with pytest.raises(InputError, match="at most 16 letters"):
        encode(attrs.evolve(ASK, inputs=(InputEvent(0, "push", "a" * 17),)))
    says = decode(encode(attrs.evolve(FRAME, takes_inputs=True)))
    assert says.takes_inputs and not says.takes_session and not decode(encode(FRAME)).takes_inputs


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        ({"action": 0}, "action of an input 0"),
        ({"action": 5}, "action of an input 5"),
        ({"time_ns": 2**62 + 1}, "instant"),
        ({"place": (math.nan, 0, 0)}, "coordinate"),
        ({"way": (0.0, 0.0, 0.0)}, "direction of an input 0"),
        ({"way": (math.inf, 0.0, 0.0)}, "direction of an input inf"),
        ({"name": b"\xff"}, "ascii"),
    ],
)
def test_an_input_that_cannot_be_is_malformed(wrong, why):
    with pytest.raises(BadRequest, match=why):
        decode(foreign.request(1, inputs=(foreign.acted(), foreign.acted(**wrong))))


def test_a_hidden_area_comes_back_and_hides_nothing_that_is_seen():
    wide, size = VIEWS[0].fov.guarded(1.2, (640, 400))
    circle = [(0.6 * np.cos(a), 0.5 * np.sin(a)) for a in np.linspace(0, 2 * np.pi, 90)]
    around = tuple((3 * x, 3 * y) for x, y in circle) + tuple(reversed(circle))
    view = View(HEAD, VIEWS[0].fov, hidden=Hidden((around,), VIEWS[0].fov)).within(wide)
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


@pytest.mark.parametrize("rows", [(0, 0), (200, 100)])
def test_a_hidden_area_that_leaves_nothing_is_refused(rows):
    view = attrs.evolve(VIEWS[0], hidden=Hidden((((-1, -1), (0, -1), (-1, 0)),), VIEWS[0].fov))
    data = encode(attrs.evolve(ASK, views=(view, view)))
    with pytest.raises(BadRequest, match="leaves nothing to see"):
        decode(data[:-128] + bytes(rows) * 64)


GAZE = (0.48, -0.6, -0.64)


def test_a_gaze_comes_back_bit_for_bit_and_without_one_it_is_straight_ahead():
    asked = attrs.evolve(ASK, views=tuple(looking(VIEWS, GAZE)), fovea=Fovea(30.5, 8))
    back = decode(encode(asked))
    assert back.fovea == asked.fovea and [view.gaze for view in back.views] == [GAZE, GAZE]
    assert decode(encode(attrs.evolve(ASK, fovea=Fovea()))).views[0].gaze == (0, 0, -1)
    assert decode(encode(ASK)).fovea is None and decode(encode(ASK)).views[0].gaze is None
    assert decode(encode(attrs.evolve(FRAME, takes_fovea=True))).takes_fovea and not decode(encode(FRAME)).takes_fovea


@pytest.mark.parametrize(
    ("look", "says"),
    [
        ((0, 0, 0, 40, 4), "length of a gaze"),
        ((1e200, 0, -1, 40, 4), "length of a gaze"),
        ((float("nan"), 0, -1, 40, 4), "length of a gaze"),
        ((*GAZE, 0, 4), "sharp region of 0 degrees"),
        ((*GAZE, float("nan"), 4), "sharp region of nan degrees"),
        ((*GAZE, 180, 4), "sharp region of 180 degrees"),
        ((*GAZE, 40, 1), "rim of 1 pixels"),
        ((*GAZE, 40, 2**32 - 1), "rim of 4294967295 pixels"),
    ],
)
def test_a_fovea_that_is_none_is_refused(look, says):
    data = encode(attrs.evolve(ASK, fovea=Fovea()))
    with pytest.raises(BadRequest, match=says):
        decode(data[:-36] + struct.pack("<4dI", *look))
    with pytest.raises(BadRequest):
        decode(data[:-1])


SMALL = FoveaGrid((13, 9), 4, (2, 1), (1, 1))  # of which 4 x 3 pixels come


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({0: 14}, "sharp rectangle"),  # columns more than come
        ({3: 3, 4: 0}, "sharp rectangle"),
        ({3: -1}, "sharp rectangle"),
        ({2: 0.5}, "sharp rectangle"),
        ({2: 2**40}, "sharp rectangle"),
        ({5: float("nan")}, "sharp rectangle"),
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


def test_a_frame_comes_back_bit_for_bit():
    back = decode(encode(FRAME))
    assert isinstance(back, FrameMessage)
    assert back.size == (4, 3) and (back.number, back.time_ns) == (7, 5)
    for ours, theirs in zip(
        (*FRAME.colours, *FRAME.inverse_depths), (*back.colours, *back.inverse_depths), strict=True
    ):
        np.testing.assert_array_equal(ours, theirs)
    assert all(map(same_view, back.views, VIEWS))


def test_bytes_of_colour_come_back_and_are_srgb():
    colours = BYTES.colours
    colours[0][0, :2, 3] = 0, 1
    back = decode(encode(BYTES))
    assert isinstance(back, FrameMessage)
    np.testing.assert_array_equal(back.colours[1], colours[1])
    np.testing.assert_array_equal(srgb8_from_linear(back.light(0)[..., :3]), colours[0][..., :3])
    assert back.light(0)[0, :2, 3].tolist() == [0, 1] and (back.light(1)[..., 3] == (colours[1][..., 3] > 0)).all()


def test_depth_in_16_bits_comes_back_and_is_its_step_times_the_codes():
    codes = RNG.integers(0, 65536, (3, 4), np.uint16)
    codes[0, :3] = (0, 65534, 65535)
    sent = attrs.evolve(BYTES, inverse_depths=(DepthCodes(codes, 0.25), DepthCodes(codes[::-1], 0.0)))
    data = encode(sent)
    back = decode(data)
    assert back.depth == DEPTH_CODES and back.bytes == 2 * (4 * 12 + 4 + 2 * 12) and back.is_finite
    np.testing.assert_array_equal(back.inverse_depths[1].codes, codes[::-1])
    assert back.inverse_depth(0)[0, :3].tolist() == [0, 0.25 * 65534, -1] and back.inverse_depth(1).max() == 0
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


def test_coded_pictures_and_the_wish_for_them_come_back_bit_for_bit():
    wish = Wish(H264, DEPTH_VIDEO, 0, 72.0, 12.5, 2.0**-10)
    back = decode(encode(attrs.evolve(ASK, wish=wish, anew=True)))
    assert (back.wish, back.anew) == (wish, True)
    assert decode(encode(attrs.evolve(ASK, wish=attrs.evolve(wish, crf=None)))).wish.crf is None
    coded = decode(encode(CODED))
    plain = ("colours", "inverse_depths", "colour", "depth", "size", "begins", "place")
    assert [getattr(coded, name) for name in plain] == [getattr(CODED, name) for name in plain]
    # One of the two coded: an engine with a video encoder and raw depth.
    mixed = decode(encode(attrs.evolve(CODED, inverse_depths=FRAME.inverse_depths)))
    assert mixed.colours == CODED.colours and mixed.depth == INVERSE_DEPTH
    np.testing.assert_array_equal(mixed.inverse_depths[1], FRAME.inverse_depths[1])


def test_a_picture_that_is_left_out_has_no_bytes():
    neither = attrs.evolve(CODED, colours=(b"", b""), inverse_depths=(b"", b""), colour=NONE, depth=NONE)
    back = decode(encode(neither))
    assert (back.colour, back.depth, back.bytes, back.size) == (NONE, NONE, 0, (4, 3))
    no_depth = decode(encode(attrs.evolve(neither, colours=FRAME.colours)))
    assert no_depth.size == (4, 3) and no_depth.inverse_depths == (b"", b"")
    with pytest.raises(Malformed, match="6 and 0 bytes in formats 255"):
        decode(encode(attrs.evolve(neither, colours=CODED.colours)))
    with pytest.raises(Malformed, match="formats 255 and 6"):
        decode(encode(attrs.evolve(neither, depth=6)))


def test_further_layers_and_the_wish_for_them_come_back_bit_for_bit():
    asked = decode(encode(attrs.evolve(ASK, wanted=WANTED)))
    assert asked.wanted == WANTED
    back = decode(encode(LAYERED))
    assert [list(of_eye) for of_eye in back.layers] == [list(OF_EYE), ["ids"]]
    for name, parts in OF_EYE.items():
        for ours, theirs in zip(parts, back.layers[0][name], strict=True):
            assert type(ours) is type(theirs)
            sent, came = (content.numbers() if isinstance(content, Packed) else content for content in (ours, theirs))
            np.testing.assert_array_equal(sent, came)
            assert sent.dtype == came.dtype
    assert back.bytes == LAYERED.bytes > FRAME.bytes
    np.testing.assert_array_equal(back.inverse_depths[1], FRAME.inverse_depths[1])


def test_a_packed_part_of_another_length_or_damaged_is_refused():
    whole = packed(np.zeros((3, 4), np.uint16))
    for data in (whole.data[:-1], whole.data + b"0", b"", zlib.compress(bytes(1 << 20)), zlib.compress(bytes(8))):
        tracemalloc.start()
        with pytest.raises(BadPart):
            attrs.evolve(whole, data=data).numbers()
        assert tracemalloc.get_traced_memory()[1] < 1 << 16
        tracemalloc.stop()


def test_parts_that_would_be_too_much_as_numbers_are_refused():
    parts = [Packed(1, (8192, 8192), b"")] * 2
    with pytest.raises(Malformed, match="as numbers"):
        decode(encode(attrs.evolve(FRAME, layers=({"peeled": parts}, {}))))


def test_a_request_in_another_version_is_refused_by_its_id_and_a_refusal_is_read_in_any():
    data = bytearray(encode(ASK))
    data[4:6] = struct.pack("<H", 4)
    with pytest.raises(BadRequest, match="version 4") as told:
        decode(bytes(data))
    assert told.value.number == ASK.number
    data = bytearray(encode(Refusal(7, "no")))
    data[4:6] = struct.pack("<H", 4)
    assert decode(bytes(data)) == Refusal(7, "no")


def test_a_refusal_is_one_printable_line():
    back = decode(encode(Refusal(3, "no\n\x1b[31m room" + "é" * 10)))
    assert back == Refusal(3, "no  [31m room" + "é" * 10)
    # Too long a one ends with a whole letter.
    assert decode(encode(Refusal(3, "a" + "é" * 300))) == Refusal(3, "a" + "é" * 249)


@pytest.mark.parametrize(
    ("at", "value", "told"),
    [
        (0, b"NOPE", "begins with"),
        (4, struct.pack("<H", 2), "version 2"),
        (6, struct.pack("<H", 9), "kind 9"),
        (8, struct.pack("<I", 12), "expected 12"),
        (8, struct.pack("<I", MOST_BYTES + 1), "expected 12 to 2.29 bytes"),
    ],
)
def test_a_malformed_message_is_refused_with_the_reason(at, value, told):
    data = bytearray(encode(ASK))
    data[at : at + len(value)] = value
    with pytest.raises(Malformed, match=told):
        decode(bytes(data))


def placed(*place: float) -> tuple[View, ...]:
    return tuple(attrs.evolve(view, pose=Pose(place)) for view in VIEWS)


NARROW = tuple(attrs.evolve(view, fov=Fov(0.5, 0.5 + 9e-5, -0.6, 0.6)) for view in VIEWS)


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"number": 0}, "id 0"),
        ({"sent_ns": -(2**62) - 1}, "instant"),
        ({"time_ns": 2**63 - 1}, "instant"),
        ({"size": (8193, 1)}, "width or height"),
        ({"head": Pose((0, 1e19, 0))}, "coordinate of a position 1e.19: expected -1e.09 to 1e.09 m"),
        ({"views": placed(-1.1e9, 0, 0)}, "coordinate"),
        ({"views": tuple(attrs.evolve(view, head_from_eye=Pose((0, 0, 1e300))) for view in VIEWS)}, "coordinate"),
        ({"views": NARROW}, "field of view from left to right"),
        (
            {"wanted": attrs.evolve(WANTED, layers=(("peeled", 60_000_000),))},
            "amount of a layer 60000000: expected 0, or 1 to 16",
        ),
        ({"wanted": attrs.evolve(WANTED, layers=(("peeled", ((1.0,) * 9,)),))}, "settings 9: expected 1 to 8"),
        ({"wanted": attrs.evolve(WANTED, size=(8193, 8))}, "width or height"),
        ({"wanted": attrs.evolve(WANTED, fovs=tuple(view.fov for view in NARROW))}, "field of view"),
        ({"wish": Wish(rate_hz=0.5)}, "frames a second 0.5: expected 1 to 1000 Hz"),
        ({"wish": Wish(bitrate_mbit=np.inf)}, "bit rate"),
        ({"wish": Wish(depth_step=np.nan)}, "step"),
    ],
    ids=lambda value: "" if isinstance(value, str) else "-".join(value),
)
def test_a_request_with_a_number_outside_its_bounds_is_refused_by_its_id(wrong, told):
    with pytest.raises(BadRequest, match=told) as found:
        decode(encode(attrs.evolve(ASK, **wrong)))
    assert found.value.number == wrong.get("number", ASK.number)


def test_numbers_at_their_bounds_are_read():
    most = {"size": (8192, 1), "views": placed(1e9, -1e9, 0), "time_ns": 2**62, "sent_ns": -(2**62)}
    wanted = attrs.evolve(WANTED, layers=(("peeled", 16),))
    assert decode(encode(attrs.evolve(ASK, **most, wanted=wanted))).wanted == wanted


@pytest.mark.parametrize(
    "wrong",
    [{"views": placed(0, 1e300, 0)}, {"views": NARROW}, {"sent_ns": 2**63 - 1}, {"render_ns": -1}],
    ids="-".join,
)
def test_a_frame_with_a_number_outside_its_bounds_is_malformed(wrong):
    with pytest.raises(Malformed, match="expected"):
        decode(encode(attrs.evolve(FRAME, **wrong)))


def test_the_bounds_are_those_that_the_documentation_lists(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[3] / "docs")
    listed = importlib.import_module("pages").text_of("bounds").splitlines()
    assert listed == [f"- {bound.what}: {bound.text}" for bound in BOUNDS]


def test_a_frame_that_claims_more_than_it_has_takes_no_memory():
    data = bytearray(encode(FRAME))
    at = data.index(struct.pack("<II", 4, 3))
    data[at : at + 8] = struct.pack("<II", 8192, 8192)
    tracemalloc.start()
    with pytest.raises(Malformed, match="expected"):
        decode(bytes(data))
    assert tracemalloc.get_traced_memory()[1] < 1 << 20
    tracemalloc.stop()


def test_broken_messages_are_read_or_refused():
    rng = random.Random(19)
    asks = [encode(ASK), encode(attrs.evolve(ASK, wanted=WANTED))]
    whole = [*asks, *map(encode, (FRAME, BYTES, CODED, LAYERED)), encode(Refusal(1, "why"))]
    refused = 0
    for _ in range(100_000):
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
    assert refused > 10_000
