"""Programs behind the console's page: the server, and the screen that it starts for each page."""

from __future__ import annotations

import asyncio
import logging
import shutil
import socket
import sys
from pathlib import Path

from aiohttp import web
from textual_serve.server import Server

from .message_socket import MessageSocket
from .terminal_app import ConsoleApp, lower_priority

CLOSING_S = 1.0  # for pages that are still open


class ConsoleServer(Server):
    """Server of the screen under a path that is a secret; anything else is not found."""

    def __init__(self, token: str, title: str, command: str, host: str, port: int) -> None:
        super().__init__(command, host=host, port=port, title=title, templates_path=Path(__file__).parent)
        self._path = f"/{token}"

    async def application(self) -> web.Application:
        """Make the application."""
        outer = web.Application()
        outer.add_subapp(self._path, await self._make_app())
        return outer

    async def on_startup(self, app: web.Application) -> None:
        """End with the program that holds the other end of stdin; print no banner."""
        asyncio.get_running_loop().add_reader(0, self.request_exit)

    def request_exit(self) -> None:
        """End, once: stdin stays readable."""
        asyncio.get_running_loop().remove_reader(0)
        super().request_exit()


def serve(listener_fd: str, token: str, title: str, command: str, folder: str) -> None:
    """Serve until stdin ends.

    command: of the screen, for a shell. folder: to be removed then; the session may have been
    killed.
    """
    lower_priority()
    # A screen may end after this server's loop; asyncio would tell the session's stderr of it.
    logging.getLogger("asyncio").setLevel(logging.ERROR)
    listener = socket.socket(fileno=int(listener_fd))
    server = ConsoleServer(token, title, command, *listener.getsockname())
    web.run_app(
        server.application(),
        sock=listener,
        shutdown_timeout=CLOSING_S,
        print=None,
        handle_signals=False,
        access_log=None,
    )
    shutil.rmtree(folder, ignore_errors=True)


def show(door: str) -> None:
    """Show the screen to the server that started this. door: where the session listens."""
    lower_priority()
    end = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    end.connect(door)
    app = ConsoleApp(MessageSocket(end))
    app.run(mouse=False)
    sys.exit(app.return_code)
