"""Who is connected to the web's door: by the feed's limits, before a byte of theirs is parsed."""

from __future__ import annotations

import asyncio
import logging
import socket
import ssl
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import attrs

from ..sources.feed.sockets import IDLE_NS, MOST_CONNECTIONS, SILENT_NS, Places, crowd_of, host_of

# Of MOST_CONNECTIONS, so that the feed keeps the rest; no page has a place of its own beside them.
MOST_VISITORS = MOST_CONNECTIONS // 2
IDLE_S, SILENT_S = IDLE_NS * 1e-9, SILENT_NS * 1e-9
_EVERY_S = 0.5
_LETTERS = 300  # of a line for the log


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

    def __init__(
        self,
        loop: asyncio.AbstractEventLoop,
        listener: socket.socket,
        server: Callable[[], Any],
        tls: ssl.SSLContext | None,
        places: Places,
    ) -> None:
        self._loop, self._listener, self._server, self._places = loop, listener, server, places
        self._tls: dict[str, Any] = {}
        if tls is not None:
            self._tls = {"ssl": tls, "ssl_handshake_timeout": SILENT_S, "ssl_shutdown_timeout": 1.0}
        self._of: dict[Any, Visitor] = {}
        listener.setblocking(False)
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
        self._forget()
        if (crowd := crowd_of([*self._of.values()], new, self._places.per_address, MOST_VISITORS)) is not None:
            now_s = self._loop.time()
            idle = [one for one in crowd[0] if one is not new and not (one.knows and now_s - one.heard_s <= IDLE_S)]
            self._cut(min(idle, key=lambda one: (one.knows, one.heard_s), default=new), crowd[1])

    def _cut(self, one: Visitor, why: str) -> None:
        if one.is_page or not one.knows:  # browsers keep others for later
            self._places.note(f"web cut {why}", one.address, f"web: {one.address} cut: {why}")
        one.cut()
        self._of = {handler: other for handler, other in self._of.items() if other is not one}

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(_EVERY_S)
            self._forget()
            now_s = self._loop.time()
            for one in [*self._of.values()]:
                if not one.is_page and now_s - one.heard_s > SILENT_S:
                    self._cut(one, f"no whole request for {SILENT_S:g} s")

    def _forget(self) -> None:
        self._of = {handler: one for handler, one in self._of.items() if one.wire.fileno() >= 0}
        self._places.visitors = len(self._of) - len(self._places.guests)

    def close(self) -> None:
        """Accept none any more, and end all."""
        for task in self._tasks:
            task.cancel()
        for one in self._of.values():
            one.cut()
        self._listener.close()


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
