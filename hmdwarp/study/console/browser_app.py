"""Programs behind the console's page: the server, and the screen that it starts for each page."""

from __future__ import annotations

import asyncio
import base64
import hashlib
import json
import logging
import re
import shutil
import socket
import sys
from pathlib import Path
from typing import Any

import textual_serve.server
from aiohttp import web
from textual_serve.app_service import AppService

from ...platforms import message_socket
from .message_socket import MessageSocket
from .terminal_app import ConsoleApp, step_back

CLOSING_S = 1.0  # for pages that are still open
CELLS = (600, 300)  # of a terminal at most: the screen would draw as many as a page names


class Screen(AppService):
    """Screen of one page, of a size that can be drawn."""

    async def start(self, width: int, height: int) -> None:
        """Start it."""
        await super().start(*_bounded(width, height))

    async def set_terminal_size(self, width: int, height: int) -> None:
        """Tell it its new size."""
        await super().set_terminal_size(*_bounded(width, height))


def _bounded(*cells: float) -> tuple[int, ...]:
    return tuple(int(min(max(count, 1), most)) for count, most in zip(cells, CELLS, strict=True))


setattr(textual_serve.server, "AppService", Screen)  # noqa: B010 (by this name the server makes them)


class ConsoleServer(textual_serve.server.Server):
    """Server of the screen under a path that is a secret; anything else is not found.

    A page of another origin gets nothing, even one that knows the secret, nor does one whose name
    leads here (DNS rebinding).
    """

    def __init__(self, token: str, title: str, command: str, host: str, port: int) -> None:
        super().__init__(command, host=host, port=port, title=title, templates_path=Path(__file__).parent)
        self._path = f"/{token}"
        self._hosts = (f"{host}:{port}", f"localhost:{port}")
        page = (Path(__file__).parent / "app_index.html").read_text(encoding="utf-8")
        scripts = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
        hashes = (base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts)
        sockets = (f"ws://{name}" for name in self._hosts)  # which 'self' does not mean in every browser
        self._headers = {
            "Content-Security-Policy": "; ".join(
                (
                    *("default-src 'none'", "frame-ancestors 'none'", "base-uri 'none'", "form-action 'none'"),
                    " ".join(("script-src 'self'", *(f"'sha256-{hash_}'" for hash_ in hashes))),
                    *("style-src 'self' 'unsafe-inline'", "font-src 'self'", "img-src 'self' data:"),  # xterm.js
                    " ".join(("connect-src 'self'", *sockets)),
                )
            ),
            "X-Frame-Options": "DENY",
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
            "Cross-Origin-Resource-Policy": "same-origin",
            "Cache-Control": "no-store",
        }

    async def application(self) -> web.Application:
        """Make the application."""
        outer = web.Application(middlewares=[self._only_here])
        outer.on_response_prepare.append(self._protect)
        outer.add_subapp(self._path, await self._make_app())
        return outer

    @web.middleware
    async def _only_here(self, request: web.Request, handler: Any) -> web.StreamResponse:
        """Refuse requests under other names or from other origins; a program names none."""
        origins = request.headers.getall("Origin", [])
        if request.host not in self._hosts or not {*origins} <= {f"http://{name}" for name in self._hosts}:
            raise web.HTTPForbidden(text="open the console by the address that hmdwarp printed")
        response: web.StreamResponse = await handler(request)
        return response

    async def _protect(self, _: web.Request, response: web.StreamResponse) -> None:
        response.headers.update(self._headers)

    async def on_startup(self, app: web.Application) -> None:
        """End with the program that holds the other end of stdin; print no banner."""
        asyncio.get_running_loop().add_reader(0, self.request_exit)

    def request_exit(self) -> None:
        """End, once: stdin stays readable."""
        asyncio.get_running_loop().remove_reader(0)
        super().request_exit()


def serve() -> None:
    """Serve until stdin ends; its first line has the listener, a folder, and for ConsoleServer.

    Arguments could be read by everybody on this machine. The folder is removed at the end: the
    session may have been killed.
    """
    step_back()
    # Neither a request nor a screen that ends after this server's loop is news for the session's
    # stderr.
    logging.disable()
    with open(0, closefd=False) as stdin:
        given = json.loads(stdin.readline())
    listener = socket.socket(fileno=given["listener"])
    server = ConsoleServer(given["token"], given["title"], given["command"], *listener.getsockname())
    web.run_app(
        server.application(),
        sock=listener,
        shutdown_timeout=CLOSING_S,
        print=None,
        handle_signals=False,
        access_log=None,
    )
    shutil.rmtree(given["folder"], ignore_errors=True)


def show(door: str) -> None:
    """Show the screen to the server that started this. door: where the session listens."""
    step_back()
    end = message_socket()
    end.connect(door)
    app = ConsoleApp(MessageSocket(end))
    app.run(mouse=False)
    sys.exit(app.return_code)
