"""The real command line, with a witness: what the store has taken is told to a pipe before anything else happens.

    python -m tests.study.witness FD study run ...

A line is written when the store's call has returned, in one write, which a pipe takes whole or not at all; what was told stays in the
pipe whatever becomes of this process. So what the witness has told is what somebody may rely on.
"""

from __future__ import annotations

import json
import os
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


if __name__ == "__main__":
    watch(int(sys.argv[1]))
    sys.argv = ["hmdwarp", *sys.argv[2:]]
    from hmdwarp.cli import main

    main()
