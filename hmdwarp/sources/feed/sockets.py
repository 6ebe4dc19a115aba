"""What both ends know of the library: addresses, and connections that hold little.

The library bounds messages, not the parts of one, so what each connection has sent is compared, by
the operating system's count, with what came out as whole messages.
"""

from __future__ import annotations

import contextlib
import errno
import ipaddress
import itertools
import os
import re
import socket
import struct
import sys
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Collection, Mapping
from types import ModuleType
from typing import Any, Self

import attrs

from ...base import InputError, fcntl, import_extra, takes_more, termios

SEAL_BYTES = 8 + 8 + 16 + 1  # what CURVE adds to a message: command, nonce, authenticator, flags (ZeroMQ RFC 26)
_TCP = re.compile(r"(?:tcp://)?(\[[^\]\s]+\]|[^:/\[\]\s]+):([0-9]+|\*)")
# Wire bytes from a client that may wait unread, in whole requests or not: those of 16 s at 90 Hz.
MOST_UNREAD = 1 << 20
MOST_OF_CLIENT = 256 << 20  # bytes of frames that wait for a client; one frame may always wait, even if it is larger
MOST_CONNECTIONS, MOST_OF_ADDRESS = 96, 8
# Without a valid request for so long a connection is silent, and one is idle from which another may
# take its place.
SILENT_NS, IDLE_NS = 10_000_000_000, 2_000_000_000
# Without a byte from a server for so long, beside the time of a round trip, a connection is dead;
# and how often a client looks.
SILENCE_NS, LOOK_NS = 1_500_000_000, 100_000_000
# A server calls within half a second, so that silence is known; how long is too long is judged by
# the system's count of bytes, as the library hears nothing within a long message. Its own limits
# are for where the system does not say.
#
# Libzmq 4.3.5 aborts the process (`Assertion failed: !_io_error`, its issue 4841) if it calls, or
# is called, over a connection that has ended while as many messages as RCVHWM allows waited. So
# there is no RCVHWM: who sends more than may wait is cut by the system's count.
CALLS = {"HEARTBEAT_IVL": 500, "HEARTBEAT_TIMEOUT": 60_000}
LINK = {"LINGER": 0, "HANDSHAKE_IVL": SILENT_NS // 1_000_000, "TCP_MAXRT": SILENT_NS // 1_000_000}
LINK |= {"TCP_KEEPALIVE": 1, "TCP_KEEPALIVE_IDLE": 5, "TCP_KEEPALIVE_INTVL": 1, "TCP_KEEPALIVE_CNT": 5}
KERNEL_BYTES = 1 << 14  # buffer of the kernel for each connection
_EVERY_MS, _MOST_EVENTS = 20, 4096
# Of struct tcp_info of Linux: tcpi_rtt in us, tcpi_bytes_received.
_RTT, _RTT_AT = struct.Struct("=I"), 68
_RECEIVED, _RECEIVED_AT, _INFO_BYTES = struct.Struct("=Q"), 128, 136


def zmq_module() -> ModuleType:
    return import_extra("zmq", "pyzmq", "feed")


def set_options(zmq: ModuleType, one: Any, options: Mapping[str, int]) -> None:
    for name, value in options.items():
        one.setsockopt(getattr(zmq, name), value)


def waiting_parts(zmq: ModuleType, one: Any, *, copy: bool = True) -> list[Any]:
    parts: list[Any] = []
    with contextlib.suppress(zmq.Again):
        parts = one.recv_multipart(zmq.NOBLOCK, copy=copy)
    return parts


def wire_bytes(parts: list[Any]) -> int:
    """Return how many bytes the parts of a message were at most: a part has less than 64 more."""
    return sum(len(part) + 64 for part in parts)


def address_of(text: str, flag: str, *, serves: bool = False) -> str:
    """Return tcp://HOST:PORT. flag: its option. serves: * is any. Errors: InputError."""
    found = _TCP.fullmatch(text)
    is_any = found is not None and "*" in found.groups()
    if found is None or (not serves and is_any) or (found[2] != "*" and not int(not serves) <= int(found[2]) <= 65535):
        raise InputError(f"{flag} '{text}': expected HOST:PORT, such as 127.0.0.1:5570")
    return f"tcp://{found[1]}:{found[2]}"


def valid_address(flag: str, *, serves: bool = False) -> Callable[[object, object, str], None]:
    def check(_: object, __: object, text: str) -> None:
        if text:
            address_of(text, flag, serves=serves)

    return check


def is_local(address: str) -> bool:
    found = _TCP.fullmatch(address)
    if found is None or found[1] == "localhost":
        return True
    try:
        return ipaddress.ip_address(found[1].strip("[]")).is_loopback
    except ValueError:
        return False


@attrs.frozen
class Wire:
    """A connection's descriptor, closed at any time, and what it opens by the system's number."""

    descriptor: int
    opens: tuple[int, int]

    @classmethod
    def of(cls, descriptor: int) -> Self:
        found = os.fstat(descriptor)
        return cls(descriptor, (found.st_dev, found.st_ino))

    def handle(self) -> socket.socket:
        descriptor = os.dup(self.descriptor)
        try:
            if Wire.of(descriptor).opens != self.opens:
                raise OSError(errno.EBADF, "the descriptor is another's by now")
            return socket.socket(fileno=descriptor)
        except OSError:
            os.close(descriptor)
            raise

    def cut(self) -> None:
        with contextlib.suppress(OSError), self.handle() as one:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            one.shutdown(socket.SHUT_RDWR)


@attrs.define(eq=False)
class Connection:
    """A connection to a server, by the system's count."""

    wire: Wire
    address: str  # the peer's host, or its /64 of IPv6
    heard_ns: int  # when it came, or was last heard with a valid request
    asks: bool = False
    taken: int = 0  # wire bytes that came out as messages

    def takes_more(self) -> bool:
        """Return whether the system has room for bytes to it: the library then holds none."""
        return takes_more(self.wire.descriptor)


@attrs.define(eq=False)
class Places:
    # Takes a kind, an address, and a line, of which so many a second are written.
    note: Callable[[str, str, str], None] = lambda kind, address, text: None
    per_address: int = MOST_OF_ADDRESS
    # The pages' addresses, by the local port from which the web's door speaks for each.
    guests: dict[int, str] = attrs.field(factory=dict)
    # How many of each address are at the feed's door, and at the web's beside pages.
    clients: Counter[str] = attrs.field(factory=Counter)
    visitors: Counter[str] = attrs.field(factory=Counter)
    # Cut one at the feed's door, at the web's, for a newcomer at the other; whether one was there.
    feed_yields: Callable[[Collection[str]], bool] = lambda addresses: False
    web_yields: Callable[[Collection[str]], bool] = lambda addresses: False


class Connections:
    """Cut connections that send without end, are silent, or too many; an idle one first."""

    def __init__(self, zmq: Any, router: Any, places: Places) -> None:
        self._zmq, self._places = zmq, places
        places.feed_yields = self._give_way
        self._of: dict[int, Connection] = {}
        # Those that have ended, and the address and the reason of each that was cut.
        self.gone: deque[Connection] = deque()
        self.cuts: deque[tuple[str, str]] = deque(maxlen=1000)
        self.listened_ns = 0  # when the server last took all that had come; it may be drawing since
        self._ended = threading.Event()
        self._lock = threading.RLock()
        self._accepted = router.get_monitor_socket(zmq.EVENT_ACCEPTED | zmq.EVENT_CLOSED | zmq.EVENT_DISCONNECTED)
        self._thread = threading.Thread(target=self._watch, name="connections", daemon=True)
        self._thread.start()

    def took(self, parts: list[Any]) -> Connection | None:
        """Note a whole message, as frames of the library; return where it came from."""
        self._catch_up()
        with contextlib.suppress(self._zmq.ZMQError):  # not of a connection that has a descriptor
            found = self._of.get(parts[-1].get(self._zmq.SRCFD))
            if found is not None:
                found.taken += wire_bytes(parts)
            return found
        return None

    def _watch(self) -> None:
        due_ns, wait_ms = 0, 0
        poller = self._zmq.Poller()  # by its descriptor, as two threads may not wait at a socket
        poller.register(self._accepted.getsockopt(self._zmq.FD), self._zmq.POLLIN)
        while not self._ended.is_set():
            poller.poll(wait_ms)
            # The descriptor tells of new events once: what is left is looked for without waiting.
            wait_ms = _EVERY_MS if self._catch_up() else 0
            if time.monotonic_ns() < due_ns:
                continue
            for one in list(self._of.values()):
                if self.listened_ns - one.heard_ns > SILENT_NS:
                    self.cut(one, f"silent for {SILENT_NS // 10**9} s")
                    continue
                with contextlib.suppress(OSError), one.wire.handle() as wire:
                    info = _info_of(wire)  # what it has received; empty where that is not known
                    if info and _RECEIVED.unpack_from(info, _RECEIVED_AT)[0] > MOST_UNREAD + one.taken:
                        most = MOST_UNREAD >> 10
                        self.cut(one, f"more than {most} KiB unread: too many requests, or one without an end")
            due_ns = time.monotonic_ns() + _EVERY_MS * 1_000_000

    def _catch_up(self) -> bool:
        """Note who has come and gone, so many at a time; return whether that is all."""
        with self._lock:
            events = list(itertools.islice(iter(lambda: waiting_parts(self._zmq, self._accepted), []), _MOST_EVENTS))
            # By descriptor, the last of each: what came and went costs no look at it.
            last = {descriptor: kind for kind, descriptor in (struct.unpack_from("=HI", event[0]) for event in events)}
            for descriptor in last:
                self._leave(descriptor)
            come = [self._note(one) for one, kind in last.items() if kind == self._zmq.EVENT_ACCEPTED]
            for new in come:
                if new is None or self._of.get(new.wire.descriptor) is not new:
                    continue
                places = self._places
                crowd = crowd_of(places.clients, places.visitors, new.address, places.per_address)
                if crowd is None:
                    continue
                # The newcomer has made no request either, and came last.
                every = [one for one in self._of.values() if one is not new and one.address in crowd[0]]
                idle = (one for one in every if not one.asks or self.listened_ns - one.heard_ns > IDLE_NS)
                first = min(idle, key=lambda one: (one.asks, one.heard_ns), default=new)
                if not ((first is new or first.asks) and places.web_yields(crowd[0])):
                    self.cut(first, crowd[1])
        return len(events) < _MOST_EVENTS

    def _note(self, descriptor: int) -> Connection | None:
        places = self._places
        with contextlib.suppress(OSError):  # closed since
            wire = Wire.of(descriptor)
            with wire.handle() as one:
                peer, own = one.getpeername(), one.getsockname()
                page = places.guests.get(peer[1]) if peer[0] == own[0] else None
                new = self._of[descriptor] = Connection(wire, page or host_of(one), time.monotonic_ns())
            places.clients = places.clients + Counter([new.address])
            return new
        return None

    def _give_way(self, addresses: Collection[str]) -> bool:
        with self._lock:
            silent = (one for one in self._of.values() if one.address in addresses and not one.asks)
            if (first := next(silent, None)) is not None:
                self.cut(first, "makes room for a page")
            return first is not None

    def cut(self, one: Connection, why: str) -> None:
        """Cut a connection; the library closes it at once, and its client learns of it."""
        with self._lock:
            if self._of.get(one.wire.descriptor) is one:
                self._leave(one.wire.descriptor)
                self.cuts.append((one.address, why))
                one.wire.cut()

    def _leave(self, descriptor: int) -> None:
        if (left := self._of.pop(descriptor, None)) is not None:
            self._places.clients = self._places.clients - Counter([left.address])  # not in place: others read it
            self.gone.append(left)

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self._accepted.close(0)


@attrs.define(eq=False)
class Hearing:
    """Whether a connection is silent; a server calls every half second while it lives."""

    wire: Wire
    looked_ns: int
    received: int = 0
    silent_ns: int = 0
    taken: int = 0  # bytes of the messages that were taken

    def is_silent(self, now_ns: int, patience: int) -> bool:
        """Look for bytes; return whether there were none for `patience` times the usual time."""
        info, waiting = b"", bytes(4)
        with contextlib.suppress(OSError), self.wire.handle() as one:
            info = _info_of(one)
            waiting = fcntl.ioctl(one, termios.FIONREAD, waiting) if info else waiting
        if not info:
            return False
        heard = int(_RECEIVED.unpack_from(info, _RECEIVED_AT)[0])
        # A program that was stopped, or does not read what waits, has not listened.
        self.silent_ns += min(now_ns - self.looked_ns, LOOK_NS * 2)
        if heard != self.received or any(waiting):
            self.silent_ns = 0
        self.looked_ns, self.received = now_ns, heard
        return self.silent_ns > patience * SILENCE_NS + 1000 * int(_RTT.unpack_from(info, _RTT_AT)[0])


def crowd_of(
    own: Counter[str], others: Counter[str], address: str, per_address: int, kept: int = 0
) -> tuple[Collection[str], str] | None:
    """Return of which addresses, at both doors, one must go for a newcomer, and why; or None."""
    both = own + others
    if both[address] > per_address:
        return [address], f"more than {per_address} from one address, see --per-address"
    if own.total() + max(others.total(), kept) <= MOST_CONNECTIONS:
        return None
    counts = own if own.total() + kept > MOST_CONNECTIONS else both
    return [one for one in counts if counts[one] == max(counts.values())], f"more than {MOST_CONNECTIONS} in all"


def host_of(one: socket.socket) -> str:
    host = ipaddress.ip_address(one.getpeername()[0].partition("%")[0])
    if isinstance(host, ipaddress.IPv6Address):
        if host.ipv4_mapped is not None:
            return str(host.ipv4_mapped)
        if not host.is_loopback:
            return str(ipaddress.ip_network((host, 64), strict=False))
    return str(host)


def _info_of(one: socket.socket) -> bytes:
    if sys.platform != "linux":
        return b""
    info = one.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _INFO_BYTES)
    return info if len(info) >= _INFO_BYTES else b""
