"""The client's end of the feed: requests go out, frames come in with the instant they arrived.

A Viewer waits for one picture at a time: the truth of a run. Two clocks tick apart: their offset
and drift are found by the exchanges of the shortest round trips (Mills 1995, clock filter).
Source: Mills 2010, RFC 5905 (NTP), section 8, for the offset of one exchange.
"""

from __future__ import annotations

import contextlib
import struct
import threading
import time
from collections import deque
from typing import Any

import attrs

from ...base import InputError, MachineError
from ...geometry import View
from . import sockets
from .message import FULL, MOST_BYTES, Ask, FrameMessage, Malformed, Refusal, Unchanged, Wish, decode, encode, token_of

KEPT = 256
MOST_DRIFT = 500e-6  # A quartz is within this; what lies further apart is a clock that was set, or another machine's


@attrs.frozen
class Exchange:
    sent_ns: int
    received_ns: int
    answered_ns: int
    heard_ns: int

    @property
    def round_trip_ns(self) -> int:
        """Time on the way, both ways, without what the other end took."""
        return (self.heard_ns - self.sent_ns) - (self.answered_ns - self.received_ns)

    @property
    def offset_ns(self) -> float:
        """Their clock less this one, within half the round trip."""
        return ((self.received_ns - self.sent_ns) + (self.answered_ns - self.heard_ns)) / 2

    @property
    def middle_ns(self) -> float:
        return (self.sent_ns + self.heard_ns) / 2


class Alignment:
    """Offset and drift between two clocks; anew after each jump, when the other clock was set."""

    def __init__(self) -> None:
        self._kept: deque[Exchange] = deque(maxlen=KEPT)
        self.jumps = 0

    def add(self, one: Exchange) -> bool:
        """Take an exchange unless it cannot be; return whether the other clock has jumped."""
        if one.round_trip_ns < 0 or one.answered_ns < one.received_ns:
            return False
        last = self._kept[-1] if self._kept else one
        # No drift within reason makes it agree with the last one.
        drifted = MOST_DRIFT * abs(one.middle_ns - last.middle_ns)
        within_ns = (one.round_trip_ns + last.round_trip_ns) / 2 + drifted + 1
        if jumped := abs(one.offset_ns - last.offset_ns) > within_ns:
            self._kept.clear()
            self.jumps += 1
        self._kept.append(one)
        return jumped

    @property
    def _by_round_trip(self) -> list[Exchange]:
        return sorted(self._kept, key=lambda one: one.round_trip_ns)

    @property
    def round_trip_ns(self) -> int:
        return self._by_round_trip[0].round_trip_ns

    @property
    def offset_ns(self) -> float:
        """Their clock less this one at the shortest round trip, within half of it."""
        return self._by_round_trip[0].offset_ns

    @property
    def drift(self) -> float | None:
        """Seconds their clock gains in one of ours, by the best exchanges; None if not known."""
        best = self._by_round_trip[: max(1, len(self._kept) // 4)]
        times, offsets = [exchange.middle_ns for exchange in best], [exchange.offset_ns for exchange in best]
        if best[-1].round_trip_ns >= MOST_DRIFT * (max(times) - min(times)):
            return None
        middle, offset = sum(times) / len(times), sum(offsets) / len(offsets)
        spread = sum((time - middle) ** 2 for time in times)
        slope = sum((time - middle) * (one - offset) for time, one in zip(times, offsets, strict=True)) / spread
        return slope if abs(slope) <= MOST_DRIFT else None

    def summary(self) -> dict[str, float | int | None]:
        known: dict[str, float | int | None] = {}
        if self._kept:
            known = {"offset_ms": self.offset_ns / 1e6, "drift_ppm": self.drift and self.drift * 1e6}
            known["shortest_round_trip_ms"] = self.round_trip_ns / 1e6
        return known | {"jumps": self.jumps}


# What came in and was not taken yet; the oldest goes first.
_MOST_FRAMES, _MOST_HELD = 128, 512 << 20
# Bytes that may wait to be taken: twice what an honest server sends before they have left it.
_MOST_BEHIND = 2 * sockets.MOST_OF_CLIENT
_MOST_PATIENCE = 4


@attrs.frozen(eq=False)
class Arrival:
    frame: FrameMessage
    heard_ns: int


class Caller:
    """One client of a server, with a thread of its own, that calls again what goes away."""

    def __init__(self, address: str, secret: str = "", server_key: bytes = b"") -> None:
        self._zmq: Any = sockets.zmq_module()
        self.address, self._token = sockets.address_of(address, "--connect"), token_of(secret)
        self._server_key = server_key
        self._hearing: sockets.Hearing | None = None  # the connection that there is
        self._is_told, self._patience = False, 1  # whether its silence is told
        self.clock = Alignment()
        self._changed = threading.Condition()
        self._arrived: deque[Arrival] = deque()
        self._unchanged: deque[int] = deque(maxlen=_MOST_FRAMES)
        self._held = 0
        self._asked = self._newest = 0  # the newest requested frame, and the newest that has arrived
        self._lines: deque[str] = deque(maxlen=100)  # lines for the log, each once
        self.malformed = 0
        self._context = self._zmq.Context()
        self._orders, orders = (self._context.socket(self._zmq.PAIR) for _ in range(2))
        for socket in (self._orders, orders):
            socket.setsockopt(self._zmq.LINGER, 0)
        orders.bind("inproc://orders")
        self._orders.connect("inproc://orders")
        socket = self._context.socket(self._zmq.DEALER)
        own = {"SNDHWM": 64, "RCVHWM": 0, "MAXMSGSIZE": MOST_BYTES + sockets.SEAL_BYTES, "IMMEDIATE": 1}
        own |= {"RECONNECT_IVL": 50, "RECONNECT_IVL_MAX": 1000, "CONNECT_TIMEOUT": 5000, "IPV6": "[" in self.address}
        sockets.set_options(self._zmq, socket, sockets.LINK | own)
        failed = "EVENT_HANDSHAKE_FAILED_NO_DETAIL", "EVENT_HANDSHAKE_FAILED_PROTOCOL"
        self._no_handshakes = sum(getattr(self._zmq, name) for name in failed)
        told = self._no_handshakes | self._zmq.EVENT_CONNECTED | self._zmq.EVENT_DISCONNECTED
        try:
            if server_key:
                socket.curve_publickey, socket.curve_secretkey = self._zmq.curve_keypair()
                socket.curve_serverkey = server_key
            events = socket.get_monitor_socket(told)
            socket.connect(self.address)
        except self._zmq.ZMQError as error:
            self._context.destroy(0)
            raise InputError(f"--connect {address}: {error}: expected the HOST:PORT of a server") from error
        self._thread = threading.Thread(target=self._work, args=(orders, socket, events), name="feed", daemon=True)
        self._thread.start()

    def ask(self, ask: Ask) -> int:
        """Send a request; return when, on this machine's clock. Errors: MachineError."""
        now_ns = time.monotonic_ns()
        newest, token, self._asked = self._newest, self._token, max(self._asked, ask.number)
        if not self._thread.is_alive():  # nobody would take the request, and sending would wait for ever
            raise MachineError(f"--connect {self.address}: the feed's thread has ended, see the error above")
        request = attrs.evolve(ask, sent_ns=now_ns, received=newest, token=token)
        self._orders.send(encode(request))
        return now_ns

    def take_unchanged(self) -> list[int]:
        with self._changed:
            found = list(self._unchanged)
            self._unchanged.clear()
        return found

    def take(self) -> list[Arrival]:
        with self._changed:
            arrived, self._held = list(self._arrived), 0
            self._arrived.clear()
        return arrived

    def wait_until(self, instant_ns: int) -> bool:
        with self._changed:
            left_s = (instant_ns - time.monotonic_ns()) * 1e-9
            if not (self._arrived or self._unchanged) and left_s > 0:
                self._changed.wait(left_s)
            return bool(self._arrived)

    def lines(self) -> list[str]:
        with self._changed:
            lines = list(self._lines)
            self._lines.clear()
        return lines

    def close(self) -> None:
        if self._thread.is_alive():
            self._orders.send(b"")
        self._thread.join()
        self._orders.close(0)
        self._context.term()

    def _work(self, orders: Any, socket: Any, events: Any) -> None:
        poller = self._zmq.Poller()
        for each in (socket, orders, events):
            poller.register(each, self._zmq.POLLIN)
        try:
            while True:
                ready = dict(poller.poll(sockets.LOOK_NS // 1_000_000 if self._hearing is not None else None))
                if socket in ready and (parts := sockets.waiting_parts(self._zmq, socket)):
                    if self._hearing is not None:
                        self._hearing.taken += sockets.wire_bytes(parts)
                    self._receive(parts, time.monotonic_ns())
                if events in ready:
                    kind, descriptor = struct.unpack_from("=HI", events.recv_multipart()[0])
                    is_new = kind == self._zmq.EVENT_CONNECTED
                    if is_new or (self._hearing is not None and descriptor == self._hearing.wire.descriptor):
                        self._hearing = None
                    if is_new:
                        with contextlib.suppress(OSError):  # closed since
                            self._hearing = sockets.Hearing(sockets.Wire.of(descriptor), time.monotonic_ns())
                    if kind & self._no_handshakes:
                        why = "--server-key is another server's, or there is none with a key pair"
                        if not self._server_key:
                            why = "a server with a key pair wants --server-key FILE, or there is no 'hmdwarp serve'"
                        self._note(f"{self.address}: refused: no handshake: {why}")
                self._cut_if_silent(time.monotonic_ns())
                if orders in ready:
                    data = orders.recv()
                    if not data:
                        return
                    # No server is there, or it takes nothing.
                    with contextlib.suppress(self._zmq.Again):
                        socket.send(data, self._zmq.NOBLOCK)
        finally:
            socket.disable_monitor()
            events.close(0)
            socket.close(0)
            orders.close(0)

    def _cut_if_silent(self, now_ns: int) -> None:
        hearing = self._hearing
        if hearing is None or now_ns - hearing.looked_ns < sockets.LOOK_NS:
            return
        is_silent = hearing.is_silent(now_ns, self._patience)
        if hearing.received - hearing.taken > _MOST_BEHIND:
            self._hearing = None
            hearing.wire.cut()
            self._note(f"{self.address}: more than {_MOST_BEHIND >> 20} MiB unread: connecting anew")
        if not is_silent or self._hearing is None:
            return
        # A tunnel may hide how long the way is, and the first answer then takes longer.
        self._hearing, self._patience = None, min(2 * self._patience, _MOST_PATIENCE)
        hearing.wire.cut()
        if not self._is_told:
            self._note(f"{self.address}: not a byte for {sockets.SILENCE_NS / 1e9:g} s: connecting anew")
            self._is_told = True

    def _receive(self, parts: list[bytes], heard_ns: int) -> None:
        try:
            if len(parts) != 1:
                raise Malformed(f"{len(parts)} parts: expected one")
            message = decode(parts[0])
            if isinstance(message, Ask):
                raise Malformed("a message for servers: expected a frame")
            if isinstance(message, FrameMessage | Unchanged) and message.number > self._asked:
                raise Malformed(f"frame {message.number}: expected one of the {self._asked} that were requested")
        except Malformed as error:
            self.malformed += 1
            if self.malformed == 1:
                self._note(f"left out: {error}; further ones are counted")
            return
        if isinstance(message, Refusal):
            self._note(f"{self.address}: refused: {message.text}")
            return
        if isinstance(message, Unchanged):
            with self._changed:
                self._unchanged.append(message.number)
                self._changed.notify_all()
            return
        if self.clock.add(Exchange(message.asked_ns, message.received_ns, message.sent_ns, heard_ns)):
            self._note(f"{self.address}: the clock there has jumped, it is aligned anew")
        with self._changed:
            self._newest, self._is_told, self._patience = max(self._newest, message.number), False, 1
            self._arrived.append(Arrival(message, heard_ns))
            self._held += message.bytes
            while len(self._arrived) > _MOST_FRAMES or (self._held > _MOST_HELD and len(self._arrived) > 1):
                self._held -= self._arrived.popleft().frame.bytes
            self._changed.notify_all()

    def _note(self, line: str) -> None:
        with self._changed:
            if line not in self._lines:
                self._lines.append(line)
            self._changed.notify_all()


_ANSWER_NS, _AGAIN_NS = 10_000_000_000, 1_000_000_000
_MOST_UNANSWERED = 3  # unanswered in a row: then no more requests are sent


class Viewer:
    """A client that waits for one eye's view at a time, never coded. Errors: as Caller."""

    def __init__(self, address: str, secret: str = "", server_key: bytes = b"", wish: Wish = FULL) -> None:
        self._caller, self._wish = Caller(address, secret, server_key), wish
        self._number = self._unanswered = 0

    def fetch(self, view: View, size: tuple[int, int], time_ns: int) -> FrameMessage | None:
        """Return the view as the server draws it, or None; always None after three in a row."""
        if self._unanswered >= _MOST_UNANSWERED:
            return None
        self._unanswered += 1
        head, first = view.pose @ view.head_from_eye.inverse(), self._number + 1
        until_ns = time.monotonic_ns() + _ANSWER_NS
        while (now_ns := time.monotonic_ns()) < until_ns:
            self._number += 1
            self._caller.ask(Ask(self._number, 0, time_ns, time_ns, 0, size, head, (view,), wish=self._wish))
            # Requested again after a while: the connection may not have been there.
            again_ns = min(until_ns, now_ns + _AGAIN_NS)
            while time.monotonic_ns() < again_ns:
                self._caller.wait_until(again_ns)
                for one in (arrival.frame for arrival in self._caller.take()):
                    plain = not one.is_coded and one.is_finite
                    if one.number >= first and one.size == size and len(one.views) == 1 and plain:
                        self._unanswered = 0
                        return one
                if any("refused" in line for line in self._caller.lines()):
                    return None
        return None

    def close(self) -> None:
        self._caller.close()
