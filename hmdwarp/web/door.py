"""The door for browsers: the page, and a WebSocket behind which the feed is spoken as it is.

A request of a browser is a request of docs/feed.md, a frame is a frame: the door reads neither, and
puts the server's token in. So whatever the server bounds, refuses or
counts, it does here too. Shaders of warps go out as WebGL 2 takes them: the same text, as fragment
shaders of GLSL ES 3.00.
"""

from __future__ import annotations

import asyncio
import hmac
import json
import logging
import mimetypes
import re
import secrets
import socket
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import zmq
import zmq.asyncio
from aiohttp import web

from ..base import InputError, are_digits
from ..gpu import VERSION, flatten
from ..sources.feed.message import LARGEST_ASK, request_bytes, token_of
from ..sources.feed.options import KeyPair
from ..sources.feed.sockets import Places, is_local, set_options
from .certificate import certified, hosts_at, is_number
from .visitors import OneLine, Visitor, Visitors

PAGE = Path(__file__).parent / "page"
_IMAGE = re.compile(r"layout\(r32f\) readonly uniform image2D")
# Of `iterative` without seeds, which WebGL 2 cannot scatter: more plain steps take their place.
STEPS = 5
WARPS: Mapping[str, tuple[str, dict[str, object]]] = {
    "rotation": ("warps/rotation.comp", {"CLAMP": 0}),
    "iterative": ("warps/iterative.comp", {"PLAIN": STEPS - 1, "SLANTED": 1, "CATMULL_ROM": 1}),
}


def shaders() -> dict[str, str]:
    """Return each shader's text by its file's name, or its warp's."""
    own = {path.name: _as_es(str(path), {}) for path in PAGE.iterdir() if path.suffix in (".vert", ".frag")}
    written = {"WRITES_DEPTH": 1, "OUTPUT": str(PAGE / "to_web.glsl")}
    return own | {name: _as_es(path, defines | written) for name, (path, defines) in WARPS.items()}


def _as_es(path: str, defines: Mapping[str, object]) -> str:
    preface = (PAGE / "preface.glsl").read_text(encoding="utf-8")
    return _IMAGE.sub("uniform sampler2D", flatten(path, defines).text.replace(VERSION + "\n", preface))


_TOKEN_BYTES = 16
_TOKEN_AT = 52  # in a request, docs/feed.md
_FEED = {"LINGER": 0, "SNDHWM": 256, "RCVHWM": 1}
_MOST_UNSENT = 1 << 16  # bytes, in the system
MOST_REPORT = 1 << 16  # letters of a page's report
_HEADERS = {
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",
}


class Door:
    """Serve the page at HOST:PORT, and pass browsers' messages on to a server of the feed.

    feed: its address, as the server says it; secret, pair: what it wants of its clients. about:
    what the page is told, by key. files: by path, what makes JSON, such as a trace. certificate: a
    PEM file with key and certificate, made if missing; None for plain HTTP. log: makes what takes
    the reports of a connection, and is closed then. places: those of the feed's door, whose limits
    hold here too.
    Errors: InputError for an address that cannot be listened at, and for one beyond this machine
    without a certificate unless is_open.
    """

    def __init__(
        self,
        address: str,
        feed: str,
        about: Mapping[str, Any],
        files: Mapping[str, Callable[[], Any]],
        *,
        secret: str = "",
        pair: KeyPair | None = None,
        certificate: Path | None = None,
        is_open: bool = False,
        log: Callable[[], Any] | None = None,
        places: Places | None = None,
        say: Callable[[str], None] = lambda text: None,
    ) -> None:
        on, separator, number = address.rpartition(":")
        if not (separator and on and (number == "*" or (are_digits(number) and int(number) < 65536))):
            raise InputError(f"--web {address}: expected HOST:PORT, such as 127.0.0.1:5580, or * for a free port")
        if not (is_local(f"tcp://{address}") or certificate or is_open):
            raise InputError(
                f"--web {address}: beyond this machine it wants --certificate FILE.pem, made if missing, without "
                "which a browser offers no VR; or give --open to send pictures and cookies unencrypted"
            )
        self._feed, self._secret, self._pair, self._say = feed.replace("0.0.0.0", "127.0.0.1"), secret, pair, say
        self._log, self._places = log, places or Places(lambda _, __, text: say(text))
        self._tls: Any = None
        self._scheme = "http" if certificate is None else "https"
        if certificate is not None:
            self._tls, fingerprint, is_new = certified(certificate, on)
            if is_new:
                say(f"made {certificate}, with a private key, which stays here")
            say(f"the SHA-256 fingerprint of {certificate}: {fingerprint}")
        self._files = {"/session.json": _as_json(about), "/shaders.json": _as_json(shaders())}
        self._made = {f"/{name}": make for name, make in files.items()}
        for path in PAGE.iterdir():
            if path.suffix in (".html", ".css", ".js"):
                self._files[f"/{path.name}"] = path.read_bytes(), mimetypes.guess_type(path.name)[0] or ""
        self._files["/"] = self._files.pop("/index.html")
        self._token = secrets.token_urlsafe(_TOKEN_BYTES)
        # A secret of its own makes cookies that a server started anew knows again.
        self._key = self._secret.encode() or secrets.token_bytes(_TOKEN_BYTES)
        host = on.strip("[]")
        try:
            family = socket.AF_INET6 if ":" in host else socket.AF_INET
            self._listener = socket.create_server((host, 0 if number == "*" else int(number)), family=family)
        except OSError as error:
            raise InputError(
                f"--web {address}: {error.strerror or error}: take another port or stop what listens there"
            ) from error
        host, port = self._listener.getsockname()[:2]
        host = hosts_at(host)[0]
        self._place = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
        self._context = zmq.asyncio.Context()
        self._cookie = f"hmdwarp-{port}"  # a browser gives a host's cookies to all of its ports
        self._loop = asyncio.new_event_loop()
        self._runner, self._visitors = self._loop.run_until_complete(self._begin())
        self._thread = threading.Thread(target=self._work, name="web", daemon=True)
        self._thread.start()

    @property
    def address(self) -> str:
        """What to open once, with a token that counts once."""
        return f"{self._scheme}://{self._place}/?token={self._token}"

    async def _begin(self) -> tuple[web.AppRunner, Visitors]:
        app = web.Application(middlewares=[self._guard], client_max_size=0)
        app.router.add_get("/feed", self._pass)
        app.router.add_get("/{path:.*}", self._give)
        logger = logging.Logger("web")
        logger.addHandler(OneLine(self._places.note))
        runner = web.AppRunner(app, access_log=None, handle_signals=False, shutdown_timeout=0.5, logger=logger)
        await runner.setup()
        assert runner.server is not None, "it is set up"
        return runner, Visitors(self._loop, self._listener, runner.server, self._tls, self._places)

    def _work(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_forever()
        self._visitors.close()
        self._loop.run_until_complete(self._runner.cleanup())
        self._loop.close()

    @web.middleware
    async def _guard(self, request: Any, handler: Any) -> Any:
        """Let nobody in by another name (DNS rebinding), from another page, or without a cookie."""
        try:
            host, origins = request.host, set(request.headers.getall("Origin", []))
            given, cookie = request.query.get("token"), request.cookies.get(self._cookie, "")
        except ValueError:  # such as an address that is none
            host, given, cookie = "", None, ""
        if not host or len(request.headers.getall("Host", [])) != 1:
            return web.Response(status=400, text="expected a request with one Host\n")
        if not _is_own(host) or not origins <= {f"{self._scheme}://{host}"}:
            return web.Response(status=403, text="open this page by the address that hmdwarp printed\n")
        if given is not None:
            return self._let_in(request, given)
        if not hmac.compare_digest(_bytes(cookie), _bytes(self._signed(cookie.partition(".")[0]))):
            return web.Response(status=403, text="open the address that hmdwarp printed: its token counts once\n")
        request["visitor"] = self._visitors.heard(request)
        response = await handler(request)
        if not response.prepared:
            sockets = f"{'ws' if self._tls is None else 'wss'}://{host}"  # which 'self' does not mean in every browser
            policy = (
                "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
                f"connect-src 'self' {sockets}; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
            )
            response.headers.update({**_HEADERS, "Content-Security-Policy": policy})
        return response

    def _signed(self, name: str) -> str:
        return f"{name}.{hmac.digest(self._key, b'a cookie of hmdwarp ' + _bytes(name), 'sha256').hex()}"

    def _let_in(self, request: Any, given: str) -> Any:
        if not hmac.compare_digest(_bytes(given), self._token.encode()):
            text = "this token was used already, or is none: take the newest address that hmdwarp printed\n"
            return web.Response(status=403, text=text)
        self._token = secrets.token_urlsafe(_TOKEN_BYTES)
        cookie = self._signed(secrets.token_urlsafe(_TOKEN_BYTES))
        self._say(f"a browser is here; for another one open {self.address}")
        rest = request.rel_url.without_query_params("token")
        response = web.Response(status=303, headers={**_HEADERS, "Location": str(rest)})
        response.set_cookie(self._cookie, cookie, httponly=True, samesite="Strict", secure=self._tls is not None)
        return response

    async def _give(self, request: Any) -> Any:
        """Give one of the files read at the start: no path of this machine is looked up."""
        if (make := self._made.pop(request.path, None)) is not None:
            self._files[request.path] = _as_json(make())
        found = self._files.get(request.path)
        if found is None:
            return web.Response(status=404, text="not here\n")
        return web.Response(body=found[0], content_type=found[1], charset="utf-8")

    async def _pass(self, request: Any) -> Any:
        """Pass messages both ways until either end goes, or says nothing at all."""
        visitor: Visitor = request["visitor"]
        browser = web.WebSocketResponse(max_msg_size=max(LARGEST_ASK, MOST_REPORT) + 1, heartbeat=5.0, compress=False)
        await browser.prepare(request)
        # The system holds few unsent bytes: what waits there gets no newer.
        if (option := getattr(socket, "TCP_NOTSENT_LOWAT", None)) is not None:
            request.transport.get_extra_info("socket").setsockopt(socket.IPPROTO_TCP, option, _MOST_UNSENT)
        server, port, token = self._context.socket(zmq.DEALER), 0, token_of(self._secret)
        log = self._log() if self._log is not None else None
        down = asyncio.ensure_future(self._pass_down(server, browser))
        try:
            port = self._connect(server, visitor.address)
            async for message in browser:
                visitor.is_page, visitor.heard_s = True, self._loop.time()
                data = message.data
                if log is not None and isinstance(data, str):
                    await asyncio.to_thread(log.take, data)  # a slow disk holds up no frames
                elif not isinstance(data, bytes) or not request_bytes(0) <= len(data) <= LARGEST_ASK:
                    break
                else:
                    data = data[:_TOKEN_AT] + token + data[_TOKEN_AT + len(token) :]
                    with suppress(zmq.Again):  # as many wait already; the page asks again
                        await server.send(data, zmq.NOBLOCK)
        finally:
            visitor.is_page = False
            down.cancel()
            server.close(0)
            self._places.guests.pop(port, None)
            if log is not None:
                log.close()
        await browser.close()
        return browser

    def _connect(self, server: Any, address: str) -> int:
        """Connect to the feed, from a free port, for which it counts the page's address."""
        host = self._feed.partition("://")[2].rpartition(":")[0]
        with socket.socket(socket.AF_INET6 if "[" in host else socket.AF_INET) as probe:
            probe.bind((host.strip("[]"), 0))
            port = int(probe.getsockname()[1])
        self._places.guests[port] = address
        self._visitors.count()
        set_options(zmq, server, _FEED | {"IPV6": "[" in host})
        if (pair := self._pair) is not None:
            server.curve_serverkey = pair.public
            server.curve_publickey, server.curve_secretkey = zmq.curve_keypair()
        server.connect(self._feed.replace("://", f"://{host}:{port};"))
        return port

    async def _pass_down(self, server: Any, browser: Any) -> None:
        while True:
            data = await server.recv(copy=False)
            await browser.send_bytes(data.buffer)  # waits until the browser has room

    def close(self) -> None:
        """Shut the door; pages say that the server is gone."""
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._context.destroy(0)


def _as_json(content: Any) -> tuple[bytes, str]:
    return json.dumps(content).encode(), "application/json"


def _bytes(text: str) -> bytes:
    return text.encode("utf-8", "backslashreplace")  # of bytes that are no text, too


def _is_own(host: str) -> bool:
    """Whether a browser came by a number or this machine's name: no page of others has these."""
    name = host.rpartition(":")[0] if are_digits(host.rpartition(":")[2]) and not host.endswith("]") else host
    name, own = name.strip("[]"), socket.gethostname()
    return name in ("localhost", own, f"{own}.local") or is_number(name)
