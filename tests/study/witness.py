"""The real command line, with a witness: what the store has taken is told to a pipe, in one write,
before anything else happens. What was told stays there whatever becomes of this process.

    python -m tests.study.witness SOCKET
"""

from __future__ import annotations

import gc
import importlib
import json
import os
import socket
import sys


def tell(fd: int, what: str, *told: object) -> None:
    os.write(fd, (json.dumps([what, *told]) + "\n").encode())


def watch(fd: int) -> None:
    """Put the witness behind the store's calls."""
    from hmdwarp.study.store import Store

    answer, begin_showing, end_showing, record = Store.answer, Store.begin_showing, Store.end_showing, Store.record

    def answered(self, session, step, *rest, **more):
        found = answer(self, session, step, *rest, **more)
        tell(fd, "answer", session.code, found.key, found.revision, found.value)
        return found

    def begun(self, session, step, *rest, **more):
        found = begin_showing(self, session, step, *rest, **more)
        tell(fd, "showing", session.code, found.key, found.presentation)
        return found

    def ended(self, session, *rest, **more):
        found = end_showing(self, session, *rest, **more)
        tell(fd, "shown", session.code, found.key, found.presentation, found.complete)
        return found

    def recorded(self, session, kind, key="", **data):
        record(self, session, kind, key, **data)
        tell(fd, "event", session.code, kind, key)

    Store.answer, Store.begin_showing, Store.end_showing, Store.record = answered, begun, ended, recorded


def nursery(link: socket.socket) -> None:
    """For each list of arguments that comes with two pipes, for the witness and for what is
    printed: a child that is the program; its process id goes back at once, its status when it is
    dead. Nothing of OpenGL is open where it is forked from.
    """
    for name in ("cli._app", "study.session.program", "study.respondents", "display.offscreen"):
        importlib.import_module(f"hmdwarp.{name}")
    gc.freeze()  # a session collects before each of its 35 runs, and would scan all modules each time
    while (asked := socket.recv_fds(link, 1 << 16, 2))[0]:
        data, (told, said) = asked[:2]
        pid = os.fork()
        if not pid:
            os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
            os.dup2(said, 1)
            os.dup2(said, 2)
            sys.stdout, sys.stderr = open(1, "w", closefd=False), open(2, "w", buffering=1, closefd=False)  # noqa: PTH123, SIM115
            watch(told)
            sys.argv = ["hmdwarp", *json.loads(data)]
            importlib.import_module("hmdwarp.cli").main()
        os.close(told)
        os.close(said)
        link.sendall(f"{pid}\n".encode())
        link.sendall(f"{os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])}\n".encode())


if __name__ == "__main__":
    nursery(socket.socket(fileno=int(sys.argv[1])))
