"""Who is connected to the web's door: by the feed's limits, before a byte of theirs is parsed."""

from __future__ import annotations

import asyncio
import logging
import socket
from collections import Counter
from collections.abc import Callable, Collection, Iterable
from contextlib import suppress
from typing import Any

import attrs

from ..sources.feed.sockets import IDLE_NS, MOST_CONNECTIONS, SILENT_NS, Places, crowd_of, host_of

# Of MOST_CONNECTIONS, pages with them; the rest is kept for the feed.
MOST_VISITORS = MOST_CONNECTIONS // 2
IDLE_S, SILENT_S = IDLE_NS * 1e-9, SILENT_NS * 1e-9
_EVERY_S, _LETTERS = 0.5, 300  # of a look at all; of a line for the log
_Loop = asyncio.AbstractEventLoop


@attrs.define(eq=False)
class Visitor:
    """A connection: of a page, of a browser that reads files, or of anybody."""

    wire: socket.socket
    address: str
    # When it came, or was last heard with a cookie.
    heard_s: float
    knows: bool = False  # has shown a cookie
    is_page: bool = False  # has a WebSocket that has spoken: a hidden page says nothing more
    transport: Any = None
    task: Any = None

    def cut(self) -> None:
        """Close it now, whatever waits to be sent."""
        self.task.cancel()
        if self.transport is None:
            self.wire.close()
        else:
            self.transport.abort()


class Visitors:
    """Accept connections and end those that are too many, or silent."""

    def __init__(self, loop: _Loop, listener: socket.socket, server: Any, tls: Any, places: Places) -> None:
        self._loop, self._listener, self._server, self._places = loop, listener, server, places
        self._tls: dict[str, Any] = {}
        if tls is not None:
            self._tls = {"ssl": tls, "ssl_handshake_timeout": SILENT_S, "ssl_shutdown_timeout": 1.0}
        self._of: dict[Any, Visitor] = {}
        listener.setblocking(False)
        places.web_yields = self._give_way
        loop.set_exception_handler(self._failed)
        self._tasks = [loop.create_task(self._accept()), loop.create_task(self._watch())]

    def _failed(self, _: object, context: dict[str, Any]) -> None:
        self._places.note("web", "", f"web: {context['message']} ({context.get('exception')!r})"[:_LETTERS])

    def heard(self, request: Any) -> Visitor:
        """Note a request with a cookie; return whose it is. Errors: ConnectionError if just cut."""
        if (one := self._of.get(request.protocol)) is None:
            raise ConnectionResetError
        one.heard_s, one.knows = self._loop.time(), True
        return one

    async def _accept(self) -> None:
        fails = False
        while True:
            try:
                wire, _ = await self._loop.sock_accept(self._listener)
                fails = False
            except OSError as error:
                if not fails:
                    self._places.note("web", "", f"web: no connection can be accepted ({error}); trying on")
                fails = True
                await asyncio.sleep(1.0)
                continue
            try:
                one = Visitor(wire, host_of(wire), self._loop.time())
            except (OSError, ValueError):  # gone again
                wire.close()
                continue
            handler = self._server()
            self._of[handler] = one
            one.task = self._loop.create_task(self._begin(one, handler))
            self._make_place(one)

    async def _begin(self, one: Visitor, handler: Any) -> None:
        with suppress(OSError):  # no TLS, or gone again
            one.transport, _ = await self._loop.connect_accepted_socket(lambda: handler, one.wire, **self._tls)
            return
        one.wire.close()

    def _make_place(self, new: Visitor) -> None:
        """Cut an idle one where there are too many, without a cookie first; else the newcomer."""
        self.count()
        places, here = self._places, Counter(one.address for one in self._of.values())
        clients = places.clients - Counter(places.guests.values())
        crowd = crowd_of(here, clients, new.address, places.per_address, MOST_CONNECTIONS - MOST_VISITORS)
        if crowd is not None:
            busy_s = self._loop.time() - IDLE_S
            idle = (one for one in self._of.values() if one is not new and not (one.knows and one.heard_s >= busy_s))
            first = _first(idle, crowd[0]) or new
            if not ((first is new or first.knows) and places.feed_yields(crowd[0])):
                self._cut(first, crowd[1])

    def _give_way(self, addresses: Collection[str]) -> bool:
        """Let one go for the feed's newcomer, from its thread; return whether one was there."""
        is_here = any(self._places.visitors[one] for one in addresses)
        with suppress(RuntimeError):  # closed meanwhile
            if is_here:
                self._loop.call_soon_threadsafe(self._cut_for_feed, addresses)
        return is_here

    def _cut_for_feed(self, addresses: Collection[str]) -> None:
        if (first := _first((one for one in self._of.values() if not one.is_page), addresses)) is not None:
            self._cut(first, "makes room for a client of the feed")

    def _cut(self, one: Visitor, why: str) -> None:
        if one.is_page or not one.knows:  # browsers keep others for later
            self._places.note(f"web cut {why}", one.address, f"web: {one.address} cut: {why}")
        one.cut()
        self._of = {handler: other for handler, other in self._of.items() if other is not one}
        self.count()

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(_EVERY_S)
            self.count()
            for newest in [*self._of.values()][-1:]:  # those who came at both doors at once were not told of each other
                self._make_place(newest)
            now_s = self._loop.time()
            for one in [*self._of.values()]:
                if not one.is_page and now_s - one.heard_s > SILENT_S:
                    self._cut(one, f"no whole request for {SILENT_S:g} s")

    def count(self) -> None:
        """Forget who has gone, and say how many are here beside pages."""
        self._of = {handler: one for handler, one in self._of.items() if one.wire.fileno() >= 0}
        here = Counter(one.address for one in self._of.values())
        self._places.visitors = here - Counter(self._places.guests.values())

    def close(self) -> None:
        """Accept none any more, and end all."""
        for task in self._tasks:
            task.cancel()
        for one in self._of.values():
            one.cut()
        self._places.visitors = Counter()
        self._listener.close()


def _first(every: Iterable[Visitor], addresses: Collection[str]) -> Visitor | None:
    those = (one for one in every if one.address in addresses)
    return min(those, key=lambda one: (one.knows, one.is_page, one.heard_s), default=None)


class OneLine(logging.Handler):
    """What the library would log with a traceback, as a line for the log of both doors."""

    def __init__(self, note: Callable[[str, str, str], None]) -> None:
        super().__init__(logging.ERROR)
        self._note = note

    def emit(self, record: logging.LogRecord) -> None:
        """Pass a record on."""
        error = record.exc_info[1] if record.exc_info else None
        what = f"{type(error).__name__}: {' '.join(str(error).split())}"
        self._note("web", "", f"web: {record.getMessage()} ({what})"[:_LETTERS])
