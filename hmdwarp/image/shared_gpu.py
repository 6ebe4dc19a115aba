"""One context that all threads share, one at a time, for calls that bring none."""

from __future__ import annotations

import atexit
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from ..gpu.context import Gpu

_shared: Gpu | None = None
# A thread that has it may take it again.
_turn = threading.RLock()


@contextmanager
def shared_gpu() -> Iterator[Gpu]:
    """Lend the shared context to this thread for the duration of the block."""
    global _shared  # noqa: PLW0603 (made late, because importing must not start a GL driver)
    with _turn:
        if _shared is None:
            _shared = Gpu()
            _shared.step_aside()
            atexit.register(_shared.close)
        with _shared.current():
            yield _shared
