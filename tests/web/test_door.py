"""The door for browsers: who is let in, what is given, and what passes to the feed."""

from __future__ import annotations

import asyncio
import hashlib
import json
import socket
import ssl
import urllib.error
import urllib.request
from contextlib import asynccontextmanager
from http.cookiejar import CookieJar
from pathlib import Path
from urllib.parse import urlsplit

import aiohttp
import attrs
import needs
import numpy as np
import pytest
from recorded_folders import taken, write_npz
from serving import Serving

from hmdwarp.errors import InputError
from hmdwarp.geometry import Pose, View
from hmdwarp.run import ServeOptions
from hmdwarp.sources.feed.message import RGBA8, FrameMessage, Refusal, decode, encode
from hmdwarp.web import Door

from .crowd import EYES, ask


@pytest.fixture(scope="module")
def serving(tmp_path_factory):
    secret = tmp_path_factory.mktemp("secret") / "secret"
    secret.write_text("a shared secret", encoding="utf-8")
    with Serving("--web", "127.0.0.1:*", "--token-file", str(secret)) as server:
        server.door = server.line("for a browser").split()[-1]
        yield server


def opened(address: str, jar: CookieJar | None = None, **headers: str):
    """(status, headers, text) of a page; redirections are followed."""
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(jar if jar is not None else CookieJar()))
    try:
        with opener.open(urllib.request.Request(address, headers=headers)) as found:
            return found.status, found.headers, found.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.headers, error.read().decode()


@pytest.fixture(scope="module")
def inside(serving):
    """The address without its token, and the cookie that it brought."""
    jar = CookieJar()
    status, _, text = opened(serving.door, jar)
    assert status == 200 and "<canvas" in text
    serving.next = serving.line("for another one").split()[-1]
    return serving.door.partition("?")[0], jar


def test_the_token_counts_once(serving, inside):
    assert opened(serving.door)[0] == 403
    jar = CookieJar()
    assert opened(serving.next, jar)[0] == 200
    serving.next = serving.line("for another one").split()[-1]
    (cookie,) = jar
    assert cookie.has_nonstandard_attr("HttpOnly") and cookie.get_nonstandard_attr("SameSite") == "Strict"


def test_what_a_page_asks_stays_when_the_token_goes(serving, inside):
    class Stay(urllib.request.HTTPRedirectHandler):
        def redirect_request(self, *_):
            return None

    with pytest.raises(urllib.error.HTTPError) as told:
        urllib.request.build_opener(Stay).open(f"{serving.next}&trace=walk&latency=200")
    serving.next = serving.line("for another one").split()[-1]
    assert told.value.headers["Location"] == "/?trace=walk&latency=200"
    told.value.close()


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


async def _spoken(address: str, jar: CookieJar, messages: list[bytes | str], answers: int) -> list[bytes]:
    found: list[bytes] = []
    async with feed(address, jar) as socket:
        for message in messages:
            await (socket.send_str(message) if isinstance(message, str) else socket.send_bytes(message))
        while len(found) < answers and (message := await socket.receive()).type is aiohttp.WSMsgType.BINARY:
            found.append(message.data)
    return found


def spoken(inside, *messages: bytes | str, answers: int = 1) -> list:
    """What a WebSocket of the page hears; [] where it is closed first."""
    return [decode(data) for data in asyncio.run(_spoken(*inside, list(messages), answers))]


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


def test_what_the_server_refuses_is_told(inside):
    broken = bytearray(ask())
    broken[84:88] = (9000).to_bytes(4, "little")
    (told,) = spoken(inside, bytes(broken))
    assert isinstance(told, Refusal) and "9000" in told.text


@pytest.mark.parametrize("message", ["text", b"", b"x" * 50, b"x" * 100_000])
def test_who_speaks_otherwise_is_cut(inside, message):
    assert spoken(inside, message) == []


async def _silent(address: str, jar: CookieJar) -> bool:
    """Whether a page that says nothing is told to go."""
    async with feed(address, jar) as socket:
        return (await socket.receive()).type in (aiohttp.WSMsgType.CLOSE, aiohttp.WSMsgType.CLOSED)


def test_who_says_nothing_is_cut(monkeypatch):
    """One that has spoken stays: a page that is hidden says nothing either."""
    monkeypatch.setattr("hmdwarp.web.visitors.SILENT_S", 1.0)
    door, jar = Door("127.0.0.1:*", "tcp://127.0.0.1:1", {}, {}), CookieJar()
    try:
        opened(door.address, jar)
        assert asyncio.run(_silent(door.address.partition("?")[0], jar))
    finally:
        door.close()


@pytest.mark.parametrize(
    ("refused", "words"),
    [
        (lambda taken, _: Door("0.0.0.0:*", "tcp://127.0.0.1:1", {}, {}), "beyond this machine it wants --certificate"),
        (lambda taken, _: Door("5580", "tcp://127.0.0.1:1", {}, {}), "expected HOST:PORT"),
        (lambda taken, _: Door(taken, "tcp://127.0.0.1:1", {}, {}), "take another port"),
        (lambda *_: ServeOptions.of({"certificate": "some.pem"}), "it is for --web"),
        (lambda _, frames: ServeOptions.of({"frames": frames, "scene": "box"}), "--scene with --frames: recorded"),
        (lambda *_: ServeOptions.of({"repair": "edges"}), "--repair edges: a rendered scene lacks no depth"),
    ],
)
def test_what_no_door_can_be_opened_by_is_refused(serving, tmp_path, refused, words):
    with pytest.raises(InputError, match=words):
        refused(urlsplit(serving.door).netloc, tmp_path)


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
        door = Door(f"{host}:*", "tcp://127.0.0.1:1", {}, {}, certificate=pem, say=said.append)
        try:
            assert "0.0.0.0" not in door.address
            answer, fingerprint = https(door.address, pem)
        finally:
            door.close()
        assert "303 See Other" in answer and "; Secure" in answer
        seen.append(fingerprint)
    assert seen[0] == seen[1] and pem.stat().st_mode & 0o777 == 0o600 and [*tmp_path.iterdir()] == [pem]
    assert [line.startswith("made ") for line in said if str(pem) in line] == [True, False, False]
    assert {line.split()[-1].replace(":", "").lower() for line in said if "fingerprint" in line} == {*seen}


def test_what_is_no_certificate_is_told(tmp_path, monkeypatch):
    wrong, missing = tmp_path / "wrong.pem", tmp_path / "missing.pem"
    wrong.write_text("no key\n", encoding="utf-8")

    def refused(pem: Path, why: str) -> None:
        with pytest.raises(InputError, match=why) as told:
            Door("127.0.0.1:*", "tcp://127.0.0.1:1", {}, {}, certificate=pem)
        assert len(str(told.value).splitlines()) == 1

    refused(wrong, "expected a PEM file with a private key")
    refused(tmp_path, "is a directory")
    if needs.program("openssl"):
        refused(tmp_path / "none" / "in.pem", "cannot be made")
    monkeypatch.setenv("PATH", "")
    refused(missing, "without the program openssl: install it, or name a PEM file")
    assert not missing.exists()


def test_recorded_frames_are_given_as_the_camera_took_them(tmp_path):
    """Squeezed into the pixels asked for, with the camera's own view and head."""
    write_npz(tmp_path, frames := taken(6, (64, 48)))
    with Serving("--frames", str(tmp_path), "--web", "127.0.0.1:*") as server:
        jar, address = CookieJar(), server.line("for a browser").split()[-1]
        opened(address, jar)
        place = address.partition("?")[0]
        about = json.loads(opened(f"{place}session.json", jar)[2])
        assert about["head"] == about["traces"][0] == "as-recorded"
        samples = json.loads(opened(f"{place}traces/as-recorded.json", jar)[2])["samples"]
        for at, late in ((0, 0), (0.11, 3), (0.29, 2)):  # there and back
            (frame,) = spoken((place, jar), encode(attrs.evolve(decode(ask()), time_ns=round(at * 1e9))))
            np.testing.assert_allclose(frame.views[0].pose.matrix(), frames[late].pose.matrix(), atol=1e-12)
            np.testing.assert_array_equal(frame.colours[0][..., :3], frames[late].colour)
        assert len(samples) == 6 and samples[3][1:4] == frames[3].pose.position_m.tolist()


def test_a_file_is_a_scene_too():
    """Its lamps are on; the view looks at its wall."""
    file = str(Path(__file__).parents[1] / "scenes" / "files" / "lamps-of-blender.glb")
    with Serving("--scene", file, "--web", "127.0.0.1:*") as server:
        jar, address = CookieJar(), server.line("for a browser").split()[-1]
        opened(address, jar)
        start = json.loads(opened(address.partition("?")[0] + "session.json", jar)[2])["viewpoint"]
        view = View(Pose(start["position"], start["orientation"]), EYES[0].fov)
        (frame,) = spoken((address.partition("?")[0], jar), encode(attrs.evolve(decode(ask()), views=(view,))))
        assert frame.colours[0][..., :3].max() > 0 and frame.inverse_depths[0].max() > 0
