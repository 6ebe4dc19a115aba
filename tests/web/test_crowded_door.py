"""The web's door under random requests, random messages, and peers that are slow or too many."""

from __future__ import annotations

import asyncio
import itertools
import json
import socket
import struct
import time
import urllib.error
import urllib.request
from contextlib import ExitStack, closing
from http.cookiejar import CookieJar

import aiohttp
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from properties import ONE_FIXTURE_FOR_ALL
from serving import Serving
from sources.feed.exchange import exchanged, port_of

from hmdwarp.sources.feed import sockets
from hmdwarp.sources.feed.caller import Caller
from hmdwarp.sources.feed.listener import Listener
from hmdwarp.sources.feed.message import FrameMessage, decode
from hmdwarp.web import Door, visitors
from hmdwarp.web.visitors import MOST_VISITORS

from .crowd import Crowd, ask, held_by

KINDS = settings(max_examples=60, suppress_health_check=ONE_FIXTURE_FOR_ALL)


@pytest.fixture(scope="module")
def serving(tmp_path_factory):
    out = tmp_path_factory.mktemp("out")
    with Serving("--web", "127.0.0.1:*", "--out", str(out)) as server:
        server.door = server.line("for a browser").split()[-1]
        jar = CookieJar()
        urllib.request.build_opener(urllib.request.HTTPCookieProcessor(jar)).open(server.door).close()
        server.cookie = "; ".join(f"{one.name}={one.value}" for one in jar)
        server.door = server.door.partition("?")[0]
        yield server


def place(serving) -> tuple[str, int]:
    host, _, port = serving.door.split("/")[2].rpartition(":")
    return host, int(port)


def answer(serving, *pieces: bytes) -> bytes:
    """What comes back until the door closes, which may be before all is sent."""
    with socket.create_connection(place(serving)) as one:
        one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        found = b""
        try:
            for piece in pieces:
                one.sendall(piece)
                time.sleep(0.002 * (len(pieces) > 1))
            one.shutdown(socket.SHUT_WR)
            while more := one.recv(1 << 16):
                found += more
        except OSError:  # cut, or so when it is to be shut
            pass
        return found


async def _spoken(serving, messages: list[bytes | str]) -> object:
    """The frame that a page gets after others, from other connections, have said all that."""
    address, headers = f"ws://{serving.door.split('/')[2]}/feed", {"Cookie": serving.cookie}
    async with aiohttp.ClientSession(headers=headers) as session:
        for message in messages:
            async with session.ws_connect(address) as one:
                await (one.send_str(message) if isinstance(message, str) else one.send_bytes(message))
        async with session.ws_connect(address) as one:
            await one.send_bytes(ask())
            return decode((await one.receive()).data)


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
            stack.enter_context(socket.create_connection(place(serving))).sendall(pieces[0])
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
def test_any_message_leaves_the_next_page_its_frame(serving, messages):
    assert isinstance(asyncio.run(_spoken(serving, messages)), FrameMessage)
    assert not any("internal error" in line or "Traceback" in line for line in serving._said)


def is_open(one: socket.socket) -> bool:
    """Whether the server has not cut it; what it sent is passed over."""
    one.setblocking(False)
    try:
        while one.recv(1 << 12):
            pass
    except BlockingIOError:
        return True
    except ConnectionError:
        pass
    return False


def test_an_address_has_its_places_at_both_doors_together(monkeypatch):
    """Those who say nothing make room at either door, so that clients and pages find some."""
    for name, value in (("IDLE_NS", 10**15), ("SILENT_NS", 10**15)):
        monkeypatch.setattr(sockets, name, value)
    monkeypatch.setattr(visitors, "SILENT_S", 1e6)
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


def test_a_crowd_shuts_nobody_out_and_leaves_nothing_behind(serving):
    """More than all may be at both doors, from one address."""
    asyncio.run(Crowd(serving, serving.cookie).all(1.0, 0, 1))
    before_mib, before = held_by(serving.process.pid)
    crowd = Crowd(serving, serving.cookie)
    asyncio.run(crowd.all(5.0, 6 * MOST_VISITORS, 6))
    assert crowd.frames >= 5
    left_s = time.monotonic()
    while held_by(serving.process.pid)[1] > before and time.monotonic() - left_s < 100:
        time.sleep(0.1)
    after_mib, after = held_by(serving.process.pid)
    assert after <= before and after_mib < before_mib + 64


def test_who_never_finishes_a_head_is_cut(serving):
    """And so is one that is sent what it does not read."""
    with socket.create_connection(place(serving)) as silent, socket.create_connection(place(serving)) as slow:
        slow.sendall(b"GET / HTTP/1.1\r\n")
        for one in (silent, slow):
            with pytest.raises(ConnectionResetError):
                assert one.recv(1) == b""
                raise ConnectionResetError
    assert serving.line("no whole request")
