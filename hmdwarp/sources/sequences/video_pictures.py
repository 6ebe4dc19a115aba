"""Pictures of a video by their number, decoded forward and kept one at a time."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from .picture_files import Size


class VideoPictures:
    """The pictures of a video file. Errors: InputError for what is no video."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()
        self._next, self._pictures = 0, iter(())  # type: int, Iterator[Any]
        self._last: tuple[int, NDArray[np.uint8]] | None = None
        self.size: Size = self.picture(0).shape[1::-1]

    def picture(self, number: int) -> NDArray[np.uint8]:
        """Return (h, w, 3) sRGB of a picture, counted from 0 as it is shown; quickest in order."""
        with self._lock:
            if self._last is None or self._last[0] != number:
                self._last = number, self._decoded(number)
            return self._last[1]

    def _decoded(self, number: int) -> NDArray[np.uint8]:
        import av

        try:
            if number < self._next or self._next == 0:
                self._next, self._pictures = 0, self._all(av)
            for picture in self._pictures:
                self._next += 1
                if self._next > number:
                    return np.asarray(picture.to_ndarray(format="rgb24"))
        except (OSError, av.FFmpegError) as error:
            raise InputError(f"{self.path}: not a video that can be read ({error})") from error
        raise InputError(f"{self.path}: {self._next} pictures; expected picture {number}, counted from 0")

    def _all(self, av: Any) -> Iterator[Any]:
        with av.open(str(self.path)) as container:
            yield from container.decode(video=0)
