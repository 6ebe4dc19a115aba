"""Pictures kept with the log, exactly as submitted."""

from __future__ import annotations

from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TYPE_CHECKING

from ..colour import picture_from_linear
from ..gpu.textures import download
from ..pipeline.loop import Refresh
from ..report import OutputFolder
from .run_summary import EYES

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


MOST = 1000
_WAITING = 8  # full pictures in memory at a time; beyond that the loop waits for the disk


class Pictures:
    """Keep every n-th refresh as images/frame-NNNNNN-{left,right}.png, at most `MOST` of them.

    Reading a picture back waits for the GPU: such a refresh is late, and its time shows it. A
    thread encodes and writes the PNGs. every: 0 for none.
    """

    def __init__(self, out: OutputFolder, every: int, most: int = MOST) -> None:
        self._out, self._every, self._most = out, every, most
        self._writer = ThreadPoolExecutor(1, "pictures") if every else None
        self._under_way: deque[Future[None]] = deque()
        self.count = 0

    def wants(self, number: int) -> bool:
        """Return whether the refresh of that number is to be kept."""
        return self._writer is not None and number % self._every == 0 and self.count < self._most

    @property
    def is_full(self) -> bool:
        """Whether the limit was reached."""
        return self.count >= self._most

    def keep(self, number: int, refresh: Refresh) -> None:
        """Read a picture back. Errors: as OutputFolder.write_png, for an earlier picture."""
        if self._writer is None:
            return
        for eye, result in enumerate(refresh.eyes):
            while len(self._under_way) >= _WAITING:
                self._under_way.popleft().result()
            name = f"images/frame-{number:06d}-{EYES[eye]}.png"
            self._under_way.append(self._writer.submit(self._write, name, download(result.panel.texture)))
        self.count += 1

    def _write(self, name: str, linear: NDArray[np.floating]) -> None:
        self._out.write_png(name, picture_from_linear(linear))

    def close(self) -> None:
        """Wait until all pictures are written. Errors: as keep; safe to call twice."""
        if self._writer is None:
            return
        self._writer.shutdown()
        while self._under_way:
            self._under_way.popleft().result()
