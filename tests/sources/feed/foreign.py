"""Messages of the feed as a program of somebody else writes them: from docs/feed.md alone. Nothing
of hmdwarp is imported, so that what both ends of it have wrong shows."""

from __future__ import annotations

import math
import random
import struct
import time

MAGIC, VERSION = b"HWFD", 3
REQUEST, FRAME, REFUSAL = 1, 2, 3
TURN = (0.0, 0.0, 0.0, 1.0)
HEAD = (0.0, 1.6, 0.0)
ANGLES = (-0.7, 0.7, -0.6, 0.6)
SENT = ("velocity", "ids", "overlay", "transparent", "peeled", "reflection", "cube")
MOST = {"peeled": 16, "reflection": 3}  # how much there may be of layers of which there is more than 1
# What docs/feed.md allows, at its ends and between.
COORDINATES = (0.0, 1.6, -3.0, 1e-300, -5e-324, 1e3, -1e6, 12345.678, 1e9, -1e9)
INSTANTS = (0, 1, -1, 10**9, 10**12, -(10**18), 2**62, -(2**62))
HALF_ANGLES = (1e-4, 1e-3, 0.1, 0.7, 1.2, 1.5, 1.562)
RATES = (1.0, 60.0, 999.999, 1000.0, 1.0000001)
BIT_RATES = (0.0, 0.0, 1e-9, 0.5, 1000.0)
STEPS = (0.0, 0.0, 2**-20, 2**-10, 0.3, 1.0)


# ZMTP 3.0, ZeroMQ's RFC 23: a greeting, commands, and the parts of messages.


def greeting(*, version: bytes = b"\x03\x00", mechanism: bytes = b"NULL", server: int = 0) -> bytes:
    return b"\xff" + bytes(8) + b"\x7f" + version + mechanism.ljust(20, b"\0") + bytes([server]) + bytes(31)


def command(body: bytes) -> bytes:
    return (b"\x04" + bytes([len(body)]) if len(body) < 256 else b"\x06" + struct.pack(">Q", len(body))) + body


def ready(kind: bytes = b"DEALER", more: bytes = b"") -> bytes:
    return command(b"\x05READY\x0bSocket-Type" + struct.pack(">I", len(kind)) + kind + more)


def part(data: bytes, *, more: bool = False) -> bytes:
    return bytes([2 + more]) + struct.pack(">Q", len(data)) + data


def message(kind: int, body: bytes, *, version: int = VERSION, length: int | None = None) -> bytes:
    """A message of that kind; length: what it says of itself."""
    return struct.pack("<4sHHI", MAGIC, version, kind, 12 + len(body) if length is None else length) + body


def pose(place=HEAD, turn=TURN) -> bytes:
    return struct.pack("<7d", *place, *turn)


def eye(place=HEAD, turn=TURN, angles=ANGLES, in_head=(0.0, 0.0, 0.0), head_turn=TURN) -> bytes:
    return pose(place, turn) + pose(in_head, head_turn) + struct.pack("<4d", *angles)


def request(
    number: int,
    *,
    size=(16, 12),
    eyes: tuple[bytes, ...] = (eye(),),
    formats=(0, 0),
    quality: int = 0,
    anew: int = 0,
    layers: tuple[tuple[str, int], ...] = (),
    shown=(16, 12),
    shown_angles=ANGLES,
    rate: float = 60.0,
    mbit: float = 0.0,
    step: float = 0.0,
    sent: int | None = None,
    instants=(0, 0),
    received: int = 0,
    token: bytes = bytes(32),
    head: bytes = pose(),
    inputs: tuple[bytes, ...] = (),
) -> bytes:
    sent = time.monotonic_ns() if sent is None else sent
    start = struct.pack("<Qqqq", number, sent, *instants) + struct.pack("<Q32s", received, token)
    how = struct.pack("<II8B", *size, len(eyes), *formats, quality, anew, len(layers), 0, 8 * bool(inputs))
    body = start + how + struct.pack("<3d", rate, mbit, step) + head + b"".join(eyes)
    if layers:
        body += struct.pack("<2I", *shown) + len(eyes) * struct.pack("<4d", *shown_angles)
        body += b"".join(struct.pack("<16sI", name.encode(), amount) for name, amount in layers)
    if inputs:
        body += struct.pack("<H", len(inputs)) + b"".join(inputs)
    return message(REQUEST, body)


def acted(time_ns=0, action=1, name=b"", place=HEAD, way=(0.0, 0.0, -1.0)) -> bytes:
    """What somebody did."""
    return struct.pack("<qB16s6d", time_ns, action, name, *place, *way)


def frame(
    asked: bytes,
    *,
    number: int | None = None,
    size: tuple[int, int] | None = None,
    eyes: tuple[bytes, ...] | None = None,
    formats=(2, 1),
    pictures: tuple[bytes, bytes] | None = None,
    instants: tuple[int, int, int, int] | None = None,
    drawing: int = 0,
    heads: tuple[bytes, ...] = (),
    parts: bytes = b"",
) -> bytes:
    """The frame that answers a request: grey, 10 m away, unless it says otherwise."""
    (id_, sent), (time_ns,) = struct.unpack_from("<Qq", asked, 12), struct.unpack_from("<q", asked, 28)
    size = size or struct.unpack_from("<2I", asked, 84)
    eyes = eyes if eyes is not None else tuple(asked[180 + 144 * one :][:144] for one in range(asked[92]))
    pixels, now = size[0] * size[1], time.monotonic_ns()
    sent, received, answered, drawn = instants or (sent, now, now, time_ns)
    colour, depth = pictures or (b"\x80\x80\x80\xff" * pixels, struct.pack("<f", 0.1) * pixels)
    start = struct.pack("<Qqqqqq", id_ if number is None else number, sent, received, answered, drawing, drawn)
    start += struct.pack("<II4BIB3x", *size, len(eyes), *formats, 1, 0, len(heads))
    lengths = struct.pack("<II", len(colour), len(depth)) * len(eyes)
    return message(FRAME, start + b"".join(eyes) + lengths + b"".join(heads) + (colour + depth) * len(eyes) + parts)


def part_head(name: str, size: tuple[int, int], length: int, *, form: int = 1, packed: int = 1, eye_: int = 0) -> bytes:
    return struct.pack("<16sBBBxIII", name.encode(), eye_, form, packed, *size, length)


def answer(data: bytes) -> tuple[str, int, str]:
    """What a server sent: its kind, the id of the request, and what it says."""
    magic, version, kind, length = struct.unpack_from("<4sHHI", data)
    assert (magic, version, length) == (MAGIC, VERSION, len(data)), data[:12]
    (number,) = struct.unpack_from("<Q", data, 12)
    if kind == REFUSAL:
        (count,) = struct.unpack_from("<I", data, 20)
        return "refusal", number, data[24 : 24 + count].decode()
    return {FRAME: "frame"}.get(kind, f"kind {kind}"), number, ""


def any_turn(rng: random.Random) -> tuple[float, ...]:
    parts = [rng.gauss(0, 1) for _ in range(4)]
    length = math.hypot(*parts) / rng.choice((1, 1, 1.0009, 0.9991))
    return tuple(part / length for part in parts)


def any_angles(rng: random.Random, least: float = 0) -> tuple[float, ...]:
    """A field of view that is allowed, of at least twice that, around the axis or beside it."""
    found: list[float] = []
    for _ in range(2):
        low, high = (sign * rng.choice([angle for angle in HALF_ANGLES if angle >= least]) for sign in (-1, 1))
        if rng.random() < 0.1 and not least:
            low, high = sorted(rng.uniform(-1.562, 1.562) for _ in range(2))
            high = max(high, low + 1.1e-4)
        found += [low, high]
    return tuple(found)


def any_size(rng: random.Random, pixels: int) -> tuple[int, int]:
    """Sides from 1 to 8192 with no more pixels than that, and sometimes as many as there may be."""
    if rng.random() < 0.01:
        return 8192, 8192
    width = round(2 ** rng.uniform(0, min(13, math.log2(pixels))))
    return width, max(1, min(8192, round(2 ** rng.uniform(0, math.log2(pixels / width)))))


def any_request(rng: random.Random, number: int, pixels: int = 1 << 12) -> bytes:
    """A request that docs/feed.md allows, of any numbers within their bounds."""

    def place() -> tuple[float, ...]:
        return tuple(rng.choice(COORDINATES) for _ in range(3))

    def one_eye() -> bytes:
        return eye(place(), any_turn(rng), any_angles(rng), place(), any_turn(rng))

    more = {}
    if rng.random() < 0.5:
        names = rng.sample((*SENT, rng.choice((*SENT, "points"))), rng.randint(1, 4))
        more["layers"] = tuple(
            (name, rng.randint(1, MOST.get(name, 1 + (rng.random() < 0.05)))) for name in dict.fromkeys(names)
        )
        # A cube is as dense as the shown picture, so this is what its size follows from.
        more |= {"shown": any_size(rng, 64), "shown_angles": any_angles(rng, 0.1)}
    return request(
        number, size=any_size(rng, pixels), eyes=tuple(one_eye() for _ in range(rng.randint(1, 2))),
        formats=(rng.choice((0, 0, 1, 2, 3, 4, 5, 6, 9, 255)), rng.choice((0, 5, 1, 2, 3, 9))),
        quality=rng.choice((0, 1, 27, 52)), anew=rng.choice((0, 1, 255)), rate=rng.choice(RATES),
        mbit=rng.choice(BIT_RATES), step=rng.choice(STEPS), sent=rng.choice((None, *INSTANTS)),
        instants=(rng.choice(INSTANTS), rng.choice(INSTANTS)), received=rng.choice((0, number - 1, 2**64 - 1)),
        head=pose(place(), any_turn(rng)), inputs=tuple(any_input(rng) for _ in range(rng.choice((0, 0, 1, 3)))),
        **more,
    )  # fmt: skip


def any_input(rng: random.Random) -> bytes:
    """What somebody did, of any numbers within their bounds, to what the hand means."""
    ray = (rng.choice(COORDINATES) for _ in range(3)), any_turn(rng)[:3]
    way = ray[1] if math.hypot(*ray[1]) > 1e-9 else (0.0, 1e-9, 0.0)
    return acted(rng.choice(INSTANTS), rng.randint(1, 4), b"", tuple(ray[0]), way)
