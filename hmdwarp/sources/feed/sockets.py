"""What both ends know of the library: addresses, and sockets that hold little."""

from __future__ import annotations

import contextlib
import ipaddress
import re
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


def zmq_module() -> ModuleType:
    """Return the library. Errors: MachineError where it is not installed."""
    return import_extra("zmq", "pyzmq", EXTRA)


def waiting_parts(zmq: ModuleType, socket: Any, *, copy: bool = True) -> list[Any]:
    """Return the parts of the next message, [] where there is none.

    A cut connection may take back a message that the library has told of: to wait for it would be
    to wait for ever.
    """
    with contextlib.suppress(zmq.Again):
        return socket.recv_multipart(zmq.NOBLOCK, copy=copy)
    return []


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
