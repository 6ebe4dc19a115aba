"""The door for browsers: who is let in, what is given, what passes to the feed; random requests and
messages, and peers that are slow or too many.
"""

from __future__ import annotations

import asyncio
import hashlib
import itertools
import json
import socket
import ssl
import struct
import time
import urllib.error
import urllib.request
from contextlib import ExitStack, asynccontextmanager, closing, suppress
from http.cookiejar import CookieJar
from pathlib import Path
from urllib.parse import urlsplit

import aiohttp
import attrs
import needs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from properties import ONE_FIXTURE_FOR_ALL
from recorded_folders import taken, write_npz
from serving import Serving
from sources.feed.exchange import exchanged, port_of

from hmdwarp.base import InputError
from hmdwarp.geometry import Pose, View
from hmdwarp.run import ServeOptions
from hmdwarp.sources.feed import sockets
from hmdwarp.sources.feed.caller import Caller
from hmdwarp.sources.feed.listener import Listener
from hmdwarp.sources.feed.message import RGBA8, FrameMessage, Refusal, decode, encode
from hmdwarp.web import Door, visitors
from hmdwarp.web.visitors import MOST_VISITORS

from .crowd import EYES, Crowd, ask, held_by

NOWHERE = ("tcp://127.0.0.1:1", {}, {})


@pytest.fixture(scope="module")
def serving(tmp_path_factory):
    folder = tmp_path_factory.mktemp("serving")
    (folder / "secret").write_text("a shared secret", encoding="utf-8")
    options = ("--web", "127.0.0.1:*", "--token-file", str(folder / "secret"), "--out", str(folder / "out"))
    with Serving(*options) as server:
        server.door = server.next = server.line("for a browser").split()[-1]
        yield server


def opened(address: str, jar: CookieJar | None = None, **headers: str):
    """(status, headers, text) of a page; redirections are followed."""
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(jar if jar is not None else CookieJar()))
    try:
        with opener.open(urllib.request.Request(address, headers=headers)) as found:
            return found.status, found.headers, found.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.headers, error.read().decode()


def let_in(server: Serving) -> tuple[str, CookieJar]:
    """The address without its token, and the cookie that it brought."""
    address, jar = server.line("for a browser").split()[-1], CookieJar()
    assert opened(address, jar)[0] == 200
    return address.partition("?")[0], jar


@pytest.fixture(scope="module")
def inside(serving):
    jar = CookieJar()
    status, _, text = opened(serving.door, jar)
    assert status == 200 and "<canvas" in text
    serving.next = serving.line("for another one").split()[-1]
    return serving.door.partition("?")[0], jar


class Stay(urllib.request.HTTPRedirectHandler):
    def redirect_request(self, *_):
        return None


def test_the_token_counts_once_and_what_a_page_asks_stays_when_it_goes(serving, inside):
    assert opened(serving.door)[0] == 403
    jar = CookieJar()
    going = urllib.request.build_opener(Stay, urllib.request.HTTPCookieProcessor(jar))
    with pytest.raises(urllib.error.HTTPError) as told:
        going.open(f"{serving.next}&trace=walk&latency=200")
    assert told.value.headers["Location"] == "/?trace=walk&latency=200"
    told.value.close()
    (cookie,) = jar
    assert cookie.has_nonstandard_attr("HttpOnly") and cookie.get_nonstandard_attr("SameSite") == "Strict"


OWN = ["", "session.json", "shaders.json", "main.js", "traces/walk.json", "feed"]
OTHERS = [
    "../pyproject.toml", "%2e%2e/pyproject.toml", "..%2fdoor.py", "/etc/passwd", "traces/../door.py", "to_web.glsl",
    "traces/none.json", "index.html%00.js", "door.py",
]  # fmt: skip


def test_without_a_cookie_nothing_is_given_and_with_it_no_path_of_the_machine(inside):
    address, jar = inside
    assert {path: opened(address + path)[0] for path in OWN} == dict.fromkeys(OWN, 403)
    assert {path: opened(address + path, jar)[0] for path in OTHERS} == dict.fromkeys(OTHERS, 404)


@pytest.mark.parametrize(
    ("name", "value"),
    [("Host", "evil.example"), ("Host", "evil.example:80"), ("Origin", "http://evil.example"), ("Origin", "null")],
)
def test_another_name_or_origin_is_refused(inside, name, value):
    """DNS rebinding comes by the attacker's name, a page of others by its origin."""
    status, _, text = opened(inside[0], inside[1], **{name: value})
    assert (status, text) == (403, "open this page by the address that hmdwarp printed\n")


def test_nothing_from_elsewhere_may_load(inside):
    for path in ("", "main.js", "shaders.json"):
        headers = opened(inside[0] + path, inside[1])[1]
        policy = dict(part.strip().split(" ", 1) for part in headers["Content-Security-Policy"].split(";"))
        own = urlsplit(inside[0]).netloc
        assert policy.pop("connect-src") == f"'self' ws://{own}" and policy.pop("img-src") == "'self' data:"
        assert policy.pop("default-src") == "'none'" and set(policy.values()) == {"'self'", "'none'"}
        assert headers["X-Content-Type-Options"] == "nosniff" and headers["Cache-Control"] == "no-store"


@asynccontextmanager
async def feed(address: str, jar: CookieJar):
    """A WebSocket of a page."""
    cookies = {cookie.name: cookie.value for cookie in jar}
    async with (
        aiohttp.ClientSession(cookies=cookies, cookie_jar=aiohttp.CookieJar(unsafe=True)) as session,
        session.ws_connect(address.replace("http", "ws") + "feed", max_msg_size=1 << 28) as socket,
    ):
        yield socket


async def _spoken(address: str, jar: CookieJar, messages: tuple[bytes | str, ...], answers: int) -> list[bytes]:
    found: list[bytes] = []
    async with feed(address, jar) as socket:
        for message in messages:
            await (socket.send_str(message) if isinstance(message, str) else socket.send_bytes(message))
        while len(found) < answers and (message := await socket.receive()).type is aiohttp.WSMsgType.BINARY:
            found.append(message.data)
    return found


def spoken(inside, *messages: bytes | str, answers: int = 1) -> list:
    """What a WebSocket of the page hears; [] where it is closed first."""
    return [decode(data) for data in asyncio.run(_spoken(*inside, messages, answers))]


def test_the_feed_is_spoken_as_it_is(inside):
    """The door puts the server's token in; the frame is the one that any client gets."""
    (frame,) = spoken(inside, ask())
    assert isinstance(frame, FrameMessage) and (frame.number, frame.size, frame.colour) == (1, (64, 48), RGBA8)
    assert frame.colours[0].shape == (48, 64, 4) and frame.inverse_depths[0].max() > 0


async def _beside_one_that_reads_nothing(address: str, jar: CookieJar, count: int) -> tuple[list[int], list[int]]:
    async with feed(address, jar) as slow, feed(address, jar) as other:
        slow._response.connection.transport.pause_reading()
        answered = []
        for number in range(1, count + 1):
            await slow.send_bytes(ask(number, (1024, 768)))
            await other.send_bytes(ask(number))
            answered.append(decode((await other.receive()).data).number)
        slow._response.connection.transport.resume_reading()
        late = [decode((await slow.receive()).data).number]
        while late[-1] < count:
            late.append(decode((await slow.receive()).data).number)
        return answered, late


def test_who_reads_slowly_slows_nobody_and_gets_the_newest(inside):
    """Every request of the other is answered meanwhile, though the first takes nothing.

    Of the slow one's frames, of 6.3 MB, up to two are in the system's buffers of each of its two
    connections, one each in the hands of door and library, two in the server; then the newest
    comes. The others were dropped.
    """
    answered, late = asyncio.run(_beside_one_that_reads_nothing(*inside, 40))
    assert answered == list(range(1, 41))
    assert late == sorted(late) and late[-1] == 40 and len(late) <= 9


def test_what_the_server_refuses_is_told_and_who_speaks_otherwise_is_cut(inside):
    broken = bytearray(ask())
    broken[84:88] = (9000).to_bytes(4, "little")
    (told,) = spoken(inside, bytes(broken))
    assert isinstance(told, Refusal) and "9000" in told.text
    for message in (b"", b"x" * 50, b"x" * 100_000):
        assert spoken(inside, message) == []


def test_who_says_nothing_or_never_finishes_a_head_is_cut(monkeypatch):
    """One that has spoken stays: a page that is hidden says nothing either."""
    monkeypatch.setattr(visitors, "SILENT_S", 0.5)
    monkeypatch.setattr(visitors, "_EVERY_S", 0.05)
    jar, said = CookieJar(), []
    with closing(Door("127.0.0.1:*", *NOWHERE, say=said.append)) as door:
        opened(door.address, jar)
        assert spoken((door.address.partition("?")[0], jar)) == []
        with ExitStack() as stack:
            silent, slow = (stack.enter_context(socket.create_connection(place(door.address))) for _ in range(2))
            slow.sendall(b"GET / HTTP/1.1\r\n")
            for one in (silent, slow):
                with suppress(ConnectionResetError):
                    assert one.recv(1) == b""
    assert any("no whole request" in line for line in said)


REFUSED = [  # by a place that is taken and a folder
    (lambda *_: Door("0.0.0.0:*", *NOWHERE), "beyond this machine it wants --certificate"),
    (lambda *_: Door("5580", *NOWHERE), "expected HOST:PORT"),
    (lambda taken, _: Door(taken, *NOWHERE), "take another port"),
    (lambda _, folder: certified(folder / "wrong.pem"), "expected a PEM file with a private key"),
    (lambda _, folder: certified(folder), "is a directory"),
    (lambda _, folder: certified(folder / "missing.pem"), "without the program openssl: install it, or name a PEM"),
    (lambda *_: ServeOptions.of({"certificate": "some.pem"}), "it is for --web"),
    (lambda _, folder: ServeOptions.of({"frames": folder, "scene": "box"}), "--scene with --frames: recorded"),
    (lambda *_: ServeOptions.of({"repair": "edges"}), "--repair edges: a rendered scene lacks no depth"),
]


def certified(pem: Path) -> Door:
    return Door("127.0.0.1:*", *NOWHERE, certificate=pem)


@pytest.mark.parametrize(("make", "words"), REFUSED, ids=[words[:20] for _, words in REFUSED])
def test_what_no_door_can_be_opened_by_is_refused(serving, tmp_path, monkeypatch, make, words):
    (tmp_path / "wrong.pem").write_text("no key\n", encoding="utf-8")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(InputError, match=words) as told:
        make(urlsplit(serving.door).netloc, tmp_path)
    assert len(str(told.value).splitlines()) == 1 and len([*tmp_path.iterdir()]) == 1


@needs.programs("openssl")
def test_a_certificate_that_cannot_be_written_is_told(tmp_path):
    with pytest.raises(InputError, match="cannot be made"):
        certified(tmp_path / "none" / "in.pem")


def https(address: str, pem: Path):
    """(answer, SHA-256 of its certificate) of a page, by a client that trusts this one alone."""
    trusting, place = ssl.create_default_context(cafile=str(pem)), urlsplit(address)
    with (
        socket.create_connection((place.hostname, place.port)) as plain,
        trusting.wrap_socket(plain, server_hostname=place.hostname) as safe,
    ):
        safe.sendall(f"GET /?{place.query} HTTP/1.0\r\nHost: {place.netloc}\r\n\r\n".encode())
        answer = b"".join(iter(lambda: safe.recv(4096), b"")).decode()
        return answer, hashlib.sha256(safe.getpeercert(binary_form=True)).hexdigest()


@needs.programs("openssl")
@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "0.0.0.0"])
def test_a_certificate_is_made_once_for_where_it_listens(tmp_path, host):
    """Python's client checks the name too; what is printed of 0.0.0.0 is an address to open."""
    pem, said, seen = tmp_path / "made.pem", [], []
    for _ in range(2):
        with closing(Door(f"{host}:*", *NOWHERE, certificate=pem, say=said.append)) as door:
            assert "0.0.0.0" not in door.address
            answer, fingerprint = https(door.address, pem)
        assert "303 See Other" in answer and "; Secure" in answer
        seen.append(fingerprint)
    assert seen[0] == seen[1] and pem.stat().st_mode & 0o777 == 0o600 and [*tmp_path.iterdir()] == [pem]
    assert [line.startswith("made ") for line in said if str(pem) in line] == [True, False, False]
    assert {line.split()[-1].replace(":", "").lower() for line in said if "fingerprint" in line} == {*seen}


def test_recorded_frames_are_given_as_the_camera_took_them(tmp_path):
    """Squeezed into the pixels asked for, with the camera's own view and head."""
    write_npz(tmp_path, frames := taken(6, (64, 48)))
    with Serving("--frames", str(tmp_path), "--web", "127.0.0.1:*") as server:
        place, jar = let_in(server)
        about = json.loads(opened(f"{place}session.json", jar)[2])
        assert about["head"] == about["traces"][0] == "as-recorded"
        samples = json.loads(opened(f"{place}traces/as-recorded.json", jar)[2])["samples"]
        for at, late in ((0, 0), (0.11, 3), (0.29, 2)):  # there and back
            (frame,) = spoken((place, jar), encode(attrs.evolve(decode(ask()), time_ns=round(at * 1e9))))
            np.testing.assert_allclose(frame.views[0].pose.matrix(), frames[late].pose.matrix(), atol=1e-12)
            np.testing.assert_array_equal(frame.colours[0][..., :3], frames[late].colour)
        assert len(samples) == 6 and samples[3][1:4] == frames[3].pose.position_m.tolist()


def test_a_file_is_a_scene_too():
    """Its lamps are on; the view looks at its wall. Nobody wants reports: who sends one is cut."""
    file = str(Path(__file__).parents[1] / "scenes" / "files" / "lamps-of-blender.glb")
    with Serving("--scene", file, "--web", "127.0.0.1:*") as server:
        place, jar = let_in(server)
        start = json.loads(opened(f"{place}session.json", jar)[2])["viewpoint"]
        view = View(Pose(start["position"], start["orientation"]), EYES[0].fov)
        (frame,) = spoken((place, jar), encode(attrs.evolve(decode(ask()), views=(view,))))
        assert frame.colours[0][..., :3].max() > 0 and frame.inverse_depths[0].max() > 0
        assert spoken((place, jar), "text") == []


# --- whatever comes ---

KINDS = settings(max_examples=60, suppress_health_check=ONE_FIXTURE_FOR_ALL)


def place(address: str) -> tuple[str, int]:
    return urlsplit(address).hostname, urlsplit(address).port


def answer(serving, *pieces: bytes) -> bytes:
    """What comes back until the door closes, which may be before all is sent."""
    found = b""
    with socket.create_connection(place(serving.door)) as one, suppress(OSError):  # cut, or so when it is to be shut
        one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for piece in pieces:
            one.sendall(piece)
            time.sleep(0.002 * (len(pieces) > 1))
        one.shutdown(socket.SHUT_WR)
        while more := one.recv(1 << 16):
            found += more
    return found


LINES = st.sampled_from(
    [b"Host: 127.0.0.1", b"Host: [", b"Origin: null", b"Cookie: hmdwarp-1=\xff", b'Cookie: a="\\377\\400', b"\0: \0",
     b"Upgrade: websocket", b"Connection: Upgrade", b"Connection: close", b"Content-Length: 9", b"Content-Length: -1",
     b"Transfer-Encoding: chunked", b"Expect: 100-continue", b"Sec-WebSocket-Version: 13", b"Sec-WebSocket-Key: x",
     b"Range: bytes=9-", b" folded"]
)  # fmt: skip
TARGETS = st.sampled_from(
    [b"/", b"/feed", b"/?token=%ff", b"/?token=\xfe", b"*", b"http://[", b"http://a:99999999/", b"//[::/", b"/%00",
     b"\xff", b"/..;/"]
)  # fmt: skip
METHODS = st.sampled_from([b"GET", b"HEAD", b"POST", b"OPTIONS", b"CONNECT", b"PRI", b"\xff", b""])
HEADS = st.builds(
    lambda method, target, lines, end: b"\r\n".join([method + b" " + target + b" HTTP/1.1", *lines]) + end,
    METHODS,
    TARGETS,
    st.lists(LINES | st.binary(max_size=40), max_size=8),
    st.sampled_from([b"\r\n\r\n", b"\n\n", b"\r\n", b""]),
)


@KINDS
@given(HEADS | st.binary(max_size=300), st.lists(st.integers(0, 400), max_size=4), st.integers(0, 3))
def test_any_request_is_refused_without_a_traceback(serving, request_, cuts, stopped):
    """Whole or in pieces, each on its way before the next; others stop within meanwhile."""
    ends = sorted({min(cut, len(request_)) for cut in cuts})
    pieces = [request_[first:last] for first, last in itertools.pairwise([0, *ends, len(request_)])]
    with ExitStack() as stack:
        for _ in range(stopped):
            stack.enter_context(socket.create_connection(place(serving.door))).sendall(pieces[0])
        found = answer(serving, *pieces)
    assert not found or int(found.split()[1]) in range(400, 432), found[:200]
    assert "Traceback" not in "".join(serving._said)


NUMBERS = st.floats(width=64) | st.integers(-(2**70), 2**70) | st.sampled_from([1e-320, 1e20, 10**400])
JSONS = st.recursive(
    NUMBERS | st.text(max_size=8) | st.none() | st.booleans(),
    lambda inner: st.lists(inner, max_size=12) | st.dictionaries(st.text(max_size=6), inner, max_size=4),
)
REPORTS = st.fixed_dictionaries(
    dict.fromkeys(("display", "warp", "missed", "delays_ms"), JSONS)
    | {"refreshes": JSONS | st.lists(st.lists(NUMBERS, min_size=10, max_size=10))}
)


def changed(fields: list[tuple[int, float]]) -> bytes:
    """A request with some of its numbers changed, of eight bytes each, behind its token."""
    data = bytearray(ask())
    for at, number in fields:
        struct.pack_into("<d", data, 84 + at % (len(data) - 92), number)
    return bytes(data)


FIELDS = st.lists(st.tuples(st.integers(0, 500), st.floats()), min_size=1, max_size=4)
MESSAGES = (
    st.builds(json.dumps, REPORTS | JSONS) | st.text(max_size=99) | st.binary(max_size=400) | st.builds(changed, FIELDS)
)


@KINDS
@given(st.lists(MESSAGES, max_size=6))
def test_any_message_leaves_the_next_page_its_frame(serving, inside, messages):
    for message in messages:
        spoken(inside, message, answers=0)
    assert isinstance(spoken(inside, ask())[0], FrameMessage)
    assert not any("internal error" in line or "Traceback" in line for line in serving._said)


def is_open(one: socket.socket) -> bool:
    """Whether the server has not cut it; what it sent is passed over."""
    one.setblocking(False)
    with suppress(ConnectionError):
        try:
            while one.recv(1 << 12):
                pass
        except BlockingIOError:
            return True
    return False


def test_an_address_has_its_places_at_both_doors_together(monkeypatch):
    """Those who say nothing make room at either door, so that clients and pages find some."""
    for name, value in (("IDLE_NS", 10**15), ("SILENT_NS", 10**15)):
        monkeypatch.setattr(sockets, name, value)
    monkeypatch.setattr(visitors, "SILENT_S", 1e6)
    monkeypatch.setattr(visitors, "_EVERY_S", 0.02)
    with closing(Listener("127.0.0.1:*", per_address=4)) as listener, ExitStack() as stack:
        door = stack.enter_context(closing(Door("127.0.0.1:*", listener.address, {}, {}, places=listener.places)))
        web, feed = (("127.0.0.1", port_of(one.partition("/?")[0])) for one in (door.address, listener.address))
        silent, callers = [], []
        for left in (4, 3, 2, 1):
            for doors in ((web, feed), (web,), (feed, web)):
                silent += [stack.enter_context(socket.create_connection(one)) for one in doors * 10]
                while sum(map(is_open, silent)) > left:
                    for caller in callers or [None]:
                        _ = exchanged(caller, listener) if caller else listener.next(1)
            callers.append(stack.enter_context(closing(Caller(listener.address))))
            exchanged(callers[-1], listener)
            with pytest.raises(ConnectionError if left == 1 else urllib.error.HTTPError):
                urllib.request.urlopen(door.address.partition("?")[0])


def test_a_crowd_shuts_nobody_out_and_leaves_nothing_behind(serving, inside):
    """More than all may be at both doors, from one address."""
    cookie = "; ".join(f"{one.name}={one.value}" for one in inside[1])
    asyncio.run(Crowd(serving, cookie).all(0.5, 0, 1))
    before_mib, before = held_by(serving.process.pid)
    crowd = Crowd(serving, cookie)
    asyncio.run(crowd.all(2.0, 6 * MOST_VISITORS, 6))
    assert crowd.frames >= 5
    left_s = time.monotonic()
    while held_by(serving.process.pid)[1] > before and time.monotonic() - left_s < 100:
        time.sleep(0.1)
    after_mib, after = held_by(serving.process.pid)
    assert after <= before and after_mib < before_mib + 64
