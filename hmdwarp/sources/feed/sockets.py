"""What both ends know of the library: addresses, and connections that hold little.

The library bounds messages, not the parts of one: a message without an end is never handed over and
never dropped. So what each connection has sent is compared, by the operating system's count, with
what came out as whole messages.
"""

from __future__ import annotations

import contextlib
import ipaddress
import os
import re
import socket
import struct
import sys
import threading
from types import ModuleType
from typing import Any

from ...errors import InputError
from ...resources import import_extra
from . import EXTRA

# What CURVE adds to a message: command, nonce, authenticator, flags (ZeroMQ RFC 26).
SEAL_BYTES = 8 + 8 + 16 + 1
_FILE = "ipc://"
_MOST_PATH = 107  # of a local socket, less its last zero
_TCP = re.compile(r"(?:tcp://)?(\[[^\]]+\]|[^:/\[\]]+):(\d+|\*)")
# Wire bytes of whole messages that may wait in the library and the kernel stay well below this.
MOST_UNREAD = 1 << 18
MOST_CONNECTIONS = 96
# Buffer of the kernel for each connection.
KERNEL_BYTES = 1 << 14
_EVERY_MS = 20
# struct tcp_info of Linux: tcpi_bytes_received.
_RECEIVED, _RECEIVED_AT, _INFO_BYTES = struct.Struct("=Q"), 128, 136


def zmq_module() -> ModuleType:
    """Return the library. Errors: MachineError where it is not installed."""
    return import_extra("zmq", "pyzmq", EXTRA)


def waiting_parts(zmq: ModuleType, one: Any, *, copy: bool = True) -> list[Any]:
    """Return the parts of a socket's next message, [] where there is none.

    A cut connection may take back a message that the library has announced: waiting for it would
    never end.
    """
    parts: list[Any] = []
    with contextlib.suppress(zmq.Again):
        parts = one.recv_multipart(zmq.NOBLOCK, copy=copy)
    return parts


def address_of(text: str) -> str:
    """Return the library's address for HOST:PORT, tcp://HOST:PORT or ipc://PATH.

    Errors: InputError.
    """
    path = text.removeprefix(_FILE)
    if path and path != text:
        if len(path.encode()) > _MOST_PATH:
            raise InputError(f"address '{text}': a path of more than {_MOST_PATH} bytes; take a shorter one")
        return text
    found = _TCP.fullmatch(text)
    if found is None or (found[2] != "*" and int(found[2]) > 65535):
        raise InputError(f"address '{text}': expected HOST:PORT, such as 127.0.0.1:5570, or ipc://PATH")
    return f"tcp://{found[1]}:{found[2]}"


def is_file(address: str) -> bool:
    """Return whether it is a file of this machine, not a network's."""
    return address.startswith(_FILE)


def is_local(address: str) -> bool:
    """Return whether only this machine reaches it."""
    found = _TCP.fullmatch(address)
    if found is None or found[1] == "localhost":
        return True
    try:
        return ipaddress.ip_address(found[1].strip("[]")).is_loopback
    except ValueError:
        return False


class Connections:
    """Cut connections that send on without finishing a message, and those beyond the most.

    Watches from a thread of its own, as the server may be drawing. On Linux, for TCP; elsewhere
    nothing is cut.
    """

    def __init__(self, zmq: Any, router: Any) -> None:
        self._zmq = zmq
        # By file descriptor: wire bytes that came out as messages.
        self._taken: dict[int, int] = {}
        self.cut = 0
        self._ended = threading.Event()
        self._accepted = router.get_monitor_socket(zmq.EVENT_ACCEPTED | zmq.EVENT_CLOSED | zmq.EVENT_DISCONNECTED)
        self._thread = threading.Thread(target=self._watch, name="connections", daemon=True)
        self._thread.start()

    def took(self, parts: list[Any]) -> None:
        """Note a whole message, as frames of the library."""
        with contextlib.suppress(self._zmq.ZMQError):  # not of a connection that has a descriptor
            descriptor = parts[-1].get(self._zmq.SRCFD)
            # Whatever the library adds to a part on the wire is less than this.
            self._taken[descriptor] = self._taken.get(descriptor, 0) + sum(len(part) + 64 for part in parts)

    def _watch(self) -> None:
        while not self._ended.is_set():
            if self._accepted.poll(_EVERY_MS):
                self._note(self._accepted.recv_multipart())
                continue
            for descriptor in list(self._taken):
                self._check(descriptor)

    def _note(self, event: list[bytes]) -> None:
        kind, descriptor = struct.unpack_from("=HI", event[0])
        if kind == self._zmq.EVENT_ACCEPTED:
            self._taken[descriptor] = 0
            if len(self._taken) > MOST_CONNECTIONS:
                self._cut(descriptor, -1)
        else:
            self._taken.pop(descriptor, None)

    def _check(self, descriptor: int) -> None:
        self._cut(descriptor, MOST_UNREAD + self._taken.get(descriptor, 0))

    def _cut(self, descriptor: int, most: int) -> None:
        """Cut the connection if it has sent more than that."""
        try:
            one = socket.socket(fileno=os.dup(descriptor))
        except OSError:  # closed since
            self._taken.pop(descriptor, None)
            return
        with one, contextlib.suppress(OSError, AttributeError):
            if _received(one) > most:
                # The library closes it at once, and its client learns of it even if it sends on.
                one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
                one.shutdown(socket.SHUT_RDWR)
                self._taken.pop(descriptor, None)
                self.cut += 1

    def close(self) -> None:
        """Stop watching; before the socket is closed."""
        self._ended.set()
        self._thread.join()
        self._accepted.close(0)


def _received(one: socket.socket) -> int:
    """Return how many bytes a connection has received, 0 where that is not known."""
    if sys.platform != "linux" or one.family not in (socket.AF_INET, socket.AF_INET6):
        return 0
    info = one.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _INFO_BYTES)
    return int(_RECEIVED.unpack_from(info, _RECEIVED_AT)[0]) if len(info) >= _INFO_BYTES else 0
