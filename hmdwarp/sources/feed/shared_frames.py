"""Frames in shared memory, for two ends on one machine: what crosses the socket only names them.

A segment is a file in /dev/shm, as shm_open makes it, with the bytes of one frame message. Its
server makes, reuses and removes it; clients read it and copy what they read, so that a segment that
shrinks or vanishes is a short read and no fault.

What a killed server left behind is removed by the next one to start: each holds a lock on a file of
its own as long as it lives. On Linux; elsewhere nothing is shared.
"""

from __future__ import annotations

import contextlib
import io
import mmap
import os
import re
import secrets
import stat
import sys
import time
import weakref
from collections import defaultdict, deque
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray

from ... import platforms
from ...platforms import CLOEXEC, NOFOLLOW, NONBLOCK
from .message import FrameMessage, Malformed, Stub, length_of, pieces_of, write

SHARED = Path("/dev/shm")
PREFIX = "hmdwarp"
_SEGMENT = re.compile(rf"{PREFIX}-([0-9a-f]{{16}})-\d{{1,10}}")
_OWNER = re.compile(rf"{PREFIX}-([0-9a-f]{{16}})")
# Bytes of frames that wait for a client; one frame may always wait, even if it is larger.
MOST_OF_CLIENT = 256 << 20
# When a frame waits that does not.
NEVER_NS = 1 << 63
# Segments of a client that hold no frame: more are removed.
_MOST_FREE = 3
IS_ABLE = sys.platform == "linux" and SHARED.is_dir() and os.access(SHARED, os.W_OK)


@attrs.define(eq=False)
class _Segment:
    name: str
    memory: mmap.mmap
    # The frame in it, 0 while it may be written, and since when.
    number: int = 0
    since_ns: int = 0

    @property
    def size(self) -> int:
        return len(self.memory)

    def remove(self) -> None:
        """Take the name away, and free the memory."""
        with contextlib.suppress(FileNotFoundError):
            (SHARED / self.name).unlink()
        with contextlib.suppress(BufferError):  # a write that a signal broke off still holds it
            self.memory.close()


class SharedFrames:
    """The segments of one server. Errors: OSError where there is no room for its lock."""

    def __init__(self) -> None:
        remove_abandoned()
        self._owner, self._lock = _locked()
        self._made = 0
        self._of: defaultdict[bytes, list[_Segment]] = defaultdict(list)

    def put(self, client: bytes, frame: FrameMessage) -> Stub | None:
        """Write a frame for a client; return what to tell it, None where there is no room."""
        pieces = pieces_of(frame)
        length = sum(map(length_of, pieces))
        segment = self._free(client, length)
        if segment is None:
            return None
        write(pieces, np.frombuffer(segment.memory, np.uint8))
        segment.number, segment.since_ns = frame.number, time.monotonic_ns()
        return Stub(frame.number, length, segment.name)

    @property
    def held(self) -> int:
        """Bytes of all segments."""
        return sum(block.size for mine in self._of.values() for block in mine)

    def bytes_of(self, client: bytes) -> int:
        """Return the bytes of a client's segments that hold frames."""
        return sum(block.size for block in self._of.get(client, ()) if block.number)

    def count(self, client: bytes) -> int:
        """Return how many frames a client has not confirmed."""
        return sum(block.number > 0 for block in self._of.get(client, ()))

    def since_ns(self, client: bytes) -> int:
        """Return since when the oldest of these is there; far from now without any."""
        return min((block.since_ns for block in self._of.get(client, ()) if block.number), default=NEVER_NS)

    def _free(self, client: bytes, length: int) -> _Segment | None:
        mine = self._of[client]
        for block in mine:
            # One that is far too large came before the client took a smaller size.
            if block.number == 0 and length <= block.size <= 2 * length + mmap.PAGESIZE:
                return block
        for block in [block for block in mine if block.number == 0]:
            if sum(other.size for other in mine) + length > MOST_OF_CLIENT:
                self._remove(client, block)
        self._made += 1
        name = f"{self._owner}-{self._made}"
        try:
            memory = _made(name, length)
        except OSError:
            return None
        mine.append(_Segment(name, memory))
        return mine[-1]

    def drop_free(self) -> None:
        """Remove the segments that hold no frame."""
        for client, mine in self._of.items():
            for block in [block for block in mine if block.number == 0]:
                self._remove(client, block)

    def _remove(self, client: bytes, block: _Segment) -> None:
        block.remove()
        self._of[client].remove(block)

    def received(self, client: bytes, number: int) -> None:
        """Note that a client has read all frames up to that one."""
        free = 0
        for block in list(self._of.get(client, ())):
            if block.number <= number:
                block.number, free = 0, free + 1
                if free > _MOST_FREE:
                    self._remove(client, block)

    def take_back(self, client: bytes, number: int) -> None:
        """Note that a frame was never announced."""
        for block in self._of.get(client, ()):
            if block.number == number:
                block.number = 0

    def forget(self, client: bytes) -> None:
        """Remove all segments of a client.

        A signal may interrupt anything: a segment leaves the books once it is removed, so that
        `close` finds the others.
        """
        for block in self._of.get(client, ()):
            block.remove()
        self._of.pop(client, None)

    def close(self) -> None:
        """Remove everything."""
        for client in list(self._of):
            self.forget(client)
        with contextlib.suppress(FileNotFoundError):
            (SHARED / self._owner).unlink()
        os.close(self._lock)


def _made(name: str, length: int) -> mmap.mmap:
    """Return the memory of a new segment. Errors: OSError, and nothing is left then."""
    descriptor = os.open(SHARED / name, os.O_RDWR | os.O_CREAT | os.O_EXCL | CLOEXEC, 0o600)
    try:
        # Without the room a write into it would end the process.
        platforms.reserve(descriptor, length)
        return mmap.mmap(descriptor, length)
    except BaseException:
        (SHARED / name).unlink()
        raise
    finally:
        os.close(descriptor)


def _locked() -> tuple[str, int]:
    """Return a new owner's name and its lock, which ends with the process."""
    while True:
        name = f"{PREFIX}-{secrets.token_hex(8)}"
        path = SHARED / name
        lock = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | CLOEXEC, 0o600)
        if _locks(lock) and path.exists():
            return name, lock
        # Another server has just taken it for one that was left behind.
        os.close(lock)


def _locks(descriptor: int) -> bool:
    try:
        platforms.lock(descriptor)
    except OSError:
        return False
    return True


def remove_abandoned() -> None:
    """Remove what servers of this user have left that live no more."""
    for path in SHARED.glob(f"{PREFIX}-*"):
        found = _SEGMENT.fullmatch(path.name)
        owner = f"{PREFIX}-{found[1]}" if found else path.name
        if _OWNER.fullmatch(owner) and _abandoned(owner) and found:
            # Another user's, or gone by now.
            with contextlib.suppress(OSError):
                path.unlink()


def _abandoned(owner: str) -> bool:
    """Return whether no process holds the lock; its file is removed then."""
    try:
        descriptor = os.open(SHARED / owner, os.O_RDWR | CLOEXEC | NOFOLLOW)
    except FileNotFoundError:
        return True
    except OSError:
        return False
    try:
        if not _locks(descriptor):
            return False
        with contextlib.suppress(OSError):
            (SHARED / owner).unlink()
        return True
    finally:
        os.close(descriptor)


class FrameReader:
    """Copies frames out of shared memory, into that of earlier ones which nobody holds any more.

    Memory that is new costs more: the system clears it, page by page.
    """

    def __init__(self) -> None:
        self._free: deque[NDArray[np.uint8]] = deque(maxlen=2)

    def read(self, stub: Stub) -> memoryview:
        """Return the bytes that a server has shared; they stay as long as anything refers to them.

        Errors: Malformed where the name is no segment's, or it is shorter; OSError where it cannot
        be read.
        """
        if _SEGMENT.fullmatch(stub.name) is None:
            raise Malformed(f"shared memory '{stub.name[:40]}': expected {PREFIX}-, an owner and a number")
        flags = os.O_RDONLY | CLOEXEC | NOFOLLOW | NONBLOCK
        descriptor = os.open(SHARED / stub.name, flags)
        try:
            found = os.fstat(descriptor)
            if not stat.S_ISREG(found.st_mode) or found.st_size < stub.length:
                raise Malformed(f"shared memory of {found.st_size} bytes: expected {stub.length}")
            # Mapping it is quicker, but a server that shrinks it would end this process.
            data = self._memory(stub.length).data
            count = io.FileIO(descriptor, closefd=False).readinto(data)
            if count < stub.length:
                raise Malformed(f"shared memory that ends at {count} bytes: expected {stub.length}")
            return data.toreadonly()
        finally:
            os.close(descriptor)

    def _memory(self, length: int) -> NDArray[np.uint8]:
        while self._free:
            memory = self._free.pop()
            if length <= memory.nbytes <= 2 * length:
                break
        else:
            # An array's memory is twice as quick to get as that of bytes: it comes in large pages.
            memory = np.empty(length, np.uint8)
        lent = memory[:length]
        weakref.finalize(lent, self._free.append, memory).atexit = False
        return lent
