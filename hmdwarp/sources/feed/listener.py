"""The server's end of the feed: what each client requests, and how much it has yet to take."""

from __future__ import annotations

import hmac
import time
from collections import deque
from collections.abc import Callable, Collection
from typing import Any

import attrs

from ...errors import InputError, counted
from .key_pairs import KeyPair
from .message import (
    LARGEST_ASK,
    Ask,
    BadRequest,
    Data,
    FrameMessage,
    Malformed,
    Refusal,
    copied,
    decode,
    encode,
    token_of,
)
from .shared_frames import IS_ABLE, SharedFrames
from .sockets import KERNEL_BYTES, SEAL_BYTES, Connections, address_of, is_file, is_local, waiting_parts, zmq_module

# Frames and bytes that a client was sent and has not acknowledged: as much as it may lag.
_MOST_FRAMES, _MOST_BYTES = 64, 256 << 20
_MOST_CLIENTS = 64
_SILENT_NS = 10_000_000_000
_EACH_NS = 1_000_000_000  # bad messages are reported once in this time, however many come


@attrs.define(eq=False)
class _Client:
    name: str
    received_ns: int
    newest: int = 0
    ask: tuple[Ask, int] | None = None
    passed_over: int = 0
    sent: deque[tuple[int, int]] = attrs.field(factory=deque)

    def note(self, ask: Ask, now_ns: int) -> None:
        """Take a request; what it replaces was never drawn."""
        self.received_ns, self.newest = now_ns, ask.number
        self.passed_over += self.ask is not None
        self.ask = ask, now_ns
        while self.sent and self.sent[0][0] <= ask.received:
            self.sent.popleft()

    @property
    def has_room(self) -> bool:
        """Whether what was sent has been taken, as far as it must."""
        return len(self.sent) < _MOST_FRAMES and sum(size for _, size in self.sent) < _MOST_BYTES


@attrs.frozen(eq=False)
class Asked:
    """A request to answer now."""

    client: bytes
    ask: Ask
    received_ns: int


class Listener:
    """Receive requests, and answer each client at its own pace.

    Of each client the newest request counts; it waits while the client has frames to take, and one
    that is replaced before it was drawn is passed over. No client waits for another: a frame that
    cannot be sent at once is dropped.
    pair: encrypts; clients without its public key are ignored. say: called with each line for the
    log.
    Errors: InputError for an address that cannot be listened at, and for one beyond the loopback
    without a secret or a pair, unless is_open; MachineError without the library.
    """

    def __init__(
        self,
        address: str,
        secret: str = "",
        pair: KeyPair | None = None,
        *,
        is_open: bool = False,
        say: Callable[[str], None] = lambda text: None,
    ) -> None:
        where = address_of(address)
        if not (is_local(where) or secret or pair or is_open):
            raise InputError(
                f"--listen {address}: beyond this machine it wants a key pair or a shared secret: give --key-pair NAME "
                "or --token-file FILE, or --open to let anybody in"
            )
        self._zmq: Any = zmq_module()
        self._token, self._say = token_of(secret), say
        self._clients: dict[bytes, _Client] = {}
        self._turns: deque[bytes] = deque()
        self._bad, self._reported_ns = 0, -_EACH_NS
        self._count = 0
        self._shared: SharedFrames | None = None
        self._context = self._zmq.Context()
        self._socket = self._context.socket(self._zmq.ROUTER)
        for name, value in (
            ("LINGER", 0),
            ("SNDHWM", _MOST_FRAMES),
            ("RCVHWM", 256),
            ("RCVBUF", KERNEL_BYTES),
            ("MAXMSGSIZE", LARGEST_ASK + SEAL_BYTES),
            ("ROUTER_MANDATORY", 1),
            ("ROUTER_HANDOVER", 0),
            ("IPV6", "[" in where),
        ):
            self._socket.setsockopt(getattr(self._zmq, name), value)
        if pair is not None:
            self._socket.curve_publickey, self._socket.curve_secretkey = pair.public, pair.secret
            self._socket.curve_server = True
        self._connections = Connections(self._zmq, self._socket)
        try:
            self._socket.bind(where)
        except self._zmq.ZMQError as error:
            self.close()
            raise InputError(f"--listen {address}: {error}: take another port or stop what listens there") from error
        self.address = self._socket.getsockopt_string(self._zmq.LAST_ENDPOINT)
        self._reported_cut = 0
        self._shared = self._sharing(pair)

    def _sharing(self, pair: KeyPair | None) -> SharedFrames | None:
        """Return what frames are shared by, None where they are not."""
        if not (IS_ABLE and is_file(self.address)) or pair is not None:
            return None
        try:
            return SharedFrames()
        except OSError as error:
            self._say(f"frames go by the socket: no shared memory ({error.strerror})")
            return None

    def next(self, wait_ms: int) -> Asked | None:
        """Return the next request to answer, None if there is none within that time."""
        self._receive(0 if self._has_turn() else wait_ms)
        self._forget_silent()
        self._report_cut()
        for _ in range(len(self._turns)):
            who = self._turns[0]
            self._turns.rotate(-1)
            client = self._clients[who]
            if client.ask is not None and client.has_room:
                (ask, received_ns), client.ask = client.ask, None
                return Asked(who, ask, received_ns)
        return None

    def _has_turn(self) -> bool:
        return any(client.ask is not None and client.has_room for client in self._clients.values())

    def _receive(self, wait_ms: int) -> None:
        # A flood does not keep the server from drawing.
        for _ in range(256):
            if not self._socket.poll(wait_ms):
                return
            wait_ms = 0
            frames = waiting_parts(self._zmq, self._socket, copy=False)
            if not frames:
                return
            self._connections.took(frames)
            who, *parts = (frame.bytes for frame in frames)
            try:
                self._take(who, parts)
            except Malformed as error:
                self._report_bad(error)

    def _take(self, who: bytes, parts: list[bytes]) -> None:
        now_ns = time.monotonic_ns()
        if len(parts) != 1:
            raise Malformed(f"{len(parts)} parts: expected one")
        try:
            ask = decode(parts[0])
        except BadRequest as error:
            self._send(who, encode(Refusal(error.number, str(error))))
            raise
        if not isinstance(ask, Ask):
            raise Malformed("a message for clients: expected a request")
        if not hmac.compare_digest(ask.token, self._token):
            self._send(who, encode(Refusal(ask.number, "the token is not the server's")))
            raise Malformed("another token than the server's")
        client = self._clients.get(who)
        if client is None:
            if len(self._clients) >= _MOST_CLIENTS:
                self._send(who, encode(Refusal(ask.number, f"{_MOST_CLIENTS} clients are here already")))
                raise Malformed(f"a client too many: there are {_MOST_CLIENTS}")
            self._count += 1
            client = self._clients[who] = _Client(f"client {self._count}", now_ns)
            self._turns.append(who)
            self._say(f"{client.name}: here, {len(ask.views)} eyes of {ask.size[0]}x{ask.size[1]} pixels")
        if ask.number <= client.newest:
            raise Malformed(f"{client.name}: request {ask.number} after {client.newest}")
        client.note(ask, now_ns)
        if self._shared is not None:
            self._shared.received(who, ask.received)

    def _report_bad(self, error: Malformed) -> None:
        self._bad += 1
        now_ns = time.monotonic_ns()
        if now_ns - self._reported_ns >= _EACH_NS:
            self._say(
                f"left out {self._bad} messages that are none: {error}" if self._bad > 1 else f"left out: {error}"
            )
            self._bad, self._reported_ns = 0, now_ns

    def _report_cut(self) -> None:
        cut = self._connections.cut
        if cut > self._reported_cut:
            self._say(f"{counted(cut - self._reported_cut, 'connection')} cut: a message without an end, or too many")
            self._reported_cut = cut

    def _forget_silent(self) -> None:
        now_ns = time.monotonic_ns()
        for who, client in list(self._clients.items()):
            if now_ns - client.received_ns > _SILENT_NS:
                self._forget(who, f"silent for {_SILENT_NS // 10**9} s")

    def _forget(self, who: bytes, why: str) -> None:
        client = self._clients.pop(who)
        self._turns.remove(who)
        if self._shared is not None:
            self._shared.forget(who)
        self._say(f"{client.name}: gone ({why}), {client.passed_over} requests passed over")

    @property
    def clients(self) -> Collection[bytes]:
        """The routing ids of those that are here."""
        return self._clients.keys()

    def answer(self, asked: Asked, frame: FrameMessage) -> bool:
        """Send a frame; return whether it could be sent at once."""
        shared = self._shared if asked.ask.shares and asked.client in self._clients else None
        stub = shared.put(asked.client, frame) if shared is not None else None
        sent = self._send(asked.client, copied(stub or frame))
        if not sent and shared is not None:
            shared.take_back(asked.client, frame.number)
        if sent and asked.client in self._clients:
            self._clients[asked.client].sent.append((frame.number, frame.bytes))
        return sent

    def refuse(self, asked: Asked, why: str) -> None:
        """Say why there is no frame."""
        why = " ".join(why.split())
        if asked.client in self._clients:  # else it has gone meanwhile
            self._say(f"{self._clients[asked.client].name}: refused: {why}")
            self._send(asked.client, encode(Refusal(asked.ask.number, why)))

    def _send(self, who: bytes, data: Data) -> bool:
        try:
            self._socket.send_multipart([who, data], self._zmq.NOBLOCK, copy=False)
        except self._zmq.Again:
            return False
        except self._zmq.ZMQError as error:
            if error.errno != self._zmq.EHOSTUNREACH:
                raise
            if who in self._clients:
                self._forget(who, "disconnected")
            return False
        return True

    def close(self) -> None:
        """Stop listening; what is not sent yet is dropped."""
        if self._shared is not None:
            self._shared.close()
        self._socket.disable_monitor()
        self._connections.close()
        self._socket.close(0)
        self._context.term()
