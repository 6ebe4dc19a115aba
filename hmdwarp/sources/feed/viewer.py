"""One picture at a time from a server elsewhere, each waited for: the truth of a run."""

from __future__ import annotations

import time

from ...geometry import View
from .caller import Caller
from .message import FULL, Ask, FrameMessage, Wish

_ANSWER_NS, _AGAIN_NS = 10_000_000_000, 1_000_000_000
_MOST_UNANSWERED = 3  # unanswered in a row: then no more requests are sent


class Viewer:
    """A client that asks for one eye's view and waits for it.

    wish: how its numbers come; coded frames are passed over. Errors: as Caller.
    """

    def __init__(self, address: str, secret: str = "", server_key: bytes = b"", wish: Wish = FULL) -> None:
        self._caller, self._wish = Caller(address, secret, server_key), wish
        self._number = self._unanswered = 0

    def fetch(self, view: View, size: tuple[int, int], time_ns: int) -> FrameMessage | None:
        """Return what the server draws for the view; None where it refuses or does not answer.

        After three such requests in a row none is sent any more.
        """
        if self._unanswered >= _MOST_UNANSWERED:
            return None
        found = self._waited_for(view, size, time_ns)
        self._unanswered = 0 if found is not None else self._unanswered + 1
        return found

    def _waited_for(self, view: View, size: tuple[int, int], time_ns: int) -> FrameMessage | None:
        head, first = view.pose @ view.head_from_eye.inverse(), self._number + 1
        until_ns = time.monotonic_ns() + _ANSWER_NS
        while (now_ns := time.monotonic_ns()) < until_ns:
            self._number += 1
            self._caller.ask(Ask(self._number, 0, time_ns, time_ns, 0, size, head, (view,), wish=self._wish))
            # Requested again after a while: the connection may not have been there.
            again_ns = min(until_ns, now_ns + _AGAIN_NS)
            while time.monotonic_ns() < again_ns:
                self._caller.wait_until(again_ns)
                for arrival in self._caller.take():
                    one = arrival.frame
                    plain = not one.is_coded and one.is_finite
                    if one.number >= first and one.size == size and len(one.views) == 1 and plain:
                        return one
                if any("refused" in line for line in self._caller.lines()):
                    return None
        return None

    def close(self) -> None:
        """Hang up."""
        self._caller.close()
