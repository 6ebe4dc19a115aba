"""The server's end of the feed: what each client requests, and how much it has yet to take."""

from __future__ import annotations

import hmac
import math
import sys
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ...base import InputError
from ...geometry import View, inverse_depth_from_metres
from ..sequences.recorded import as_pictures
from . import bounds, message, sockets
from .message import Ask, FrameMessage, Malformed, Refusal, encode
from .options import KeyPair, key_pair, secret_in
from .sockets import MOST_OF_CLIENT, SILENT_NS, Connection

MOST_OF_ALL = 4 * MOST_OF_CLIENT  # bytes of frames that wait for all clients
_MOST_WAITING = 2  # frames that wait for a client: the one that is under way, and the next
_MOST_CLIENTS = 64
_LOOK_MS = 2  # what a frame waits for may come at any time, but tells nobody
_STUCK_NS = 1_000_000_000  # frames that wait longer than this for their client make room for others'
# Lines of one kind and address, and all lines, in a second.
_MOST_LINES, _MOST_LINES_IN_ALL = 4, 40


@attrs.frozen(eq=False)
class _Waiting:
    bytes: int
    since_ns: int
    tracker: Any  # the library's; done once it has handed over the last byte to the system


@attrs.define(eq=False)
class _Client:
    name: str
    received_ns: int
    connection: Connection | None  # None where the system does not say
    newest: int = 0
    ask: tuple[Ask, int] | None = None
    passed_over: int = 0
    waiting: deque[_Waiting] = attrs.field(factory=deque)
    spent_ns: int = 0  # time that the server took for it; raised to the others' where it did not ask

    @property
    def address(self) -> str:
        return self.connection.address if self.connection is not None else ""


@attrs.frozen(eq=False)
class Asked:
    client: bytes
    ask: Ask
    received_ns: int


class _Log:
    """Pass on so many lines a second of each kind and address, and of all; count the rest."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._second = self._left_out = 0
        self._said: Counter[tuple[str, str]] = Counter()
        self._lock = threading.RLock()  # the web's door has a thread of its own

    def say(self, kind: str, address: str, text: str) -> None:
        with self._lock:
            self.next_second()
            self._said[kind, address] += 1
            if self._said[kind, address] > _MOST_LINES or self._said.total() - self._left_out > _MOST_LINES_IN_ALL:
                self._left_out += 1
            else:
                self._say("".join(letter if letter.isprintable() else " " for letter in text))

    def next_second(self) -> None:
        with self._lock:
            if (second := time.monotonic_ns() // 1_000_000_000) != self._second:
                if self._left_out:
                    self._say(f"left out {self._left_out} more lines like these")
                self._second, self._left_out = second, 0
                self._said.clear()


class Listener:
    """Receive requests, and answer each client at its own pace.

    Of each client the newest request counts, while it has no frames to take. The client that took
    least of the server's time has its turn. A frame that cannot be sent at once is dropped; what
    waits is counted by what the library has handed to the system. per_address: connections from one
    address. pair: encrypts. say: takes lines for the log. Errors: InputError for an address that
    cannot be listened at, or beyond the loopback without a secret or a pair, unless is_open.
    """

    def __init__(
        self,
        address: str,
        secret: str = "",
        pair: KeyPair | None = None,
        *,
        is_open: bool = False,
        per_address: int = sockets.MOST_OF_ADDRESS,
        say: Callable[[str], None] = lambda text: None,
    ) -> None:
        where = sockets.address_of(address, "--listen", serves=True)
        if not (sockets.is_local(where) or secret or pair or is_open):
            hint = "give --key-pair NAME or --token-file FILE, or --open to let anybody in"
            raise InputError(f"--listen {address}: beyond this machine it wants a key pair or a shared secret: {hint}")
        self._zmq: Any = sockets.zmq_module()
        self._token, self._log, self._is_encrypted = message.token_of(secret), _Log(say), pair is not None
        self.places = sockets.Places(self._log.say, per_address)  # for the web's door beside it
        self._clients: dict[bytes, _Client] = {}
        # Who has a turn since when, and what the client with the last turn had spent before it.
        self._drawn_for: tuple[bytes, int] | None = None
        self._begun_ns = 0
        self._left: list[_Waiting] = []  # what still waits for clients that are forgotten
        self._count = 0
        self._context = self._zmq.Context()
        self._socket = self._context.socket(self._zmq.ROUTER)
        # Frames of any size are given without a copy, so that it is known when they have left.
        self._socket.copy_threshold = 0
        own = sockets.CALLS | {"RCVHWM": 0, "SNDHWM": 64, "RCVBUF": sockets.KERNEL_BYTES, "IPV6": "[" in where}
        own |= {"MAXMSGSIZE": message.LARGEST_ASK + sockets.SEAL_BYTES, "ROUTER_MANDATORY": 1, "ROUTER_HANDOVER": 0}
        sockets.set_options(self._zmq, self._socket, sockets.LINK | own)
        if pair is not None:
            self._socket.curve_publickey, self._socket.curve_secretkey = pair.public, pair.secret
            self._socket.curve_server = True
        self._connections = sockets.Connections(self._zmq, self._socket, self.places)
        try:
            self._socket.bind(where)
        except self._zmq.ZMQError as error:
            self.close()
            raise InputError(f"--listen {address}: {error}: take another port or stop what listens there") from error
        self.address = self._socket.getsockopt_string(self._zmq.LAST_ENDPOINT)

    def next(self, wait_ms: int) -> Asked | None:
        """Return the next request to answer, or None; the time until the next call is its."""
        if self._drawn_for is not None:
            (before, since_ns), self._drawn_for = self._drawn_for, None
            if before in self._clients:
                self._clients[before].spent_ns += time.monotonic_ns() - since_ns
        waits = any(client.ask is not None for client in self._clients.values())
        self._receive(0 if self._turn() else min(wait_ms, _LOOK_MS) if waits else wait_ms)
        # While a frame is drawn nobody listens, and who asks meanwhile is not silent.
        self._connections.listened_ns = time.monotonic_ns()
        now_ns, gone = time.monotonic_ns(), set()
        while self._connections.gone:
            gone.add(self._connections.gone.popleft())
        for one, client in list(self._clients.items()):
            if now_ns - client.received_ns > SILENT_NS:
                self._cut(one, f"cut, silent for {SILENT_NS // 10**9} s")
            elif client.connection in gone:
                self._forget(one, "disconnected")
        while self._connections.cuts:
            address, why = self._connections.cuts.popleft()
            self._log.say(f"cut {why}", address, f"{address} cut: {why}")
        self._log.next_second()
        if (turn := self._turn()) is None:
            return None
        client = self._clients[turn]
        self._drawn_for, self._begun_ns = (turn, time.monotonic_ns()), client.spent_ns
        assert client.ask is not None, "it has a turn"
        (ask, received_ns), client.ask = client.ask, None
        return Asked(turn, ask, received_ns)

    def _turn(self) -> bytes | None:
        """Return the next client to draw for: start-time fair queueing (Goyal, Vin, Cheng 1996)."""
        asking = [who for who, client in self._clients.items() if client.ask is not None]
        for who in sorted(asking, key=lambda who: self._clients[who].spent_ns):
            # One that is stuck may go meanwhile.
            if who not in self._clients or (asked := self._clients[who].ask) is None:
                continue
            ask, _ = asked
            # Raw, without further layers; what it is in the end is counted before it is sent. More
            # than a message may have waits for nothing: it is refused.
            if self._has_room(who, min(12 * math.prod(ask.size) * len(ask.views), message.MOST_BYTES)):
                return who
        return None

    def _has_room(self, who: bytes, size: int) -> bool:
        """Return whether so many bytes may wait; where all would be too many, cut what is stuck."""
        client, held = self._clients[who], self._held(who)
        if len(client.waiting) >= _MOST_WAITING or (held and held + size > MOST_OF_CLIENT):
            return False
        self._left = [one for one in self._left if not one.tracker.done]
        waiting = [*self._left, *(one for each in self._clients.values() for one in each.waiting)]
        if sum(one.bytes for one in waiting) + size <= MOST_OF_ALL:
            return True
        # Whoever has the oldest frame, of the address that holds most; not who asks.
        held_by: Counter[str] = Counter()
        for other, each in self._clients.items():
            held_by[each.address] += self._held(other)
        since = {other: each.waiting[0].since_ns for other, each in self._clients.items() if each.waiting}
        before_ns, most = time.monotonic_ns() - _STUCK_NS, max(held_by.values())
        stuck = [
            (since_ns, other)
            for other, since_ns in since.items()
            if other != who and held_by[self._clients[other].address] == most and since_ns < before_ns
        ]
        if stuck:
            self._cut(min(stuck)[1], "cut, as its frames wait and leave no room for others'")
        return False

    def _held(self, who: bytes) -> int:
        client = self._clients[who]
        waiting = client.waiting
        while waiting and waiting[0].tracker.done:
            is_last = len(waiting) == 1 or not waiting[1].tracker.done
            # An encrypted frame is another one, held by the library until the system took it.
            if self._is_encrypted and is_last and client.connection and not client.connection.takes_more():
                break
            waiting.popleft()
        return sum(one.bytes for one in waiting)

    def _cut(self, who: bytes, why: str) -> None:
        if (connection := self._clients[who].connection) is not None:
            self._connections.cut(connection, why)
        self._forget(who, why)

    def _receive(self, wait_ms: int) -> None:
        # A flood does not keep the server from drawing.
        for _ in range(256):
            if not self._socket.poll(wait_ms):
                return
            wait_ms = 0
            frames = sockets.waiting_parts(self._zmq, self._socket, copy=False)
            if not frames:
                return
            connection = self._connections.took(frames)
            who, *parts = (frame.bytes for frame in frames)
            try:
                self._take(who, parts, connection)
            except Malformed as error:
                self._log.say("left out", connection.address if connection else "", f"left out: {error}")

    def _take(self, who: bytes, parts: list[bytes], connection: Connection | None) -> None:
        now_ns = time.monotonic_ns()
        if len(parts) != 1:
            raise Malformed(f"{len(parts)} parts: expected one")
        try:
            ask = message.decode(parts[0])
        except message.BadRequest as error:
            self._send(who, Refusal(error.number, str(error)))
            raise
        if not isinstance(ask, Ask):
            raise Malformed("a message for clients: expected a request")
        if not hmac.compare_digest(ask.token, self._token):
            self._send(who, Refusal(ask.number, "the token is not the server's"))
            raise Malformed("another token than the server's")
        client = self._clients.get(who)
        if client is None:
            if len(self._clients) >= _MOST_CLIENTS:
                self._send(who, Refusal(ask.number, f"{_MOST_CLIENTS} clients are here already"))
                raise Malformed(f"a client too many: there are {_MOST_CLIENTS}")
            self._count += 1
            client = self._clients[who] = _Client(f"client {self._count}", now_ns, connection)
            here = f"{client.name} connected: {len(ask.views)} x {ask.size[0]}x{ask.size[1]}"
            self._log.say("here", client.address, here)
        if ask.number <= client.newest:
            raise Malformed(f"{client.name}: request {ask.number} after {client.newest}")
        if client.ask is None:
            client.spent_ns = max(client.spent_ns, self._begun_ns)  # who did not ask has saved up nothing
        client.passed_over += client.ask is not None  # what it replaces was never drawn
        client.received_ns, client.newest, client.ask = now_ns, ask.number, (ask, now_ns)
        if connection is not None:
            connection.heard_ns, connection.asks, client.connection = now_ns, True, connection

    def _forget(self, who: bytes, why: str) -> None:
        client = self._clients.pop(who)
        self._left += client.waiting
        gone = f"{client.name} {why}; {client.passed_over} requests superseded"
        self._log.say("gone", client.address, gone)

    @property
    def clients(self) -> Collection[bytes]:
        return self._clients.keys()

    def answer(self, asked: Asked, frame: FrameMessage) -> bool:
        who = asked.client
        if who not in self._clients or not self._has_room(who, frame.bytes):
            return False
        return self._send(who, frame)

    def leave_out(self, asked: Asked) -> None:
        self._send(asked.client, message.Unchanged(asked.ask.number))

    def tell(self, asked: Asked, what: str) -> None:
        if asked.client in self._clients:
            client = self._clients[asked.client]
            self._log.say("told", client.address, f"{client.name}: {what}")

    def refuse(self, asked: Asked, why: str) -> None:
        why = " ".join(why.split())
        if asked.client in self._clients:  # else it has gone meanwhile
            client = self._clients[asked.client]
            self._log.say("refused", client.address, f"{client.name}: refused: {why}")
            self._send(asked.client, Refusal(asked.ask.number, why))

    def _send(self, who: bytes, what: message.Message) -> bool:
        data = message.copied(what) if isinstance(what, FrameMessage) else encode(what)
        try:
            tracker = self._socket.send_multipart([who, data], self._zmq.NOBLOCK, copy=False, track=True)
        except self._zmq.Again:
            return False
        except self._zmq.ZMQError as error:
            if error.errno != self._zmq.EHOSTUNREACH:
                raise
            if who in self._clients:
                self._forget(who, "disconnected")
            return False
        if who in self._clients and not isinstance(data, bytes):
            self._clients[who].waiting.append(_Waiting(len(data), time.monotonic_ns(), tracker))
        return True

    def close(self) -> None:
        self._socket.disable_monitor()
        self._connections.close()
        self._socket.close(0)
        self._context.term()


def listening(
    address: str, say: Callable[[str], None], token_file: Path | None, pair_name: Path | None, **how: Any
) -> tuple[Listener, str, KeyPair | None]:
    """Return what listens, the shared secret and the key pair. how, errors: as Listener."""
    secret, pair = secret_in(token_file), None
    if pair_name is not None:
        pair, is_new = key_pair(pair_name)
        if is_new:
            say(f"made {pair_name}.key_secret, which stays here, and {pair_name}.key, which clients need")
    return Listener(address, secret, pair, **how, say=say), secret, pair


_WAIT_MS = 200  # between looks at whether to stop


class Views(tuple[View, ...]):
    """The eyes to render, the left one first: world_from_eye and field of view of each."""

    size: tuple[int, int]  # (w, h) of each one's image, in pixels


# views, instant in ns -> colour and depth of each eye, and its view where that is another one
Render = Callable[[Views, int], Sequence[Any]]


def serve(
    render: Render, listen: str = "127.0.0.1:5570", *, goes_on: Callable[[], bool] = lambda: True, **who: Any
) -> None:
    """Render for `hmdwarp live|replay --connect` until interrupted, or until goes_on() says no.

    Parameters
    ----------
    render : callable
        ``render(views, time_ns) -> colour, depth_m``, or ``colour, depth_m, views`` of a camera:
        where it really was. ``views.size`` is (w, h) pixels, ``time_ns`` counts from the trace's
        begin. For each eye, row 0 at the top: colour (h, w, 3), or (h, w, 4) with coverage, uint8
        sRGB or floats of linear light; depth_m (h, w) metres along -z, inf infinitely far, 0 or NaN
        no depth.
    listen : str
        HOST:PORT; port ``*`` takes a free one.
    key_pair, token_file, is_open
        Who may connect from other machines, as `hmdwarp serve` takes it.

    Raises
    ------
    InputError
        For an address that cannot be listened at, and for results of another shape.
    MachineError
        Without ZeroMQ.
    """
    with closing(_listener(listen, **who)) as listener, suppress(KeyboardInterrupt):
        _run(listener, render, goes_on)


@contextmanager
def serving(render: Render, listen: str = "127.0.0.1:*", **who: Any) -> Iterator[str]:
    """Serve in a thread while the block runs; gives the address for `--connect`.

    Parameters
    ----------
    render, listen, who
        As for serve. What render raises is raised at the end of the block.
    """
    is_over = threading.Event()
    with closing(_listener(listen, **who)) as listener, ThreadPoolExecutor(1) as thread:
        running = thread.submit(_run, listener, render, lambda: not is_over.is_set())
        try:
            yield listener.address.removeprefix("tcp://")
        finally:
            is_over.set()
        running.result()


def _listener(listen: str, key_pair: Any = None, token_file: Any = None, *, is_open: bool = False) -> Listener:
    def say(text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    found, _, _ = listening(listen, say, token_file, key_pair, is_open=is_open)
    say(f"listening at {found.address}")
    return found


def _run(listener: Listener, render: Render, goes_on: Callable[[], bool]) -> None:
    while goes_on():
        if (asked := listener.next(_WAIT_MS)) is None:
            continue
        ask, begun_ns = asked.ask, time.monotonic_ns()
        try:
            bounds.DRAWN_BY_CPU.check(13 * len(ask.views) * ask.size[0] * ask.size[1])
        except bounds.OutOfBounds as error:
            listener.refuse(asked, str(error))
            continue
        listener.answer(asked, _drawn(render, asked, begun_ns))


def _drawn(render: Render, asked: Asked, begun_ns: int) -> FrameMessage:
    ask = asked.ask
    views = Views(ask.views)
    views.size = ask.size
    colours, depths, *seen = render(views, ask.time_ns)
    at = tuple(seen[0]) if seen else ask.views
    if not len(colours) == len(depths) == len(at) == len(views):
        found = f"{len(colours)} colours, {len(depths)} depths and {len(at)} views"
        raise InputError(f"render returned {found}: expected {len(views)} of each, as it was given")
    pairs: list[tuple[Any, Any]] = []
    shape: tuple[int, ...] = ask.size[::-1]
    for colour, depth_m in zip(map(np.asarray, colours), map(np.asarray, depths), strict=True):
        if depth_m.shape != shape or colour.shape not in ((*shape, 3), (*shape, 4)):
            found = f"colour {colour.shape} and depth {depth_m.shape}"
            raise InputError(f"render returned {found}: expected {(*shape, 3)} and {shape}")
        covered = colour[..., 3] > 0 if colour.shape[2] == 4 else np.ones(shape, bool)
        picture, metres = as_pictures(colour, depth_m)
        inverse = inverse_depth_from_metres(metres)
        inverse[np.isnan(inverse)] = -1
        pairs.append((np.dstack([picture, np.uint8(255) * covered]), inverse.astype(np.float32)))
    sent_ns = time.monotonic_ns()
    times = (ask.number, ask.sent_ns, asked.received_ns, sent_ns, sent_ns - begun_ns, ask.time_ns)
    return FrameMessage(*times, at, tuple(one for one, _ in pairs), tuple(one for _, one in pairs))
